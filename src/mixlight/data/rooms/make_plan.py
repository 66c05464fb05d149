"""A seed becomes a plan."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Sequence
from random import Random
from typing import Any

from mixlight.data.rooms.cameras import place_cameras
from mixlight.data.rooms.layout import draw_building
from mixlight.data.rooms.plan import KINDS, Plan, Sky
from mixlight.data.rooms.plan_json import plain
from mixlight.data.rooms.skies import OutdoorSky

__all__ = ["make_plan", "stream"]

_DAYLIGHT = Sky("day", None, 0.0, 10_000.0, (0.75, 0.87, 1.0), None)


def stream(seed: int, name: str) -> Random:
    """Random numbers of one stage of a room: the same on every machine, apart from those of the other stages.

    >>> round(stream(7, "layout").random(), 6) == round(stream(7, "layout").random(), 6)
    True
    """
    return Random(f"mixlight rooms {seed} {name}")


def make_plan(
    seed: int,
    *,
    library: Any = None,
    skies: Sequence[OutdoorSky] = (),
    cameras: int = 3,
    kind: str | None = None,
) -> Plan:
    """The room of a seed: its building, then its furniture, its light and its cameras.

    The same arguments give the same plan on any machine. Each stage draws from numbers of its own, so that a
    change of the furniture leaves the walls where they are.

    Args:
        seed: a number of the room.
        library: furniture beside the own pieces (`catalogue.Catalogue`); None: own pieces only.
        skies: outdoor panoramas (`skies.read_skies`); empty: analytic skies.
        cameras: how many panoramas are taken.
        kind: one of `KINDS` for the main space; None: drawn.

    Raises:
        ValueError: an unknown kind, fewer than one camera, or a room in which no camera has a place.
    """
    if kind is not None and kind not in KINDS:
        raise ValueError(f"expected one of {', '.join(KINDS)}, got {kind!r}")
    building = draw_building(stream(seed, "layout"), kind)
    plan = Plan(seed, tuple(building.spaces), tuple(building.openings), (), (), _DAYLIGHT, ())
    plan = _stage("furnish", "furnish")(plan, stream(seed, "furnish"), library)
    plan = _stage("fixtures", "light")(plan, stream(seed, "light"), skies)
    return plain(place_cameras(plan, stream(seed, "cameras"), cameras))


def _stage(module: str, name: str) -> Any:
    full = f"mixlight.data.rooms.{module}"
    if importlib.util.find_spec(full) is None:
        return lambda plan, rng, choice: plan
    return getattr(importlib.import_module(full), name, lambda plan, rng, choice: plan)
