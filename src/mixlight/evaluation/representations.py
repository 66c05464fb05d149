"""What each combination of functions makes of a true panorama: no network, only its own best parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import functions, harmonics, lamps
from mixlight.light.fit import parameters
from mixlight.light.gaussians import SHARPNESS, evaluate_map
from mixlight.light.separate import Method, check_rule, separate
from mixlight.network.methods import Part
from mixlight.sphere import equirect, points

__all__ = ["PARTS", "Part", "Representation"]

Ambient = Literal["sh2", "constant", "sg9", "none"]
Sources = Literal["anchors", "colours", "sh6", "lamps", "none"]

PARTS: tuple[Part, ...] = get_args(Part)
"""What of the light lights the spheres."""


@dataclass(frozen=True)
class Representation:
    """A way to write a panorama's light down in few numbers."""

    ambient: Ambient = "sh2"
    """Functions of the ambient light: 9 harmonics, a constant, 9 smooth Gaussians, or none."""
    sources: Sources = "anchors"
    """Sources: 128 Gaussians of one colour (`anchors`) or of a colour each (`colours`), harmonics of degree
    6, 3 free lamps, or none."""
    separation: Method = "top_fraction"
    """Which texels are sources (`mixlight.light.separate`); lamps find their own."""
    fraction: float = 0.05
    """The fraction of that rule."""
    anchors: int = 128
    """Number of anchors."""
    sharpness: float = SHARPNESS
    """Angular size s of the sources' Gaussians."""
    lamps: int = lamps.COUNT
    """Number of free lamps."""

    def __post_init__(self) -> None:
        check_rule(self.separation, self.fraction)
        for name, known in (
            ("ambient", get_args(Ambient)),
            ("sources", get_args(Sources)),
        ):
            if getattr(self, name) not in known:
                raise ValueError(f"expected {name} out of {', '.join(known)}, got {getattr(self, name)!r}")
        if self.anchors < 1 or self.lamps < 1:
            raise ValueError(f"expected at least one anchor and lamp, got {self.anchors} and {self.lamps}")
        if self.sources == "lamps" and self.ambient != "constant":
            raise ValueError(f"expected constant ambient light around lamps, got {self.ambient!r}")

    @property
    def numbers(self) -> int:
        """How many numbers a panorama takes, as the paper counts them: one for each anchor and 4 for E and R.

        >>> Representation("sh2", "anchors").numbers, Representation("sg9", "sh6").numbers
        (159, 174)
        """
        ambient = {"sh2": 27, "sg9": 27, "constant": 3, "none": 0}[self.ambient]
        sources = {
            "anchors": self.anchors + 4,
            "colours": 3 * self.anchors,
            "sh6": 147,
            "lamps": 7 * self.lamps,
            "none": 0,
        }[self.sources]
        return ambient + sources

    def environment(
        self, true: Float[Tensor, "height width 3"], part: Part = "whole"
    ) -> Float[Tensor, "height width 3"]:
        """The panorama's light as the representation holds it, as a map of the same size.

        Ambient light is clamped at 0 before sources are added; where the sources are harmonics, which ring,
        the sum is clamped.

        Args:
            true: radiance, 2:1.
            part: all of the light, or one part of it alone.

        Raises:
            ValueError: not a panorama of radiance, or a part of what is no sum of two.

        >>> even = torch.full((32, 64, 3), 0.5)
        >>> Representation("sh2", "sh6").environment(even).mean()
        tensor(0.500)
        """
        height = true.shape[0]
        if self.sources == "lamps":
            found = lamps.find(true, self.lamps)
            if part == "sources":
                found = found._replace(ambient=torch.zeros_like(found.ambient))
            elif part == "ambient":
                found = found._replace(energy=torch.zeros_like(found.energy))
            return lamps.environment(found, height)
        sources, rest = separate(true, self.separation, self.fraction)
        ambient = torch.zeros_like(true) if part == "sources" else self._ambient(rest)
        if part == "ambient" or self.sources == "none":
            return ambient.clamp(min=0)
        if self.sources == "sh6":
            return (ambient + _expanded(sources, "sh6")).clamp(min=0)
        return ambient.clamp(min=0) + self._lobes(true)

    def _ambient(self, rest: Tensor) -> Tensor:
        if self.ambient == "none":
            return torch.zeros_like(rest)
        return _expanded(rest, self.ambient)

    def _lobes(self, true: Tensor) -> Tensor:
        found = parameters(
            true, separation=self.separation, fraction=self.fraction, degree=0, anchors=self.anchors
        )
        energy = found.anchor_energy if self.sources == "colours" else found.lobe_energy()
        return evaluate_map(points.vogel(self.anchors), energy, self.sharpness, true.shape[0])


def true_part(true: Float[Tensor, "height width 3"], part: Part) -> Float[Tensor, "height width 3"]:
    """What a part is compared with: the panorama, or what the default rule makes of it.

    Raises:
        ValueError: not a panorama of radiance.
    """
    equirect.check(true)
    if part == "whole":
        return true
    sources, ambient = separate(true)
    return sources if part == "sources" else ambient


def _expanded(panorama: Tensor, name: functions.Functions) -> Tensor:
    coefficients = functions.project(panorama, name)
    if name != "sg9":
        return harmonics.evaluate_map(coefficients, panorama.shape[0])
    return functions.maps(name, panorama.shape[0]) @ coefficients
