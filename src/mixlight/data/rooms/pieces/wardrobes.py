"""Cupboards, chests of drawers, lockers, rails with clothes, shoe racks, coat stands."""

from __future__ import annotations

from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.contents import clothes_on_hangers, fill
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.seating import legs
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.pieces.tables import drawers
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES", "hanging_cloth", "shoe_pair"]


def _cupboard(item: Item) -> list[Part]:
    """Carcass with doors or drawers on legs or a plinth."""
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    x, y, foot = width / 2, depth / 2, p["foot"]
    if foot > 0.09:
        legs(bodies, 1, width, depth, foot, 0.04, inset=0.04, round_=True)
    else:
        bodies.box(0, (-x + 0.01, -y + 0.06, 0.0), (x - 0.01, y - 0.01, foot))
    top = 0.022
    a = -x
    for share, rows, columns, doors in p["fronts"]:
        b = a + share * width
        drawers(bodies, 2, 1, a, b, -y + 0.022, y, foot, height - top, rows, columns=columns, doors=doors)
        a = b
    bodies.box(0, (-x, -y + 0.012, height - top), (x, y, height))
    return bodies.parts()


def _draw_cupboard(rng: Random, style: Style, kind: str) -> Item:
    wood = style.wood if rng.random() < 0.75 else style.wood_2
    front = wood if rng.random() < 0.7 else style.front
    foot = rng.choice([0.05, rng.uniform(0.1, 0.2)])
    fronts: list[list[float | int | bool]]
    if kind == "sideboard":
        size = (rng.uniform(1.2, 2.0), rng.uniform(0.38, 0.48), rng.uniform(0.65, 0.9))
        fronts = rng.choice(
            [
                [[0.5, 1, 2, True], [0.5, 3, 1, False]],
                [[1.0, 1, 4, True]],
                [[1 / 3, 1, 1, True], [1 / 3, 3, 1, False], [1 / 3, 1, 1, True]],
            ]
        )
    elif kind == "dresser":
        size = (rng.uniform(0.7, 1.5), rng.uniform(0.42, 0.52), rng.uniform(0.75, 1.2))
        fronts = [[1.0, rng.choice([3, 4, 5]), 1 if size[0] < 1.0 else 2, False]]
    elif kind == "nightstand":
        size = (rng.uniform(0.38, 0.55), rng.uniform(0.35, 0.45), rng.uniform(0.42, 0.6))
        fronts = [[1.0, rng.choice([1, 2, 2, 3]), 1, False]]
    elif kind == "tv_stand":
        size = (rng.uniform(1.2, 2.0), rng.uniform(0.38, 0.46), rng.uniform(0.35, 0.55))
        fronts = rng.choice([[[1.0, 1, 3, False]], [[0.5, 1, 2, True], [0.5, 2, 1, False]]])
    elif kind == "cabinet":
        size = (rng.uniform(0.8, 1.2), rng.uniform(0.4, 0.6), rng.uniform(1.3, 2.0))
        fronts = [[1.0, rng.choice([1, 2]), 2, True]]
    else:  # a wardrobe
        columns = rng.choice([2, 3, 4, 4])
        size = (columns * rng.uniform(0.46, 0.58), rng.uniform(0.56, 0.65), rng.uniform(1.95, 2.35))
        fronts = [[1.0, 1, columns, True]]
        foot = rng.choice([0.05, 0.08])
    return draft(size, (wood, style.metal, front), fronts=fronts, foot=round(foot, 3))


def _draw_filing(rng: Random, style: Style) -> Item:
    rows = rng.choice([2, 3, 4])
    body = rng.choice([style.front, style.metal, style.plastic])
    return draft(
        (0.42, rng.uniform(0.5, 0.65), rows * 0.32 + 0.06),
        (body, style.metal, body),
        fronts=[[1.0, rows, 1, False]],
        foot=0.03,
    )


