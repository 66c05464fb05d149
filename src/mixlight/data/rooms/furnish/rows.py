"""Rows across a large room: desks, racks, chairs."""

from __future__ import annotations

import math
from dataclasses import replace

from mixlight.data.rooms.furnish.homes import at_desk
from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.plan import Item

__all__ = ["chair_rows", "desk_rows", "racks_across"]


def desk_rows(room: Room) -> None:
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
                position, turn = _in_row(room, along, at, across, side * (depth / 2 + 0.012))
                placed = room.put(desk, position, turn)
                if placed is not None:
                    at_desk(room, placed, "office_chair")
            number += 1
            at += pitch + (1.2 if number % block == 0 else 0.0)
        across += aisle


def racks_across(room: Room, kind: str, aisle: float, *, own: bool | None = None) -> None:
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
                position, turn = _in_row(room, along, at, across, side * (rack.size[1] / 2 + 0.004))
                room.put(rng.choice(racks), position, turn)
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


def _in_row(
    room: Room, along: float, at: float, across: float, off: float
) -> tuple[tuple[float, float, float], float]:
    """Position and turn of a thing in a double row, `at` metres along it, its middle `across` from the wall.

    `along`: 0 for rows along x, else along y. `off`: metres from the row's middle; the thing faces away from
    it, so that two stand back to back.
    """
    x0, y0, _, _ = room.bounds
    if along == 0.0:
        return (x0 + at, y0 + (across + off), 0.0), 0.0 if off < 0 else math.pi
    return (x0 + (across + off), y0 + at, 0.0), -math.pi / 2 if off < 0 else math.pi / 2


def chair_rows(room: Room) -> None:
    """Chairs that all face one way, an aisle in the middle, a table before them."""
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
