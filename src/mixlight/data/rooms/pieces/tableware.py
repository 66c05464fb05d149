"""Small things of kitchens, dining tables and bathrooms."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.contents import vessel
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft, draw_seed
from mixlight.data.rooms.pieces.style import Style, tone
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]


def _vessel(
    what: str, across: tuple[float, float], tall: tuple[float, float], glass: float = 0.0
) -> Callable[[Random, Style], Item]:
    """A turned thing of a kind: how wide, how tall, how often of glass."""

    def draw(rng: Random, style: Style) -> Item:
        wide = rng.uniform(*across)
        surface = (
            style.glass
            if rng.random() < glass
            else rng.choice([style.ceramic, style.ceramic, *style.accents])
        )
        return draft((wide, wide, rng.uniform(*tall)), (surface,), what=what)

    return draw


def _build_vessel(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies = Bodies(item)
    bodies.add(0, vessel(item.parameters["what"], width / 2, height, segments=20))
    return bodies.parts()


def _draw_cup(rng: Random, style: Style) -> Item:
    return draft((0.12, 0.085, rng.uniform(0.08, 0.11)), (rng.choice([style.ceramic, *style.accents[:4]]),))


def _cup(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    r = depth / 2
    at = -width / 2 + r
    bodies.put(0, vessel("cup", r, height, segments=18), shapes.placement((at, 0, 0)))
    turn = np.linspace(-math.pi / 2, math.pi / 2, 6)
    path = np.stack(
        (at + r * 0.88 + np.cos(turn) * (width - depth), np.zeros(6), height * (0.52 + 0.28 * np.sin(turn))),
        -1,
    )
    bodies.add(0, shapes.tube(path, 0.005, segments=6, caps=False))
    return bodies.parts()


def _draw_plate(rng: Random, style: Style) -> Item:
    count = rng.choice([1, 1, 1, 2, 5])
    across = rng.uniform(0.18, 0.28)
    return draft(
        (across, across, 0.02 + 0.008 * (count - 1)),
        (rng.choice([style.ceramic, style.ceramic, *style.accents[:2]]), style.metal),
        count=count,
    )


def _plate(item: Item) -> list[Part]:
    width, _, _ = item.size
    bodies = Bodies(item)
    r = width / 2
    profile = np.array(
        [(r * 0.55, 0.0), (r * 0.65, 0.004), (r, 0.018), (r * 0.97, 0.02), (r * 0.62, 0.007), (0.0, 0.006)]
    )
    for i in range(item.parameters["count"]):
        bodies.put(0, shapes.lathe(profile, segments=28, crease=1.0), shapes.placement((0, 0, 0.008 * i)))
    return bodies.parts()


def _draw_food(rng: Random, style: Style) -> Item:
    fruit = [
        Surface("plastic", tone(rng, c, 0.1, 0.35, spread=0.1), roughness=0.4)
        for c in ((1, 0.12, 0.06), (1, 0.55, 0.05), (0.6, 0.9, 0.1), (1, 0.85, 0.1))
    ]
    across = rng.uniform(0.2, 0.32)
    return draft(
        (across, across, across * 0.42),
        (rng.choice([style.ceramic, style.wood, style.metal, style.glass]), *fruit),
        seed=draw_seed(rng),
    )


def _food(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    r = width / 2
    bodies.add(0, vessel("bowl", r, height * 0.6, segments=20))
    ball = shapes.sphere(1.0, segments=12, rings=8)
    for i in range(rng.randint(3, 8)):
        size = rng.uniform(0.03, 0.042)
        angle, ring = i * 2.4, 0.0 if i == 0 else rng.uniform(0.3, 0.55)
        z = height * (0.3 if ring else 0.55) + size * 0.4
        at = (math.cos(angle) * ring * r, math.sin(angle) * ring * r, min(z, height - size))
        bodies.put(1 + rng.randrange(4), ball, shapes.placement(at, 0, (size, size, size * 0.95)))
    return bodies.parts()


def _draw_kitchen_clutter(rng: Random, style: Style) -> Item:
    what = rng.choice(["board", "knives", "rack", "roll", "utensils", "jars"])
    size = {
        "board": (0.38, 0.06, 0.27),
        "knives": (0.12, 0.2, 0.24),
        "rack": (0.42, 0.32, 0.2),
        "roll": (0.14, 0.14, 0.3),
        "utensils": (0.13, 0.13, 0.33),
        "jars": (0.3, 0.11, 0.16),
    }[what]
    return draft(
        size,
        (
            rng.choice([style.wood, style.metal, style.ceramic]),
            style.metal,
            style.paper,
            style.ceramic,
            *style.accents[:3],
        ),
        what=what,
        seed=draw_seed(rng),
    )


def _kitchen_clutter(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, what, rng = Bodies(item), item.parameters["what"], Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    if what == "board":
        lean = shapes.placement((0, 0.0, 0.0)) @ shapes.rotation("x", -0.15)
        bodies.put(0, shapes.box((-x, -0.01, 0.003), (x, 0.01, height * 0.97)), lean)
    elif what == "knives":
        lean = shapes.placement((0, 0.02, 0.0)) @ shapes.rotation("x", -0.25)
        bodies.put(0, shapes.box((-x, -0.05, 0.02), (x, 0.05, height * 0.6)), lean)
        for i in range(5):
            bodies.put(
                1,
                shapes.box(
                    (-x + 0.015 + i * 0.02, -0.012, height * 0.6),
                    (-x + 0.027 + i * 0.02, 0.012, height * 0.95),
                ),
                lean,
            )
        bodies.box(0, (-x, -y + 0.04, 0.0), (x, y - 0.02, 0.02))
    elif what == "rack":
        for z in (0.01, 0.1):
            loop = np.array(
                [
                    (-x + 0.01, -y + 0.01, z),
                    (x - 0.01, -y + 0.01, z),
                    (x - 0.01, y - 0.01, z),
                    (-x + 0.01, y - 0.01, z),
                ]
            )
            bodies.add(1, shapes.tube(loop, 0.004, segments=6, closed=True))
        for i in range(rng.randint(2, 8)):
            at = -x + 0.05 + i * 0.04
            disc = shapes.lathe(np.array([(0.11, 0.0), (0.11, 0.006), (0.0, 0.008)]), segments=24)
            bodies.put(
                3,
                disc,
                shapes.placement((at, 0.0, 0.095))
                @ shapes.rotation("z", 0.0)
                @ shapes.rotation("y", math.pi / 2 - 0.2)
                @ shapes.placement(scale=(0.78, 1.1, 1)),
            )
    elif what == "roll":
        bodies.add(2, shapes.cylinder(0.058, height - 0.06, base=(0, 0, 0.015), segments=20))
        bodies.add(0, shapes.cylinder(x, 0.014, segments=20))
        bodies.bars(0, [((0, 0, 0.0), (0, 0, height))], 0.007)
    elif what == "utensils":
        bodies.add(
            3,
            shapes.lathe(
                np.array([(0.055, 0.0), (0.062, 0.15), (0.055, 0.15), (0.05, 0.01), (0.0, 0.01)]), segments=18
            ),
        )
        for i in range(rng.randint(4, 8)):
            a = i * 2.4
            head = (0.05 * math.cos(a), 0.05 * math.sin(a), height * rng.uniform(0.8, 0.92))
            bodies.bars(rng.choice([0, 1]), [((0.02 * math.cos(a), 0.02 * math.sin(a), 0.02), head)], 0.004)
            bodies.put(
                rng.choice([0, 1]),
                shapes.sphere(0.5, segments=8, rings=6),
                shapes.placement(head, a, (0.014, 0.04, 0.05)),
            )
    else:
        for i in range(3):
            bodies.put(
                3 + i,
                vessel("jar", 0.045, height * rng.uniform(0.75, 1.0)),
                shapes.placement((-x + 0.05 + i * 0.1, 0, 0)),
            )
    return bodies.parts()


def _draw_pot(rng: Random, style: Style) -> Item:
    r = rng.uniform(0.16, 0.26)
    return draft(
        (r + 0.1, r, rng.uniform(0.1, 0.2)),
        (rng.choice([style.metal, style.metal, style.accents[1], style.dark_metal]), style.dark_metal),
        pan=rng.random() < 0.35,
    )


def _pot(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    r = depth / 2
    tall = height * (0.35 if item.parameters["pan"] else 0.8)
    bodies.add(
        0,
        shapes.lathe(
            np.array(
                [(r * 0.95, 0.0), (r, 0.012), (r, tall), (r * 0.96, tall), (r * 0.93, 0.012), (0.0, 0.01)]
            ),
            segments=26,
        ),
    )
    if item.parameters["pan"]:
        bodies.bars(1, [((r * 0.95, 0, tall * 0.8), (width / 2, 0, height * 0.6))], 0.01)
    else:
        bodies.put(
            0,
            shapes.lathe(
                np.array(
                    [
                        (r, 0.0),
                        (r * 0.5, height * 0.1),
                        (0.015, height * 0.13),
                        (0.015, height * 0.2),
                        (0.0, height * 0.2),
                    ]
                ),
                segments=26,
            ),
            shapes.placement((0, 0, tall)),
        )
        for side in (-1, 1):
            bodies.bars(
                1,
                [
                    ((side * r * 0.98, -0.03, tall * 0.8), (side * (width / 2 - 0.008), 0, tall * 0.8)),
                    ((side * (width / 2 - 0.008), 0, tall * 0.8), (side * r * 0.98, 0.03, tall * 0.8)),
                ],
                0.006,
            )
    return bodies.parts()


def _draw_candle(rng: Random, style: Style) -> Item:
    height = rng.uniform(0.06, 0.3)
    return draft(
        (0.09, 0.09, height),
        (
            rng.choice([style.metal, style.ceramic, style.wood]),
            Surface("plastic", (0.7, 0.66, 0.55), roughness=0.5),
        ),
    )


def _candle(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies = Bodies(item)
    r = width / 2
    if height < 0.14:
        bodies.add(1, shapes.cylinder(r * 0.8, height - 0.012, base=(0, 0, 0.012), segments=18))
        bodies.add(0, shapes.cylinder(r, 0.012, segments=18))
    else:
        bodies.add(
            0,
            shapes.lathe(
                np.array([(r, 0.0), (r, 0.01), (0.012, 0.03), (0.012, height * 0.4), (0.022, height * 0.45)]),
                segments=16,
            ),
        )
        bodies.add(1, shapes.cylinder(0.011, height * 0.55, base=(0, 0, height * 0.45), segments=12))
    return bodies.parts()


def _draw_tray(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.3, 0.45), rng.uniform(0.2, 0.32), 0.11),
        (rng.choice([style.wood, style.metal, style.accents[2]]), style.ceramic, style.glass),
        seed=draw_seed(rng),
    )


def _tray(item: Item) -> list[Part]:
    width, depth, _height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y, 0.0), (x, y, 0.008))
    for lo, hi in (
        ((-x, -y), (x, -y + 0.01)),
        ((-x, y - 0.01), (x, y)),
        ((-x, -y), (-x + 0.01, y)),
        ((x - 0.01, -y), (x, y)),
    ):
        bodies.box(0, (*lo, 0.008), (*hi, 0.035))
    for i in range(rng.randint(1, 4)):
        at = (-x + 0.07 + i * 0.08, rng.uniform(-y + 0.06, y - 0.06), 0.008)
        if at[0] < x - 0.05:
            bodies.put(
                rng.choice([1, 2]),
                vessel(rng.choice(["cup", "cup", "can"]), 0.038, 0.09),
                shapes.placement(at),
            )
    return bodies.parts()


def _draw_bath_clutter(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.1, 0.3), rng.uniform(0.07, 0.12), 0.2),
        (style.ceramic, *rng.sample(style.accents, 4), style.glass),
        seed=draw_seed(rng),
    )


def _bath_clutter(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x = -width / 2
    while x < width / 2 - 0.04:
        r = min(rng.uniform(0.018, 0.036), depth / 2)
        if x + 2 * r > width / 2:
            break
        tall = rng.uniform(0.06, height)
        bodies.put(
            rng.randrange(6),
            vessel(rng.choice(["bottle", "jar", "can", "cup"]), r, tall),
            shapes.placement((x + r, rng.uniform(-1, 1) * (depth / 2 - r), 0)),
        )
        x += 2 * r + rng.uniform(0.002, 0.02)
    return bodies.parts()


PIECES = (
    Piece("cup", "cup", _draw_cup, _cup),
    Piece("bottle", "bottle", _vessel("bottle", (0.06, 0.09), (0.2, 0.34), 0.3), _build_vessel),
    Piece("glass", "glass", _vessel("cup", (0.06, 0.08), (0.09, 0.16), 1.0), _build_vessel),
    Piece("bowl", "bowl", _vessel("bowl", (0.12, 0.3), (0.06, 0.12), 0.1), _build_vessel),
    Piece("can", "can", _vessel("can", (0.06, 0.17), (0.1, 0.2)), _build_vessel),
    Piece("vase", "vase", _vessel("vase", (0.09, 0.2), (0.16, 0.42), 0.15), _build_vessel),
    Piece("floor_vase", "floor_vase", _vessel("vase", (0.25, 0.4), (0.5, 0.9)), _build_vessel),
    Piece("plate", "plate", _draw_plate, _plate),
    Piece("food", "food", _draw_food, _food),
    Piece("kitchen_clutter", "kitchen_clutter", _draw_kitchen_clutter, _kitchen_clutter),
    Piece("pot", "pot", _draw_pot, _pot),
    Piece("candle_holder", "candle_holder", _draw_candle, _candle),
    Piece("tray", "tray", _draw_tray, _tray),
    Piece("bath_clutter", "bath_clutter", _draw_bath_clutter, _bath_clutter),
)