def _draw_drawer_unit(rng: Random, style: Style) -> Item:
    body = rng.choice([style.front, style.plastic, style.wood])
    return draft(
        (0.42, rng.uniform(0.45, 0.58), rng.uniform(0.52, 0.62)),
        (body, style.metal, body),
        fronts=[[1.0, 3, 1, False]],
        foot=0.05,
    )


def _draw_locker(rng: Random, style: Style) -> Item:
    columns, rows = rng.choice([3, 4, 5, 6]), rng.choice([1, 2, 4])
    body = rng.choice([style.front, style.metal, *style.accents[:2]])
    return draft(
        (columns * 0.3, 0.5, rng.uniform(1.75, 1.95)),
        (body, style.metal, body),
        fronts=[[1.0, rows, columns, True]],
        foot=0.07,
    )


def _draw_open_wardrobe(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.9, 1.8), rng.uniform(0.45, 0.58), rng.uniform(1.5, 1.9))
    return draft(
        size, (style.metal, *_cloths(rng, style)), seed=rng.randrange(1 << 20), shelf=rng.random() < 0.6
    )


def _cloths(rng: Random, style: Style) -> tuple[Surface, ...]:
    found = [style.upholstery, style.upholstery_2, style.linen]
    found += [Surface("fabric", surface.colour, roughness=0.95) for surface in rng.sample(style.books, 4)]
    return tuple(found)


def _rail(item: Item) -> list[Part]:
    """A rail on two posts with clothes on it."""
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2 - 0.02, depth / 2 - 0.02
    for side in (-1, 1):
        bodies.bars(
            0,
            [
                ((side * x, 0, 0.02), (side * x, 0, height - 0.015)),
                ((side * x, -y, 0.02), (side * x, y, 0.02)),
            ],
            0.014,
        )
    bodies.bars(0, [((-x, 0, height - 0.015), (x, 0, height - 0.015)), ((-x, 0, 0.2), (x, 0, 0.2))], 0.013)
    colours = range(1, len(item.surfaces))
    end = x - 0.05 if rng.random() < 0.5 else x * rng.uniform(0.1, 0.9)
    clothes_on_hangers(
        bodies,
        rng,
        -x + 0.05,
        end,
        0.0,
        height - 0.02,
        min(1.15, height - 0.35),
        colours,
        deep=min(0.5, depth - 0.02),
    )
    if item.parameters["shelf"]:
        bodies.box(0, (-x, -y * 0.7, 0.195), (x, y * 0.7, 0.205))
        fill(bodies, rng, rng.choice(["boxes", "folded"]), -x, x, -y * 0.65, y * 0.65, 0.206, 0.28, colours)
    return bodies.parts()


def _draw_shoe_rack(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.6, 1.0), 0.32, rng.uniform(0.45, 0.8))
    return draft(
        size,
        (rng.choice([style.wood, style.metal]), *rng.sample(style.books, 4), style.dark_metal),
        seed=rng.randrange(1 << 20),
    )


