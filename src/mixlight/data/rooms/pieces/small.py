"""Small things that stand and lie on tables, shelves and the floor."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.contents import stack, vessel
from mixlight.data.rooms.pieces.hung import _art
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.storage import shoe_pair
from mixlight.data.rooms.pieces.style import Style, tone
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]

_CARDBOARD = Surface("paper", (0.33, 0.21, 0.11), roughness=0.9)


def _seed(rng: Random) -> int:
    return rng.randrange(1 << 20)


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


def _draw_book(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.13, 0.24), rng.uniform(0.18, 0.3), rng.uniform(0.012, 0.04)),
        (rng.choice(style.books), style.paper),
        open=rng.random() < 0.15,
    )


def _book(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, t = width / 2, depth / 2, 0.002
    if item.parameters["open"]:
        u = np.linspace(-1, 1, 13)
        rise = t + (height - t) * (1 - np.abs(u)) ** 0.5 * np.abs(u) ** 0.25 * 1.6
        rise = np.clip(rise, t, height)
        points = np.stack([np.stack((u * x, np.full(13, s * y), rise), -1) for s in (-1, 1)], 1)
        bodies.add(1, shapes.sheet(points))
        bodies.box(0, (-x, -y, 0.0), (x, y, t))
        return bodies.parts()
    bodies.box(0, (-x, -y, 0.0), (x, y, t))
    bodies.box(0, (-x, -y, height - t), (x, y, height))
    bodies.box(0, (-x, -y, t), (-x + t, y, height - t))
    bodies.box(1, (-x + t, -y + 0.003, t), (x - 0.003, y - 0.003, height - t))
    return bodies.parts()


def _draw_books(rng: Random, style: Style) -> Item:
    lying = rng.random() < 0.5
    size = (
        (0.25, 0.31, rng.uniform(0.05, 0.2))
        if lying
        else (rng.uniform(0.12, 0.4), 0.2, rng.uniform(0.2, 0.28))
    )
    return draft(size, tuple(style.books), lying=lying, seed=_seed(rng))


def _books(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    colours = range(len(item.surfaces))
    if item.parameters["lying"]:
        stack(bodies, rng, 0.0, 0.0, 0.0, height, colours, wide=width, deep=depth)
        return bodies.parts()
    x = -width / 2
    while True:
        thick = rng.uniform(0.014, 0.045)
        if x + thick > width / 2:
            break
        tall, deep = height * rng.uniform(0.75, 1.0), depth * rng.uniform(0.65, 0.98)
        bodies.box(
            rng.choice(list(colours)), (x, depth / 2 - deep, 0.0), (x + thick - 0.001, depth / 2, tall)
        )
        x += thick
    if x == -width / 2:
        bodies.box(0, (x, -depth / 2, 0.0), (x + 0.03, depth / 2, height))
    return bodies.parts()


def _draw_pile(rng: Random, style: Style) -> Item:
    return draft((0.3, 0.32, rng.uniform(0.12, 0.5)), tuple(style.books), lying=True, seed=_seed(rng))


def _draw_papers(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.25, 0.4), rng.uniform(0.3, 0.42), rng.uniform(0.004, 0.05)),
        (style.paper, rng.choice(style.books), _art(rng)),
        seed=_seed(rng),
    )


def _papers(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    z = 0.0
    while z < height - 0.002:
        thick = min(rng.choice([0.001, 0.001, 0.003, 0.012]), height - z)
        w, d = min(0.21, width * 0.8), min(0.297, depth * 0.8)
        reach = (width - w) / 2 * 0.6, (depth - d) / 2 * 0.6
        angle = rng.uniform(-0.15, 0.15)
        place = shapes.placement((rng.uniform(-1, 1) * reach[0], rng.uniform(-1, 1) * reach[1], z), angle)
        bodies.put(
            0 if rng.random() < 0.75 else 1,
            shapes.box((-w / 2, -d / 2, 0), (w / 2, d / 2, thick * 0.95)),
            place,
        )
        z += thick
        if rng.random() < 0.1 and z < height - 0.001:
            bodies.put(
                2,
                shapes.panel((-w / 2, -d / 2, 0.0002), (w, 0, 0), (0, d, 0), unit_uv=True),
                shapes.placement((0, 0, z), angle),
            )
    return bodies.parts()


def _draw_clutter(rng: Random, style: Style) -> Item:
    what = rng.choice(["pens", "stapler", "tray", "tape", "calculator", "cup"])
    size = {
        "pens": (0.09, 0.09, 0.19),
        "stapler": (0.04, 0.14, 0.055),
        "tray": (0.27, 0.36, 0.16),
        "tape": (0.14, 0.06, 0.07),
        "calculator": (0.09, 0.15, 0.02),
        "cup": (0.08, 0.08, 0.1),
    }[what]
    return draft(
        size,
        (
            rng.choice([style.plastic, style.dark_metal, style.metal, *style.accents[:3]]),
            style.paper,
            *style.accents[:4],
        ),
        what=what,
        seed=_seed(rng),
    )


def _clutter(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, what, rng = Bodies(item), item.parameters["what"], Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    if what in ("pens", "cup"):
        tall = height * (0.55 if what == "pens" else 1.0)
        bodies.add(
            0,
            shapes.lathe(
                np.array([(x * 0.9, 0.0), (x * 0.9, tall), (x * 0.82, tall), (x * 0.8, 0.01), (0.0, 0.01)]),
                segments=16,
            ),
        )
        for _ in range(rng.randint(3, 9) if what == "pens" else 0):
            a, b = rng.uniform(0, 6.28), rng.uniform(0, 6.28)
            foot, head = (
                (x * 0.4 * math.cos(a), x * 0.4 * math.sin(a), 0.015),
                (x * 0.7 * math.cos(b), x * 0.7 * math.sin(b), height * rng.uniform(0.8, 0.98)),
            )
            bodies.bars(2 + rng.randrange(4), [(foot, head)], 0.004)
    elif what == "tray":
        for i in range(3):
            z = i * height / 3
            bodies.box(0, (-x, -y, z), (x, y, z + 0.004))
            for side in (-1, 1):
                bodies.box(
                    0,
                    (side * x - (0.004 if side > 0 else 0), -y, z),
                    (side * x + (0 if side > 0 else 0.004), y, z + 0.04 if i < 2 else height),
                )
            bodies.box(1, (-0.1, -0.14, z + 0.004), (0.1, 0.15, z + 0.004 + rng.uniform(0.002, 0.04)))
        for sx in (-1, 1):
            for sy in (-1, 1):
                bodies.bars(
                    0,
                    [((sx * (x - 0.006), sy * (y - 0.006), 0), (sx * (x - 0.006), sy * (y - 0.006), height))],
                    0.004,
                )
    elif what == "tape":
        roll = shapes.rotation("x", math.pi / 2)
        bodies.put(
            0,
            shapes.cylinder(height / 2, depth * 0.6, segments=18),
            shapes.placement((0, depth * 0.3, height / 2)) @ roll,
        )
        bodies.box(0, (-x, -y, 0.0), (x, y, 0.02))
    else:
        bodies.add(0, shapes.rounded_box((-x, -y, 0.0), (x, y, height), min(0.01, height * 0.3), steps=1))
    return bodies.parts()


def _draw_small_box(rng: Random, style: Style) -> Item:
    surface = rng.choice([_CARDBOARD, *style.accents[:6], *style.books[:4]])
    return draft(
        (rng.uniform(0.06, 0.3), rng.uniform(0.06, 0.22), rng.uniform(0.03, 0.2)),
        (surface, rng.choice(style.books)),
        lid=rng.random() < 0.5,
    )


def _small_box(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    if item.parameters["lid"]:
        bodies.box(0, (-x + 0.002, -y + 0.002, 0.0), (x - 0.002, y - 0.002, height * 0.7))
        bodies.box(1, (-x, -y, height * 0.7), (x, y, height))
    else:
        bodies.box(0, (-x, -y, 0.0), (x, y, height))
    return bodies.parts()


def _draw_frame(rng: Random, style: Style) -> Item:
    width = rng.uniform(0.1, 0.24)
    return draft(
        (width, 0.1, width * rng.choice([0.75, 1.33])),
        (rng.choice([style.wood, style.metal, style.dark_metal, style.ceramic]), _art(rng)),
    )


def _frame(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, t = width / 2, 0.014
    lean = shapes.placement((0, -depth / 2 + 0.012, 0.0)) @ shapes.rotation("x", -0.2)
    tall = height / math.cos(0.2) - 0.004
    bodies.put(0, shapes.box((-x, 0.0, 0.0), (x, 0.012, tall)), lean)
    bodies.put(
        1, shapes.panel((-x + t, -0.0008, t), (width - 2 * t, 0, 0), (0, 0, tall - 2 * t), unit_uv=True), lean
    )
    bodies.bars(0, [((0, depth / 2 - 0.004, 0.003), (0, -depth / 2 + 0.05, height * 0.7))], 0.003)
    return bodies.parts()


def _draw_ornament(rng: Random, style: Style) -> Item:
    what = rng.choice(["ball", "figure", "stack", "ring", "cone"])
    height = rng.uniform(0.08, 0.3)
    return draft(
        (height * 0.5, height * 0.5, height),
        (rng.choice([*style.accents, style.ceramic, style.wood]),),
        what=what,
    )


def _ornament(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies, what = Bodies(item), item.parameters["what"]
    r = width / 2
    if what == "ball":
        bodies.add(0, shapes.cylinder(r * 0.5, height * 0.15, segments=14))
        bodies.put(
            0,
            shapes.sphere(r, segments=18, rings=10),
            shapes.placement((0, 0, height * 0.55), 0, (1, 1, height * 0.43 / r)),
        )
    elif what == "figure":
        profile = np.array(
            [
                (r, 0.0),
                (r * 0.9, 0.06),
                (r * 0.45, 0.12),
                (r * 0.7, 0.4),
                (r * 0.75, 0.55),
                (r * 0.3, 0.74),
                (r * 0.5, 0.82),
                (r * 0.45, 0.95),
                (0.0, 1.0),
            ]
        ) * [1, height]
        bodies.add(0, shapes.lathe(profile, segments=16))
    elif what == "stack":
        for i, share in enumerate((1.0, 0.8, 0.6, 0.4)):
            bodies.put(
                0,
                shapes.sphere(0.5, segments=14, rings=8),
                shapes.placement(
                    (0, 0, height * (0.125 + 0.25 * i)), 0, (width * share, width * share, height * 0.26)
                ),
            )
    elif what == "ring":
        ring = shapes.torus(r * 0.78, r * 0.2, segments=20, sides=8)
        stretch = shapes.placement(
            (0, 0, height / 2 + 0.005), 0, (1, 1, height / width * 0.98)
        ) @ shapes.rotation("x", math.pi / 2)
        bodies.put(0, ring, stretch)
        bodies.box(0, (-r, -r * 0.5, 0.0), (r, r * 0.5, 0.012))
    else:
        bodies.add(0, shapes.cone(r, 0.0, height, segments=12))
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
        seed=_seed(rng),
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
        seed=_seed(rng),
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
        seed=_seed(rng),
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


def _draw_toy(rng: Random, style: Style) -> Item:
    bright = [
        Surface("plastic", tone(rng, c, 0.08, 0.4, spread=0.1), roughness=0.35)
        for c in ((1, 0.08, 0.05), (0.08, 0.3, 1), (1, 0.7, 0.05), (0.1, 0.7, 0.2))
    ]
    return draft(
        (rng.uniform(0.1, 0.4), rng.uniform(0.1, 0.35), rng.uniform(0.06, 0.22)), bright, seed=_seed(rng)
    )


def _toy(item: Item) -> list[Part]:
    """Blocks and balls that were left where they fell."""
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    for _ in range(rng.randint(3, 9)):
        side = rng.uniform(0.25, 0.5) * min(width, depth, 0.12)
        x, y = rng.uniform(-1, 1) * (width / 2 - side * 0.75), rng.uniform(-1, 1) * (depth / 2 - side * 0.75)
        if rng.random() < 0.3:
            r = min(side * 0.6, height / 2)
            bodies.put(rng.randrange(4), shapes.sphere(r, segments=14, rings=8), shapes.placement((x, y, r)))
        else:
            tall = min(side * rng.choice([1, 1, 2]), height)
            bodies.put(
                rng.randrange(4),
                shapes.box((-side / 2, -side / 2, 0), (side / 2, side / 2, tall)),
                shapes.placement((x, y, 0), rng.uniform(0, 6)),
            )
    return bodies.parts()


def _draw_bath_clutter(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.1, 0.3), rng.uniform(0.07, 0.12), 0.2),
        (style.ceramic, *rng.sample(style.accents, 4), style.glass),
        seed=_seed(rng),
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


# --- on the floor -------------------------------------------------------------------------------------------


def _draw_box(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.3, 0.6), rng.uniform(0.25, 0.45), rng.uniform(0.2, 0.45)),
        (
            rng.choice([_CARDBOARD, _CARDBOARD, _CARDBOARD, style.plastic, style.accents[0]]),
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
        seed=_seed(rng),
    )


def _basket(item: Item) -> list[Part]:
    from mixlight.data.rooms.pieces.beds import crumpled

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
        seed=_seed(rng),
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
        seed=_seed(rng),
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
        seed=_seed(rng),
    )


def _hamper(item: Item) -> list[Part]:
    from mixlight.data.rooms.pieces.beds import crumpled

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
    Piece("cup", "cup", _draw_cup, _cup),
    Piece("bottle", "bottle", _vessel("bottle", (0.06, 0.09), (0.2, 0.34), 0.3), _build_vessel),
    Piece("glass", "glass", _vessel("cup", (0.06, 0.08), (0.09, 0.16), 1.0), _build_vessel),
    Piece("bowl", "bowl", _vessel("bowl", (0.12, 0.3), (0.06, 0.12), 0.1), _build_vessel),
    Piece("can", "can", _vessel("can", (0.06, 0.17), (0.1, 0.2)), _build_vessel),
    Piece("vase", "vase", _vessel("vase", (0.09, 0.2), (0.16, 0.42), 0.15), _build_vessel),
    Piece("floor_vase", "floor_vase", _vessel("vase", (0.25, 0.4), (0.5, 0.9)), _build_vessel),
    Piece("plate", "plate", _draw_plate, _plate),
    Piece("book", "book", _draw_book, _book),
    Piece("books", "books", _draw_books, _books),
    Piece("book_pile", "book_pile", _draw_pile, _books),
    Piece("papers", "papers", _draw_papers, _papers),
    Piece("office_clutter", "office_clutter", _draw_clutter, _clutter),
    Piece("small_box", "small_box", _draw_small_box, _small_box),
    Piece("frame", "frame", _draw_frame, _frame),
    Piece("ornament", "ornament", _draw_ornament, _ornament),
    Piece("food", "food", _draw_food, _food),
    Piece("kitchen_clutter", "kitchen_clutter", _draw_kitchen_clutter, _kitchen_clutter),
    Piece("pot", "pot", _draw_pot, _pot),
    Piece("candle_holder", "candle_holder", _draw_candle, _candle),
    Piece("tray", "tray", _draw_tray, _tray),
    Piece("small_toy", "small_toy", _draw_toy, _toy),
    Piece("toys", "toy", _draw_toy, _toy),
    Piece("bath_clutter", "bath_clutter", _draw_bath_clutter, _bath_clutter),
    Piece("box", "box", _draw_box, _box),
    Piece("basket", "basket", _draw_basket, _basket),
    Piece("bin", "bin", _draw_bin, _bin),
    Piece("bag", "bag", _draw_bag, _bag),
    Piece("shoes", "shoes", _draw_shoes, _shoes),
    Piece("cable", "cable", _draw_cable, _cable),
    Piece("cleaning", "cleaning", _draw_cleaning, _cleaning),
    Piece("hamper", "hamper", _draw_hamper, _hamper),
)
