"""Furnishing: a building with openings becomes rooms that people use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from random import Random

from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.furnish import clutter, homes, kitchens, public, trade
from mixlight.data.rooms.furnish.mixes import MORE
from mixlight.data.rooms.furnish.room import Room
from mixlight.data.rooms.pieces import draw_style
from mixlight.data.rooms.plan import Item, Plan

__all__ = ["furnish"]

_RULES: dict[str, Callable[[Room], object]] = {
    "living": homes.living,
    "bedroom": homes.bedroom,
    "kitchen": kitchens.kitchen,
    "bathroom": homes.bathroom,
    "office": public.office,
    "hall": public.hall,
    "corridor": public.corridor,
    "shop": trade.shop,
    "workshop": trade.workshop,
    "empty": public.empty,
}
"""What fills a space of each kind."""


_USUAL = 2.6
"""Small things in the median main space, against the rates of `mixes`; neighbours have less."""


def furnish(plan: Plan, rng: Random, catalogue: Catalogue | None = None) -> Plan:
    """The plan with furniture and small things in every space.

    Things stand on the floor, hang on walls and lie on each other as they do in rooms of that kind; none
    enters another or a wall, doors can swing, windows are not blocked by what is higher than their sill. How
    much lies about differs from room to room, from tidy to messy.

    Args:
        plan: spaces and openings; items that it already has are kept but not looked at.
        rng: the only source of chance: the same state gives the same furniture on any machine.
        catalogue: the library; None: our own pieces only.

    Returns:
        The plan with more items; an item that stands on another comes after it.
    """
    items: list[Item] = list(plan.items)
    for space in range(len(plan.spaces)):
        here = Random(rng.getrandbits(64))  # so that one space does not hang on what was drawn for another
        room = Room(plan, space, here, draw_style(here), catalogue, items)
        room.density = _USUAL * here.lognormvariate(0.0, 0.45) if room.main else 0.8
        if room.kind == "empty":
            room.density *= 0.4
        _RULES[room.kind](room)
        if room.main and room.kind in MORE:
            kinds, share, free = MORE[room.kind]
            room.fill(kinds, share * here.uniform(0.6, 1.15), free=free)
        clutter.walls(room)
        clutter.ceilings(room)
        clutter.floors(room)
        clutter.tops(room)
    return replace(plan, items=tuple(items))
