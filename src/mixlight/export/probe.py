"""One main light and harmonics of all other light: what a phone tells its apps."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.export import sh
from mixlight.export.reading import make_light
from mixlight.export.rig import Rig, light_harmonics
from mixlight.light import entries
from mixlight.light.document import numbers
from mixlight.light.lights import Light

__all__ = ["Probe", "describe", "from_words", "load_probe", "make_probe", "to_words"]


@dataclass(frozen=True, eq=False)
class Probe:
    """A rig for consumers that take a single light and no map.

    Convention: our frame. ``harmonics`` plus `light_harmonics` of the main light, where that is on, is the
        light of the whole rig.
    """

    harmonics: Float[Tensor, "9 3"]
    """Radiance harmonics of all light that is not the main light's."""
    main: Light | None
    """The brightest light; None where there is none."""
    on: bool
    """Whether the main light counts. If not, the harmonics hold its light and it is only named."""
    exposure_gain: float = 1.0
    """As in `Rig`."""
    name: str = "mixlight"
    """As in `Rig`."""

    @property
    def intensity(self) -> Float[Tensor, "3"]:
        """Irradiance of the main light as a consumer is to use it: 0 where it does not count."""
        return self.main.irradiance if self.main is not None and self.on else torch.zeros(3)

    @property
    def direction(self) -> Float[Tensor, "3"]:
        """Unit vector towards the main light; up where there is none."""
        return torch.tensor([0.0, 1.0, 0.0]) if self.main is None else self.main.direction


def make_probe(rig: Rig) -> Probe:
    """The rig with all lights but the brightest put into the harmonics.

    >>> lights = [Light(f"light_{i}", torch.eye(3)[i], torch.ones(3) / i, 0.14) for i in (1, 2)]
    >>> empty = torch.zeros(4, 8, 3)
    >>> rig = Rig(empty, tuple(lights), True, torch.zeros(9, 3), light_harmonics(lights))
    >>> probe = make_probe(rig)
    >>> probe.main.name, probe.harmonics[:4, 0]
    ('light_1', tensor([0.1410, 0.0000, 0.2443, 0.0000]))
    """
    main = rig.lights[0] if rig.lights else None
    others = light_harmonics(rig.lights[1:]) if rig.lights_on else torch.zeros(9, 3)
    return Probe(rig.ambient + others, main, rig.lights_on, rig.exposure_gain, rig.name)


def describe(probe: Probe) -> str:
    """In one line: where the light is, for `README.txt`.

    >>> describe(Probe(torch.zeros(9, 3), None, False))
    'The harmonics hold all light; there is no main light.'
    """
    if probe.main is None:
        return "The harmonics hold all light; there is no main light."
    if probe.on:
        return (
            "The main light is not in the harmonics, all other light is: "
            "use both together, neither holds the other's light."
        )
    return (
        "The harmonics hold all light, so the main light's intensity is written as 0; "
        "with that of main_light light would count twice."
    )


def to_words(probe: Probe, target: str) -> dict[str, Any]:
    """What every probe's file says before the consumer's own entries.

    >>> probe = Probe(torch.zeros(9, 3), None, False)
    >>> to_words(probe, "arcore")["format"], to_words(probe, "arcore")["main_light"]
    ('mixlight/arcore', None)
    """
    main = probe.main
    return {
        "format": f"mixlight/{target}",
        "version": 1,
        "name": probe.name,
        "frame": "mixlight",
        "exposure_gain": float(probe.exposure_gain),
        "main_light": None
        if main is None
        else {
            "name": main.name,
            "irradiance": numbers(main.irradiance),
            "angular_diameter_deg": round(math.degrees(main.angular_diameter), 4),
            "enabled": probe.on,
        },
    }


def from_words(
    document: object,
    target: str,
    harmonics: Float[Tensor, "9 3"],
    direction: Sequence[float],
    intensity: Sequence[float],
) -> Probe:
    """The probe of a file, from `to_words` and what its reader found in the consumer's own entries.

    Args:
        document: the file.
        target: the name of its target.
        harmonics: ours.
        direction: towards the main light.
        intensity: its irradiance; 0 where it does not count.

    Raises:
        ValueError: another format, or an entry that contradicts another; the message names it.
    """
    words = entries.mapping(document, "the document")
    entries.equal(words.get("format"), "format", f"mixlight/{target}")
    entries.equal(words.get("version"), "version", 1)
    entries.equal(words.get("frame"), "frame", "mixlight")
    gain = entries.number(words.get("exposure_gain"), "exposure_gain", above=0)
    name = entries.text(words.get("name"), "name")
    if words.get("main_light") is None:
        if any(intensity):
            entries.fail("main_light", "a light, as there is an intensity", None)
        return Probe(harmonics, None, False, float(gain), name)
    about = entries.mapping(words["main_light"], "main_light")
    on = about.get("enabled")
    if not isinstance(on, bool):
        entries.fail("main_light.enabled", "true or false", on)
    irradiance = entries.rgb(about.get("irradiance"), "main_light.irradiance", minimum=0)
    if list(intensity) != (irradiance if on else [0, 0, 0]):
        entries.fail("the main light's intensity", f"{irradiance if on else [0, 0, 0]}", list(intensity))
    main = make_light(
        about.get("name"), direction, irradiance, about.get("angular_diameter_deg"), "main_light"
    )
    return Probe(harmonics, main, on, float(gain), name)


def load_probe(
    path: Path,
    target: str,
    harmonics: str,
    direction: str,
    intensity: str,
    vector: Callable[[Any, str], list[float]] = entries.rgb,
) -> Probe:
    """The probe of a consumer's file, exact to float32.

    Args:
        path: the file.
        target: the name of its target.
        harmonics: the entry with the coefficients.
        direction: the entry that points towards the main light.
        intensity: the entry with its irradiance.
        vector: how three numbers are read from an entry, which it names in errors.

    Raises:
        ValueError: no such file; the message names the file and the entry.
        OSError: the file cannot be read.
    """
    document = entries.load(path)
    try:
        found = entries.mapping(document, "the document")
        return from_words(
            found,
            target,
            sh.read_document(found.get(harmonics), target),
            vector(found.get(direction), direction),
            vector(found.get(intensity), intensity),
        )
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
