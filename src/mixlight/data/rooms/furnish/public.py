"""Offices, halls, corridors, and rooms that stand empty."""

from __future__ import annotations

import math

from mixlight.data.rooms.furnish.homes import at_desk, dining, seating
from mixlight.data.rooms.furnish.mixes import mix
from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.furnish.rows import chair_rows, desk_rows, racks_across

__all__ = ["corridor", "empty", "hall", "office"]


def office(room: Room) -> None:
    """Desks along the walls or face to face in rows; shelves for files; a table to meet at."""
    rng = room.rng
    room.again("desk")
    if room.area > 22 and room.chance(0.75):
        desk_rows(room)
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
    room.scatter(
        (
            ("plant", 0.7, 4),
            ("bin", 0.9, 4),
            ("water_cooler", 0.2, 1),
            ("coat_stand", 0.4, 1),
            ("box", 0.5, 5),
            ("chair", 0.4, 3),
            ("armchair", 0.25, 2),
            ("bag", 0.5, 3),
        ),
        full=0.45,
        corner=0.3,
    )
    for _ in range(rng.randint(0, 2)):
        room.hang("board", middle=(1.4, 1.6))
    if room.chance(0.15):
        room.free("person", margin=0.2)


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
        racks_across(room, "shelf", rng.uniform(1.3, 2.0), own=True)
        for _ in range(int(room.area / 25)):
            _dining_alike(room)
    if use == "exhibition":
        for _ in range(int(room.area / 16)):
            room.free(rng.choice(["display_table", "display_cabinet", "bench", "plant"]), margin=0.7)
    if use == "rows":
        chair_rows(room)
    if room.chance(0.7):
        room.against("counter", gap=rng.choice([0.02, 1.0]))
    room.scatter(
        (
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
        ),
        full=0.4,
        corner=0.3,
    )
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
