"""Tables of every height, desks, counters of shops, workbenches."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.seating import legs
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.plan import Item, Point3

__all__ = ["PIECES"]


def _table(rng: Random, style: Style, kind: str, size: Point3, *, shelf: float = 0.0) -> Item:
    """A rectangular table: a top on legs, trestles, panels or a frame."""
    wood = style.wood if rng.random() < 0.7 else style.wood_2
    under = rng.choice([wood, wood, style.metal, style.dark_metal])
    top = wood if rng.random() < 0.9 or kind == "desk" else style.glass
    return draft(
        size,
        (top, under),
        base=rng.choice(
            ["legs", "legs", "splayed", "frame", "panels"] if top.kind != "glass" else ["frame", "legs"]
        ),
        thick=round(rng.uniform(0.018, 0.045), 3),
        leg=round(rng.uniform(0.035, 0.075), 3),
        apron=rng.random() < 0.6 and top.kind != "glass",
        shelf=shelf if rng.random() < 0.5 else 0.0,
    )


def _build_table(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    x, y, thick, leg = width / 2, depth / 2, p["thick"], p["leg"]
    bodies.box(0, (-x, -y, height - thick), (x, y, height))
    under = height - thick
    if p["base"] == "panels":
        for side in (-1, 1):
            a, b = sorted((side * (x - 0.03), side * (x - 0.055)))
            bodies.box(1, (a, -y + 0.02, 0.0), (b, y - 0.02, under))
        bodies.box(1, (-x + 0.05, y - 0.06, under * 0.45), (x - 0.05, y - 0.04, under))
    elif p["base"] == "frame":
        t = min(leg, 0.05)
        for side in (-1, 1):
            a, b = sorted((side * (x - 0.04), side * (x - 0.04 - t)))
            bodies.box(1, (a, -y + 0.03, 0.0), (b, -y + 0.03 + t, under))
            bodies.box(1, (a, y - 0.03 - t, 0.0), (b, y - 0.03, under))
            bodies.box(1, (a, -y + 0.03 + t, 0.0), (b, y - 0.03 - t, t))
            bodies.box(1, (a, -y + 0.03 + t, under - t), (b, y - 0.03 - t, under))
    else:
        splay = 0.09 if p["base"] == "splayed" else 0.0
        legs(bodies, 1, width, depth, under, leg, inset=0.03 if not splay else 0.01, splay=splay)
    if p["apron"] and p["base"] in ("legs", "splayed"):
        inset = 0.03 + leg / 2 + (0.06 if p["base"] == "splayed" else 0.0)
        drop = min(0.09, height * 0.2)
        for side in (-1, 1):
            bodies.box(
                0,
                (-x + inset, side * (y - inset) - 0.01, under - drop),
                (x - inset, side * (y - inset) + 0.01, under),
            )
            bodies.box(
                0,
                (side * (x - inset) - 0.01, -y + inset, under - drop),
                (side * (x - inset) + 0.01, y - inset, under),
            )
    if p["shelf"]:
        inset = 0.045
        bodies.box(0, (-x + inset, -y + inset, p["shelf"]), (x - inset, y - inset, p["shelf"] + 0.018))
    return bodies.parts()


def _draw_table(rng: Random, style: Style) -> Item:
    seats = rng.choice([2, 4, 4, 6, 6, 8])
    width = {
        2: rng.uniform(0.7, 0.9),
        4: rng.uniform(1.1, 1.4),
        6: rng.uniform(1.5, 1.9),
        8: rng.uniform(2.0, 2.5),
    }
    return _table(rng, style, "table", (width[seats], rng.uniform(0.7, 1.0), rng.uniform(0.72, 0.77)))


def _draw_coffee_table(rng: Random, style: Style) -> Item:
    height = rng.uniform(0.34, 0.48)
    return _table(
        rng,
        style,
        "coffee_table",
        (rng.uniform(0.8, 1.3), rng.uniform(0.45, 0.75), height),
        shelf=round(height * 0.35, 3),
    )


def _draw_console(rng: Random, style: Style) -> Item:
    return _table(
        rng,
        style,
        "console",
        (rng.uniform(0.8, 1.3), rng.uniform(0.28, 0.4), rng.uniform(0.74, 0.9)),
        shelf=0.2,
    )


def _draw_display_table(rng: Random, style: Style) -> Item:
    return _table(
        rng,
        style,
        "display_table",
        (rng.uniform(1.0, 1.8), rng.uniform(0.7, 1.1), rng.uniform(0.6, 0.9)),
        shelf=0.25,
    )


def _draw_bar_table(rng: Random, style: Style) -> Item:
    return _table(
        rng, style, "bar_table", (rng.uniform(0.6, 1.4), rng.uniform(0.5, 0.7), rng.uniform(1.0, 1.1))
    )


def _draw_round(rng: Random, style: Style, kind: str) -> Item:
    if kind == "round_table":
        across, height = rng.uniform(0.7, 1.3), rng.uniform(0.72, 0.77)
    elif kind == "coffee_table":
        across, height = rng.uniform(0.5, 0.95), rng.uniform(0.35, 0.48)
    else:
        across, height = rng.uniform(0.35, 0.55), rng.uniform(0.45, 0.62)
    wood = style.wood if rng.random() < 0.7 else style.wood_2
    r = across / 2 * 0.7
    return draft(
        (across, across, height),
        (
            rng.choice([wood, wood, style.counter, style.glass]),
            rng.choice([wood, style.metal, style.dark_metal]),
        ),
        base=rng.choice(["column", "legs", "legs"]),
        thick=round(rng.uniform(0.015, 0.035), 3),
        tops=[[-r, -r, r, r, round(height, 3), 1.0]],
    )


def _round_table(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    radius, thick = min(width, depth) / 2, p["thick"]
    bodies.add(0, shapes.cylinder(radius, thick, base=(0, 0, height - thick), segments=40))
    under = height - thick
    if p["base"] == "column":
        foot = radius * 0.62
        profile = np.array(
            [(foot, 0.0), (foot, 0.012), (0.05, 0.05), (0.035, 0.09), (0.035, under - 0.06), (0.09, under)]
        )
        bodies.add(1, shapes.lathe(profile, segments=24))
    else:
        count, reach = (3 if radius < 0.4 else 4), radius * 0.86
        for i in range(count):
            angle = 2 * math.pi * (i + 0.5) / count
            c, s = math.cos(angle), math.sin(angle)
            bodies.bars(
                1, [((c * reach, s * reach, 0.0), (c * reach * 0.72, s * reach * 0.72, under))], 0.016
            )
    return bodies.parts()


def _desk_size(rng: Random) -> Point3:
    return rng.uniform(1.0, 1.8), rng.uniform(0.58, 0.82), rng.uniform(0.71, 0.76)


def _draw_desk(rng: Random, style: Style) -> Item:
    size = _desk_size(rng)
    surface = rng.choice([style.wood, style.wood, style.front])
    return draft(
        size,
        (surface, rng.choice([surface, style.front, style.dark_metal]), style.metal),
        side=rng.choice([-1, 1]),
        drawers=rng.choice([2, 3, 4]),
    )


def _desk(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    x, y, side = width / 2, depth / 2, p["side"]
    bodies.box(0, (-x, -y, height - 0.028), (x, y, height))
    unit = min(0.42, width * 0.35)
    a, b = sorted((side * (x - 0.02), side * (x - 0.02 - unit)))
    drawers(bodies, 1, 2, a, b, -y + 0.05, y - 0.03, 0.03, height - 0.028, p["drawers"])
    a, b = sorted((-side * (x - 0.02), -side * (x - 0.045)))
    bodies.box(1, (a, -y + 0.02, 0.0), (b, y - 0.02, height - 0.028))
    bodies.box(1, (-x + 0.05, y - 0.07, height * 0.4), (x - 0.05, y - 0.052, height - 0.028))
    return bodies.parts()


def drawers(
    bodies: Bodies,
    surface: int,
    handle: int,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z0: float,
    z1: float,
    count: int,
    *,
    columns: int = 1,
    doors: bool = False,
) -> None:
    """A carcass with fronts that stand 18 mm before it at y0, a 3 mm gap around each, and bar handles."""
    bodies.box(surface, (x0, y0 + 0.019, z0), (x1, y1, z1))
    gap = 0.0025
    for column in range(columns):
        a = x0 + (x1 - x0) * column / columns
        b = x0 + (x1 - x0) * (column + 1) / columns
        for row in range(count):
            c, d = z0 + (z1 - z0) * row / count, z0 + (z1 - z0) * (row + 1) / count
            bodies.box(surface, (a + gap, y0, c + gap), (b - gap, y0 + 0.018, d - gap))
            if doors:
                at = b - 0.05 if column % 2 == 0 else a + 0.05
                middle = (c + d) / 2
                bodies.box(
                    handle, (at - 0.006, y0 - 0.022, middle - 0.07), (at + 0.006, y0 - 0.01, middle + 0.07)
                )
                for z in (middle - 0.065, middle + 0.057):
                    bodies.box(handle, (at - 0.004, y0 - 0.01, z), (at + 0.004, y0, z + 0.008))
            else:
                half = min(0.08, (b - a) * 0.3)
                middle, z = (a + b) / 2, d - min(0.05, (d - c) * 0.4)
                bodies.box(
                    handle, (middle - half, y0 - 0.022, z - 0.006), (middle + half, y0 - 0.01, z + 0.006)
                )
                for at in (middle - half, middle + half - 0.008):
                    bodies.box(handle, (at, y0 - 0.01, z - 0.004), (at + 0.008, y0, z + 0.004))


def _draw_workbench(rng: Random, style: Style) -> Item:
    size = (rng.uniform(1.2, 2.4), rng.uniform(0.6, 0.8), rng.uniform(0.82, 0.95))
    return draft(
        size,
        (style.wood_2, rng.choice([style.dark_metal, style.wood_2, *style.accents[:1]]), style.dark_metal),
        shelf=round(rng.uniform(0.15, 0.3), 3),
        vise=rng.random() < 0.6,
        drawers=rng.random() < 0.5,
    )


def _workbench(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies = item.parameters, Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y, height - 0.06), (x, y, height))
    legs(bodies, 1, width, depth, height - 0.06, 0.08, inset=0.05)
    bodies.box(0, (-x + 0.1, -y + 0.09, p["shelf"]), (x - 0.1, y - 0.09, p["shelf"] + 0.022))
    bodies.box(1, (-x + 0.13, y - 0.1, p["shelf"] - 0.06), (x - 0.13, y - 0.08, p["shelf"]))
    if p["drawers"]:
        drawers(bodies, 1, 2, x - 0.62, x - 0.14, -y + 0.06, y - 0.14, height - 0.36, height - 0.06, 2)
    if p["vise"]:
        v = -x + 0.3
        bodies.box(2, (v - 0.09, -y + 0.0, height - 0.2), (v + 0.09, -y + 0.05, height - 0.01))
        bodies.bars(2, [((v - 0.12, -y + 0.03, height - 0.24), (v + 0.12, -y + 0.03, height - 0.24))], 0.01)
    return bodies.parts()


def _draw_counter(rng: Random, style: Style) -> Item:
    size = (rng.uniform(1.4, 3.0), rng.uniform(0.6, 0.8), rng.uniform(0.92, 1.12))
    return draft(
        size,
        (style.counter, rng.choice([style.front, style.wood]), style.dark_metal),
        panels=rng.choice([1, 2, 3, 4]),
    )


def _counter(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y, height - 0.035), (x, y, height))
    bodies.box(2, (-x + 0.05, -y + 0.08, 0.0), (x - 0.05, y - 0.03, 0.08))
    bodies.box(1, (-x + 0.02, -y + 0.04, 0.08), (x - 0.02, y - 0.02, height - 0.035))
    count = item.parameters["panels"]
    for i in range(count):
        a, b = -x + 0.03 + i * (width - 0.06) / count, -x + 0.03 + (i + 1) * (width - 0.06) / count
        bodies.box(1, (a + 0.006, -y + 0.025, 0.09), (b - 0.006, -y + 0.04, height - 0.05))
    return bodies.parts()


PIECES = (
    Piece("table", "table", _draw_table, _build_table),
    Piece(
        "round_table", "round_table", lambda rng, style: _draw_round(rng, style, "round_table"), _round_table
    ),
    Piece("coffee_table", "coffee_table", _draw_coffee_table, _build_table, 2.0),
    Piece(
        "round_coffee_table",
        "coffee_table",
        lambda rng, style: _draw_round(rng, style, "coffee_table"),
        _round_table,
    ),
    Piece("side_table", "side_table", lambda rng, style: _draw_round(rng, style, "side_table"), _round_table),
    Piece("console", "console", _draw_console, _build_table),
    Piece("display_table", "display_table", _draw_display_table, _build_table),
    Piece("bar_table", "bar_table", _draw_bar_table, _build_table),
    Piece("desk", "desk", _draw_desk, _desk),
    Piece("desk_table", "desk", lambda rng, style: _table(rng, style, "desk", _desk_size(rng)), _build_table),
    Piece("workbench", "workbench", _draw_workbench, _workbench),
    Piece("counter", "counter", _draw_counter, _counter),
)
