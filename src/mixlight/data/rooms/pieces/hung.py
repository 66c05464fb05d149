"""What hangs on walls and under ceilings."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft, draw_seed
from mixlight.data.rooms.pieces.style import Style, tone
from mixlight.data.rooms.pieces.wardrobes import hanging_cloth
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]

_WHITE = Surface("plastic", (0.7, 0.69, 0.66), roughness=0.4)
_MIRROR = Surface("mirror", (0.88, 0.89, 0.88), roughness=0.0)


def art(rng: Random) -> Surface:
    tints = [
        (1.0, 0.6, 0.4),
        (0.5, 0.7, 1.0),
        (0.6, 0.9, 0.5),
        (1.0, 0.9, 0.7),
        (0.8, 0.8, 0.8),
        (1.0, 0.4, 0.3),
    ]
    return Surface(
        "picture",
        tone(rng, rng.choice(tints), 0.08, 0.5, spread=0.2),
        tone(rng, rng.choice(tints), 0.03, 0.6, spread=0.2),
        roughness=rng.choice([0.1, 0.5, 0.8]),
        scale=round(rng.uniform(0.5, 2.0), 2),
        seed=rng.randrange(100_000),
    )


def _frame(rng: Random, style: Style) -> Surface:
    return rng.choice(
        [
            style.wood,
            style.wood_2,
            style.dark_metal,
            style.dark_metal,
            _WHITE,
            Surface("metal", (0.5, 0.36, 0.14), roughness=0.35, metallic=1.0),
        ]
    )


def _draw_picture(rng: Random, style: Style) -> Item:
    width = rng.lognormvariate(math.log(0.5), 0.45)
    width = min(max(width, 0.16), 1.7)
    height = min(max(width * rng.choice([0.7, 1.0, 1.33, 1.4, 0.6]), 0.16), 1.3)
    mat = rng.random() < 0.4
    return draft(
        (width, 0.028, height),
        (_frame(rng, style), art(rng), style.paper),
        bar=round(rng.choice([0.0, 0.015, 0.025, 0.05]), 3),
        mat=round(0.14 * min(width, height), 3) if mat else 0.0,
    )


def _picture(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    x, front = width / 2, -depth / 2
    bar, mat = p["bar"], p["mat"]
    if bar > 0:
        for lo, hi in (
            ((-x, 0), (x, bar)),
            ((-x, height - bar), (x, height)),
            ((-x, bar), (-x + bar, height - bar)),
            ((x - bar, bar), (x, height - bar)),
        ):
            bodies.box(0, (lo[0], front, lo[1]), (hi[0], depth / 2, hi[1]))
    at = front + (0.012 if bar > 0 else 0.0)
    bodies.box(2, (-x + bar * 0.9, at + 0.001, bar * 0.9), (x - bar * 0.9, depth / 2, height - bar * 0.9))
    edge = bar + mat
    bodies.add(
        1,
        shapes.panel(
            (-x + edge, at, edge), (width - 2 * edge, 0, 0), (0, 0, height - 2 * edge), unit_uv=True
        ),
    )
    return bodies.parts()


def _draw_mirror(rng: Random, style: Style) -> Item:
    round_ = rng.random() < 0.3
    width = rng.uniform(0.4, 1.0)
    return draft(
        (width, 0.03, width if round_ else rng.uniform(0.5, 1.0)),
        (_frame(rng, style), _MIRROR),
        round=round_,
        bar=round(rng.choice([0.008, 0.02, 0.045]), 3),
    )


def _mirror(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, bar = Bodies(item), item.parameters["bar"]
    x, front = width / 2, -depth / 2
    if item.parameters["round"]:
        face = shapes.rotation("x", math.pi / 2)
        place = shapes.placement((0, depth / 2, height / 2), 0, (width, 1, height)) @ face
        bodies.put(
            0,
            shapes.lathe(
                np.array([(0.5, 0.0), (0.5, depth - 0.004), (0.5 - bar, depth), (0.5 - bar, depth - 0.008)]),
                segments=48,
                caps=False,
            ),
            place,
        )
        bodies.put(
            1,
            shapes.lathe(
                np.array([(0.5 - bar * 0.9, depth - 0.009), (0.0, depth - 0.0089)]), segments=48, caps=False
            ),
            place,
        )
        return bodies.parts()
    for lo, hi in (
        ((-x, 0), (x, bar)),
        ((-x, height - bar), (x, height)),
        ((-x, bar), (-x + bar, height - bar)),
        ((x - bar, bar), (x, height - bar)),
    ):
        bodies.box(0, (lo[0], front, lo[1]), (hi[0], depth / 2, hi[1]))
    bodies.box(0, (-x + bar * 0.5, 0.0, bar * 0.5), (x - bar * 0.5, depth / 2, height - bar * 0.5))
    bodies.add(1, shapes.panel((-x + bar, -0.001, bar), (width - 2 * bar, 0, 0), (0, 0, height - 2 * bar)))
    return bodies.parts()


def _draw_clock(rng: Random, style: Style) -> Item:
    across = rng.uniform(0.22, 0.38)
    return draft(
        (across, 0.045, across),
        (_frame(rng, style), *rng.choice([(style.paper, style.dark_metal), (style.dark_metal, style.paper)])),
        hour=round(rng.uniform(0, 6.28), 2),
        minute=round(rng.uniform(0, 6.28), 2),
    )


def _clock(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    r = width / 2
    face = shapes.placement((0, depth / 2, height / 2)) @ shapes.rotation("x", math.pi / 2)
    bodies.put(
        0,
        shapes.lathe(
            np.array([(r, 0.0), (r, depth * 0.8), (r * 0.93, depth), (r * 0.9, depth * 0.7)]),
            segments=32,
            caps=False,
        ),
        face,
    )
    bodies.put(
        1,
        shapes.lathe(np.array([(r * 0.92, depth * 0.7), (0.0, depth * 0.701)]), segments=32, caps=False),
        face,
    )
    for angle, share in ((item.parameters["hour"], 0.45), (item.parameters["minute"], 0.75)):
        hand = shapes.box((-0.006, 0.0, depth * 0.72), (0.006, r * share, depth * 0.75))
        bodies.put(2, hand, face @ shapes.rotation("z", -angle))
    for i in range(12):
        tick = shapes.box((-0.004, r * 0.76, depth * 0.71), (0.004, r * 0.86, depth * 0.72))
        bodies.put(2, tick, face @ shapes.rotation("z", i * math.pi / 6))
    return bodies.parts()


def _draw_board(rng: Random, style: Style) -> Item:
    cork = rng.random() < 0.45
    size = (
        (rng.uniform(0.5, 0.9), 0.03, rng.uniform(0.4, 0.7))
        if cork
        else (rng.uniform(0.9, 2.0), 0.03, rng.uniform(0.7, 1.2))
    )
    face = (
        Surface("paper", (0.33, 0.19, 0.09), roughness=0.9)
        if cork
        else Surface("plastic", (0.76, 0.76, 0.75), roughness=0.15)
    )
    return draft(
        size,
        (rng.choice([style.metal, style.wood]), face, style.paper, *style.accents[:3]),
        notes=rng.randint(3, 14) if cork else rng.randint(0, 6),
        seed=rng.randrange(1 << 20),
    )


def _board(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, front, t = width / 2, -depth / 2, 0.02
    for lo, hi in (
        ((-x, 0), (x, t)),
        ((-x, height - t), (x, height)),
        ((-x, t), (-x + t, height - t)),
        ((x - t, t), (x, height - t)),
    ):
        bodies.box(0, (lo[0], front, lo[1]), (hi[0], depth / 2, hi[1]))
    bodies.box(1, (-x + t, front + 0.012, t), (x - t, depth / 2, height - t))
    for i in range(item.parameters["notes"]):
        w, h = rng.choice([(0.21, 0.297), (0.148, 0.21), (0.08, 0.08), (0.1, 0.15)])
        if w > width - 0.1 or h > height - 0.1:
            continue
        at, z = rng.uniform(-x + t, x - t - w), rng.uniform(t, height - t - h)
        bodies.add(
            2 if rng.random() < 0.6 else 3 + i % 3,
            shapes.panel((at, front + 0.011 - 0.0004 * i, z), (w, 0, rng.uniform(-0.01, 0.01)), (0, 0, h)),
        )
    return bodies.parts()


def _draw_radiator(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.5, 1.4), rng.uniform(0.08, 0.12), rng.uniform(0.4, 0.7)),
        (Surface("paint", (0.7, 0.69, 0.65), roughness=0.3), style.metal),
        panel=rng.random() < 0.5,
    )


def _radiator(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    if item.parameters["panel"]:
        bodies.box(0, (-x, -y + 0.006, 0.0), (x, -y + 0.02, height))
        bodies.box(0, (-x, y - 0.035, 0.0), (x, y - 0.02, height))
        bodies.box(0, (-x, -y + 0.02, height - 0.01), (x, y - 0.02, height))
        count = int(width / 0.035)
        for i in range(count):
            a = -x + (i + 0.3) * width / count
            bodies.box(0, (a, -y, 0.03), (a + 0.016, -y + 0.006, height - 0.03))
    else:
        count = max(3, int(width / 0.06))
        for i in range(count):
            a = -x + (i + 0.5) * width / count
            bodies.add(
                0, shapes.rounded_box((a - 0.022, -y, 0.02), (a + 0.022, y - 0.02, height), 0.018, steps=1)
            )
        for z in (0.06, height - 0.06):
            bodies.bars(0, [((-x, -0.01, z), (x, -0.01, z))], 0.016)
    for side in (-1, 1):
        bodies.bars(
            1, [((side * (x - 0.1), y - 0.03, height * 0.5), (side * (x - 0.1), y, height * 0.5))], 0.012
        )
    return bodies.parts()


def _draw_hooks(rng: Random, style: Style) -> Item:
    cloths = [
        style.upholstery,
        style.upholstery_2,
        *(Surface("fabric", s.colour, roughness=0.95) for s in style.books[:3]),
    ]
    count = rng.randint(0, 5)
    size = (rng.uniform(0.5, 1.1), 0.24, rng.uniform(0.75, 1.25) if count else 0.14)
    return draft(size, (style.wood, style.metal, *cloths), seed=draw_seed(rng), count=count)


def _hooks(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, y - 0.022, height - 0.12), (x, y, height))
    places = max(3, int(width / 0.16))
    inner = width - 0.36  # a coat is wider than its hook
    ats = [-inner / 2 + i * inner / (places - 1) for i in range(places)]
    for at in ats:
        bodies.add(
            1,
            shapes.tube(
                np.array(
                    [
                        (at, y - 0.02, height - 0.05),
                        (at, y - 0.07, height - 0.06),
                        (at, y - 0.075, height - 0.03),
                    ]
                ),
                0.006,
            ),
        )
    longest = height - 0.06
    for i, at in enumerate(rng.sample(ats, min(item.parameters["count"], places))):
        length = longest * (1.0 if i == 0 else rng.uniform(0.5, 1.0))
        hanging_cloth(
            bodies,
            rng,
            at,
            y - 0.1,
            height - 0.05,
            length,
            rng.uniform(0.2, 0.3),
            2 + rng.randrange(5),
            deep=0.17,
        )
    return bodies.parts()


def _draw_air_conditioner(rng: Random, style: Style) -> Item:
    return draft((rng.uniform(0.75, 1.0), 0.21, 0.29), (_WHITE, style.dark_metal))


def _air_conditioner(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.add(0, shapes.rounded_box((-x, -y, 0.02), (x, y, height), 0.05))
    bodies.box(1, (-x + 0.05, -y + 0.02, 0.015), (x - 0.05, y - 0.06, 0.03))
    bodies.box(0, (-x + 0.05, -y + 0.01, 0.0), (x - 0.05, -y + 0.03, 0.05))
    return bodies.parts()


def _draw_extinguisher(rng: Random, style: Style) -> Item:
    return draft(
        (0.17, 0.2, 0.55),
        (Surface("paint", (0.42, 0.012, 0.01), roughness=0.25), style.dark_metal, style.metal),
    )


def _extinguisher(item: Item) -> list[Part]:
    _, depth, height = item.size
    bodies = Bodies(item)
    at = shapes.placement((0, depth / 2 - 0.09, 0))
    bodies.put(
        0,
        shapes.lathe(
            np.array([(0.07, 0.0), (0.078, 0.01), (0.078, 0.38), (0.06, 0.43), (0.025, 0.46)]), segments=20
        ),
        at,
    )
    bodies.put(2, shapes.cylinder(0.02, 0.04, base=(0, 0, 0.46), segments=10), at)
    bodies.box(1, (-0.02, -depth / 2 + 0.02, height - 0.05), (0.02, depth / 2 - 0.06, height))
    bodies.add(
        1,
        shapes.tube(
            np.array(
                [
                    (0.02, depth / 2 - 0.09, 0.48),
                    (0.075, depth / 2 - 0.1, 0.42),
                    (0.08, depth / 2 - 0.1, 0.15),
                ]
            ),
            0.01,
        ),
    )
    bodies.box(2, (-0.05, depth / 2 - 0.012, 0.2), (0.05, depth / 2, 0.35))
    return bodies.parts()


def _draw_sign(rng: Random, style: Style) -> Item:
    size = rng.choice(
        [(0.3, 0.012, 0.15), (0.21, 0.008, 0.297), (0.42, 0.008, 0.594), (0.6, 0.02, 0.3), (0.15, 0.01, 0.15)]
    )
    colours = [style.paper, Surface("plastic", (0.02, 0.3, 0.08), roughness=0.4), *style.accents[:3]]
    return draft(size, (rng.choice(colours), art(rng)), poster=rng.random() < 0.5)


def _sign(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, front = width / 2, -depth / 2
    bodies.box(0, (-x, front + 0.002, 0.0), (x, depth / 2, height))
    if item.parameters["poster"]:
        bodies.add(
            1,
            shapes.panel(
                (-x * 0.92, front + 0.001, height * 0.05),
                (width * 0.92, 0, 0),
                (0, 0, height * 0.9),
                unit_uv=True,
            ),
        )
    return bodies.parts()


def _draw_detector(rng: Random, style: Style) -> Item:
    return draft((0.11, 0.11, 0.045), (_WHITE, style.dark_metal))


def _detector(item: Item) -> list[Part]:
    _, _, height = item.size
    bodies = Bodies(item)
    bodies.add(
        0,
        shapes.lathe(
            np.array([(0.02, 0.0), (0.035, 0.002), (0.045, 0.02), (0.055, 0.025), (0.055, height)]),
            segments=20,
        ),
    )
    return bodies.parts()


def _draw_vent(rng: Random, style: Style) -> Item:
    return draft(
        rng.choice([(0.6, 0.6, 0.02), (0.3, 0.3, 0.02), (0.6, 0.15, 0.02)]), (_WHITE, style.dark_metal)
    )


def _vent(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(1, (-x + 0.02, -y + 0.02, 0.012), (x - 0.02, y - 0.02, height))
    t = 0.03
    for lo, hi in (
        ((-x, -y), (x, -y + t)),
        ((-x, y - t), (x, y)),
        ((-x, -y + t), (-x + t, y - t)),
        ((x - t, -y + t), (x, y - t)),
    ):
        bodies.box(0, (*lo, 0.0), (*hi, height))
    count = int((depth - 2 * t) / 0.045)
    for i in range(count):
        a = -y + t + (i + 0.3) * (depth - 2 * t) / count
        bodies.box(0, (-x + t, a, 0.002), (x - t, a + 0.02, 0.012))
    return bodies.parts()


PIECES = (
    Piece("picture", "picture", _draw_picture, _picture),
    Piece("mirror", "mirror", _draw_mirror, _mirror),
    Piece("clock", "clock", _draw_clock, _clock),
    Piece("board", "board", _draw_board, _board),
    Piece("radiator", "radiator", _draw_radiator, _radiator),
    Piece("hooks", "hooks", _draw_hooks, _hooks),
    Piece("air_conditioner", "air_conditioner", _draw_air_conditioner, _air_conditioner),
    Piece("extinguisher", "extinguisher", _draw_extinguisher, _extinguisher),
    Piece("sign", "sign", _draw_sign, _sign),
    Piece("smoke_detector", "smoke_detector", _draw_detector, _detector),
    Piece("vent", "vent", _draw_vent, _vent),
)
