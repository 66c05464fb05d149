"""A seed becomes a plan."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from mixlight.data.rooms.cameras import place_cameras
from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.fixtures import light
from mixlight.data.rooms.furnish import furnish
from mixlight.data.rooms.layout import draw_building
from mixlight.data.rooms.plan import KINDS, Plan, Sky
from mixlight.data.rooms.plan_json import plain
from mixlight.data.rooms.skies import OutdoorSky

__all__ = ["make_plan", "stream"]

_DAYLIGHT = Sky("day", None, 0.0, 10_000.0, (0.75, 0.87, 1.0), None)
"""Until `light` has chosen one."""


def stream(seed: int, name: str) -> Random:
    """Random numbers of one stage of a room: the same on every machine, apart from those of the other stages.

    >>> round(stream(7, "layout").random(), 6)
    0.107558
    """
    return Random(f"mixlight rooms {seed} {name}")


def make_plan(
    seed: int,
    *,
    library: Catalogue | None = None,
    skies: Sequence[OutdoorSky] = (),
    cameras: int = 3,
    kind: str | None = None,
) -> Plan:
    """The room of a seed: its building, then its furniture, its light and its cameras.

    The same arguments give the same plan on any machine. Each stage draws from numbers of its own, so that a
    change of the furniture leaves the walls where they are. The plan is the one that `plan_json.from_json`
    gives back.

    Args:
        seed: a number of the room.
        library: furniture beside the own pieces; None: own pieces only.
        skies: outdoor panoramas, as `skies.read_skies` gives them; empty: analytic skies.
        cameras: how many panoramas are taken.
        kind: one of `KINDS` for the main space; None: drawn.

    Raises:
        ValueError: an unknown kind, fewer than one camera, or a room in which no camera has a place.

    >>> plan = make_plan(1, kind="bedroom")
    >>> plan.spaces[0].kind, len(plan.cameras)
    ('bedroom', 3)
    """
    if kind is not None and kind not in KINDS:
        raise ValueError(f"expected one of {', '.join(KINDS)}, got {kind!r}")
    building = draw_building(stream(seed, "layout"), kind)
    plan = Plan(seed, tuple(building.spaces), tuple(building.openings), (), (), _DAYLIGHT, ())
    plan = furnish(plan, stream(seed, "furnish"), library)
    plan = light(plan, stream(seed, "light"), skies)
    return plain(place_cameras(plan, stream(seed, "cameras"), cameras))
