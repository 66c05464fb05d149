"""Exact relightings: light adds up, so one render of separate light groups is any number of pictures."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.rooms.plan import Colour, Plan, Sky
from mixlight.data.rooms.sky import LUMENS_PER_UNIT
from mixlight.data.rooms.store import SKY, SUN
from mixlight.data.rooms.switches import chance_on, likely_temperature, likely_times
from mixlight.image.color import LUMINANCE_WEIGHTS
from mixlight.image.temperature import COOLEST, WARMEST, black_body
from mixlight.sphere import equirect

__all__ = ["Recipe", "mix", "plan_recipe", "random_recipe", "remix", "white_balance_gain"]

_SAME_TIME = 0.6
"""Share of remixes at the hour of the render: as nights stay nights, too few would see the day else."""
_DIMMEST = (0.5, 4.0)
"""cd/m²: mean luminance around the camera below which somebody reaches for a switch."""


@dataclass(frozen=True)
class Recipe:
    """How bright and of what colour each light group shines."""

    gains: Mapping[str, Colour]
    """Factor of each channel for each group; a group that is not named is off."""
    white_balance: float = 0.0
    """Share of the mean's colour cast that the camera takes out, 0 to 1."""
    facts: Mapping[str, Any] = field(default_factory=dict)
    """What was drawn, for people: time, illuminance, temperatures."""


def mix(
    groups: Mapping[str, Float[Tensor, "*shape 3"]], gains: Mapping[str, Colour]
) -> Float[Tensor, "*shape 3"]:
    """The sum of all groups times their gains: linear and exact.

    Raises:
        ValueError: no groups, a gain for a group that is not there, or one that is negative or not finite.

    >>> lamp = torch.full((1, 2, 3), 2.0)
    >>> mix({"lamp": lamp, "sky": lamp}, {"lamp": (1.0, 0.5, 0.25)})[0, 0]
    tensor([2.0000, 1.0000, 0.5000])
    """
    unknown = [name for name in gains if name not in groups]
    if unknown or not groups:
        raise ValueError(f"expected gains for the groups {list(groups)}, got some for {unknown}")
    if not all(0 <= g < math.inf for gain in gains.values() for g in gain):
        raise ValueError(f"expected finite gains of at least 0, got {dict(gains)}")
    total = torch.zeros_like(next(iter(groups.values())))
    for name, gain in gains.items():
        total = total + groups[name] * torch.tensor(gain, dtype=total.dtype)
    return total


def white_balance_gain(mean: Float[Tensor, "*batch 3"], share: float) -> Float[Tensor, "*batch 3"]:
    """Channel gains that take a share of a colour cast out, and keep its luminance.

    gain_c = (Y / mean_c)^share, times the factor that leaves the luminance Y of `mean` as it was.

    Args:
        mean: mean colour of what the camera measures.
        share: 0 leaves the colours, 1 makes the mean grey.

    >>> white_balance_gain(torch.tensor([2.0, 1.0, 0.5]), 1.0) * torch.tensor([2.0, 1.0, 0.5])
    tensor([1.1765, 1.1765, 1.1765])
    """
    mean = mean.clamp(min=1e-6)
    weights = torch.tensor(LUMINANCE_WEIGHTS, dtype=mean.dtype)
    luminance = (mean @ weights)[..., None]
    cast = (luminance / mean) ** share
    return cast * luminance / ((mean * cast) @ weights)[..., None]


def remix(
    groups: Mapping[str, Float[Tensor, "height width 3"]], recipe: Recipe
) -> Float[Tensor, "height width 3"]:
    """One relighting of a room: its groups mixed, then white-balanced as the recipe says.

    Raises:
        ValueError: as `mix`.
    """
    panorama = mix(groups, recipe.gains)
    if recipe.white_balance:
        panorama = panorama * white_balance_gain(equirect.integrate(panorama), recipe.white_balance)
    return panorama


def plan_recipe(plan: Plan) -> Recipe:
    """The lights as the plan switches them."""
    gains: dict[str, Colour] = {f.group: (1.0, 1.0, 1.0) for f in plan.fixtures if f.on}
    gains[SKY] = (1.0, 1.0, 1.0)
    if plan.sky.sun_direction is not None and plan.sky.sun_illuminance > 0:
        gains[SUN] = (1.0, 1.0, 1.0)
    return Recipe(gains)


