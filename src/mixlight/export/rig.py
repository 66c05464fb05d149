"""The rig: a light made ready for a consumer, each unit of it in the map or in the lights, never in both."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import harmonics
from mixlight.light.document import numbers
from mixlight.light.lighting import Lighting
from mixlight.light.lights import Light, merge
from mixlight.sphere import equirect
from mixlight.sphere.frames import convert_directions

__all__ = ["Rig", "light_harmonics", "make_rig"]


@dataclass(frozen=True, eq=False)
class Rig:
    """Light made ready for a consumer: a map, named lights, ambient harmonics.

    Each unit of light is in exactly one of the map and the lights that are on. Every target reads this and
    nothing else.

    Convention: all in our frame, +X right, +Y up, -Z forward; targets turn it into theirs. A rig of a light
        whose only lobe has the energy 1 has, with ``residual``, a map of integral 0 beside one light of
        irradiance 1; without, a map of integral 1 beside the same light, switched off.

    Raises:
        ValueError: a map that is not 2:1 with a width divisible by 4 (consumers' rolls must be exact), or
            that holds NaN, infinite or negative radiance; an exposure gain that is not above 0.

    >>> energy = torch.zeros(128, 3)
    >>> energy[40] = energy[100] = 1.0
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), energy), height=16)
    >>> len(rig.lights), rig.map_kind, rig.lights_on, float(rig.environment.sum())
    (2, 'residual', True, 0.0)
    """

    environment: Float[Tensor, "height width 3"]
    """The map, linear Rec.709 radiance; without the light of `lights` if `residual`."""
    lights: tuple[Light, ...]
    """Named lights, brightest first; may be empty."""
    residual: bool
    """True: the map does not hold the light of `lights`, which are on. False: the map holds all light, and
    the lights are written switched off."""
    ambient: Float[Tensor, "9 3"]
    """Radiance harmonics of what the map holds: with the lights that are on, the complete light for matte
    surfaces."""
    sh: Float[Tensor, "9 3"]
    """Radiance harmonics of all light, for consumers that take harmonics alone."""
    exposure_gain: float = 1.0
    """Stored radiance over absolute radiance, where that is known (`Lighting.exposure_gain`)."""
    name: str = "mixlight"
    """Stem of the names that consumers show."""

    def __post_init__(self) -> None:
        equirect.check(self.environment, "environment")
        if self.environment.shape[-2] % 4:
            raise ValueError(
                "environment: expected a width divisible by 4 (a quarter turn is exact), received "
                f"{self.environment.shape[-2]}"
            )
        if not (self.exposure_gain > 0 and math.isfinite(self.exposure_gain)):
            raise ValueError(f"exposure_gain: expected a number above 0, received {self.exposure_gain!r}")

    @property
    def map_kind(self) -> Literal["residual", "full"]:
        """What files say of their map: "residual" where lights were taken out of it, else "full"."""
        return "residual" if self.residual and self.lights else "full"

    @property
    def lights_on(self) -> bool:
        """Whether the lights are written switched on."""
        return self.map_kind == "residual"

    def document(self, frame: str = "mixlight") -> dict[str, Any]:
        """The rig in words and numbers without its map, for the JSON of targets whose frame is one of
        `mixlight.sphere.FRAMES`.

        The harmonics stay in our frame and say so: a program's own order, sign and scale are the business of
        `mixlight.export.sh`.

        Convention: `direction` points towards the light in the axes of ``frame``; `enabled` is false where
            the map holds the light already.

        Raises:
            ValueError: unknown frame.

        >>> up = Light("light_1", torch.tensor([0.0, 1.0, 0.0]), torch.ones(3), 0.14)
        >>> rig = Rig(torch.zeros(4, 8, 3), (up,), True, torch.zeros(9, 3), light_harmonics([up]))
        >>> light = rig.document("blender")["lights"][0]
        >>> light["name"], light["direction"], light["enabled"]
        ('light_1', [0.0, 0.0, 1.0], True)
        """
        return {
            "format": "mixlight/rig",
            "version": 1,
            "name": self.name,
            "frame": frame,
            "map": self.map_kind,
            "exposure_gain": float(self.exposure_gain),
            "lights": [
                {
                    "name": light.name,
                    "direction": numbers(convert_directions(light.direction, "mixlight", frame)),
                    "irradiance": numbers(light.irradiance),
                    "angular_diameter_deg": round(math.degrees(light.angular_diameter), 4),
                    "enabled": self.lights_on,
                }
                for light in self.lights
            ],
            "harmonics": {
                "kind": "radiance",
                "basis": "real-sh",
                "order": "l*l+l+m",
                "degree": 2,
                "frame": "mixlight",
                "ambient": numbers(self.ambient),
                "all_light": numbers(self.sh),
            },
        }


def make_rig(
    lighting: Lighting,
    *,
    lights: int | None = None,
    residual: bool = True,
    height: int = 256,
    environment: Float[Tensor, "height width 3"] | Callable[[Lighting], Tensor] | None = None,
    name: str = "mixlight",
) -> Rig:
    """Make a lighting ready for export.

    Args:
        lighting: a single one, not a batch.
        lights: take only the brightest that many of the merged lights (`mixlight.light.lights.merge`); None:
            all of them. The lobes of the others stay in the map.
        residual: take the lobes of those lights out of the map. Otherwise the map holds everything and the
            lights are written switched off.
        height: rows of the map, even, so that a quarter turn of its columns is exact.
        environment: what makes a map [height, 2 height, 3] of a lighting in place of `Lighting.environment`,
            `mixlight.light.detail.Detail.environment` for instance; or a finished map, from which nothing
            is taken any more.
        name: stem of the names that consumers show.

    Returns:
        The rig, in float32 on the CPU.

    Convention: the energy of the map plus that of the lobes that became lights is the energy of the whole
        map: nothing is counted twice and nothing lost.

    Raises:
        ValueError: a batch of lightings, lights below 0, an odd height, or a map that is no panorama.

    >>> energy = torch.zeros(128, 3)
    >>> energy[40], energy[100] = 2.0, 1.0
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), energy), lights=1, height=16)
    >>> [light.anchors for light in rig.lights], equirect.integrate(rig.environment)
    ([(40,)], tensor([1., 1., 1.]))
    """
    if lights is not None and lights < 0:
        raise ValueError(f"lights: expected a number of at least 0, received {lights}")
    lighting = lighting.to("cpu")
    chosen = tuple(merge(lighting, lights))
    taken = [anchor for light in chosen for anchor in light.anchors]
    rest = lighting.without(taken)
    if height < 2 or height % 2:
        raise ValueError(f"height: expected an even number of at least 2, received {height}")
    if isinstance(environment, Tensor):
        kept = environment
        rows = len(kept)
        whole = kept + lighting.sources_map(rows) - rest.sources_map(rows) if residual else kept
    else:
        synthesise = partial(Lighting.environment, height=height) if environment is None else environment
        whole = synthesise(lighting)
        kept = synthesise(rest) if residual and taken else whole
    kept, whole = (panorama.detach().to("cpu", torch.float64) for panorama in (kept, whole))
    return Rig(
        environment=kept.float(),
        lights=tuple(
            replace(light, direction=light.direction.float(), irradiance=light.irradiance.float())
            for light in chosen
        ),
        residual=residual,
        ambient=harmonics.project(kept).float(),
        sh=harmonics.project(whole).float(),
        exposure_gain=lighting.exposure_gain,
        name=name,
    )


def light_harmonics(lights: tuple[Light, ...] | list[Light]) -> Float[Tensor, "9 3"]:
    """Radiance harmonics of directional lights, for consumers that take fewer lights than there are.

    A light of irradiance E from the direction d has the coefficients E B_lm(d) of a point: its irradiance on
    a surface is then, to the second degree, that of the light.

    Convention: a white light of irradiance 1 straight above adds (.282095, .488603, 0, 0, ...).

    >>> up = Light("light_1", torch.tensor([0.0, 1.0, 0.0]), torch.ones(3), 0.14)
    >>> light_harmonics([up])[:4, 0]
    tensor([0.2821, 0.4886, 0.0000, 0.0000])
    """
    total = torch.zeros(9, 3)
    for light in lights:
        total = total + harmonics.basis(light.direction)[:, None] * light.irradiance
    return total
