"""The small things: on tables and shelves, on the floor, on walls and ceilings. They make a room lived in."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.furnish.tops import tops_of
from mixlight.data.rooms.palette import choose

__all__ = ["ceilings", "floors", "tops", "walls"]

_DINING = (
    ("plate", 3),
    ("glass", 3),
    ("cup", 2),
    ("bowl", 2),
    ("bottle", 2),
    ("vase", 1),
    ("flowers", 1),
    ("food", 2),
    ("papers", 1.5),
    ("book", 1),
    ("candle_holder", 0.7),
    ("kitchen_clutter", 1),
    ("phone", 0.7),
    ("laptop", 0.4),
    ("small_box", 1),
    ("small_toy", 0.4),
    ("tray", 0.6),
)
_LOW_TABLE = (
    ("book", 2.5),
    ("books", 2),
    ("cup", 2),
    ("glass", 1.5),
    ("bowl", 1.5),
    ("papers", 2),
    ("vase", 1),
    ("flowers", 0.8),
    ("small_plant", 1),
    ("electronics", 1.5),
    ("candle_holder", 1),
    ("food", 0.8),
    ("tray", 1),
    ("small_toy", 0.6),
    ("phone", 0.7),
    ("bottle", 0.8),
    ("small_box", 0.8),
)
_DISPLAY = (
    ("frame", 3),
    ("vase", 2),
    ("books", 2.5),
    ("small_plant", 2),
    ("ornament", 3),
    ("small_box", 2),
    ("candle_holder", 1.2),
    ("stereo", 0.7),
    ("bowl", 1),
    ("clock", 0.0),
    ("papers", 1),
    ("flowers", 1),
    ("electronics", 0.8),
    ("bottle", 0.5),
    ("book", 1),
)
_DESK = (
    ("papers", 4),
    ("book", 2),
    ("books", 2),
    ("cup", 1.5),
    ("office_clutter", 4),
    ("phone", 1),
    ("small_plant", 0.7),
    ("frame", 0.7),
    ("electronics", 1),
    ("bottle", 0.7),
    ("small_box", 1),
    ("printer", 0.3),
    ("glass", 0.5),
    ("ornament", 0.5),
)
_KITCHEN = (
    ("bottle", 2.5),
    ("appliance", 2.5),
    ("pot", 1.5),
    ("kitchen_clutter", 3.5),
    ("bowl", 1.5),
    ("food", 2),
    ("cup", 2),
    ("plate", 1.5),
    ("glass", 1.5),
    ("can", 1.5),
    ("microwave", 0.5),
    ("small_plant", 0.5),
    ("papers", 0.5),
    ("tray", 0.8),
    ("towel", 0.7),
    ("vase", 0.3),
    ("small_box", 0.7),
)
_BATH = (
    ("bath_clutter", 7),
    ("towel", 2),
    ("cup", 1),
    ("bottle", 3),
    ("small_plant", 0.6),
    ("small_box", 0.8),
    ("candle_holder", 0.5),
    ("clothes", 0.4),
)
_NIGHT = (
    ("book", 2),
    ("books", 1),
    ("glass", 1),
    ("phone", 1.5),
    ("frame", 1),
    ("bottle", 0.6),
    ("papers", 0.7),
    ("small_plant", 0.6),
    ("small_box", 1),
    ("cup", 1),
    ("electronics", 0.7),
)
_BED = (
    ("clothes", 3),
    ("cushion", 3),
    ("blanket", 2),
    ("book", 1),
    ("laptop", 0.6),
    ("small_toy", 0.8),
    ("papers", 0.4),
    ("towel", 0.6),
)
_SEAT = (
    ("cushion", 3),
    ("blanket", 1.5),
    ("book", 0.7),
    ("clothes", 0.8),
    ("papers", 0.6),
    ("small_toy", 0.4),
    ("electronics", 0.4),
)
_BENCH = (
    ("tool", 6),
    ("can", 3),
    ("small_box", 3),
    ("bottle", 1.5),
    ("papers", 1),
    ("cup", 0.6),
    ("goods", 1),
    ("electronics", 1),
    ("appliance", 0.3),
)
_GOODS = (
    ("goods", 5),
    ("small_box", 3),
    ("books", 1),
    ("vase", 1),
    ("clothes", 1.5),
    ("bowl", 0.7),
    ("ornament", 1),
    ("can", 1),
    ("bottle", 1),
    ("small_plant", 0.5),
)
_SHELF = (
    ("books", 4),
    ("book", 1),
    ("ornament", 2),
    ("vase", 1.5),
    ("frame", 1.5),
    ("small_box", 2.5),
    ("small_plant", 1),
    ("bowl", 1),
    ("papers", 1),
    ("electronics", 0.6),
    ("small_toy", 0.8),
    ("bottle", 0.5),
)

_TOPS: dict[str, tuple[tuple[tuple[str, float], ...], float]] = {
    "table": (_DINING, 6.0),
    "round_table": (_DINING, 6.5),
    "coffee_table": (_LOW_TABLE, 8.5),
    "side_table": (_LOW_TABLE, 16.0),
    "ottoman": (_LOW_TABLE, 0.0),
    "nightstand": (_NIGHT, 17.0),
    "desk": (_DESK, 9.0),
    "console": (_DISPLAY, 13.0),
    "sideboard": (_DISPLAY, 11.0),
    "dresser": (_DISPLAY, 10.0),
    "low_shelf": (_DISPLAY, 11.0),
    "tv_stand": (_DISPLAY, 7.0),
    "filing_cabinet": (_DESK, 11.0),
    "drawer_unit": (_DESK, 12.0),
    "shelf": (_SHELF, 15.0),
    "wall_shelf": (_SHELF, 16.0),
    "display_cabinet": (_SHELF, 6.0),
    "cabinet": (_SHELF, 6.0),
    "piano": (_DISPLAY, 5.0),
    "kitchen": (_KITCHEN, 9.0),
    "island": (_KITCHEN, 7.0),
    "washing_machine": (_BATH, 9.0),
    "vanity": (_BATH, 22.0),
    "basin": (_BATH, 22.0),
    "bath": (_BATH, 14.0),
    "toilet": (_BATH, 10.0),
    "bed": (_BED, 1.3),
    "child_bed": (_BED, 1.8),
    "sofa": (_SEAT, 1.2),
    "armchair": (_SEAT, 1.5),
    "workbench": (_BENCH, 12.0),
    "tool_cabinet": (_BENCH, 14.0),
    "shop_rack": (_GOODS, 11.0),
    "display_table": (_GOODS, 12.0),
    "counter": (_GOODS, 7.0),
    "bar_table": (_DINING, 7.0),
    "shoe_rack": (_DISPLAY, 8.0),
    "bench": (_SEAT, 2.0),
    "pallet": (_GOODS, 0.0),
}
"""What stands on a kind of thing, and how many a square metre at the usual density."""

_FLOOR: dict[str, tuple[tuple[tuple[str, float], ...], float]] = {
    "living": (
        (
            ("basket", 2),
            ("book_pile", 2),
            ("bag", 1.5),
            ("box", 1.2),
            ("toy", 1.5),
            ("shoes", 1),
            ("cable", 1),
            ("plant", 1.5),
            ("laundry", 0.4),
            ("bin", 0.5),
        ),
        0.22,
    ),
    "bedroom": (
        (
            ("shoes", 2),
            ("laundry", 2),
            ("bag", 2),
            ("basket", 1.5),
            ("box", 1.5),
            ("book_pile", 1.5),
            ("toy", 0.8),
            ("cable", 0.5),
        ),
        0.32,
    ),
    "office": (
        (("box", 2.5), ("bag", 2), ("bin", 2), ("cable", 1.5), ("book_pile", 1), ("crate", 0.3)),
        0.16,
    ),
    "kitchen": (
        (("bag", 1.5), ("crate", 1), ("bin", 1), ("box", 1), ("basket", 1), ("shoes", 0.4), ("stool", 0.5)),
        0.25,
    ),
    "bathroom": (
        (("basket", 1.5), ("laundry", 1.5), ("bin", 1), ("shoes", 0.7), ("cleaning", 0.8), ("box", 0.3)),
        0.4,
    ),
    "hall": ((("bag", 2), ("box", 1), ("plant", 1.5), ("bin", 0.8), ("basket", 0.5)), 0.05),
    "corridor": ((("shoes", 2.5), ("bag", 2), ("box", 1), ("basket", 1), ("bin", 0.4)), 0.3),
    "shop": ((("box", 2.5), ("basket", 1.5), ("crate", 1), ("bag", 0.7)), 0.1),
    "workshop": ((("box", 2.5), ("crate", 1.5), ("cable", 1.5), ("bin", 0.7), ("bag", 0.6)), 0.18),
    "empty": ((("box", 2), ("cable", 1)), 0.02),
}
"""What lies about on the floor, and how many a square metre."""


def tops(room: Room) -> None:
    """Small things on every top of the space."""
    rng = room.rng
    for index in range(room.first, len(room.items)):
        item = room.items[index]
        if item.kind not in _TOPS:
            continue
        options, rate = _TOPS[item.kind]
        if room.kind in ("workshop", "shop") and item.kind in ("table", "desk"):
            options = _BENCH if room.kind == "workshop" else _GOODS
        if room.kind in ("office", "hall") and item.kind == "table" and room.chance(0.5):
            options = _DESK
        surface = min(sum(top.area for top in tops_of(item)), 4.0)
        if surface == 0:
            continue
        count = _about(rng, surface * rate * room.density * rng.lognormvariate(0.0, 0.45))
        count = min(count, 14)
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
    options, rate = _FLOOR[room.kind]
    for _ in range(min(_about(rng, room.area * rate * room.density), 18)):
        kind = choose(rng, options)
        if room.chance(0.72):
            room.against(kind, gap=rng.uniform(0.01, 0.12), corner=0.3, tries=6)
        else:
            room.free(kind, margin=0.02, loose=math.pi, tries=6)


def walls(room: Room) -> None:
    """Pictures and mirrors, shelves, clocks, radiators under windows."""
    rng, ground = room.rng, room.ground
    kind = room.kind
    home = kind in ("living", "bedroom", "kitchen", "corridor")
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
        edge = ground.edges[hole.edge]
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
    perimeter = sum(edge.length for edge in ground.edges)
    per_metre = {
        "living": 0.28,
        "bedroom": 0.22,
        "office": 0.12,
        "kitchen": 0.12,
        "bathroom": 0.1,
        "hall": 0.12,
        "corridor": 0.25,
        "shop": 0.12,
        "workshop": 0.1,
        "empty": 0.02,
    }[kind]
    for _ in range(_about(rng, perimeter * per_metre * room.density**0.5)):
        what = choose(
            rng,
            [
                ("picture", 6),
                ("mirror", 0.8 if home else 0.3),
                ("wall_shelf", 1.2 if home or kind == "office" else 0.5),
                ("clock", 0.6),
                ("board", 0.4 if home else 1.5),
            ],
        )
        if what == "picture" and room.chance(0.3):
            _group(room)
        else:
            room.hang(what, middle=(1.35, 1.7))
    if room.chance(0.5):
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
