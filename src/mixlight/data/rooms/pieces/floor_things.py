"""What stands and lies about on the floor: boxes, baskets, bins, bags, shoes, cables."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.beds import crumpled
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft, draw_seed
from mixlight.data.rooms.pieces.style import CARDBOARD, Style, tone
from mixlight.data.rooms.pieces.wardrobes import shoe_pair
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]


def _draw_box(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.3, 0.6), rng.uniform(0.25, 0.45), rng.uniform(0.2, 0.45)),
        (
            rng.choice([CARDBOARD, CARDBOARD, CARDBOARD, style.plastic, style.accents[0]]),
            Surface("plastic", (0.25, 0.18, 0.1), roughness=0.3),
        ),
        open=rng.random() < 0.3,
    )


def _box(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    if not item.parameters["open"]:
        bodies.box(0, (-x, -y, 0.0), (x, y, height - 0.001))
        bodies.box(1, (-x - 0.0005, -0.025, height * 0.8), (x + 0.0005, 0.025, height))
        return bodies.parts()
    t, low = 0.006, height * 0.8
    bodies.box(0, (-x + 0.05, -y + 0.05, 0.0), (x - 0.05, y - 0.05, t))
    for lo, hi in (
        ((-x, -y), (x, -y + t)),
        ((-x, y - t), (x, y)),
        ((-x, -y), (-x + t, y)),
        ((x - t, -y), (x, y)),
    ):
        inner_lo = (lo[0] * 0.86, lo[1] * 0.86)
        inner_hi = (hi[0] * 0.86, hi[1] * 0.86)
        bodies.box(
            0,
            (min(inner_lo[0], inner_hi[0]), min(inner_lo[1], inner_hi[1]), 0.0),
            (max(inner_lo[0], inner_hi[0]), max(inner_lo[1], inner_hi[1]), low),
        )
    for side in (-1, 1):  # flaps that stand open
        a, b = side * x * 0.86, side * x
        bodies.add(0, shapes.panel((a, -y * 0.86, low), (0, depth * 0.86, 0), (b - a, 0, height - low)))
        bodies.add(
            0,
            shapes.panel((a - side * 0.002, y * 0.86, low), (0, -depth * 0.86, 0), (b - a, 0, height - low)),
        )
    return bodies.parts()


def _draw_basket(rng: Random, style: Style) -> Item:
    across = rng.uniform(0.28, 0.5)
    straw = Surface("fabric", tone(rng, (1, 0.72, 0.42), 0.12, 0.4), roughness=0.9, bump=0.8, scale=3.0)
    return draft(
        (across, across, rng.uniform(0.2, 0.42)),
        (rng.choice([straw, straw, style.upholstery, style.dark_metal]), style.linen, *style.books[:3]),
        full=rng.random() < 0.6,
        seed=draw_seed(rng),
    )


def _basket(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    r = width / 2
    tall = height * 0.88
    bodies.add(
        0,
        shapes.lathe(
            np.array([(r * 0.8, 0.0), (r, tall), (r * 0.95, tall), (r * 0.77, 0.015), (0.0, 0.012)]),
            segments=26,
        ),
    )
    bodies.add(0, shapes.torus(r * 0.965, r * 0.035, centre=(0, 0, tall), segments=26, sides=6))
    if item.parameters["full"]:
        bodies.put(
            1 + rng.randrange(4),
            crumpled(rng, width * 0.85, width * 0.85, height * 0.4),
            shapes.placement((0, 0, height * 0.58)),
        )
    return bodies.parts()


def _draw_bin(rng: Random, style: Style) -> Item:
    across = rng.uniform(0.22, 0.36)
    return draft(
        (across, across, rng.uniform(0.28, 0.65)),
        (rng.choice([style.metal, style.plastic, style.dark_metal, style.accents[3]]), style.plastic),
        lid=rng.random() < 0.4,
    )


def _bin(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies = Bodies(item)
    r = width / 2
    if item.parameters["lid"]:
        bodies.add(
            0,
            shapes.lathe(
                np.array(
                    [
                        (r, 0.0),
                        (r, height * 0.84),
                        (r * 0.98, height * 0.86),
                        (r * 0.8, height * 0.95),
                        (r * 0.3, height),
                        (0.0, height),
                    ]
                ),
                segments=26,
            ),
        )
        bodies.add(1, shapes.cylinder(r, 0.03, base=(0, 0, 0.0), segments=26))
    else:
        bodies.add(
            0,
            shapes.lathe(
                np.array([(r * 0.78, 0.0), (r, height), (r * 0.96, height), (r * 0.75, 0.01), (0.0, 0.01)]),
                segments=26,
            ),
        )
    return bodies.parts()


def _draw_bag(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.3, 0.48), rng.uniform(0.14, 0.25), rng.uniform(0.3, 0.52)),
        (
            rng.choice(
                [
                    style.upholstery,
                    style.upholstery_2,
                    *style.books[:3],
                    *(Surface("leather", (0.03, 0.02, 0.015), roughness=0.4),),
                ]
            ),
            style.dark_metal,
        ),
    )


def _bag(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, tall = width / 2, depth / 2, height * 0.68
    bodies.add(
        0,
        shapes.rounded_box(
            (-x + 0.02, -y + 0.02, 0.012),
            (x - 0.02, y - 0.02, tall),
            min(0.06, depth * 0.3),
            puff=0.02,
            middle=5,
        ),
    )
    turn = np.linspace(0, math.pi, 9)
    for side in (-1, 1):
        path = np.stack(
            (
                x * 0.45 * np.cos(turn),
                np.full(9, side * y * 0.4),
                tall - 0.01 + (height - tall) * np.sin(turn),
            ),
            -1,
        )
        bodies.add(1, shapes.tube(path, 0.008, segments=6))
    return bodies.parts()


def _draw_shoes(rng: Random, style: Style) -> Item:
    count = rng.choice([1, 1, 2, 3])
    return draft(
        (0.24 * count, 0.34, 0.1),
        (*rng.sample(style.books, 3), Surface("leather", (0.02, 0.015, 0.012), roughness=0.4)),
        count=count,
        seed=draw_seed(rng),
    )


def _shoes(item: Item) -> list[Part]:
    width, _, _ = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    for i in range(item.parameters["count"]):
        shoe_pair(bodies, rng, -width / 2 + 0.12 + i * 0.24, rng.uniform(-0.02, 0.02), 0.0, rng.randrange(4))
    return bodies.parts()


def _draw_cable(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.3, 1.0), rng.uniform(0.2, 0.5), 0.05),
        (rng.choice([style.dark_metal, Surface("plastic", (0.6, 0.6, 0.58), roughness=0.5)]), style.plastic),
        seed=draw_seed(rng),
    )


def _cable(item: Item) -> list[Part]:
    """A cable on the floor with a block of sockets at its end."""
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    t = np.linspace(0, 1, 40)
    x, y = (t - 0.5) * (width - 0.03), np.zeros(40)
    for k in (1.5, 2.7, 4.3):
        y += np.sin(t * k * 6.28 + rng.uniform(0, 6.28)) / k
    y *= (depth / 2 - 0.02) / max(float(np.abs(y).max()), 1e-6)
    bodies.add(0, shapes.tube(np.stack((x, y, np.full(40, 0.005)), -1), 0.004, segments=6))
    bodies.box(
        1,
        (-width / 2, max(-depth / 2, y[0] - 0.03), 0.0),
        (-width / 2 + min(0.3, width * 0.5), min(depth / 2, y[0] + 0.03), height),
    )
    return bodies.parts()


def _draw_cleaning(rng: Random, style: Style) -> Item:
    if rng.random() < 0.5:
        return draft(
            (0.28, 0.28, 0.28), (rng.choice([style.plastic, *style.accents[:3]]), style.metal), what="bucket"
        )
    return draft((0.12, 0.12, 0.4), (rng.choice([style.ceramic, style.metal]), style.metal), what="brush")


def _cleaning(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies = Bodies(item)
    r = width / 2
    if item.parameters["what"] == "bucket":
        bodies.add(
            0,
            shapes.lathe(
                np.array(
                    [
                        (r * 0.72, 0.0),
                        (r * 0.96, height),
                        (r, height),
                        (r * 0.92, height - 0.002),
                        (r * 0.7, 0.008),
                        (0.0, 0.008),
                    ]
                ),
                segments=24,
            ),
        )
        turn = np.linspace(0, math.pi, 9)
        bodies.add(
            1,
            shapes.tube(
                np.stack(
                    (r * 0.95 * np.cos(turn), -0.6 * r * np.sin(turn), height * (0.9 - 0.1 * np.sin(turn))),
                    -1,
                ),
                0.003,
                segments=5,
            ),
        )
    else:
        bodies.add(
            0,
            shapes.lathe(
                np.array(
                    [
                        (r, 0.0),
                        (r * 0.9, height * 0.35),
                        (r * 0.8, height * 0.35),
                        (r * 0.5, height * 0.3),
                        (0.0, height * 0.3),
                    ]
                ),
                segments=18,
            ),
        )
        bodies.bars(1, [((0, 0, height * 0.3), (0, 0, height))], 0.008)
    return bodies.parts()


def _draw_hamper(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.35, 0.45), rng.uniform(0.3, 0.42), rng.uniform(0.5, 0.65)),
        (rng.choice([style.linen, style.upholstery_2, style.wood]), style.linen),
        seed=draw_seed(rng),
    )


def _hamper(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, tall = width / 2, depth / 2, height * 0.9
    t = 0.012
    for lo, hi in (
        ((-x, -y), (x, -y + t)),
        ((-x, y - t), (x, y)),
        ((-x, -y), (-x + t, y)),
        ((x - t, -y), (x, y)),
    ):
        bodies.box(0, (*lo, 0.0), (*hi, tall))
    bodies.put(
        1,
        crumpled(Random(item.parameters["seed"]), width * 0.95, depth * 0.95, height * 0.25),
        shapes.placement((0, 0, height * 0.75)),
    )
    return bodies.parts()


PIECES = (
    Piece("box", "box", _draw_box, _box),
    Piece("basket", "basket", _draw_basket, _basket),
    Piece("bin", "bin", _draw_bin, _bin),
    Piece("bag", "bag", _draw_bag, _bag),
    Piece("shoes", "shoes", _draw_shoes, _shoes),
    Piece("cable", "cable", _draw_cable, _cable),
    Piece("cleaning", "cleaning", _draw_cleaning, _cleaning),
    Piece("hamper", "hamper", _draw_hamper, _hamper),
)
