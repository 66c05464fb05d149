"""Living rooms, bedrooms, bathrooms."""

from __future__ import annotations

import math
from dataclasses import replace

from mixlight.data.rooms import pieces
from mixlight.data.rooms.furnish.mixes import mix
from mixlight.data.rooms.furnish.placed import Placed
from mixlight.data.rooms.furnish.room import Room

__all__ = ["bathroom", "bedroom", "dining", "living", "seating", "work_place"]


def living(room: Room) -> None:
    """A group to sit, something to look at, shelves; a table to eat at or a desk where there is place."""
    rng = room.rng
    group = seating(room)
    if group is not None and room.chance(0.75):
        _television(room, group)
    if room.area > 30 and room.chance(0.45):
        seating(room)
    if room.area > 14 and room.chance(0.6):
        dining(room)
    if room.chance(0.35):
        work_place(room)
    for kind, often in mix(
        "shelf 0.85 sideboard 0.6 display_cabinet 0.35 low_shelf 0.45 dresser 0.3 "
        "console 0.25 piano 0.1 shelf 0.5 cabinet 0.35"
    ):
        if room.chance(often) and not room.full():
            room.against(kind)
    for _ in range(rng.randint(1, 4)):
        room.against("plant", corner=0.6)
    for kind, often in mix(
        "armchair 0.3 ottoman 0.35 speaker 0.25 floor_vase 0.2 basket 0.45 bench 0.15 "
        "pet 0.04 toy 0.2 fan 0.1 screen_divider 0.05"
    ):
        if room.chance(often) and not room.full():
            (room.free if room.chance(0.35) else room.against)(kind)


def seating(room: Room) -> Placed | None:
    """A sofa, a low table before it, chairs beside it, a rug under it all."""
    rng = room.rng
    sofa = room.against(
        "sofa",
        gap=rng.choice([0.03, 0.08, 0.25]),
        corner=0.15,
        tries=24,
        width=min(room.bounds[2] - room.bounds[0], 3.6),
    )
    if sofa is None:
        sofa = room.free("sofa", margin=0.05, tries=16) or room.against("armchair", tries=20)
    if sofa is None:
        return None
    table = None
    if room.chance(0.85):
        table = room.before(
            "coffee_table", sofa, rng.uniform(0.3, 0.5), shift=rng.uniform(-0.25, 0.25), facing=False
        )
    if room.chance(0.7):
        _rug_under(room, table or sofa, rng.uniform(1.5, 2.6), rng.uniform(1.2, 2.0), 0.0 if table else -0.9)
    if table is not None:
        for side in (-1, 1):
            if room.chance(0.55):
                reach = table.item.size[0] / 2 + rng.uniform(0.55, 0.9)
                chair = room.make("armchair")
                if chair is not None:
                    c, s = math.cos(table.item.turn), math.sin(table.item.turn)
                    x, y = (
                        table.item.position[0] + c * side * reach,
                        table.item.position[1] + s * side * reach,
                    )
                    turn = sofa.item.turn - side * math.pi / 2 + rng.uniform(-0.4, 0.4)
                    room.put(chair, (x, y, 0.0), turn)
    for side in (-1, 1):
        if room.chance(0.5):
            room.beside("side_table", sofa, side)
    if room.chance(0.2):
        room.before(room.make("ottoman"), sofa, 0.2, shift=rng.uniform(-0.6, 0.6))
    return sofa


def _rug_under(room: Room, thing: Placed, width: float, depth: float, shift: float) -> None:
    rug = pieces.draw("rug", room.rng, room.style)
    rug = replace(rug, size=(round(width, 3), round(depth, 3), rug.size[2]))
    base = thing.item
    c, s = math.cos(base.turn), math.sin(base.turn)
    x, y = base.position[0] - s * shift, base.position[1] + c * shift
    for _ in range(6):
        if room.put(rug, (x, y, 0.0), base.turn + room.rng.uniform(-0.03, 0.03), ways=False) is not None:
            return
        rug = replace(rug, size=(rug.size[0] * 0.85, rug.size[1] * 0.85, rug.size[2]))


def _television(room: Room, group: Placed) -> None:
    edges = room.opposite(group)
    if not edges:
        return
    stand = room.against("tv_stand", edges=edges, near=group, corner=0.0, tries=20)
    if stand is None or room.chance(0.25):
        room.hang("wall_tv", middle=(1.05, 1.35), edges=edges)
        return
    limit = stand.item.size[0] * 0.95
    screen = room.make("tv", width=limit)
    room.on(screen, stand, x=room.rng.uniform(-0.3, 0.3), y=0.6, turn=0.0, spread=0.06)


def dining(room: Room) -> Placed | None:
    """A table with matching chairs; a rug or nothing under it."""
    kind = room.rng.choice(["table", "table", "round_table"])
    table = room.free(kind, margin=0.45, tries=20, loose=0.03) or room.free(
        kind, margin=0.2, tries=20, loose=0.02
    )
    if table is None:
        table = room.against("table", gap=0.03, width=1.5)
    if table is None:
        return None
    if room.chance(0.3):
        _rug_under(room, table, table.item.size[0] + 0.9, table.item.size[1] + 0.9, 0.0)
    room.forget("chair")
    room.around(table, "chair", share=0.92)
    return table


def work_place(room: Room, *, chair: str = "office_chair") -> Placed | None:
    """A desk against a wall, a chair at it, a screen on it."""
    desk = room.against("desk", corner=0.35)
    if desk is None:
        return None
    at_desk(room, desk, chair)
    return desk


