"""What readers of targets share: harmonics, lights and the words about a rig, checked entry by entry."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import entries
from mixlight.light.lights import Light
from mixlight.sphere.frames import convert_directions

__all__ = ["check_words", "coefficients", "make_light", "make_lights"]


def check_words(value: object, where: str, kind: str, header: Mapping[str, str]) -> Mapping[str, Any]:
    """The words that a target's JSON says of its rig (`Rig.document`), `map` and `exposure_gain` among them.

    Args:
        value: the entry.
        where: its name in complaints.
        kind: what its `format` must be.
        header: the header of the map beside it, which must say the same of itself.

    Raises:
        ValueError: another format or version, or a map that was written for another rig.

    >>> words = {"format": "mixlight/three", "version": 1, "map": "full", "exposure_gain": 1}
    >>> check_words(words, "about", "mixlight/three", {"map": "residual"})
    Traceback (most recent call last):
    ValueError: about.map: expected 'residual', received 'full'
    """
    words = entries.mapping(value, where)
    entries.equal(words.get("format"), f"{where}.format", kind)
    entries.equal(words.get("version"), f"{where}.version", 1)
    entries.equal(words.get("map"), f"{where}.map", header.get("map", "none"))
    entries.number(words.get("exposure_gain"), f"{where}.exposure_gain", above=0)
    return words


def coefficients(value: object, where: str) -> Float[Tensor, "9 3"]:
    """Nine rows of red, green and blue.

    >>> coefficients([[1, 2, 3]] * 9, "sh").shape
    torch.Size([9, 3])
    """
    rows = entries.entries(value, where, 9)
    checked = [entries.rgb(row, f"{where}[{place}]") for place, row in enumerate(rows)]
    return torch.tensor(checked, dtype=torch.float32)  # JSON's numbers may all be whole


def make_light(
    name: object, towards: Sequence[float], irradiance: Sequence[float], diameter_deg: object, where: str
) -> Light:
    """A light from what a file says of it; `towards` may have any length but 0.

    Convention: our frame; `towards` points to the light.

    Raises:
        ValueError: a direction of length 0, or a name or diameter that is none.

    >>> make_light("lamp", [0, 2, 0], [1, 1, 1], 8.1, "lights[0]").direction
    tensor([0., 1., 0.])
    """
    length = math.hypot(*towards)
    if not 0 < length < math.inf:
        entries.fail(where, "a light in some direction", list(towards))
    diameter = entries.number(diameter_deg, f"{where}.angular_diameter_deg", above=0, maximum=360)
    return Light(
        name=entries.text(name, f"{where}.name"),
        direction=torch.tensor([part / length for part in towards], dtype=torch.float32),
        irradiance=torch.tensor(list(irradiance), dtype=torch.float32),
        angular_diameter=math.radians(diameter),
    )


def make_lights(value: object, frame: str) -> tuple[Light, ...]:
    """The lights of `Rig.document`, turned from ``frame`` back into ours.

    Raises:
        ValueError: an entry that is no light; the message names it.

    >>> entry = {"name": "lamp", "direction": [0, 0, 1], "irradiance": [1, 1, 1], "angular_diameter_deg": 8}
    >>> make_lights([entry], "blender")[0].direction
    tensor([0., 1., 0.])
    """
    lights = []
    for place, entry in enumerate(entries.entries(value, "lights")):
        where = f"lights[{place}]"
        about = entries.mapping(entry, where)
        light = make_light(
            about.get("name"),
            entries.rgb(about.get("direction"), f"{where}.direction"),
            entries.rgb(about.get("irradiance"), f"{where}.irradiance", minimum=0),
            about.get("angular_diameter_deg"),
            where,
        )
        lights.append(replace(light, direction=convert_directions(light.direction, frame, "mixlight")))
    return tuple(lights)
