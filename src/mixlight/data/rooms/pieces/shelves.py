"""Shelves and glass cabinets with what stands in them."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.contents import fill
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.pieces.tables import drawers
from mixlight.data.rooms.plan import Item, Point3, Surface

__all__ = ["PIECES"]


def _shelf_item(
    rng: Random,
    size: Point3,
    body: Surface,
    back: bool,
    contents: Sequence[Surface],
    what: str,
    boards: int,
    columns: int,
    full: float,
) -> Item:
    """A shelf with a share `full` of its boards filled with `what`; the others are left for things."""
    width, depth, height = size
    thick = 0.02
    filled, tops = [], []
    low = 0.05 if height > 0.5 else 0.0
    pitch = (height - thick - low) / boards
    bay = (width - thick) / columns
    for column in range(columns):
        for row in range(boards):
            takes = rng.random() < full
            filled.append(what if takes else "")
            z = low + row * pitch + thick
            if not takes and 0.3 < z < 1.7:
                x0 = -width / 2 + thick + column * bay
                tops.append([x0, -depth / 2 + 0.01, x0 + bay - thick, depth / 2 - 0.02, z, pitch - thick])
    if height < 1.4:
        tops.append([-width / 2, -depth / 2, width / 2, depth / 2, height, 0.8])
    return draft(
        size,
        (body, *contents),
        boards=boards,
        columns=columns,
        filled=filled,
        back=back,
        seed=rng.randrange(1 << 20),
        tops=[[round(v, 3) for v in top] for top in tops],
    )


def _shelf(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies, rng = item.parameters, Bodies(item), Random(item.parameters["seed"])
    x, y, thick = width / 2, depth / 2, 0.02
    boards, columns = p["boards"], p["columns"]
    low = 0.05 if height > 0.5 else 0.0
    pitch, bay = (height - thick - low) / boards, (width - thick) / columns
    for column in range(columns + 1):
        a = -x + column * bay
        bodies.box(0, (a, -y, 0.0), (a + thick, y, height))
    for column in range(columns):
        a, b = -x + column * bay + thick, -x + (column + 1) * bay
        for row in range(boards + 1):
            z = low + row * pitch
            bodies.box(0, (a, -y + 0.003, z), (b, y - 0.004, z + thick))
        if p["back"]:
            bodies.box(0, (a, y - 0.012, low), (b, y - 0.004, height))
        for row in range(boards):
            what = p["filled"][column * boards + row]
            if what:
                z = low + row * pitch + thick
                colours = range(1, len(item.surfaces))
                fill(
                    bodies,
                    rng,
                    what,
                    a + 0.004,
                    b - 0.004,
                    -y + 0.008,
                    y - 0.02,
                    z + 0.001,
                    pitch - thick,
                    colours,
                )
    return bodies.parts()


def _draw_bookshelf(rng: Random, style: Style) -> Item:
    columns = rng.choice([1, 1, 2, 2, 3])
    size = (columns * rng.uniform(0.6, 0.95), rng.uniform(0.24, 0.34), rng.uniform(1.7, 2.3))
    body = style.wood if rng.random() < 0.7 else style.wood_2
    return _shelf_item(
        rng,
        size,
        body,
        rng.random() < 0.7,
        style.books,
        "books",
        rng.choice([5, 6, 7]),
        columns,
        rng.uniform(0.5, 0.95),
    )


def _draw_cubes(rng: Random, style: Style) -> Item:
    columns, rows = rng.choice([(2, 2), (4, 2), (2, 4), (4, 4), (3, 3), (1, 4), (5, 5)])
    body = style.wood if rng.random() < 0.7 else style.wood_2
    what = rng.choice(["mixed", "mixed", "books", "boxes"])
    contents = (*rng.sample(style.books, 5), *rng.sample(style.accents, 3))
    return _shelf_item(
        rng,
        (columns * 0.365 + 0.03, 0.39, rows * 0.365 + 0.03),
        body,
        False,
        contents,
        what,
        rows,
        columns,
        rng.uniform(0.4, 0.9),
    )


def _draw_low_shelf(rng: Random, style: Style) -> Item:
    columns = rng.choice([1, 2, 3])
    size = (columns * rng.uniform(0.5, 0.8), rng.uniform(0.28, 0.38), rng.uniform(0.7, 1.1))
    return _shelf_item(
        rng,
        size,
        style.wood,
        True,
        (*rng.sample(style.books, 6), *rng.sample(style.accents, 2)),
        "mixed",
        rng.choice([2, 3]),
        columns,
        0.75,
    )


def _draw_file_shelf(rng: Random, style: Style) -> Item:
    columns = rng.choice([1, 2, 3, 4])
    size = (columns * rng.uniform(0.8, 1.0), rng.uniform(0.34, 0.44), rng.uniform(1.6, 2.2))
    contents = (*rng.sample(style.books, 4), *rng.sample(style.accents, 2), style.paper)
    body = rng.choice([style.wood, style.front, style.metal])
    return _shelf_item(
        rng,
        size,
        body,
        rng.random() < 0.5,
        contents,
        rng.choice(["boxes", "mixed"]),
        5,
        columns,
        rng.uniform(0.6, 1.0),
    )


def _draw_store_shelf(rng: Random, style: Style) -> Item:
    """Open metal shelving with cartons, as in store rooms and workshops."""
    columns = rng.choice([1, 2])
    size = (columns * rng.uniform(0.9, 1.2), rng.uniform(0.4, 0.6), rng.uniform(1.8, 2.1))
    cardboard = Surface("paper", (0.36, 0.23, 0.12), roughness=0.9)
    contents = (cardboard, cardboard, cardboard, *rng.sample(style.accents, 4))
    return _shelf_item(
        rng,
        size,
        rng.choice([style.metal, style.dark_metal]),
        False,
        contents,
        rng.choice(["boxes", "boxes", "jars"]),
        4,
        columns,
        0.8,
    )


def _draw_glass_cabinet(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.8, 1.3), rng.uniform(0.36, 0.45), rng.uniform(1.7, 2.1))
    body = rng.choice([style.wood, style.wood_2, style.dark_metal])
    return draft(
        size,
        (body, style.glass, style.metal, *rng.sample(style.accents, 4), style.ceramic),
        seed=rng.randrange(1 << 20),
        low=rng.choice([0.08, 0.6]),
        what=rng.choice(["jars", "jars", "books"]),
    )


def _glass_cabinet(item: Item) -> list[Part]:
    width, depth, height = item.size
    p, bodies, rng = item.parameters, Bodies(item), Random(item.parameters["seed"])
    x, y, low = width / 2, depth / 2, p["low"]
    if low > 0.3:
        drawers(bodies, 0, 2, -x, x, -y + 0.022, y, 0.05, low, 1, columns=2, doors=True)
    else:
        bodies.box(0, (-x, -y + 0.03, 0.0), (x, y, low))
    for side in (-1, 1):
        a, b = sorted((side * x, side * (x - 0.02)))
        bodies.box(0, (a, -y + 0.02, low), (b, y, height))
    bodies.box(0, (-x + 0.02, y - 0.012, low), (x - 0.02, y, height - 0.02))
    bodies.box(0, (-x + 0.02, -y + 0.02, height - 0.02), (x - 0.02, y, height))
    count = max(2, round((height - low) / 0.36))
    pitch = (height - 0.02 - low) / count
    colours = range(3, len(item.surfaces))
    for i in range(count):
        z = low + i * pitch
        if i:
            bodies.box(0, (-x + 0.02, -y + 0.06, z - 0.016), (x - 0.02, y - 0.012, z))
        fill(
            bodies, rng, p["what"], -x + 0.05, x - 0.05, -y + 0.07, y - 0.02, z + 0.001, pitch - 0.02, colours
        )
    for a, b in ((-x + 0.02, -0.002), (0.002, x - 0.02)):  # two framed doors
        t = 0.045
        bodies.box(0, (a, -y, low + 0.004), (a + t, -y + 0.02, height - 0.004))
        bodies.box(0, (b - t, -y, low + 0.004), (b, -y + 0.02, height - 0.004))
        bodies.box(0, (a + t, -y, low + 0.004), (b - t, -y + 0.02, low + t))
        bodies.box(0, (a + t, -y, height - t), (b - t, -y + 0.02, height - 0.004))
        bodies.add(
            1, shapes.panel((a + t, -y + 0.01, low + t), (b - a - 2 * t, 0, 0), (0, 0, height - low - 2 * t))
        )
    return bodies.parts()


def _draw_wall_shelf(rng: Random, style: Style) -> Item:
    boards = rng.choice([1, 1, 2, 3])
    size = (rng.uniform(0.5, 1.2), rng.uniform(0.18, 0.26), boards * 0.32)
    width, depth, _height = size
    filled = [rng.random() < 0.6 for _ in range(boards)]
    tops = [
        [-width / 2, -depth / 2, width / 2, depth / 2, round(0.03 + i * 0.32, 3), 0.28]
        for i in range(boards)
        if not filled[i]
    ]
    return draft(
        size, (style.wood, style.metal, *style.books), filled=filled, tops=tops, seed=rng.randrange(1 << 20)
    )


def _wall_shelf(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    for i, filled in enumerate(item.parameters["filled"]):
        z = i * 0.32
        bodies.box(0, (-x, -y, z), (x, y, z + 0.028))
        if filled:
            fill(
                bodies,
                rng,
                "mixed",
                -x + 0.01,
                x - 0.01,
                -y + 0.01,
                y - 0.005,
                z + 0.029,
                0.28,
                range(2, len(item.surfaces)),
            )
    if len(item.parameters["filled"]) > 1:
        for side in (-1, 1):
            bodies.box(
                1,
                (side * (x - 0.06) - 0.01, y - 0.012, 0.0),
                (side * (x - 0.06) + 0.01, y - 0.002, height - 0.29),
            )
    return bodies.parts()


def _draw_ladder(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.45, 0.55), rng.uniform(0.6, 0.9), rng.uniform(1.3, 2.0)),
        (style.metal, style.dark_metal),
    )


def _ladder(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2 - 0.02, depth / 2 - 0.02
    for side in (-1, 1):
        bodies.bars(0, [((side * x, -y, 0.02), (side * x * 0.75, y * 0.2, height - 0.02))], 0.016)
        bodies.bars(0, [((side * x, y, 0.02), (side * x * 0.75, y * 0.25, height - 0.04))], 0.013)
    steps = int(height / 0.25)
    for i in range(1, steps + 1):
        share = i / (steps + 0.2)
        half, at = x * (1 - 0.25 * share), -y + 1.2 * y * share
        bodies.box(1, (-half, at - 0.035, share * height - 0.02), (half, at + 0.035, share * height + 0.005))
    return bodies.parts()


PIECES = (
    Piece("bookshelf", "shelf", _draw_bookshelf, _shelf, 3.0),
    Piece("cubes", "shelf", _draw_cubes, _shelf),
    Piece("file_shelf", "shelf", _draw_file_shelf, _shelf, 0.7),
    Piece("store_shelf", "shop_rack", _draw_store_shelf, _shelf, 0.4),
    Piece("low_shelf", "low_shelf", _draw_low_shelf, _shelf),
    Piece("glass_cabinet", "display_cabinet", _draw_glass_cabinet, _glass_cabinet),
    Piece("wall_shelf", "wall_shelf", _draw_wall_shelf, _wall_shelf),
    Piece("ladder", "ladder", _draw_ladder, _ladder),
)
