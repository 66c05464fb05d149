"""Shops and workshops."""

from __future__ import annotations

import math

from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.furnish.rows import racks_across

__all__ = ["shop", "workshop"]


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
        racks_across(room, wall, rng.uniform(1.2, 1.7))
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
    room.scatter(
        (
            ("plant", 0.5, 4),
            ("box", 0.6, 4),
            ("person", 0.2, 2),
            ("basket", 0.6, 3),
            ("chair", 0.4, 2),
            ("bin", 0.6, 1),
            ("pallet", 0.2, 2),
            ("ladder", 0.12, 1),
        ),
        full=0.45,
        walls=0.7,
    )
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
    room.scatter(
        (
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
        ),
        full=0.5,
        walls=0.75,
    )
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
