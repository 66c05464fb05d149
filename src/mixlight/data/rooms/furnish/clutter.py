"""The small things: on tables and shelves, on the floor, on walls and ceilings. They make a room lived in."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from random import Random

from mixlight.data.rooms.furnish.mixes import BENCH, DESK, FLOOR, GOODS, HUNG, TOPS
from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.furnish.tops import tops_of
from mixlight.data.rooms.palette import choose

__all__ = ["ceilings", "floors", "tops", "walls"]


_MOST_ON_WALLS = {"clock": 1, "mirror": 2, "board": 3, "hooks": 2}
"""In one space."""


def tops(room: Room) -> None:
    """Small things on every top of the space."""
    rng = room.rng
    for index in range(room.first, len(room.items)):
        item = room.items[index]
        if item.kind not in TOPS:
            continue
        options, rate = TOPS[item.kind]
        if room.kind in ("workshop", "shop") and item.kind in ("table", "desk"):
            options = BENCH if room.kind == "workshop" else GOODS
        if room.kind in ("office", "hall") and item.kind == "table" and room.chance(0.5):
            options = DESK
        surface = min(sum(top.area for top in tops_of(item)), 4.0)
        if surface == 0:
            continue
        count = _about(rng, surface * rate * room.density * rng.lognormvariate(0.0, 0.45))
        count = min(count, 24)
        for _ in range(count):
            kind = choose(rng, options)
            spread = (
                math.pi
                if kind not in ("papers", "books", "frame", "printer", "microwave", "stereo", "laptop")
                else 0.5
            )
            back = kind in ("frame", "books", "vase", "appliance", "microwave", "flowers") and room.chance(
                0.6
            )
            room.on(kind, index, turn=0.0, spread=spread, back=back, tries=4)


def floors(room: Room) -> None:
    """What lies and stands about, mostly near walls and furniture."""
    rng = room.rng
    options, rate = FLOOR[room.kind]
    for _ in range(min(_about(rng, 1.6 * room.area * rate * room.density**0.6), 30)):
        kind = choose(rng, options)
        if room.chance(0.72):
            room.against(kind, gap=rng.uniform(0.01, 0.12), corner=0.3, tries=6)
        else:
            room.free(kind, margin=0.02, loose=math.pi, tries=6)


def walls(room: Room) -> None:
    """Pictures and mirrors, shelves, clocks, radiators under windows."""
    rng, ground = room.rng, room.ground
    kind = room.kind
    home = kind in ("living", "bedroom", "kitchen", "corridor", "bathroom")
    warm = {
        "living": 0.7,
        "bedroom": 0.75,
        "office": 0.6,
        "bathroom": 0.6,
        "kitchen": 0.5,
        "corridor": 0.35,
        "hall": 0.4,
    }.get(kind, 0.3)
    for hole in ground.holes:
        if hole.opening.kind == "window" and hole.bottom > 0.45 and room.chance(warm):
            width = min(hole.end - hole.start, 1.8) * rng.uniform(0.6, 1.0)
            radiator = room.make("radiator", own=True)
            if radiator is not None:
                height = min(radiator.size[2], hole.bottom - 0.2)
                radiator = replace(
                    radiator, size=(round(max(width, 0.4), 3), radiator.size[1], round(height, 3))
                )
                room.hang(
                    radiator, bottom=0.11, edges=[hole.edge], along=(hole.start + hole.end) / 2, tries=1
                )
    if not any(item.kind == "radiator" for item in room.items[room.first :]) and room.chance(0.35):
        room.hang("radiator", bottom=0.12)
    options, per_metre = HUNG[kind]
    perimeter = sum(edge.length for edge in ground.edges)
    widest = 0.6 if kind == "bathroom" else 2.0
    count: Counter[str] = Counter()
    for _ in range(_about(rng, 1.2 * perimeter * per_metre * room.density**0.5)):
        what = choose(rng, options)
        if count[what] >= _MOST_ON_WALLS.get(what, 99):
            continue
        if what == "picture" and widest > 1.0 and room.chance(0.3):
            _group(room)
        elif room.hang(what, middle=(1.35, 1.7), width=widest) is not None:
            count[what] += 1
    if not count["clock"] and room.chance(0.4):
        room.hang("clock", middle=(1.7, 2.1))
    for what, often in (
        ("air_conditioner", 0.12 if kind != "corridor" else 0.02),
        ("hooks", 0.3),
        ("sign", 0.05 if home else 0.35),
        ("extinguisher", 0.0 if home else 0.4),
    ):
        if room.chance(often):
            room.hang(
                what,
                middle={"air_conditioner": (2.1, 2.25), "extinguisher": (0.9, 1.1)}.get(what, (1.5, 1.75)),
            )


def _group(room: Room) -> None:
    """A few pictures side by side, their middles in line."""
    rng = room.rng
    first = room.hang("picture", middle=(1.45, 1.6), width=0.8)
    if first is None or first.edge is None:
        return
    middle = first.item.position[2] + first.item.size[2] / 2
    at = first.along + first.item.size[0] / 2
    for _ in range(rng.randint(1, 4)):
        picture = first.item if room.chance(0.5) else room.make("picture", width=0.8)
        if picture is None:
            continue
        at += picture.size[0] / 2 + rng.uniform(0.04, 0.15)
        if room.hang(picture, middle=(middle, middle), edges=[first.edge], along=at, tries=1) is None:
            return
        at += picture.size[0] / 2


def ceilings(room: Room) -> None:
    """Smoke detectors and vents."""
    rng = room.rng
    if room.chance(0.45):
        room.ceiling("smoke_detector")
    if room.kind in ("office", "hall", "shop", "corridor"):
        for _ in range(_about(rng, room.area / 25)):
            room.ceiling("vent")


def _about(rng: Random, mean: float) -> int:
    """A whole number whose mean is `mean` (Poisson, by its definition; large means by the normal law).

    >>> sum(_about(Random(i), 2.5) for i in range(400)) / 400
    2.5
    """
    if mean > 30:
        return max(0, round(rng.gauss(mean, math.sqrt(mean))))
    limit, product, count = math.exp(-mean), rng.random(), 0
    while product > limit:
        product *= rng.random()
        count += 1
    return count
