"""Kitchens."""

from __future__ import annotations

from mixlight.data.rooms import pieces
from mixlight.data.rooms.furnish.homes import dining
from mixlight.data.rooms.furnish.mixes import mix
from mixlight.data.rooms.furnish.placed import Placed
from mixlight.data.rooms.furnish.room import Room

__all__ = ["kitchen"]


def kitchen(room: Room) -> None:
    """Units along one or two walls, cupboards above them, a fridge, a table or an island."""
    rng = room.rng
    lengths = [
        (max((b - a for a, b in room.stretches(i, 0.62, 0.9)), default=0.0), i)
        for i in range(len(room.ground.edges))
    ]
    walls = [i for length, i in sorted(lengths, reverse=True) if length > 1.2]
    style = room.style
    fridge = room.make("fridge")
    for count, wall in enumerate(walls[: rng.choice([1, 1, 2, 2, 3])]):
        stretches = room.stretches(wall, 0.62, 0.9)
        if not stretches:
            continue
        start, end = max(stretches, key=lambda s: s[1] - s[0])
        if count == 0 and fridge is not None and end - start > 2.2:
            side = rng.choice([0, 1])
            edge = room.ground.edges[wall]
            half = fridge.size[0] / 2 + 0.01
            at = start + half if side == 0 else end - half
            x, y = edge.at(at, fridge.size[1] / 2 + 0.03)
            if room.put(fridge, (x, y, 0.0), edge.turn, edge=wall, along=at) is not None:
                start, end = (start + 2 * half, end) if side == 0 else (start, end - 2 * half)
                fridge = None
        width = min(end - start - 0.01, rng.uniform(2.4, 4.8))
        if width < 0.9:
            continue
        first = start if room.chance(0.5) else end - width - 0.005
        unit = pieces.draw_kitchen(
            rng, style, width, sink=count == 0, hob=count == (0 if len(walls) == 1 else rng.choice([0, 0, 1]))
        )
        edge = room.ground.edges[wall]
        at = first + width / 2
        x, y = edge.at(at, unit.size[1] / 2 + 0.003)
        placed = room.put(unit, (x, y, 0.0), edge.turn, edge=wall, along=at)
        if placed is not None:
            _above_counter(room, placed)
    if fridge is not None:
        room.against(fridge, corner=0.8, tries=30)
    if room.area > 11 and room.chance(0.35):
        island = room.free("island", margin=0.75, tries=20, loose=0.0)
        if island is not None:
            room.forget("bar_stool")
            room.around(island, "bar_stool", share=0.7, ends=False)
    if room.chance(0.8):
        dining(room)
    for kind, often in mix(
        "washing_machine 0.25 shelf 0.3 display_cabinet 0.2 bin 0.8 plant 0.35 low_shelf 0.2 "
        "crate 0.25 stool 0.3 cooker 0.1 pet 0.03 cleaning 0.3 box 0.3"
    ):
        if room.chance(often) and not room.full(0.5):
            room.against(kind, corner=0.5)
    if room.chance(0.3):
        room.free("rug", margin=0.0, tries=6, width=1.8, depth=1.0)


def _above_counter(room: Room, counter: Placed) -> None:
    """Wall cupboards or open shelves over a row of units, where windows let them; a hood over the hob."""
    rng = room.rng
    if counter.edge is None:
        return
    c = counter.item.size[0] / 2
    bottom = rng.uniform(1.38, 1.5)
    height = rng.choice([0.58, 0.7, 0.9])
    hob = counter.item.parameters.get("hob_at")
    if hob is not None and room.chance(0.75):
        hood = pieces.draw("hood", rng, room.style)
        room.hang(
            hood, bottom=rng.uniform(1.5, 1.65), edges=[counter.edge], along=counter.along - hob, tries=1
        )
    if room.chance(0.85):
        width = rng.choice([0.4, 0.5, 0.6])
        at = counter.along - c + width / 2
        shelves = room.chance(0.2)
        while at + width / 2 <= counter.along + c + 0.01:
            if room.chance(0.88):
                unit = pieces.draw_wall_cabinet(rng, room.style, width, height)
                room.hang(
                    room.make("wall_shelf", width=0.9) if shelves else unit,
                    bottom=bottom,
                    edges=[counter.edge],
                    along=at,
                    tries=1,
                )
            at += width
