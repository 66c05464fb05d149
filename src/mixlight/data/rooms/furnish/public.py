"""Offices, halls, corridors, shops, workshops, and rooms that stand empty."""

from __future__ import annotations

import math
from dataclasses import replace

from mixlight.data.rooms.furnish.homes import at_desk, dining, seating
from mixlight.data.rooms.furnish.mixes import mix
from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.plan import Item

__all__ = ["corridor", "empty", "hall", "office", "shop", "workshop"]


def office(room: Room) -> None:
    """Desks along the walls or face to face in rows; shelves for files; a table to meet at."""
    rng = room.rng
    room.again("desk")
    if room.area > 22 and room.chance(0.75):
        _desk_rows(room)
    else:
        for _ in range(max(1, round(room.area / rng.uniform(6, 9)))):
            desk = room.again("desk") if room.chance(0.7) else room.make("desk")
            placed = room.against(desk, corner=0.35) if room.chance(0.7) else room.free(desk, margin=0.5)
            if placed is not None:
                at_desk(room, placed, "office_chair")
    if room.area > 16 and room.chance(0.45):
        dining(room)
    if room.area > 28 and room.chance(0.35):
        seating(room)
    count = 2 + int(room.area / 14)
    room.again("shelf")
    for kind, often in mix(
        "shelf 0.75 filing_cabinet 0.6 cabinet 0.5 sideboard 0.35 locker 0.12 low_shelf 0.4"
    ):
        for _ in range(rng.randint(1, max(1, count // 2))):
            if room.chance(often) and not room.full(0.45):
                room.against(room.again(kind), gap=rng.uniform(0.01, 0.03))
    for kind, often, most in (
        ("plant", 0.7, 4),
        ("bin", 0.9, 4),
        ("water_cooler", 0.2, 1),
        ("coat_stand", 0.4, 1),
        ("box", 0.5, 5),
        ("chair", 0.4, 3),
        ("armchair", 0.25, 2),
        ("bag", 0.5, 3),
    ):
        for _ in range(rng.randint(0, most)):
            if room.chance(often) and not room.full(0.45):
                room.against(kind, corner=0.3)
    for _ in range(rng.randint(0, 2)):
        room.hang("board", middle=(1.4, 1.6))
    if room.chance(0.15):
        room.free("person", margin=0.2)


def _desk_rows(room: Room) -> None:
    """Pairs of desks face to face, in as many rows as fit."""
    rng = room.rng
    desk = room.again("desk")
    if desk is None:
        return
    along = rng.choice([0.0, math.pi / 2])
    width, depth, _ = desk.size
    x0, y0, x1, y1 = room.bounds
    pitch, aisle = width + 0.03, 2 * depth + rng.uniform(1.7, 2.4)
    span, rows = (x1 - x0, y1 - y0) if along == 0.0 else (y1 - y0, x1 - x0)
    block = rng.choice([2, 3, 4, 99])
    across = depth + 0.9
    while across + depth < rows - 0.4:
        at = 0.7 + width / 2
        number = 0
        while at + width / 2 < span - 0.5:
            for side in (-1, 1):
                u, v = at, across + side * (depth / 2 + 0.012)
                x, y = (x0 + u, y0 + v) if along == 0.0 else (x0 + v, y0 + u)
                # The desk at the lower side faces down, so that two look at each other's backs.
                turn = (
                    (0.0 if side < 0 else math.pi)
                    if along == 0.0
                    else (-math.pi / 2 if side < 0 else math.pi / 2)
                )
                placed = room.put(desk, (x, y, 0.0), turn)
                if placed is not None:
                    at_desk(room, placed, "office_chair")
            number += 1
            at += pitch + (1.2 if number % block == 0 else 0.0)
        across += aisle


def hall(room: Room) -> None:
    """A large room: a restaurant, a lobby, a reading room, an exhibition or rows of chairs."""
    rng = room.rng
    use = rng.choices(
        ["restaurant", "lobby", "library", "exhibition", "rows", "mixed"], [3.5, 3, 1.5, 1.2, 1.2, 3]
    )[0]
    if use in ("restaurant", "mixed"):
        room.again("chair")
        room.again("table")
        for _ in range(min(int(room.area / rng.uniform(7, 11)), 22)):
            _dining_alike(room)
    if use in ("lobby", "mixed"):
        for _ in range(min(max(1, int(room.area / 28)), 6)):
            _island_group(room)
    if use == "library":
        _racks(room, "shelf", rng.uniform(1.3, 2.0), own=True)
        for _ in range(int(room.area / 25)):
            _dining_alike(room)
    if use == "exhibition":
        for _ in range(int(room.area / 16)):
            room.free(rng.choice(["display_table", "display_cabinet", "bench", "plant"]), margin=0.7)
    if use == "rows":
        _chair_rows(room)
    if room.chance(0.7):
        room.against("counter", gap=rng.choice([0.02, 1.0]))
    for kind, often, most in (
        ("plant", 0.8, 8),
        ("sideboard", 0.5, 3),
        ("shelf", 0.5, 4),
        ("bench", 0.4, 4),
        ("console", 0.3, 3),
        ("display_cabinet", 0.4, 3),
        ("piano", 0.15, 1),
        ("bin", 0.6, 3),
        ("armchair", 0.4, 4),
        ("cabinet", 0.5, 4),
        ("screen_divider", 0.2, 2),
        ("box", 0.3, 4),
    ):
        for _ in range(rng.randint(0, most)):
            if room.chance(often) and not room.full(0.4):
                room.against(kind, corner=0.3)
    for _ in range(rng.randint(0, 3)):
        if room.chance(0.3):
            room.free("person", margin=0.3)


def _dining_alike(room: Room) -> None:
    kind = "table" if room.chance(0.75) else "round_table"
    table = room.again(kind)
    placed = room.free(table, margin=0.5, tries=10, loose=0.02)
    if placed is not None:
        room.around(placed, "chair", share=0.92)


def _island_group(room: Room) -> None:
    """Sofas or armchairs around a low table in the middle of a large room."""
    rng = room.rng
    table = room.free(room.again("coffee_table"), margin=1.0, tries=12)
    if table is None:
        return
    kind = rng.choice(["sofa", "armchair"])
    for side in range(4):
        seat = room.again(kind) if side % 2 == 0 else room.again("armchair")
        if seat is None or not room.chance(0.75):
            continue
        turn = table.item.turn + side * math.pi / 2
        reach = (
            (table.item.size[1] if side % 2 == 0 else table.item.size[0]) / 2
            + rng.uniform(0.3, 0.5)
            + seat.size[1] / 2
        )
        x = table.item.position[0] - math.sin(turn) * reach
        y = table.item.position[1] + math.cos(turn) * reach
        room.put(seat, (x, y, 0.0), turn + rng.uniform(-0.1, 0.1))


def _racks(room: Room, kind: str, aisle: float, *, own: bool | None = None) -> None:
    """Rows of racks back to back across the room."""
    rng = room.rng
    rack = room.make(kind, own=own)
    if rack is None:
        return
    racks = _variants(room, rack)
    along = rng.choice([0.0, math.pi / 2])
    x0, y0, x1, y1 = room.bounds
    span, rows = (x1 - x0, y1 - y0) if along == 0.0 else (y1 - y0, x1 - x0)
    across = aisle + rack.size[1] + rng.uniform(0.3, 1.0)
    while across + rack.size[1] < rows - aisle * 0.8:
        at = rng.uniform(1.0, 1.6) + rack.size[0] / 2
        while at + rack.size[0] / 2 < span - 1.0:
            for side in (-1, 1):
                u, v = at, across + side * (rack.size[1] / 2 + 0.004)
                x, y = (x0 + u, y0 + v) if along == 0.0 else (x0 + v, y0 + u)
                turn = (
                    (0.0 if side < 0 else math.pi)
                    if along == 0.0
                    else (-math.pi / 2 if side < 0 else math.pi / 2)
                )
                room.put(rng.choice(racks), (x, y, 0.0), turn)
            at += rack.size[0] + 0.005
            if room.chance(0.12):
                at += 1.1
        across += 2 * rack.size[1] + aisle


def _variants(room: Room, item: Item, count: int = 5) -> list[Item]:
    """The same rack with other goods on it, a few times: more of the same cost nothing to build."""
    if "seed" not in item.parameters:
        return [item]
    seeds = [room.rng.randrange(1 << 20) for _ in range(count)]
    return [replace(item, parameters={**item.parameters, "seed": seed}) for seed in seeds]


def _chair_rows(room: Room) -> None:
    rng = room.rng
    chair = room.again("chair")
    if chair is None:
        return
    x0, y0, x1, y1 = room.bounds
    pitch, row = chair.size[0] + 0.06, chair.size[1] + rng.uniform(0.4, 0.6)
    y = y0 + 1.5
    while y < y1 - 2.5 and len(room.items) < 260:
        x = x0 + 1.2
        while x < x1 - 1.2:
            if room.chance(0.94) and abs(x - (x0 + x1) / 2) > 0.6:
                room.put(chair, (x, y, 0.0), math.pi + rng.gauss(0.0, 0.05))
            x += pitch
        y += row
    room.free(room.make("table"), margin=0.4)


def corridor(room: Room) -> None:
    """What stands along a corridor: coats and shoes at home, boxes and signs elsewhere."""
    rng = room.rng
    narrow = min(room.bounds[2] - room.bounds[0], room.bounds[3] - room.bounds[1])
    deep = max(min(narrow - 0.85, 0.55), 0.12)
    home = room.chance(0.6)
    kinds = (
        (
            ("shoe_rack", 0.7),
            ("console", 0.5),
            ("bench", 0.35),
            ("coat_stand", 0.35),
            ("low_shelf", 0.3),
            ("dresser", 0.3),
            ("shelf", 0.35),
            ("wardrobe", 0.3),
            ("plant", 0.5),
            ("basket", 0.3),
            ("chair", 0.3),
            ("shoes", 0.8),
            ("shoes", 0.6),
            ("bag", 0.6),
            ("bicycle", 0.1),
            ("box", 0.4),
        )
        if home
        else (
            ("bench", 0.6),
            ("plant", 0.6),
            ("locker", 0.4),
            ("cabinet", 0.4),
            ("chair", 0.5),
            ("chair", 0.4),
            ("bin", 0.7),
            ("water_cooler", 0.25),
            ("box", 0.5),
            ("filing_cabinet", 0.4),
            ("cleaning", 0.2),
            ("shelf", 0.3),
            ("crate", 0.2),
            ("ladder", 0.1),
        )
    )
    for kind, often in kinds:
        for _ in range(1 + int(room.area / 16)):
            if room.chance(often) and not room.full(0.4):
                placed = room.against(kind, depth=deep, gap=0.01, tries=16)
                if placed is not None and kind in ("console", "shoe_rack", "dresser") and room.chance(0.6):
                    room.above("mirror", placed, placed.item.size[2] + 0.25, width=1.0)
    if home:
        for _ in range(rng.randint(1, 2)):
            room.hang("hooks", middle=(1.5, 1.6))
        if room.chance(0.5):
            room.free("rug", margin=0.0, tries=10, width=narrow - 0.2, loose=0.0)
    else:
        for kind in ("extinguisher", "sign", "sign", "board", "board"):
            if room.chance(0.6):
                room.hang(kind, middle=(1.1, 1.6) if kind != "sign" else (2.0, 2.2))


def shop(room: Room) -> None:
    """Racks along the walls and in rows, tables with goods, a counter with a till."""
    rng = room.rng
    counter = room.against("counter", gap=rng.uniform(0.8, 1.1), tries=20) or room.free("counter", margin=0.3)
    if counter is not None:
        room.on("till", counter, x=rng.uniform(-0.6, 0.6), y=0.0, turn=math.pi, spread=0.1)
        room.hang("wall_shelf", middle=(1.2, 1.6))
    use = rng.choice(["clothes", "goods", "goods", "books", "mixed"])
    wall = {"clothes": "clothes_rack", "goods": "shop_rack", "books": "shelf", "mixed": "shop_rack"}[use]
    for _ in range(int(room.area / 5) + 3):
        if not room.full(0.4):
            room.against(
                wall
                if room.chance(0.75)
                else rng.choice(["display_cabinet", "shelf", "shop_rack", "sideboard"]),
                corner=0.3,
            )
    if use in ("goods", "books") and room.area > 30:
        _racks(room, wall, rng.uniform(1.2, 1.7))
    for _ in range(int(room.area / rng.uniform(8, 14))):
        if not room.full(0.45):
            kind = rng.choice(
                [
                    "display_table",
                    "display_table",
                    "clothes_rack" if use == "clothes" else "display_table",
                    "crate",
                    "round_table",
                ]
            )
            room.free(kind, margin=0.55)
    for kind, often, most in (
        ("plant", 0.5, 4),
        ("box", 0.6, 4),
        ("person", 0.2, 2),
        ("basket", 0.6, 3),
        ("chair", 0.4, 2),
        ("bin", 0.6, 1),
        ("pallet", 0.2, 2),
        ("ladder", 0.12, 1),
    ):
        for _ in range(rng.randint(0, most)):
            if room.chance(often) and not room.full(0.45):
                (room.against if room.chance(0.7) else room.free)(kind)
    for _ in range(rng.randint(1, 5)):
        room.hang(rng.choice(["mirror", "sign", "picture", "board"]), middle=(1.4, 2.0))


def workshop(room: Room) -> None:
    """Benches along the walls with tools above, shelves of boxes, machines, crates, and things in the way."""
    rng = room.rng
    for _ in range(rng.randint(1, 2) + int(room.area / 22)):
        bench = room.against("workbench", corner=0.3, tries=20)
        if bench is None:
            continue
        if room.chance(0.75):
            room.above("tool_board", bench, rng.uniform(1.15, 1.35))
        if room.chance(0.6):
            room.before("stool", bench, rng.uniform(0.0, 0.3), shift=rng.uniform(-0.5, 0.5))
    for _ in range(2 + int(room.area / 14)):
        if not room.full(0.45):
            room.against(
                rng.choice(["shop_rack", "shop_rack", "cabinet", "tool_cabinet", "locker", "shelf"]),
                corner=0.4,
            )
    for _ in range(int(room.area / rng.uniform(9, 16))):
        if not room.full(0.45):
            room.free(rng.choice(["machine", "machine", "workbench", "pallet", "table"]), margin=0.5)
    for kind, often, most in (
        ("crate", 0.7, 5),
        ("box", 0.8, 7),
        ("pallet", 0.4, 3),
        ("barrel", 0.4, 4),
        ("ladder", 0.6, 2),
        ("bin", 0.8, 2),
        ("stool", 0.5, 3),
        ("bicycle", 0.2, 2),
        ("cable", 0.6, 3),
        ("cleaning", 0.5, 2),
        ("fan", 0.3, 1),
        ("heater", 0.3, 1),
        ("bag", 0.5, 3),
        ("chair", 0.4, 2),
        ("plant", 0.1, 1),
    ):
        for _ in range(rng.randint(0, most)):
            if room.chance(often) and not room.full(0.5):
                (room.against if room.chance(0.75) else room.free)(kind)
    for kind, most in (
        ("tool_board", 2),
        ("wall_shelf", 2),
        ("extinguisher", 1),
        ("sign", 2),
        ("board", 1),
        ("clock", 1),
    ):
        for _ in range(rng.randint(0, most)):
            room.hang(kind, middle=(1.4, 1.8))


def empty(room: Room) -> None:
    """A room before anyone moves in, or after everyone left: a few things, or none."""
    rng = room.rng
    for _ in range(rng.choice([0, 0, 1, 2, 4, 7])):
        kind = rng.choice(
            [
                "ladder",
                "box",
                "box",
                "box",
                "chair",
                "bag",
                "bin",
                "cable",
                "crate",
                "book_pile",
                "cleaning",
                "table",
                "rug",
                "shelf",
                "plant",
            ]
        )
        (room.against if room.chance(0.7) else room.free)(kind)
