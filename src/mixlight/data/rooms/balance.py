"""How bright each light group is while it is rendered, so that faint ones get their share of the light paths.

A path asks one light what it gives, the brighter ones more often. By day that is the sky nearly always, and a
lamp of 400 lm is asked once in a thousand times: its picture is noise, which shows as soon as a remix makes
it night. So all groups are rendered about equally bright, and each is divided by its factor afterwards;
light adds up, so nothing else changes. In a sunny living room at 16 samples that took the ceiling lamp's
noise (root mean square of the logarithm) from 1.50 to .99, and from .44 to .40 denoised.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms.mesh import Emission, Part
from mixlight.data.rooms.outline import area
from mixlight.data.rooms.plan import Plan
from mixlight.data.rooms.scene import RoomScene
from mixlight.data.rooms.store import SKY, SUN, group_names

__all__ = ["balanced", "render_gains", "restored"]

_UTILISATION = 0.4
"""Share of a lamp's light that arrives on the floor."""
_LUX = 100.0
_SHARES = {SKY: 3.0, SUN: 1.5, "ceiling": 1.5, "screen": 0.5, "candle": 0.3, "neighbour": 0.7}
"""How much of the light each is to be: what is most often on gets most. Others have 1."""


def render_gains(plan: Plan) -> dict[str, float]:
    """The factor of each light group while it is rendered.

    gain = share * 100 lx / E, with E the light on the floor that a group's lamps would give without shades
    (.4 of their lumens over the area), or on open ground for sky and sun.
    """
    gains = {}
    for name in group_names(plan):
        members = [f for f in plan.fixtures if f.group == name]
        if name == SKY:
            lux, kind = plan.sky.illuminance, SKY
        elif name == SUN:
            lux, kind = plan.sky.sun_illuminance, SUN
        else:
            floor = area(plan.spaces[members[0].space].outline)
            lux = _UTILISATION * sum(f.power for f in members) / floor
            kind = "ceiling" if name.startswith("ceiling") else members[0].kind
        gains[name] = _SHARES.get(kind, 1.0) * _LUX / lux
    return gains


def balanced(scene: RoomScene, gains: Mapping[str, float]) -> RoomScene:
    """The scene with each group's light times its gain (1 where none is given)."""
    parts = tuple(_scaled(part, gains) for part in scene.parts)
    sun = scene.sun
    if sun is not None:
        red, green, blue = (c * gains.get(SUN, 1.0) for c in sun.irradiance)
        sun = replace(sun, irradiance=(red, green, blue))
    return replace(scene, parts=parts, sky=scene.sky * gains.get(SKY, 1.0), sun=sun)


def _scaled(part: Part, gains: Mapping[str, float]) -> Part:
    if not isinstance(part.material, Emission):
        return part
    gain = gains.get(part.material.group, 1.0)
    red, green, blue = (c * gain for c in part.material.radiance)
    return replace(part, material=replace(part.material, radiance=(red, green, blue)))


def restored(
    groups: Mapping[str, Float[np.ndarray, "height width 3"]], gains: Mapping[str, float]
) -> dict[str, Float[np.ndarray, "height width 3"]]:
    """The groups of a balanced scene's picture as those of the scene itself."""
    return {name: pixels / np.float32(gains.get(name, 1.0)) for name, pixels in groups.items()}
