"""What shines through the windows: which sky, how bright, where the sun stands; and its map."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.rooms.outline import area, edges
from mixlight.data.rooms.plan import Colour, Plan, Point3, Sky
from mixlight.data.rooms.skies import OutdoorSky, Time, horizontal_illuminance
from mixlight.data.rooms.sky_analytic import analytic_map
from mixlight.data.rooms.switches import likely_times
from mixlight.image import exr
from mixlight.sphere import equirect

__all__ = ["LUMENS_PER_UNIT", "TURNS", "choose_sky", "daylight", "sky_map"]

LUMENS_PER_UNIT = 683.0
"""Radiance 1 of a rendered room is this many cd/m²."""

TURNS = 64
"""Skies are turned by whole parts of a turn, which roll their columns exactly."""

_SUN_ANGLE = 0.02
"""Angular diameter in radians, twice the sun's. A panorama lit by the sun's own disc alone would be 180,000
times as bright there as on average, beyond half floats; from this disc it is 40,000 times."""


_DRESSINGS = {"curtain": 0.08, "sheer": 0.5, "venetian": 0.3, "roller": 0.2}
"""Share of the light that passes through what hangs before a window."""


def choose_sky(plan: Plan, rng: random.Random, skies: Sequence[OutdoorSky] = ()) -> Sky:
    """Draws the time of day and what is outside.

    The sky's light on open ground follows the height of the sun where there is one, E = 800 + 15500
    sqrt(sin h) lux under a clear sky; overcast days have 3 to 25 thousand lux, dusk 30 to 2000, night .2 to
    15. The sun keeps its ratio to the sky, up to the 128 klx exp(-.2 / sin h) of clear air. Four in ten suns
    are turned so that they shine in at a window.

    Args:
        plan: the room with its openings.
        rng: the plan's own source of chance.
        skies: what `read_skies` gave; without any the sky is analytic.
    """
    kind = plan.spaces[0].kind
    time: Time = rng.choices(("day", "dusk", "night"), likely_times(kind))[0]
    fitting = [sky for sky in skies if sky.time == time]
    step = rng.randrange(TURNS)
    inward = rng.random() < 0.4
    place = rng.random()
    if fitting:
        chosen = rng.choice(fitting)
        sun, ratio, temperature = chosen.sun_direction, chosen.sun_ratio, chosen.sun_temperature
        cloud = 0.0 if sun is not None else 1.0
    else:
        chosen = None
        cloud = rng.choice((0.0, rng.uniform(0.1, 0.7), 1.0))
        sun, ratio, temperature = _analytic_sun(time, cloud, rng)
    if sun is not None and inward:
        step = _towards_window(plan, sun, place, step)
    turn = 2 * math.pi * step / TURNS
    height = None if sun is None else max(sun[2], 0.02)
    illuminance = _illuminance(time, height, rng)
    sun_illuminance = 0.0
    if sun is not None and height is not None:
        clear = 128e3 * math.exp(-0.2 / height) * rng.uniform(0.85, 1.05)
        sun_illuminance = min(ratio * illuminance, clear)
    return Sky(
        time=time,
        file=None if chosen is None else chosen.name,
        turn=turn,
        illuminance=illuminance,
        colour=(1.0, 1.0, 1.0) if chosen is not None else _zenith(time, cloud, rng),
        sun_direction=None if sun is None else _turned(sun, turn),
        sun_illuminance=sun_illuminance,
        sun_temperature=temperature,
        sun_angle=_SUN_ANGLE,
        seed=rng.randrange(2**31),
        cloud=cloud,
    )


def _illuminance(time: str, height: float | None, rng: random.Random) -> float:
    if time == "night":
        return math.exp(rng.uniform(math.log(0.2), math.log(15)))
    if height is not None:
        return (800 + 15500 * math.sqrt(height)) * rng.uniform(0.8, 1.4)
    low, high = (30, 2000) if time == "dusk" else (3e3, 25e3)
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _analytic_sun(time: str, cloud: float, rng: random.Random) -> tuple[Point3 | None, float, float]:
    azimuth, share, dim = rng.uniform(-math.pi, math.pi), rng.random(), rng.uniform(0.3, 1.0)
    if time == "night" or cloud > 0.9:
        return None, 0.0, 5500.0
    elevation = math.radians(3 + 5 * share if time == "dusk" else 10 + 55 * share)
    level = math.cos(elevation)
    direction = (level * math.sin(azimuth), level * math.cos(azimuth), math.sin(elevation))
    temperature = 2200 + 3300 * min(1.0, math.degrees(elevation) / 30)
    # Direct over diffuse of a clear sky, dimmed by thin clouds.
    return direction, 8.0 * math.sqrt(math.sin(elevation)) * (1 if cloud == 0 else dim), temperature


def _zenith(time: str, cloud: float, rng: random.Random) -> Colour:
    warm = rng.uniform(-0.06, 0.06)
    red, blue = {"day": (0.62, 1.6), "dusk": (0.7, 1.5), "night": (0.9, 1.2)}[time]
    return (
        red + (1 - red) * cloud + warm,
        0.9 + 0.1 * cloud,
        blue + (1 - blue) * cloud - warm,
    )


def _turned(direction: Point3, turn: float) -> Point3:
    x, y, z = direction
    c, s = math.cos(turn), math.sin(turn)
    return (c * x - s * y, s * x + c * y, z)


def _towards_window(plan: Plan, sun: Point3, place: float, step: int) -> int:
    """The turn that brings the sun before one of the windows, at up to 50 degrees from its normal."""
    windows = [o for o in plan.openings if o.kind == "window" and o.leads is None and o.space == 0]
    if not windows:
        return step
    window = windows[int(place * len(windows)) % len(windows)]
    inward = edges(plan.spaces[0].outline)[window.edge].inward
    outward = math.atan2(-inward[1], -inward[0])
    aside = math.radians(100) * ((place * len(windows)) % 1.0 - 0.5)
    turn = outward + aside - math.atan2(sun[1], sun[0])
    return round(turn / (2 * math.pi) * TURNS) % TURNS


def daylight(plan: Plan, space: int = 0) -> float:
    """What the sky gives a room through its windows, in lux on the floor, roughly and without the sun.

    E = .3 E_sky sum(window area x share that its dressing lets through) / floor area: a window sees half of
    the sky at a slant, and its panes keep some of it.
    """
    through = 0.0
    for o in plan.openings:
        if o.kind == "window" and o.leads is None and o.space == space:
            covered = float(o.details.get("drawn", 0.0))
            passed = _DRESSINGS.get(str(o.details.get("dressing", "none")), 1.0)
            through += (o.end - o.start) * (o.top - o.bottom) * (1 - covered * (1 - passed))
    return 0.3 * plan.sky.illuminance * through / area(plan.spaces[space].outline)


def sky_map(sky: Sky, skies: Sequence[OutdoorSky] = (), height: int = 512) -> Float[Tensor, "height width 3"]:
    """The outside without the sun, as a panorama in the room's own orientation.

    Convention: radiance 1 is 683 cd/m²; the centre column looks along the room's +Y, what is right of it lies
        at +X. The sky's turn is in it.

    Args:
        sky: of the plan.
        skies: where a sky with a `file` is looked up.
        height: rows of an analytic sky; a panorama keeps its own.

    Raises:
        ValueError: the sky's panorama is not among `skies`.

    >>> outside = sky_map(Sky("day", None, 0.0, 6830.0, (1.0, 1.0, 1.0), None, cloud=1.0), height=64)
    >>> round(horizontal_illuminance(outside), 3)  # 6830 lux / 683
    10.0
    """
    if sky.file is None:
        panorama = analytic_map(sky, height)
    else:
        found = [s for s in skies if s.name == sky.file]
        if not found:
            raise ValueError(f"expected the sky {sky.file!r} among those given, received {len(skies)} others")
        pixels, _ = exr.read(found[0].file)
        panorama = torch.from_numpy(pixels) * torch.tensor(sky.colour)
    panorama = panorama * (sky.illuminance / LUMENS_PER_UNIT / horizontal_illuminance(panorama))
    return equirect.rotate_azimuth(panorama, sky.turn)