def random_recipe(
    groups: Mapping[str, Float[Tensor, "height width 3"]], plan: Plan, rng: random.Random
) -> Recipe:
    """Draws a time of day, which lamps are on, how bright and how warm; no room stays dark.

    A room rendered by day can be seen at any time, though mostly by day; one of dusk or night is never made
    brighter outside than that time allows, as street lamps and lit windows would shine like the sun.
    """
    gains: dict[str, Colour] = {}
    facts: dict[str, Any] = {}
    kind = plan.spaces[0].kind
    time = rng.choices(("day", "dusk", "night"), likely_times(kind))[0]
    order = ("day", "dusk", "night")
    lamps = list(dict.fromkeys(f.group for f in plan.fixtures))
    stays = rng.random() < _SAME_TIME
    if stays or order.index(time) < order.index(plan.sky.time) or not lamps:
        time = plan.sky.time
    facts["time"] = time
    level = _sky_level(time, plan.sky.time, plan.sky.illuminance, rng)
    tint = _tint(6500.0, math.exp(rng.uniform(math.log(4800), math.log(9500))))
    gains[SKY] = _scaled(tint, level / plan.sky.illuminance)
    facts["sky_lx"] = level
    if SUN in groups:
        gain = _sun_gain(time, plan.sky, level, rng)
        if gain > 0:
            warmer = plan.sky.sun_temperature * rng.uniform(0.8, 1.1)
            if time == "dusk" and plan.sky.time == "day":
                warmer = rng.uniform(2100, 3200)
            gains[SUN] = _scaled(_tint(plan.sky.sun_temperature, warmer), gain)
    style = likely_temperature(kind, rng)
    for name in lamps:
        members = [f for f in plan.fixtures if f.group == name]
        first = members[0]
        on = rng.random() < chance_on(first.kind, plan.spaces[first.space].kind, time)
        bright = math.exp(rng.gauss(0.0, 0.45))
        own = style * math.exp(rng.gauss(0.0, 0.06))
        if name not in groups or not on:
            continue
        temperature = sum(f.temperature for f in members) / len(members)
        if first.kind in ("screen", "candle"):
            own = temperature * math.exp(rng.gauss(0.0, 0.03))
        gains[name] = _scaled(_tint(temperature, own), bright)
        facts[name] = round(own)
    _keep_lit(gains, groups, lamps, rng)
    return Recipe(gains, rng.uniform(0.6, 1.0), facts)


def _sky_level(time: str, rendered: str, illuminance: float, rng: random.Random) -> float:
    if time == rendered:
        return illuminance * math.exp(rng.gauss(0.0, 0.5))
    low, high = {"dusk": (30.0, 2000.0), "night": (0.05, 8.0)}[time]
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _sun_gain(time: str, sky: Sky, level: float, rng: random.Random) -> float:
    """As bright as rendered or a little less; at dusk of a sunny day, up to twice the sky's light."""
    clouded, share = rng.random() < 0.3, rng.random()
    if time == "night" or clouded:
        return 0.0
    return 0.3 + 0.8 * share if time == sky.time else (0.1 + 1.9 * share) * level / sky.sun_illuminance


def _tint(was: float, becomes: float) -> Colour:
    """Gain that turns the light of one black body into that of another, as bright."""
    ratio = black_body(min(max(becomes, WARMEST), COOLEST)) / black_body(min(max(was, WARMEST), COOLEST))
    red, green, blue = (float(c) for c in ratio)
    return red, green, blue


def _scaled(colour: Colour, factor: float) -> Colour:
    return colour[0] * factor, colour[1] * factor, colour[2] * factor


def _keep_lit(
    gains: dict[str, Colour],
    groups: Mapping[str, Float[Tensor, "height width 3"]],
    lamps: list[str],
    rng: random.Random,
) -> None:
    """Switches lamps on until the room is as bright as people bear it, at random, strong ones first."""
    means = {name: float(pixels.mean()) for name, pixels in groups.items()}
    wanted = math.exp(rng.uniform(math.log(_DIMMEST[0]), math.log(_DIMMEST[1]))) / LUMENS_PER_UNIT
    lit = sum(means[name] * sum(gain) / 3 for name, gain in gains.items() if name in means)
    off = [name for name in lamps if name not in gains and means.get(name, 0.0) > 0]
    while off and lit < wanted:
        name = rng.choices(off, [math.sqrt(means[n]) for n in off])[0]
        off.remove(name)
        gains[name] = (1.0, 1.0, 1.0)
        lit += means[name]
    if not lit > 0:
        gains[SKY] = (1.0, 1.0, 1.0)
