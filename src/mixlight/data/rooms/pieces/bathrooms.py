"""Toilets, basins, baths, showers."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.pieces.kitchens import faucet, sink
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.pieces.tables import drawers
from mixlight.data.rooms.plan import Item

__all__ = ["PIECES", "bowl"]


def bowl(width: float, depth: float, height: float, wall: float, deep: float) -> Mesh:
    """A basin of elliptic plan that stands on z = 0: outside, rim and inside, open above."""
    steps = np.linspace(0, math.pi / 2, 6)
    outside = [(0.5 + 0.5 * math.sin(t), height * (1 - math.cos(t))) for t in steps]
    outside[-1] = (1.0, height - 0.01)
    share = 1 - 2 * wall / min(width, depth)
    inside = [(share * math.cos(t), height - deep * math.sin(t)) for t in steps]
    profile = np.array([*outside, (0.995, height), (share + 0.004, height), *inside])
    profile[-1, 0] = 0.0
    return shapes.transform(
        shapes.lathe(profile, segments=32, crease=1.2), shapes.placement(scale=(width / 2, depth / 2, 1))
    )


def _draw_toilet(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.36, 0.4), rng.uniform(0.6, 0.7), rng.uniform(0.76, 0.82)),
        (style.ceramic, style.metal),
        lid=rng.random() < 0.75,
        tops=[[-0.17, 0.17, 0.17, 0.3, 0.78, 0.5]],
    )


def _toilet(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, seat = width / 2, depth / 2, 0.4
    tank = 0.19
    bodies.add(0, shapes.rounded_box((-x, y - tank, seat), (x, y, height), 0.025))
    bodies.box(1, (-0.03, y - tank / 2 - 0.02, height - 0.002), (0.03, y - tank / 2 + 0.02, height + 0.004))
    long = depth - tank + 0.06
    middle = -y + long / 2
    outer = shapes.lathe(
        np.array([(0.62, 0.0), (0.6, 0.12), (0.72, 0.26), (0.96, 0.36), (1.0, 0.385)]),
        segments=28,
        caps=False,
    )
    bodies.put(0, outer, shapes.placement((0, middle, 0), 0, (x * 0.98, long / 2, seat / 0.4)))
    bodies.box(0, (-x * 0.55, middle, 0.0), (x * 0.55, y - 0.02, seat))
    if item.parameters["lid"]:
        lid = shapes.lathe(
            np.array([(0.98, 0.0), (1.0, 0.01), (0.97, 0.03), (0.0, 0.035)]), segments=28, crease=1.0
        )
    else:
        lid = shapes.lathe(
            np.array([(0.62, 0.0), (1.0, 0.0), (0.98, 0.025), (0.62, 0.025), (0.62, 0.0)]),
            segments=28,
            caps=False,
        )
        up = shapes.rounded_box((-x * 0.95, -0.02, 0.0), (x * 0.95, 0.01, 0.36), 0.01)
        bodies.put(0, up, shapes.placement((0, y - tank - 0.025, seat + 0.02)))
        bodies.put(
            0,
            shapes.lathe(np.array([(0.64, 0.02), (0.5, -0.06), (0.0, -0.1)]), segments=28, caps=False),
            shapes.placement((0, middle, seat), 0, (x, long / 2, 1)),
        )
    bodies.put(0, lid, shapes.placement((0, middle, seat - 0.012), 0, (x * 0.97, long / 2, 1)))
    return bodies.parts()


def _draw_basin(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.45, 0.65), rng.uniform(0.4, 0.5), 0.86 + 0.14),
        (style.ceramic, style.metal),
        column=rng.random() < 0.7,
    )


def _basin(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    top, y = height - 0.14, depth / 2
    bodies.put(0, bowl(width, depth * 0.98, 0.2, 0.03, 0.15), shapes.placement((0, 0, top - 0.2)))
    bodies.box(0, (-width * 0.4, y - 0.14, top - 0.1), (width * 0.4, y, top))
    if item.parameters["column"]:
        profile = np.array([(0.12, 0.0), (0.09, 0.05), (0.075, 0.4), (0.1, top - 0.18)])
        bodies.put(0, shapes.lathe(profile, segments=20), shapes.placement((0, y - 0.14, 0)))
    else:
        bodies.bars(
            1,
            [
                ((0, y - 0.14, top - 0.45), (0, y - 0.14, top - 0.18)),
                ((0, y - 0.14, top - 0.45), (0, y, top - 0.45)),
            ],
            0.018,
        )
    faucet(bodies, 1, 0.0, y - 0.07, top, 0.13, 0.11)
    return bodies.parts()


def _draw_vanity(rng: Random, style: Style) -> Item:
    width = rng.choice([0.6, 0.8, 1.0, 1.2, 1.4])
    height = rng.uniform(0.82, 0.9)
    reach = width / 2 - 0.02
    basin = 0.23
    y = 0.24
    tops = [
        [-reach, -y + 0.03, -basin - 0.02, y - 0.02, height, 0.5],
        [basin + 0.02, -y + 0.03, reach, y - 0.02, height, 0.5],
    ]
    return draft(
        (width, 0.48, height + 0.15),
        (
            rng.choice([style.front, style.wood]),
            rng.choice([style.counter, style.ceramic]),
            style.metal,
            style.ceramic,
        ),
        top=round(height, 3),
        above=rng.random() < 0.4,
        columns=1 if width < 0.7 else 2,
        drawers=rng.random() < 0.5,
        foot=round(rng.choice([0.25, 0.08]), 3),
        tops=[[round(v, 3) for v in t] for t in tops if t[2] - t[0] > 0.06],
    )


def _vanity(item: Item) -> list[Part]:
    width, depth, _ = item.size
    p, bodies = item.parameters, Bodies(item)
    x, y, top = width / 2, depth / 2, p["top"]
    drawers(
        bodies,
        0,
        2,
        -x,
        x,
        -y + 0.024,
        y,
        p["foot"],
        top - 0.03,
        2 if p["drawers"] else 1,
        columns=p["columns"],
        doors=not p["drawers"],
    )
    if p["above"]:
        bodies.box(1, (-x, -y, top - 0.03), (x, y, top))
        bodies.put(3, bowl(0.42, 0.36, 0.12, 0.015, 0.1), shapes.placement((0, -0.02, top)))
        faucet(bodies, 2, 0.0, y - 0.05, top, 0.15, 0.12)
    else:
        c, front, rear = 0.21, -y + 0.06, y - 0.13
        for lo, hi in (((-x, -y), (-c, y)), ((c, -y), (x, y)), ((-c, -y), (c, front)), ((-c, rear), (c, y))):
            bodies.box(1, (*lo, top - 0.03), (*hi, top))
        sink(bodies, 3, -c, c, front, rear, top - 0.13, top + 0.003)
        faucet(bodies, 2, 0.0, y - 0.07, top, 0.14, 0.11)
    return bodies.parts()


def _draw_bath(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(1.5, 1.8), rng.uniform(0.7, 0.8), rng.uniform(0.54, 0.62)),
        (style.ceramic, rng.choice([style.ceramic, style.front, style.ceramic]), style.metal),
        screen=rng.random() < 0.3,
        tops=[[-0.7, 0.29, 0.4, 0.345, 0.56, 0.5]],
    )


def _bath(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, rim = width / 2, depth / 2, 0.065
    bodies.box(1, (-x + 0.01, -y + 0.015, 0.0), (x - 0.01, y, height - 0.04))
    rings = []
    angles = np.linspace(0, 2 * math.pi, 41)[:-1]
    c, s = np.cos(angles), np.sin(angles)
    for share, z in (
        (1.0, height),
        (0.97, height - 0.03),
        (0.88, height - 0.25),
        (0.76, height - 0.4),
        (0.6, height - 0.42),
        (0.0, height - 0.42),
    ):
        a, b, n = (x - rim) * share, (y - rim) * share, 5.0
        scale = 1 / np.maximum((np.abs(c) ** n + np.abs(s) ** n) ** (1 / n), 1e-9)
        rings.append(np.stack((a * c * scale, b * s * scale, np.full(40, z)), -1))
    # Going down on the inside: the outside of this skin is towards the water.
    bodies.add(0, shapes.loft(np.stack(rings)))
    outer = np.stack((np.clip(1.6 * x * c, -x, x), np.clip(1.6 * y * s, -y, y), np.full(40, height)), -1)
    bodies.add(0, shapes.loft(np.stack((outer, rings[0])), smooth=False))
    skirt = outer.copy()
    skirt[:, 2] = height - 0.045
    bodies.add(0, shapes.loft(np.stack((skirt, outer)), smooth=False))
    bodies.box(1, (-x + 0.02, -y + 0.03, 0.02), (x - 0.02, y - 0.02, height - 0.44))
    tap = -x + 0.25
    bodies.bars(
        2,
        [
            ((tap, y - 0.0, height + 0.12), (tap, y - 0.09, height + 0.12)),
            ((tap - 0.08, y - 0.04, height + 0.12), (tap + 0.08, y - 0.04, height + 0.12)),
        ],
        0.014,
    )
    return bodies.parts()


def _draw_shower(rng: Random, style: Style) -> Item:
    side = rng.uniform(0.8, 1.0)
    return draft(
        (side, rng.choice([side, 0.8]), rng.uniform(1.95, 2.1)),
        (style.ceramic, style.glass, style.metal),
        tray=round(rng.choice([0.03, 0.12]), 3),
        side=rng.choice([-1, 1]),
    )


def _shower(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, tray, side = width / 2, depth / 2, item.parameters["tray"], item.parameters["side"]
    bodies.box(0, (-x, -y, 0.0), (x, y, tray))
    # Glass before it and on the side that stands free; both sheets are one pane each.
    bodies.add(
        1,
        shapes.panel(
            (-x + 0.03, -y + 0.012, tray + 0.02), (width - 0.06, 0, 0), (0, 0, height - tray - 0.05)
        ),
    )
    bodies.add(
        1,
        shapes.panel(
            (side * (x - 0.012), side * (-y + 0.03), tray + 0.02),
            (0, side * (depth - 0.06), 0),
            (0, 0, height - tray - 0.05),
        ),
    )
    for z in (tray, height - 0.03):
        bodies.box(2, (-x, -y, z), (x, -y + 0.025, z + 0.03))
        a, b = sorted((side * x, side * (x - 0.025)))
        bodies.box(2, (a, -y, z), (b, y, z + 0.03))
    for at in (-x, x - 0.025):
        bodies.box(2, (at, -y, tray), (at + 0.025, -y + 0.025, height))
    bodies.bars(
        2,
        [
            ((0.0, y - 0.05, 1.0), (0.0, y - 0.05, height - 0.05)),
            ((0.0, y - 0.05, height - 0.06), (0.0, y - 0.3, height - 0.08)),
        ],
        0.009,
    )
    bodies.put(2, shapes.cylinder(0.09, 0.015, segments=20), shapes.placement((0.0, y - 0.3, height - 0.1)))
    bodies.bars(2, [((-0.1, y - 0.05, 1.05), (0.1, y - 0.05, 1.05))], 0.02)
    return bodies.parts()


def _draw_paper_roll(rng: Random, style: Style) -> Item:
    return draft((0.14, 0.12, 0.13), (style.metal, style.paper))


def _paper_roll(item: Item) -> list[Part]:
    bodies = Bodies(item)
    across = shapes.rotation("y", math.pi / 2)
    bodies.put(1, shapes.cylinder(0.052, 0.1, segments=20), shapes.placement((-0.05, -0.005, 0.058)) @ across)
    bodies.bars(
        0,
        [((-0.068, -0.005, 0.06), (0.068, -0.005, 0.06)), ((0.066, -0.005, 0.06), (0.066, 0.06, 0.06))],
        0.005,
    )
    bodies.box(0, (-0.07, 0.052, 0.03), (0.07, 0.06, 0.09))
    return bodies.parts()


PIECES = (
    Piece("toilet", "toilet", _draw_toilet, _toilet),
    Piece("basin", "basin", _draw_basin, _basin),
    Piece("vanity", "vanity", _draw_vanity, _vanity),
    Piece("bath", "bath", _draw_bath, _bath),
    Piece("shower", "shower", _draw_shower, _shower),
    Piece("paper_roll", "paper_roll", _draw_paper_roll, _paper_roll),
)
