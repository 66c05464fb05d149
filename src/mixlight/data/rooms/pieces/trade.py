"""What shops and stores hold: racks of goods, crates, pallets, barrels."""

from __future__ import annotations

from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.contents import boxes, fill, folded, vessel
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import CARDBOARD, RAW_WOOD, Style, tone
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]


def _packages(rng: Random) -> list[Surface]:
    """Bright packages as shops have them."""
    tints = [
        (1, 0.1, 0.08),
        (0.1, 0.25, 1),
        (1, 0.7, 0.05),
        (0.1, 0.6, 0.2),
        (1, 0.95, 0.9),
        (1, 0.95, 0.9),
        (0.7, 0.2, 0.6),
        (0.1, 0.6, 0.8),
        (1, 0.5, 0.1),
    ]
    return [
        Surface("paper", tone(rng, tint, 0.06, 0.5, spread=0.15), roughness=0.5)
        for tint in rng.sample(tints, 7)
    ]


def _draw_gondola(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.9, 1.3), rng.uniform(0.38, 0.5), rng.uniform(1.4, 2.1))
    return draft(
        size,
        (rng.choice([style.metal, style.ceramic, style.dark_metal, style.wood]), *_packages(rng)),
        boards=rng.choice([4, 5, 6]),
        what=rng.choice(["boxes", "boxes", "jars", "folded", "books", "mixed"]),
        seed=rng.randrange(1 << 20),
    )


def _gondola(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng, p = Bodies(item), Random(item.parameters["seed"]), item.parameters
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, y - 0.03, 0.0), (x, y, height))
    bodies.box(0, (-x, -y, 0.0), (x, y - 0.03, 0.12))
    pitch = (height - 0.15) / p["boards"]
    for i in range(p["boards"]):
        z, front = 0.12 + i * pitch, -y if i == 0 else -y + 0.06
        if i:
            bodies.box(0, (-x, front, z - 0.02), (x, y - 0.03, z))
            bodies.box(0, (-x, front - 0.004, z - 0.035), (x, front, z + 0.005))
        fill(
            bodies,
            rng,
            p["what"],
            -x + 0.01,
            x - 0.01,
            front + 0.01,
            y - 0.035,
            z + 0.001,
            pitch - 0.03,
            range(1, len(item.surfaces)),
        )
    return bodies.parts()


def _draw_crate(rng: Random, style: Style) -> Item:
    wood = rng.random() < 0.5
    size = (rng.uniform(0.4, 0.6), rng.uniform(0.3, 0.4), rng.uniform(0.22, 0.34))
    return draft(
        size,
        (RAW_WOOD if wood else rng.choice(style.accents), *_packages(rng)),
        slats=wood,
        full=rng.random() < 0.6,
        seed=rng.randrange(1 << 20),
    )


