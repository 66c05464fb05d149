"""Changes to a light after the fact: turn, exposure, temperature, single lights. Nothing is changed in place.

Each function takes a `Lighting` and gives a new one, and says what happens to the energy:

| function | energy |
|---|---|
| `turn` | kept in every lobe and in the ambient light; nothing is resampled |
| `expose` | all of it times 2^EV |
| `tint` | each channel times one number; the luminance of white light stays |
| `switch`, `strengthen` | of that light's lobes alone |
"""

import math
from dataclasses import replace

from mixlight.image.temperature import white_point_gain
from mixlight.light.lighting import Group, Lighting
from mixlight.light.lights import merge

__all__ = ["expose", "light_names", "named", "strengthen", "switch", "tint", "turn"]

LARGEST_EV = 40.0
"""Stops up and down: a factor of 10^12."""


def turn(lighting: Lighting, angle: float) -> Lighting:
    """The light turned to the right about the vertical by an angle in radians, exactly (`Lighting.turned`).

    Convention: what came from ahead (-Z) comes from the right (+X) after pi / 2. The photo stays ahead: its
        light is turned against it.

    Raises:
        ValueError: the angle is not finite.

    >>> import torch
    >>> lighting = Lighting(torch.zeros(9, 3), torch.eye(128)[:, :3])
    >>> turned = turn(lighting, math.radians(30))
    >>> round(math.degrees(turned.turn), 6), turned.total_energy()
    (30.0, tensor([1., 1., 1.]))
    """
    return lighting.turned(angle)


def expose(lighting: Lighting, ev: float) -> Lighting:
    """All light times 2^EV, as if the photo had been exposed so much longer (`Lighting.exposed`).

    The exposure gain is multiplied too, so that the light on its absolute scale (`Lighting.absolute`) is what
    it was.

    Convention: 1 EV doubles every radiance and energy.

    Raises:
        ValueError: not from -40 to 40 EV.

    >>> import torch
    >>> expose(Lighting(torch.ones(9, 3), torch.ones(4, 3)), -1).energy[0]
    tensor([0.5000, 0.5000, 0.5000])
    """
    if not abs(ev) <= LARGEST_EV:
        raise ValueError(f"exposure: expected -{LARGEST_EV:g} to {LARGEST_EV:g} EV, received {ev:g}")
    return lighting.exposed(2.0**ev)


def tint(lighting: Lighting, kelvin: float) -> Lighting:
    """All light in the colour that white light has at a colour temperature
    (`mixlight.image.temperature.white_point_gain`).

    Each channel is multiplied by one number. White light keeps its luminance exactly, coloured light nearly.
    Lights keep their names.

    Convention: 6504 K (D65) changes nothing; lower is warmer. White at 3000 K is (1.71, .86, .26).

    Raises:
        ValueError: not from 2000 to 15000 K.

    >>> import torch
    >>> tint(Lighting(torch.ones(9, 3), torch.ones(4, 3)), 3000.0).energy[0]
    tensor([1.7063, 0.8645, 0.2628])
    """
    red, green, blue = white_point_gain(kelvin).tolist()
    return named(lighting).scaled((red, green, blue))


def switch(lighting: Lighting, name: str, on: bool) -> Lighting:
    """The lighting with one of its lights switched on or off; no change where it is so already.

    A light that is off has no energy in the lighting, which remembers it (`Lighting.groups`), through
    exposure, tint, turn and file, so that it can be switched on again. All lights keep their names from now
    on.

    Raises:
        ValueError: no such light, naming those there are; a batch of lightings.

    >>> import torch
    >>> energy = torch.zeros(128, 3)
    >>> energy[40], energy[100] = 2.0, 1.0
    >>> lighting = Lighting(torch.zeros(9, 3), energy)
    >>> dark = switch(lighting, "light_2", on=False)
    >>> dark.total_energy(), switch(dark, "light_2", on=True).total_energy()
    (tensor([2., 2., 2.]), tensor([3., 3., 3.]))
    """
    lighting = named(lighting)
    found = _group(lighting, name)
    if on == (found.off is None):
        return lighting
    anchors, energy = list(found.anchors), lighting.energy.clone()
    if found.off is None:
        changed = replace(found, off=energy[anchors])
        energy[anchors] = 0
    else:
        changed = replace(found, off=None)
        energy[anchors] = found.off
    return replace(lighting, energy=energy, groups=_exchanged(lighting, changed))


def strengthen(lighting: Lighting, name: str, factor: float) -> Lighting:
    """The lighting with one of its lights so many times as strong, whether it is on or off.

    All lights keep their names from now on.

    Raises:
        ValueError: no such light, naming those there are; a factor that is not above 0; a batch.

    >>> import torch
    >>> energy = torch.zeros(128, 3)
    >>> energy[40], energy[100] = 2.0, 1.0
    >>> lighting = Lighting(torch.zeros(9, 3), energy)
    >>> strengthen(lighting, "light_2", 0.5).total_energy()
    tensor([2.5000, 2.5000, 2.5000])
    """
    if not 0 < factor < math.inf:
        raise ValueError(f"{name}: expected a strength above 0 (off switches it off), received {factor:g}")
    lighting = named(lighting)
    found = _group(lighting, name)
    if found.off is not None:
        return replace(lighting, groups=_exchanged(lighting, replace(found, off=found.off * factor)))
    energy, anchors = lighting.energy.clone(), list(found.anchors)
    energy[anchors] *= factor
    return replace(lighting, energy=energy)


def named(lighting: Lighting) -> Lighting:
    """The same light, whose lights keep the names that they have now, whatever becomes of their brightness
    (`mixlight.light.lights.merge` names them).

    Raises:
        ValueError: a batch of lightings.

    >>> import torch
    >>> energy = torch.zeros(128, 3)
    >>> energy[40], energy[100] = 2.0, 1.0
    >>> lighting = Lighting(torch.zeros(9, 3), energy)
    >>> named(lighting).groups[1]
    Group(name='light_2', anchors=(100,), off=None)
    """
    kept = {group.name for group in lighting.groups}
    fresh = [Group(light.name, light.anchors) for light in merge(lighting) if light.name not in kept]
    return replace(lighting, groups=(*lighting.groups, *fresh)) if fresh else lighting


def light_names(lighting: Lighting) -> list[str]:
    """Names of all lights, those that are off among them.

    >>> import torch
    >>> energy = torch.zeros(128, 3)
    >>> energy[40], energy[100] = 2.0, 1.0
    >>> lighting = Lighting(torch.zeros(9, 3), energy)
    >>> light_names(lighting)
    ['light_1', 'light_2']
    """
    return [group.name for group in named(lighting).groups]


def _group(lighting: Lighting, name: str) -> Group:
    for group in lighting.groups:
        if group.name == name:
            return group
    known = ", ".join(group.name for group in lighting.groups)
    raise ValueError(f"expected a light out of {known or '(there is none)'}, received {name!r}")


def _exchanged(lighting: Lighting, changed: Group) -> tuple[Group, ...]:
    return tuple(changed if group.name == changed.name else group for group in lighting.groups)
