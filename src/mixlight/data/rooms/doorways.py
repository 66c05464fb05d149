"""Doors and passages: between two spaces, and shut doors that lead elsewhere."""

from __future__ import annotations

from random import Random
from typing import Literal

from mixlight.data.rooms.building import Building
from mixlight.data.rooms.footprints import millimetres
from mixlight.data.rooms.outline import edges, holes_of
from mixlight.data.rooms.palette import choose
from mixlight.data.rooms.plan import Opening
from mixlight.data.rooms.plan_json import surface_document

__all__ = ["add_shut_doors", "draw_doorway"]

_OPEN_PLAN: dict[frozenset[str], float] = {
    frozenset({"living", "kitchen"}): 0.7,
    frozenset({"living"}): 0.9,
    frozenset({"hall"}): 0.9,
    frozenset({"shop"}): 0.8,
    frozenset({"hall", "living"}): 0.7,
    frozenset({"living", "corridor"}): 0.3,
    frozenset({"hall", "corridor"}): 0.5,
    frozenset({"office"}): 0.35,
    frozenset({"workshop"}): 0.6,
}
"""Probability that two kinds are joined by a passage without a door."""


def draw_doorway(
    rng: Random, building: Building, here: str, there: str
) -> tuple[float, float, float, dict[str, object], Literal["door", "passage"]]:
    """Width, top, depth, details and kind of the opening between two spaces."""
    depth = millimetres(rng.uniform(0.09, 0.24))
    if rng.random() < _OPEN_PLAN.get(frozenset({here, there}), 0.08):
        width = rng.uniform(0.95, 1.6) if rng.random() < 0.5 else rng.uniform(1.6, 4.2)
        top = rng.choice([2.05, 2.15, 2.3, 2.5, 9.0])  # the last: up to a lintel under the ceiling
        return width, top, depth, {"lining": rng.random() < 0.3, **_lining(building)}, "passage"
    width, details = door_details(rng, building, here)
    details["angle"] = round(choose(rng, [(rng.uniform(1.2, 1.57), 3.0), (rng.uniform(0.15, 1.2), 2.0)]), 3)
    return width, rng.choice([1.98, 2.01, 2.05, 2.1]), depth, details, "door"


def _lining(building: Building) -> dict[str, object]:
    return {"frame": surface_document(building.palette.trim)}


def door_details(rng: Random, building: Building, here: str) -> tuple[float, dict[str, object]]:
    """Width and details of a door."""
    wide = here in ("hall", "shop", "workshop", "office") and rng.random() < 0.3
    width = millimetres(rng.uniform(1.3, 1.9) if wide else rng.uniform(0.68, 0.95))
    style = choose(rng, [("panel", 4.0), ("flush", 3.5), ("glazed", 1.5 if here != "bathroom" else 0.1)])
    details: dict[str, object] = {
        "frame": surface_document(building.palette.trim),
        "leaf": surface_document(building.palette.door),
        "metal": surface_document(building.palette.metal),
        "style": style,
        "leaves": 2 if wide else 1,
        "hinge": rng.choice(["start", "end"]),
        "into": rng.random() < 0.5,
        "angle": 0.0,
    }
    return width, details


def add_shut_doors(rng: Random, building: Building, space: int) -> None:
    """Every room can be entered: a shut door where there is no other way, sometimes one more."""
    here = building.spaces[space]
    ways = [h for h in holes_of(building.spaces, building.openings, space) if h.opening.kind != "window"]
    wanted = (0 if ways else 1) + choose(rng, [(0, 7.5), (1, 2.0), (2, 0.5)])
    if here.kind == "corridor":
        wanted += rng.randint(0, 3)
    order = [i for i in range(len(here.outline)) for _ in range(3)]
    rng.shuffle(order)
    for edge_index in order:
        if wanted <= 0:
            return
        width, details = door_details(rng, building, here.kind)
        length = edges(here.outline)[edge_index].length
        if length < width + 0.3:
            continue
        start = rng.choice([0.15, length - width - 0.15, rng.uniform(0.15, length - width - 0.15)])
        start, end = millimetres(start), millimetres(start + width)
        # A shut door needs its wall's thickness: no other room may begin right behind it.
        e = edges(here.outline)[edge_index]
        if building.free(space, edge_index, start, end, 0.12) and building.clear(
            e.rectangle(start, end, -0.1, -0.02)
        ):
            top = min(rng.choice([1.98, 2.01, 2.05, 2.1]), here.height - 0.15)
            building.openings.append(
                Opening("door", space, edge_index, start, end, 0.0, millimetres(top), None, 0.06, details)
            )
            wanted -= 1