def _crate(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y, t = width / 2, depth / 2, 0.012
    bodies.box(0, (-x + t, -y + t, 0.0), (x - t, y - t, t))
    count = 3 if item.parameters["slats"] else 1
    for i in range(count):
        a = i * height / count + (0.012 if i and count > 1 else 0.0)
        b = (i + 1) * height / count
        for lo, hi in (
            ((-x, -y), (x, -y + t)),
            ((-x, y - t), (x, y)),
            ((-x, -y + t), (-x + t, y - t)),
            ((x - t, -y + t), (x, y - t)),
        ):
            bodies.box(0, (*lo, a), (*hi, b))
    if item.parameters["slats"]:
        for sx in (-1, 1):
            for sy in (-1, 1):
                px, py = sx * (x - t - 0.015), sy * (y - t - 0.015)
                bodies.box(0, (px - 0.015, py - 0.015, 0.0), (px + 0.015, py + 0.015, height))
    if item.parameters["full"]:
        fill(
            bodies,
            rng,
            rng.choice(["jars", "boxes", "books"]),
            -x + 0.02,
            x - 0.02,
            -y + 0.02,
            y - 0.02,
            t,
            height,
            range(1, len(item.surfaces)),
        )
    return bodies.parts()


def _draw_pallet(rng: Random, style: Style) -> Item:
    return draft(
        (1.2, 0.8, rng.choice([0.145, rng.uniform(0.5, 1.4)])),
        (RAW_WOOD, CARDBOARD, rng.choice([CARDBOARD, *style.accents[:2]])),
        seed=rng.randrange(1 << 20),
    )


def _pallet(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    for i in range(3):
        at = -y + 0.05 + i * (depth - 0.1) / 2
        bodies.box(0, (-x, at - 0.05, 0.0), (x, at + 0.05, 0.02))
        for j in range(3):
            b = -x + 0.07 + j * (width - 0.14) / 2
            bodies.box(0, (b - 0.07, at - 0.05, 0.02), (b + 0.07, at + 0.05, 0.12))
    for i in range(6):
        at = -x + 0.07 + i * (width - 0.14) / 5
        bodies.box(0, (at - 0.06, -y, 0.12), (at + 0.06, y, 0.143))
    z = 0.145
    while z + 0.25 < height:
        tall = min(rng.uniform(0.25, 0.4), height - z)
        for i in range(3):
            for j in range(2):
                if rng.random() < 0.92:
                    a, b = -x + 0.02 + i * (width - 0.04) / 3, -y + 0.02 + j * (depth - 0.04) / 2
                    bodies.box(
                        rng.choice([1, 1, 2]),
                        (a + 0.004, b + 0.004, z),
                        (a + (width - 0.04) / 3 - 0.004, b + (depth - 0.04) / 2 - 0.004, z + tall - 0.002),
                    )
        z += tall
    return bodies.parts()


def _draw_barrel(rng: Random, style: Style) -> Item:
    return draft(
        (0.58, 0.58, 0.88), (rng.choice([*style.accents[:4], style.metal, RAW_WOOD]), style.dark_metal)
    )


def _barrel(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies = Bodies(item)
    r = width / 2
    bulge = [
        (r * 0.93, 0.0),
        (r * 0.95, height * 0.32),
        (r, height * 0.33),
        (r * 0.95, height * 0.34),
        (r * 0.95, height * 0.66),
        (r, height * 0.67),
        (r * 0.95, height * 0.68),
        (r * 0.93, height),
        (r * 0.88, height),
        (r * 0.88, height - 0.02),
        (0, height - 0.02),
    ]
    bodies.add(0, shapes.lathe(np.array(bulge), segments=28, crease=0.3))
    return bodies.parts()


def _draw_goods(rng: Random, style: Style) -> Item:
    packages = _packages(rng)
    size = (rng.uniform(0.2, 0.6), rng.uniform(0.15, 0.35), rng.uniform(0.1, 0.3))
    return draft(
        size, packages, what=rng.choice(["boxes", "jars", "folded", "boxes"]), seed=rng.randrange(1 << 20)
    )


def _goods(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    colours = range(len(item.surfaces))
    x, y = width / 2, depth / 2
    {"boxes": boxes, "folded": folded}.get(item.parameters["what"], _rows)(
        bodies, rng, -x, x, -y, y, 0.0, height, colours
    )
    if not bodies.parts():
        bodies.box(0, (-x, -y, 0.0), (x, y, height))
    return bodies.parts()


def _rows(
    bodies: Bodies,
    rng: Random,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z: float,
    clear: float,
    surfaces: range,
) -> None:
    """Bottles or cans in rows."""
    r = rng.uniform(0.03, 0.045)
    what = rng.choice(["can", "bottle", "jar"])
    tall = min(clear, {"can": 0.12, "bottle": 0.28, "jar": 0.14}[what])
    mesh = vessel(what, r, tall, segments=12)
    x = x0 + r
    while x + r <= x1:
        y, colour = y0 + r, rng.choice(list(surfaces))
        while y + r <= y1:
            if rng.random() < 0.92:
                bodies.put(colour, mesh, shapes.placement((x, y, z)))
            y += 2 * r + 0.004
        x += 2 * r + 0.004


PIECES = (
    Piece("gondola", "shop_rack", _draw_gondola, _gondola),
    Piece("crate", "crate", _draw_crate, _crate),
    Piece("pallet", "pallet", _draw_pallet, _pallet),
    Piece("barrel", "barrel", _draw_barrel, _barrel),
    Piece("goods", "goods", _draw_goods, _goods),
)
