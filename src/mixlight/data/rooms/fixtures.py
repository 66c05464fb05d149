"""Artificial light and the sky of a plan: what hangs where, how strong and how warm, and what is on."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace

from mixlight.data.rooms.fixture_ceiling import ceiling, plain_lamp
from mixlight.data.rooms.fixture_lamps import candles, lamps, sconces, screens, under_cabinets
from mixlight.data.rooms.fixture_site import Site
from mixlight.data.rooms.plan import Fixture, Item, Plan
from mixlight.data.rooms.skies import OutdoorSky
from mixlight.data.rooms.sky import choose_sky, daylight
from mixlight.data.rooms.switches import chance_on

__all__ = ["light", "place_fixtures"]

_DARKEST = 80.0
"""Lux of daylight below which a lamp is on by day, too."""


def light(plan: Plan, rng: random.Random, skies: Sequence[OutdoorSky] = ()) -> Plan:
    """The plan with its sky and its lamps.

    Args:
        plan: spaces, openings and items; cameras may come later.
        rng: the plan's source of chance.
        skies: what `skies.read_skies` gave; without any the sky is analytic.
    """
    return place_fixtures(replace(plan, sky=choose_sky(plan, rng, skies)), rng)


def place_fixtures(plan: Plan, rng: random.Random) -> Plan:
    """Lamps by the kind of room, switched as people do at the sky's time of day.

    At least one group is on unless daylight comes in. Small things on tables make way for lamps.
    """
    site = Site(plan, rng)
    makers: tuple[Callable[[Site], None], ...] = (ceiling, sconces, lamps, under_cabinets, screens, candles)
    for make in makers:
        make(site)
    if not _own(site.fixtures) and (plan.spaces[0].kind != "empty" or not _daylight(plan)):
        plain_lamp(site)
    for space in range(1, len(plan.spaces)):
        ceiling(Site(plan, rng, space, site))
    fixtures = tuple(_switched(plan, site.fixtures, rng))
    return replace(plan, items=_without(plan.items, site.gone), fixtures=fixtures)


def _without(items: tuple[Item, ...], gone: set[int]) -> tuple[Item, ...]:
    """The items that stay, with their supports at their new places."""
    place = {old: new for new, old in enumerate(i for i in range(len(items)) if i not in gone)}
    return tuple(
        replace(items[old], supported_by=None if (on := items[old].supported_by) is None else place[on])
        for old in place
    )


def _switched(plan: Plan, fixtures: list[Fixture], rng: random.Random) -> list[Fixture]:
    first: dict[str, Fixture] = {}
    for fixture in fixtures:
        first.setdefault(fixture.group, fixture)
    on = {
        group: rng.random() < chance_on(f.kind, plan.spaces[f.space].kind, plan.sky.time)
        for group, f in first.items()
    }
    own = list(dict.fromkeys(f.group for f in _own(fixtures)))
    if own and not _daylight(plan) and not any(on[group] for group in own):
        on[rng.choice(own)] = True
    return [replace(fixture, on=on[fixture.group]) for fixture in fixtures]


def _own(fixtures: Sequence[Fixture]) -> list[Fixture]:
    """Lamps of the main space that are there to light it."""
    return [f for f in fixtures if f.space == 0 and f.kind not in ("screen", "candle")]


def _daylight(plan: Plan) -> bool:
    return plan.sky.time == "day" and daylight(plan) > _DARKEST
