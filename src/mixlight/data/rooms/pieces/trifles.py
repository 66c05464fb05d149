"""Small things of shelves and desks: books, papers, boxes, frames, ornaments, toys."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.contents import stack
from mixlight.data.rooms.pieces.hung import art
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft, draw_seed
from mixlight.data.rooms.pieces.style import CARDBOARD, Style, tone
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]


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
    return draft(size, tuple(style.books), lying=lying, seed=draw_seed(rng))


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
    return draft((0.3, 0.32, rng.uniform(0.12, 0.5)), tuple(style.books), lying=True, seed=draw_seed(rng))


def _draw_papers(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.25, 0.4), rng.uniform(0.3, 0.42), rng.uniform(0.004, 0.05)),
        (style.paper, rng.choice(style.books), art(rng)),
        seed=draw_seed(rng),
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
        seed=draw_seed(rng),
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
    surface = rng.choice([CARDBOARD, *style.accents[:6], *style.books[:4]])
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
        (rng.choice([style.wood, style.metal, style.dark_metal, style.ceramic]), art(rng)),
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


def _draw_toy(rng: Random, style: Style) -> Item:
    bright = [
        Surface("plastic", tone(rng, c, 0.08, 0.4, spread=0.1), roughness=0.35)
        for c in ((1, 0.08, 0.05), (0.08, 0.3, 1), (1, 0.7, 0.05), (0.1, 0.7, 0.2))
    ]
    return draft(
        (rng.uniform(0.1, 0.4), rng.uniform(0.1, 0.35), rng.uniform(0.06, 0.22)), bright, seed=draw_seed(rng)
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


PIECES = (
    Piece("book", "book", _draw_book, _book),
    Piece("books", "books", _draw_books, _books),
    Piece("book_pile", "book_pile", _draw_pile, _books),
    Piece("papers", "papers", _draw_papers, _papers),
    Piece("office_clutter", "office_clutter", _draw_clutter, _clutter),
    Piece("small_box", "small_box", _draw_small_box, _small_box),
    Piece("frame", "frame", _draw_frame, _frame),
    Piece("ornament", "ornament", _draw_ornament, _ornament),
    Piece("small_toy", "small_toy", _draw_toy, _toy),
    Piece("toys", "toy", _draw_toy, _toy),
)
