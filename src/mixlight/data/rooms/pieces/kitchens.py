"""Kitchen units with sinks and hobs, cupboards, white goods."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import Any

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.pieces.tables import drawers
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES", "draw_kitchen", "draw_wall_cabinet", "faucet"]

_BLACK = Surface("plastic", (0.012, 0.012, 0.013), roughness=0.08)


def draw_kitchen(rng: Random, style: Style, width: float, *, sink: bool = True, hob: bool = True) -> Item:
    """A row of floor units of a given width under one counter, with a sink, and a hob with an oven."""
    depth, height = 0.62, rng.uniform(0.86, 0.93)
    free = [[-width / 2 + 0.02, width / 2 - 0.02]]
    units: list[dict[str, Any]] = []
    at, end = -width / 2, width / 2
    places: dict[str, float] = {}
    widths = []
    while at < end - 0.01:
        step = rng.choice([0.4, 0.5, 0.6, 0.6, 0.8])
        if end - at - step < 0.3:  # the last unit takes what is left
            step = end - at
        widths.append((at, at + step))
        at += step
    wide = [i for i, (a, b) in enumerate(widths) if b - a >= 0.5]
    rng.shuffle(wide)
    if sink and wide:
        places["sink"] = wide.pop()
    if hob and wide:
        places["hob"] = wide.pop()
    if wide and rng.random() < 0.5:
        places["dishwasher"] = wide.pop()
    for i, (a, b) in enumerate(widths):
        what = next((name for name, place in places.items() if place == i), "")
        front = rng.choice(["door", "door", "drawers"]) if not what or what == "sink" else what
        units.append({"x0": round(a, 3), "x1": round(b, 3), "what": what, "front": front})
    for name in ("sink", "hob"):
        if name in places:
            a, b = widths[int(places[name])]
            free = [
                piece
                for x0, x1 in free
                for piece in ([x0, min(x1, a)], [max(x0, b), x1])
                if piece[1] - piece[0] > 0.1
            ]
    item = draft(
        (width, depth, height),
        (
            style.front,
            style.counter,
            style.metal,
            rng.choice([style.metal, style.ceramic]),
            _BLACK,
            style.dark_metal,
        ),
        units=units,
        tops=[
            [round(a, 3), -depth / 2 + 0.03, round(b, 3), depth / 2 - 0.02, round(height, 3), 0.46]
            for a, b in free
        ],
        splash=round(rng.choice([0.0, 0.05]), 3),
    )
    if "hob" in places:
        a, b = widths[int(places["hob"])]
        item.parameters["hob_at"] = round((a + b) / 2, 3)
    return replace(item, kind="kitchen", piece="own:kitchen")


def _kitchen(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, thick = width / 2, depth / 2, 0.035
    low, high = 0.1, height - thick
    bodies.box(5, (-x, -y + 0.07, 0.0), (x, y, low))
    cut = None
    for unit in item.parameters["units"]:
        a, b = unit["x0"], unit["x1"]
        if unit["front"] in ("hob", "dishwasher"):
            bodies.box(0, (a, -y + 0.042, low), (b, y, high))
            _oven_front(bodies, unit["front"], a, b, -y + 0.02, low, high)
        else:
            rows = 3 if unit["front"] == "drawers" else 1
            columns = 2 if unit["front"] == "door" and b - a > 0.65 else 1
            drawers(
                bodies,
                0,
                2,
                a,
                b,
                -y + 0.024,
                y,
                low,
                high,
                rows,
                columns=columns,
                doors=unit["front"] == "door",
            )
        if unit["what"] == "sink":
            cut = ((a + b) / 2, min(b - a - 0.1, 0.55))
        if unit["what"] == "hob":
            bodies.box(4, (a + 0.02, -y + 0.06, height), (b - 0.02, y - 0.06, height + 0.006))
    if cut is None:
        bodies.box(1, (-x, -y, high), (x, y, height))
    else:
        middle, wide = cut
        c, d = middle - wide / 2, middle + wide / 2
        front, rear = -y + 0.09, y - 0.12
        for lo, hi in (((-x, -y), (c, y)), ((d, -y), (x, y)), ((c, -y), (d, front)), ((c, rear), (d, y))):
            if hi[0] - lo[0] > 1e-3:
                bodies.box(1, (*lo, high), (*hi, height))
        sink(bodies, 3, c, d, front, rear, height - 0.17, height + 0.002)
        faucet(bodies, 2, middle, y - 0.07, height, 0.28, 0.2)
    if item.parameters["splash"]:
        bodies.box(1, (-x, y - 0.015, height), (x, y, height + item.parameters["splash"]))
    return bodies.parts()


def _oven_front(bodies: Bodies, what: str, a: float, b: float, y: float, low: float, high: float) -> None:
    metal = 2
    bodies.box(
        metal if what == "dishwasher" else 4, (a + 0.003, y, low + 0.003), (b - 0.003, y + 0.022, high - 0.1)
    )
    bodies.box(metal, (a + 0.003, y, high - 0.096), (b - 0.003, y + 0.022, high - 0.003))
    bodies.bars(metal, [((a + 0.06, y - 0.03, high - 0.15), (b - 0.06, y - 0.03, high - 0.15))], 0.008)
    for at in (a + 0.07, b - 0.07):
        bodies.bars(metal, [((at, y - 0.03, high - 0.15), (at, y, high - 0.15))], 0.006)
    if what == "hob":
        for i in range(4):
            at = a + (b - a) * (i + 1) / 5
            knob = shapes.transform(
                shapes.cylinder(0.018, 0.02, segments=12), shapes.rotation("x", math.pi / 2)
            )
            bodies.put(5, knob, shapes.placement((at, y, high - 0.05)))


def sink(
    bodies: Bodies, surface: int, x0: float, x1: float, y0: float, y1: float, bottom: float, top: float
) -> None:
    """An open basin: bottom and four walls, 8 mm thick."""
    t = 0.008
    bodies.box(surface, (x0, y0, bottom - t), (x1, y1, bottom))
    for lo, hi in (
        ((x0, y0), (x0 + t, y1)),
        ((x1 - t, y0), (x1, y1)),
        ((x0, y0), (x1, y0 + t)),
        ((x0, y1 - t), (x1, y1)),
    ):
        bodies.box(surface, (*lo, bottom), (*hi, top))


def faucet(bodies: Bodies, surface: int, x: float, y: float, z: float, tall: float, reach: float) -> None:
    """A tap: a post, an arc, an outlet towards -Y."""
    turn = np.linspace(0, math.pi, 9)
    r = reach / 2
    path = [(x, y, z), (x, y, z + tall - r)]
    path += [(x, y - r + r * math.cos(t), z + tall - r + r * math.sin(t)) for t in turn[1:]]
    path.append((x, y - reach, z + tall - r - 0.04))
    bodies.add(surface, shapes.tube(np.array(path), 0.011))
    bodies.bars(surface, [((x, y, z + 0.05), (x + 0.06, y - 0.02, z + 0.08))], 0.007)
    bodies.add(surface, shapes.cylinder(0.024, 0.035, base=(x, y, z), segments=14))


def draw_wall_cabinet(rng: Random, style: Style, width: float, height: float) -> Item:
    """A cupboard that hangs over a counter."""
    item = draft(
        (width, 0.35, height),
        (style.front, style.metal, style.front),
        fronts=[[1.0, 1, 1 if width < 0.55 else 2, True]],
    )
    return replace(item, kind="wall_cabinet", piece="own:wall_cabinet")


def _wall_cabinet(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    _, rows, columns, doors = item.parameters["fronts"][0]
    drawers(
        bodies,
        0,
        1,
        -width / 2,
        width / 2,
        -depth / 2 + 0.022,
        depth / 2,
        0.0,
        height,
        rows,
        columns=columns,
        doors=doors,
    )
    return bodies.parts()


def _draw_island(rng: Random, style: Style) -> Item:
    size = (rng.uniform(1.2, 2.2), rng.uniform(0.75, 1.0), rng.uniform(0.88, 0.94))
    return draft(
        size, (style.counter, style.front, style.metal, style.dark_metal), columns=rng.choice([2, 3, 4])
    )


def _island(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y, height - 0.04), (x, y, height))
    bodies.box(3, (-x + 0.08, -y + 0.1, 0.0), (x - 0.08, y - 0.3, 0.1))
    drawers(
        bodies,
        1,
        2,
        -x + 0.03,
        x - 0.03,
        -y + 0.045,
        y - 0.25,
        0.1,
        height - 0.04,
        1,
        columns=item.parameters["columns"],
        doors=True,
    )
    return bodies.parts()


def _draw_fridge(rng: Random, style: Style) -> Item:
    body = rng.choice(
        [
            style.ceramic,
            style.ceramic,
            Surface("metal", (0.55, 0.55, 0.54), roughness=0.32),
            style.front,
            *style.accents[:1],
        ]
    )
    small = rng.random() < 0.15
    size = (rng.uniform(0.55, 0.7), rng.uniform(0.6, 0.7), 0.85 if small else rng.uniform(1.55, 2.0))
    return draft(
        size,
        (body, style.metal, style.dark_metal),
        split=round(1.0 if small else rng.choice([0.3, 0.4, 0.7]), 2),
    )


def _fridge(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y + 0.065, 0.04), (x, y, height))
    bodies.box(2, (-x + 0.02, -y + 0.07, 0.0), (x - 0.02, y - 0.02, 0.04))
    split = 0.05 + (height - 0.05) * item.parameters["split"]
    for a, b in ((0.05, min(split, height) - 0.004), (split + 0.004, height)):
        if b - a > 0.1:
            bodies.add(0, shapes.rounded_box((-x, -y + 0.004, a), (x, -y + 0.06, b), 0.012, steps=1))
            middle, half = (a + b) / 2, min(0.25, (b - a) * 0.35)
            bodies.box(1, (x - 0.06, -y - 0.0, middle - half), (x - 0.04, -y + 0.008, middle + half))
    return bodies.parts()


def _draw_washing_machine(rng: Random, style: Style) -> Item:
    return draft((0.6, rng.uniform(0.55, 0.62), 0.85), (style.ceramic, style.metal, _BLACK, style.plastic))


def _washing_machine(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y + 0.03, 0.0), (x, y, height))
    front = shapes.rotation("x", math.pi / 2)
    ring = shapes.lathe(
        np.array([(0.2, 0.0), (0.2, 0.02), (0.17, 0.03), (0.14, 0.02)]), segments=28, caps=False
    )
    bodies.put(1, ring, shapes.placement((0, -y + 0.03, height * 0.47)) @ front)
    bowl = shapes.lathe(np.array([(0.15, 0.005), (0.1, 0.022), (0.0, 0.027)]), segments=28, caps=False)
    bodies.put(2, bowl, shapes.placement((0, -y + 0.03, height * 0.47)) @ front)
    bodies.box(3, (-x + 0.02, -y + 0.018, height - 0.12), (x - 0.02, -y + 0.03, height - 0.02))
    bodies.put(
        1,
        shapes.cylinder(0.025, 0.02, segments=14),
        shapes.placement((0.05, -y + 0.02, height - 0.07)) @ front,
    )
    return bodies.parts()


def _draw_cooker(rng: Random, style: Style) -> Item:
    return draft(
        (rng.choice([0.5, 0.6, 0.9]), 0.62, 0.9),
        (
            rng.choice([style.ceramic, style.metal]),
            _BLACK,
            style.metal,
            style.metal,
            _BLACK,
            style.dark_metal,
        ),
    )


def _cooker(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y + 0.042, 0.0), (x, y, height - 0.02))
    bodies.box(1, (-x, -y + 0.03, height - 0.02), (x, y, height))
    _oven_front(bodies, "hob", -x, x, -y + 0.02, 0.12, height - 0.02)
    return bodies.parts()


def _draw_hood(rng: Random, style: Style) -> Item:
    return draft(
        (rng.choice([0.6, 0.6, 0.9]), rng.uniform(0.42, 0.5), rng.uniform(0.5, 0.75)),
        (style.metal,),
        flat=rng.random() < 0.4,
    )


def _hood(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, -y, 0.0), (x, y, 0.06))
    bodies.box(0, (-0.13, y - 0.25, 0.2), (0.13, y, height))
    if not item.parameters["flat"]:
        low = np.array([(-x, -y, 0.06), (x, -y, 0.06), (x, y, 0.06), (-x, y, 0.06)])
        high = np.array([(-0.13, y - 0.25, 0.22), (0.13, y - 0.25, 0.22), (0.13, y, 0.22), (-0.13, y, 0.22)])
        bodies.add(0, shapes.loft(np.stack((low, high)), smooth=False))
    else:
        bodies.box(0, (-0.13, y - 0.25, 0.06), (0.13, y, 0.2))
    return bodies.parts()


PIECES = (
    Piece("kitchen", "kitchen", lambda rng, style: draw_kitchen(rng, style, rng.uniform(1.2, 3.6)), _kitchen),
    Piece(
        "wall_cabinet",
        "wall_cabinet",
        lambda rng, style: draw_wall_cabinet(rng, style, rng.choice([0.4, 0.5, 0.6]), rng.uniform(0.55, 0.8)),
        _wall_cabinet,
    ),
    Piece("island", "island", _draw_island, _island),
    Piece("fridge", "fridge", _draw_fridge, _fridge),
    Piece("washing_machine", "washing_machine", _draw_washing_machine, _washing_machine),
    Piece("cooker", "cooker", _draw_cooker, _cooker),
    Piece("hood", "hood", _draw_hood, _hood),
)