def at_desk(room: Room, desk: Placed, chair: str) -> None:
    """What makes a desk a work place."""
    rng = room.rng
    seat = room.again(chair) if room.chance(0.8) else room.make("chair")
    if seat is not None:
        room.before(seat, desk, rng.uniform(-0.25, 0.3), shift=rng.uniform(-0.2, 0.2), loose=0.7, ways=False)
    if room.chance(0.3):
        laptop = room.make("laptop")
        room.on(laptop, desk, x=rng.uniform(-0.4, 0.4), y=rng.uniform(-0.7, 0.0), turn=0.0, spread=0.25)
    if room.chance(0.75):
        count = rng.choice([1, 1, 2])
        for i in range(count):
            x = rng.uniform(-0.35, 0.35) if count == 1 else (-0.45, 0.45)[i]
            room.on(room.again("monitor"), desk, x=x, y=rng.uniform(0.5, 0.95), turn=0.0, spread=0.2)
        room.on("keyboard", desk, x=rng.uniform(-0.2, 0.2), y=-0.75, turn=0.0, spread=0.08)
    if room.chance(0.45):
        for side in (rng.choice([-1, 1]),):
            room.beside("drawer_unit", desk, side, gap=0.03)


def bedroom(room: Room) -> None:
    """A bed with a table on either side, a place for clothes, a place to sit."""
    rng = room.rng
    single = room.area < 9.5 or room.chance(0.25)
    bed = room.against("child_bed" if single else "bed", gap=0.02, corner=0.9 if single else 0.05, tries=40)
    if bed is None and not single:
        bed = room.against("child_bed", gap=0.02, corner=0.9, tries=40)
    if bed is not None:
        room.forget("nightstand")
        for side in (-1, 1):
            if room.chance(0.8):
                table = room.again("nightstand") if room.chance(0.8) else room.make("side_table")
                room.beside(table, bed, side, gap=rng.uniform(0.03, 0.12))
        if room.chance(0.6):
            _rug_under(
                room,
                bed,
                bed.item.size[0] + rng.uniform(0.6, 1.2),
                rng.uniform(1.2, 2.0),
                -rng.uniform(0.5, 1.1),
            )
        if room.chance(0.6):
            picture = room.make("picture", width=bed.item.size[0])
            room.above(picture, bed, rng.uniform(1.25, 1.5))
        if room.chance(0.2):
            room.before("bench", bed, 0.03, facing=False)
    for kind, often in mix(
        "wardrobe 0.9 dresser 0.75 wardrobe 0.25 shelf 0.55 low_shelf 0.45 cabinet 0.2 clothes_rack 0.2"
    ):
        if room.chance(often) and not room.full(0.55):
            placed = room.against(kind, corner=0.5, tries=20)
            if placed is not None and kind == "dresser" and room.chance(0.5):
                room.above("mirror", placed, placed.item.size[2] + 0.12, width=1.2)
    if room.chance(0.55):
        work_place(room, chair="chair")
    for kind, often in mix(
        "armchair 0.45 plant 0.5 hamper 0.6 chair 0.3 toy 0.2 basket 0.5 ottoman 0.2 sports 0.06 fan 0.12"
    ):
        if room.chance(often) and not room.full(0.55):
            room.against(kind, corner=0.4)


def bathroom(room: Room) -> None:
    """Bath or shower, basin with a mirror, toilet, and all that stands around them."""
    rng = room.rng
    if room.chance(0.6):
        if room.against("bath", gap=0.005, corner=0.95, tries=40) is None:
            room.against("shower", gap=0.005, corner=1.0, tries=40)
    else:
        room.against("shower", gap=0.005, corner=1.0, tries=40)
    if room.area > 6.5 and room.chance(0.5):
        room.against("shower", gap=0.005, corner=1.0, tries=30)
    basin = room.against(
        rng.choice(["vanity", "vanity", "basin"]), gap=0.003, corner=0.1, tries=40
    ) or room.against("basin", gap=0.003, tries=40)
    if basin is not None:
        width = min(basin.item.size[0] * rng.uniform(0.7, 1.1), 1.4)
        mirror = room.make("mirror", width=max(width, 0.45), own=True)
        room.above(mirror, basin, rng.uniform(1.05, 1.2))
    toilet = room.against("toilet", gap=0.003, corner=0.1, tries=40)
    if toilet is not None:
        room.hang("paper_roll", bottom=rng.uniform(0.6, 0.8), tries=4)
        if room.chance(0.7):
            room.beside("cleaning", toilet, rng.choice([-1, 1]), gap=0.08)
    for kind, often in mix(
        "washing_machine 0.35 hamper 0.6 cabinet 0.25 shelf 0.25 stool 0.3 bin 0.6 plant 0.25 drawer_unit 0.2"
    ):
        if room.chance(often) and not room.full(0.6):
            room.against(kind, corner=0.4, width=0.8)
    for _ in range(rng.randint(1, 4)):
        room.hang("towel_rail", middle=(1.0, 1.5))
    if room.chance(0.7):
        room.free("rug", margin=0.0, tries=8, width=1.0, depth=0.7)
    if room.chance(0.4):
        room.hang("wall_shelf", middle=(1.2, 1.6), width=0.7)
    if room.chance(0.3):
        room.hang("wall_cabinet", middle=(1.4, 1.7), width=0.7)
