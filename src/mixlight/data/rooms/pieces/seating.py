"""Things to sit on: sofas, armchairs, chairs, stools, benches."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.plan import Item

__all__ = ["PIECES", "legs"]


def legs(
    bodies: Bodies,
    surface: int,
    width: float,
    depth: float,
    height: float,
    thick: float,
    *,
    inset: float = 0.0,
    splay: float = 0.0,
    round_: bool = False,
    bottom: float = 0.0,
) -> None:
    """Four legs from `bottom` to `height` under the corners of a rectangle around the origin."""
    x, y = width / 2 - thick / 2 - inset, depth / 2 - thick / 2 - inset
    for sx in (-1, 1):
        for sy in (-1, 1):
            if round_ or splay:
                foot = (sx * x, sy * y, bottom)
                head = (sx * (x - splay), sy * (y - splay), height)
                bodies.bars(surface, [(foot, head)], thick / 2)
            else:
                bodies.box(
                    surface,
                    (sx * x - thick / 2, sy * y - thick / 2, bottom),
                    (sx * x + thick / 2, sy * y + thick / 2, height),
                )


def _cushions(
    bodies: Bodies, surface: int, item: Item, rng: Random, x0: float, x1: float, y: float, z: float
) -> None:
    """Loose cushions that lean on a back at y, between x0 and x1, on a seat at z."""
    for _ in range(int(item.parameters.get("cushions", 0))):
        side = min(rng.uniform(0.32, 0.46), x1 - x0, item.size[2] - z + 0.04)
        if side < 0.2:
            return
        x = rng.choice([x0 + side / 2, x1 - side / 2, rng.uniform(x0 + side / 2, x1 - side / 2)])
        mesh = shapes.pillow(side, side, 0.13)
        lean = shapes.rotation("x", math.radians(rng.uniform(68, 80)))
        spin = shapes.rotation("z", rng.uniform(-0.3, 0.3))
        at = shapes.placement((x, y - 0.2, z + side * 0.44))
        bodies.put(surface + rng.randrange(2), mesh, at @ spin @ lean @ shapes.placement((0, 0, -0.065)))


def _draw_sofa(rng: Random, style: Style, *, seats: int | None = None) -> Item:
    seats = seats or rng.choice([2, 2, 3, 3, 3, 4])
    arm = rng.choice([0.0, rng.uniform(0.08, 0.14), rng.uniform(0.15, 0.26)])
    width = seats * rng.uniform(0.58, 0.72) + 2 * arm
    depth, height = rng.uniform(0.8, 1.0), rng.uniform(0.7, 0.92)
    back = rng.uniform(0.18, 0.26)
    seat = rng.uniform(0.38, 0.46)
    inner = width / 2 - arm - 0.03
    return draft(
        (width, depth, height),
        (
            style.upholstery,
            rng.choice([style.wood, style.metal, style.dark_metal]),
            *rng.sample(_soft(style), 2),
        ),
        seats=seats,
        arm=round(arm, 3),
        back=round(back, 3),
        seat=round(seat, 3),
        leg=round(rng.choice([0.03, rng.uniform(0.08, 0.17)]), 3),
        one=rng.random() < 0.25,
        cushions=rng.choice([0, 1, 2, 3, 4, 5]),
        seed=rng.randrange(1 << 20),
        tops=[[-inner, -depth / 2 + 0.12, inner, depth / 2 - back - 0.2, seat, 1.0]],
    )


def _soft(style: Style) -> list:  # type: ignore[type-arg]
    accents = [replace(accent, kind="fabric", roughness=0.95, metallic=0.0) for accent in style.accents[:4]]
    return [style.upholstery_2, style.linen, *accents]


def _sofa(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies, rng = item.parameters, Bodies(item), Random(item.parameters["seed"])
    arm, back, seat, leg = p["arm"], p["back"], p["seat"], p["leg"]
    x, front, rear = width / 2, -depth / 2, depth / 2
    legs(bodies, 1, width, depth, leg + 0.02, 0.05, inset=0.04, round_=True)
    pad = min(0.17, (seat - leg) * 0.55)
    bodies.add(
        0,
        shapes.rounded_box(
            (-x + 0.005, front + 0.03, leg), (x - 0.005, rear - 0.005, seat - pad + 0.01), 0.02
        ),
    )
    bodies.add(
        0, shapes.rounded_box((-x + arm, rear - back * 0.55, leg), (x - arm, rear, height - 0.04), 0.05)
    )
    if arm:
        tall = seat + min(0.22, (height - seat) * 0.6)
        for side in (-1, 1):
            low, high = sorted((side * (x - arm), side * x))
            bodies.add(0, shapes.rounded_box((low, front, leg), (high, rear, tall), min(0.05, arm / 2.2)))
    count = 1 if p["one"] else p["seats"]
    wide = (width - 2 * arm) / count
    for i in range(count):
        a = -x + arm + i * wide
        bodies.add(
            0,
            shapes.rounded_box(
                (a + 0.004, front + 0.01, seat - pad),
                (a + wide - 0.004, rear - back * 0.9, seat - 0.012),
                0.045,
                puff=0.012,
                middle=4,
            ),
        )
        lean = shapes.rotation("x", math.radians(-8))
        tall = height - seat - 0.015
        cushion = shapes.rounded_box(
            (-wide / 2 + 0.006, -back * 0.28, 0.0),
            (wide / 2 - 0.006, back * 0.28, tall),
            0.06,
            puff=0.02,
            middle=4,
        )
        bodies.put(0, cushion, shapes.placement((a + wide / 2, rear - back * 0.72, seat - 0.02)) @ lean)
    _cushions(bodies, 2, item, rng, -x + arm, x - arm, rear - back, seat)
    return bodies.parts()


def _draw_armchair(rng: Random, style: Style) -> Item:
    item = _draw_sofa(rng, style, seats=1)
    width = max(item.size[0], 0.66)
    parameters = item.parameters | {"cushions": rng.choice([0, 0, 1]), "one": True}
    second = rng.random() < 0.4
    surfaces = ((style.upholstery_2 if second else style.upholstery), *item.surfaces[1:])
    return replace(
        item,
        kind="armchair",
        size=(width, item.size[1], item.size[2]),
        surfaces=surfaces,
        parameters=parameters,
    )


def _draw_chair(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.4, 0.5), rng.uniform(0.44, 0.54), rng.uniform(0.78, 0.98))
    padded = rng.random() < 0.4
    return draft(
        size,
        (style.wood if rng.random() < 0.7 else style.wood_2, style.upholstery_2 if padded else style.wood),
        seat=round(rng.uniform(0.43, 0.47), 3),
        back=rng.choice(["slats", "ladder", "board", "frame"]),
        leg=round(rng.uniform(0.028, 0.042), 3),
        padded=padded,
        stretcher=rng.random() < 0.5,
    )


def _chair(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    seat, leg = p["seat"], p["leg"]
    x, y = width / 2 - leg / 2, depth / 2 - leg / 2
    for side in (-1, 1):
        bodies.bars(0, [((side * x, -y, 0.0), (side * x, -y, seat - 0.02))], leg / 2)
        post = np.array([(side * x, y, 0.0), (side * x, y - 0.05, seat), (side * x, y, height - leg / 2)])
        bodies.add(0, shapes.tube(post, leg / 2))
    thick = 0.055 if p["padded"] else 0.022
    bodies.add(
        1,
        shapes.rounded_box(
            (-width / 2, -depth / 2, seat - 0.02),
            (width / 2, depth / 2 - 0.04, seat - 0.02 + thick),
            thick * 0.42,
        ),
    )
    bodies.box(0, (-x, -y - 0.01, seat - 0.07), (x, -y + 0.01, seat - 0.02))
    for side in (-1, 1):
        bodies.box(0, (side * x - 0.01, -y, seat - 0.07), (side * x + 0.01, y - 0.05, seat - 0.02))
    if p["stretcher"]:
        for side in (-1, 1):
            bodies.bars(0, [((side * x, -y, 0.18), (side * x, y - 0.02, 0.18))], leg / 3)
        bodies.bars(0, [((-x, 0.0, 0.18), (x, 0.0, 0.18))], leg / 3)

    def behind(z: float) -> float:
        return float(y - 0.05 * (1 - (z - seat) / (height - seat)))

    top = height - 0.012
    bodies.box(0, (-x, y - 0.015, top - 0.07), (x, y + 0.012, top))
    if p["back"] == "slats":
        for i in range(5):
            at = -x + (i + 1) * 2 * x / 6
            bodies.bars(
                0, [((at, behind(seat + 0.02), seat + 0.02), (at, behind(top - 0.05), top - 0.05))], 0.009
            )
    elif p["back"] == "ladder":
        for share in (0.25, 0.52, 0.78):
            z = seat + share * (height - seat)
            bodies.box(0, (-x, behind(z) - 0.01, z), (x, behind(z) + 0.008, z + 0.045))
    elif p["back"] == "board":
        low = seat + 0.16
        bodies.box(1, (-x, behind(low) - 0.012, low), (x, behind(low) + 0.02, top))
    return bodies.parts()


def _draw_shell(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.46, 0.56), rng.uniform(0.5, 0.58), rng.uniform(0.76, 0.86))
    shell = rng.choice([style.plastic, style.ceramic, *style.accents[:2], style.upholstery_2])
    return draft(
        size,
        (rng.choice([style.wood, style.metal, style.dark_metal]), shell),
        seat=round(rng.uniform(0.43, 0.46), 3),
        splay=round(rng.uniform(0.05, 0.11), 3),
    )


def shell(width: float, depth: float, seat: float, height: float, arms: float = 0.1) -> Mesh:
    """The moulded seat of a chair, from its front edge over the seat up the back: two skins."""
    along = np.linspace(0, 1, 15)
    across = np.linspace(-1, 1, 11)
    # Side view: a seat that sinks a little, a bend, a back that leans.
    front, rear = -depth / 2, depth / 2
    y = np.interp(
        along, [0, 0.08, 0.5, 0.62, 1.0], [front, front + 0.04, rear - 0.14, rear - 0.08, rear - 0.012]
    )
    z = np.interp(along, [0, 0.08, 0.5, 0.62, 1.0], [seat - 0.025, seat, seat - 0.015, seat + 0.05, height])
    half = np.interp(along, [0, 0.3, 0.62, 0.85, 1.0], [0.42, 0.5, 0.5, 0.44, 0.3]) * width
    points = np.empty((15, 11, 3))
    points[..., 0] = half[:, None] * across
    lift = np.abs(across) ** 3
    points[..., 1] = y[:, None] - arms * 0.9 * lift * np.clip((along - 0.5) * 3, 0, 1)[:, None] * 0.7
    points[..., 2] = z[:, None] + arms * lift * np.clip(1 - np.abs(along - 0.45) * 2.6, 0, 1)[:, None]
    top = shapes.sheet(points.transpose(1, 0, 2))
    below = points.copy()
    below[..., 2] -= 0.012 * np.clip(1.2 - along, 0, 1)[:, None]
    below[..., 1] += 0.011 * np.clip(along * 1.5 - 0.3, 0, 1)[:, None]
    return shapes.merge([top, shapes.sheet(below)])


def _shell_chair(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    seat, splay = item.parameters["seat"], item.parameters["splay"]
    bodies.add(1, shell(width, depth, seat, height))
    reach = max(min(width, depth) - 0.04, 0.3)
    legs(bodies, 0, reach, reach, seat - 0.03, 0.03, splay=splay, round_=True)
    inner = reach / 2 - splay - 0.01
    bodies.box(0, (-inner, -inner, seat - 0.05), (inner, inner, seat - 0.03))
    return bodies.parts()


def _draw_office_chair(rng: Random, style: Style) -> Item:
    arms = rng.random() < 0.6
    size = (rng.uniform(0.58, 0.68), rng.uniform(0.58, 0.66), rng.uniform(0.86, 1.2))
    cloth = rng.choice(
        [style.upholstery, style.upholstery_2, replace(style.upholstery, colour=(0.02, 0.02, 0.022))]
    )
    return draft(
        size,
        (cloth, rng.choice([style.dark_metal, style.metal])),
        seat=round(rng.uniform(0.44, 0.52), 3),
        arms=arms,
    )


def _office_chair(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, seat = Bodies(item), item.parameters["seat"]
    reach = min(width, depth) / 2
    for i in range(5):
        angle = 2 * math.pi * i / 5 + 0.3
        x, y = math.cos(angle) * (reach - 0.03), math.sin(angle) * (reach - 0.03)
        bodies.bars(1, [((x, y, 0.07), (0.0, 0.0, 0.11))], 0.016)
        bodies.add(1, shapes.sphere(0.028, centre=(x, y, 0.028), segments=10, rings=6))
    bodies.add(1, shapes.cylinder(0.028, seat - 0.14, base=(0, 0, 0.08), segments=12))
    half = width / 2 - (0.07 if item.parameters["arms"] else 0.04)
    bodies.add(
        0,
        shapes.rounded_box(
            (-half, -depth / 2 + 0.05, seat - 0.07), (half, depth / 2 - 0.1, seat), 0.03, puff=0.01, middle=4
        ),
    )
    low = seat + 0.1
    back = shapes.rounded_box(
        (-half + 0.03, -0.025, 0.0), (half - 0.03, 0.03, height - low - 0.01), 0.026, middle=2
    )
    bodies.put(0, back, shapes.placement((0, depth / 2 - 0.12, low)) @ shapes.rotation("x", -0.1))
    bodies.add(
        1,
        shapes.tube(
            np.array(
                [(0, 0.1, seat - 0.09), (0, depth / 2 - 0.06, seat - 0.09), (0, depth / 2 - 0.07, low + 0.12)]
            ),
            0.02,
        ),
    )
    if item.parameters["arms"]:
        for side in (-1, 1):
            x = side * (width / 2 - 0.03)
            bodies.add(
                1,
                shapes.tube(
                    np.array([(x * 0.7, 0, seat - 0.09), (x, 0, seat - 0.05), (x, 0, seat + 0.2)]), 0.014
                ),
            )
            bodies.box(1, (x - 0.028, -0.14, seat + 0.2), (x + 0.028, 0.12, seat + 0.23))
    return bodies.parts()


def _draw_stool(rng: Random, style: Style, kind: str = "stool") -> Item:
    high = kind == "bar_stool"
    height = rng.uniform(0.62, 0.8) if high else rng.uniform(0.42, 0.48)
    side = rng.uniform(0.32, 0.42)
    return draft(
        (side, side, height),
        (
            rng.choice([style.wood, style.metal, style.dark_metal]),
            rng.choice([style.wood, style.upholstery_2, style.plastic]),
        ),
        round=rng.random() < 0.6,
        splay=round(rng.uniform(0.0, 0.06), 3),
        soft=rng.random() < 0.4,
    )


def _stool(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    thick = 0.06 if p["soft"] else 0.03
    if p["round"]:
        radius = min(width, depth) / 2
        profile = np.array(
            [
                (radius * 0.92, height - thick),
                (radius, height - thick * 0.6),
                (radius, height - thick * 0.3),
                (radius * 0.9, height),
            ]
        )
        bodies.add(1, shapes.lathe(profile, crease=1.0))
    else:
        bodies.add(
            1,
            shapes.rounded_box(
                (-width / 2, -depth / 2, height - thick), (width / 2, depth / 2, height), thick * 0.35
            ),
        )
    legs(bodies, 0, width * 0.86, depth * 0.86, height - thick, 0.03, splay=p["splay"], round_=True)
    if height > 0.55:
        z, s = 0.22, width * 0.43 - p["splay"] * 0.3 - 0.01
        bodies.bars(
            0,
            [
                ((-s, -s, z), (s, -s, z)),
                ((-s, s, z), (s, s, z)),
                ((-s, -s, z), (-s, s, z)),
                ((s, -s, z), (s, s, z)),
            ],
            0.01,
        )
    return bodies.parts()


def _draw_bench(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.9, 1.6), rng.uniform(0.32, 0.45), rng.uniform(0.42, 0.48))
    return draft(size, (style.wood, style.upholstery_2), soft=rng.random() < 0.4)


def _bench(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    thick = 0.08 if item.parameters["soft"] else 0.035
    if item.parameters["soft"]:
        bodies.add(
            1,
            shapes.rounded_box(
                (-width / 2, -depth / 2, height - thick), (width / 2, depth / 2, height), 0.03
            ),
        )
    else:
        bodies.box(0, (-width / 2, -depth / 2, height - thick), (width / 2, depth / 2, height))
    legs(bodies, 0, width, depth, height - thick, 0.05, inset=0.03)
    return bodies.parts()


def _draw_ottoman(rng: Random, style: Style) -> Item:
    side = rng.uniform(0.42, 0.75)
    size = (side, side * rng.uniform(0.75, 1.0), rng.uniform(0.34, 0.45))
    return draft(
        size, (rng.choice([style.upholstery, style.upholstery_2]), style.wood), round=rng.random() < 0.4
    )


def _ottoman(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    if item.parameters["round"]:
        r = min(width, depth) / 2
        profile = np.array(
            [(r * 0.9, 0.0), (r, 0.06), (r, height - 0.08), (r * 0.93, height - 0.02), (0.0, height)]
        )
        bodies.put(
            0, shapes.lathe(profile, crease=1.2), shapes.placement(scale=(width / 2 / r, depth / 2 / r, 1))
        )
    else:
        legs(bodies, 1, width, depth, 0.08, 0.04, inset=0.03, round_=True)
        bodies.add(
            0,
            shapes.rounded_box(
                (-width / 2, -depth / 2, 0.07),
                (width / 2, depth / 2, height - 0.01),
                0.05,
                puff=0.01,
                middle=4,
            ),
        )
    return bodies.parts()


PIECES = (
    Piece("sofa", "sofa", _draw_sofa, _sofa),
    Piece("armchair", "armchair", _draw_armchair, _sofa),
    Piece("chair_wood", "chair", _draw_chair, _chair, 2.0),
    Piece("chair_shell", "chair", _draw_shell, _shell_chair, 1.0),
    Piece("office_chair", "office_chair", _draw_office_chair, _office_chair),
    Piece("stool", "stool", _draw_stool, _stool),
    Piece("bar_stool", "bar_stool", lambda rng, style: _draw_stool(rng, style, "bar_stool"), _stool),
    Piece("bench", "bench", _draw_bench, _bench),
    Piece("ottoman", "ottoman", _draw_ottoman, _ottoman),
)