def _shoe_rack(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    for side in (-1, 1):
        a, b = sorted((side * x, side * (x - 0.02)))
        bodies.box(0, (a, -y, 0.0), (b, y, height))
    bodies.box(0, (-x + 0.02, -y, height - 0.018), (x - 0.02, y, height))
    rows = max(2, int(height / 0.22))
    for row in range(rows):
        z = 0.06 + row * (height - 0.1) / rows
        bodies.box(0, (-x + 0.02, -y, z), (x - 0.02, y, z + 0.015))
        at = -x + 0.04
        while at + 0.2 < x - 0.02:
            if rng.random() < 0.8:
                shoe_pair(bodies, rng, at + 0.1, 0.0, z + 0.015, rng.randrange(1, len(item.surfaces)))
            at += 0.23
    return bodies.parts()


def shoe_pair(bodies: Bodies, rng: Random, x: float, y: float, z: float, surface: int) -> None:
    """Two shoes with their tips towards -Y."""
    for side in (-1, 1):
        tip = [(0.0, 0.032, 0.02), (0.09, 0.044, 0.045), (0.17, 0.036, 0.07), (0.265, 0.03, 0.08)]
        rings = []
        for at, half, tall in tip:
            angles = np.linspace(0, 2 * np.pi, 9)[:-1]
            ring = np.stack((half * np.cos(angles), np.full(8, at), tall / 2 + tall / 2 * np.sin(angles)), -1)
            rings.append(ring)
        mesh = shapes.loft(np.stack(rings)[:, ::-1], caps=True)
        bodies.put(surface, mesh, shapes.placement((x + side * 0.05, y - 0.13, z), rng.uniform(-0.1, 0.1)))


def _draw_coat_stand(rng: Random, style: Style) -> Item:
    return draft(
        (0.55, 0.55, rng.uniform(1.65, 1.85)),
        (rng.choice([style.wood, style.metal, style.dark_metal]), *_cloths(rng, style)),
        seed=rng.randrange(1 << 20),
        coats=rng.choice([0, 1, 2, 3, 4]),
    )


def hanging_cloth(
    bodies: Bodies,
    rng: Random,
    x: float,
    y: float,
    z: float,
    length: float,
    width: float,
    surface: int,
    *,
    deep: float = 0.1,
) -> None:
    """A coat or bag that hangs from a point, wider below, with folds."""
    angles = np.linspace(0, 2 * np.pi, 17)[:-1]
    phase, folds = rng.uniform(0, 6), rng.choice([3, 4, 5])
    rings = []
    for share in (1.0, 0.7, 0.35, 0.12, 0.0):
        grow = 0.25 + 0.75 * min(1.0, share * 2.2)
        ripple = 1 + 0.18 * share * np.sin(folds * angles + phase)
        rings.append(
            np.stack(
                (
                    x + width / 2 * grow * ripple * np.cos(angles),
                    y + deep / 2 * grow * ripple * np.sin(angles),
                    np.full(16, z - length * share),
                ),
                -1,
            )
        )
    bodies.add(surface, shapes.loft(np.stack(rings), caps=True))


def _coat_stand(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    r = width / 2
    bodies.add(0, shapes.cylinder(0.018, height, segments=10))
    for i in range(4):
        c, s = np.cos(i * np.pi / 2 + 0.4), np.sin(i * np.pi / 2 + 0.4)
        bodies.bars(
            0,
            [
                ((c * (r - 0.02), s * (r - 0.02), 0.015), (0, 0, 0.22)),
                ((0, 0, height - 0.22), (c * 0.14, s * 0.14, height - 0.08)),
            ],
            0.013,
        )
    for i in range(item.parameters["coats"]):
        c, s = np.cos(i * np.pi / 2 + 0.4), np.sin(i * np.pi / 2 + 0.4)
        hanging_cloth(
            bodies,
            rng,
            c * 0.13,
            s * 0.13,
            height - 0.1,
            rng.uniform(0.6, 1.1),
            0.26,
            rng.randrange(1, len(item.surfaces)),
            deep=0.2,
        )
    return bodies.parts()


PIECES = (
    *(
        Piece(kind, kind, lambda rng, style, kind=kind: _draw_cupboard(rng, style, kind), _cupboard)  # type: ignore[misc]
        for kind in ("sideboard", "dresser", "nightstand", "tv_stand", "cabinet", "wardrobe")
    ),
    Piece("filing_cabinet", "filing_cabinet", _draw_filing, _cupboard),
    Piece("drawer_unit", "drawer_unit", _draw_drawer_unit, _cupboard),
    Piece("locker", "locker", _draw_locker, _cupboard),
    Piece("clothes_rail", "clothes_rack", _draw_open_wardrobe, _rail),
    Piece("shoe_rack", "shoe_rack", _draw_shoe_rack, _shoe_rack),
    Piece("coat_stand", "coat_stand", _draw_coat_stand, _coat_stand),
)
