"""The ceiling of a representation: the true light through its own parameters, with no network in between."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

from jaxtyping import Float
from torch import Tensor

from mixlight.light import harmonics
from mixlight.light.fit import fit
from mixlight.light.lighting import Lighting

__all__ = ["ORACLES", "Oracle", "SMOOTH_DEGREE", "harmonic_light", "lobes_and_constant"]

Light = Float[Tensor, "height width 3"]
Oracle = Callable[[Light], Light | Lighting]
"""A true map to the same light in a representation: as a lighting, where it is one, else as a map."""

SMOOTH_DEGREE = 6
"""Degree of the harmonics that have about as many numbers as 128 lobes (147 against 132)."""


def harmonic_light(environment: Light, degree: int) -> Light:
    """The map's harmonics up to a degree, nothing else; negative values are clamped at 0.

    >>> import torch
    >>> harmonic_light(torch.full((16, 32, 3), 0.5), 2)[3, 4]
    tensor([0.5000, 0.5000, 0.5000])
    """
    return harmonics.evaluate_map(harmonics.project(environment, degree), environment.shape[0]).clamp_min(0)


def lobes_and_constant(environment: Light) -> Lighting:
    """128 lobes of a colour each for the sources, and one constant colour for all the rest.

    The representation of EMLight before its generator, but for the lobes' own colours. Energy is kept.

    >>> import torch
    >>> lobes_and_constant(torch.full((16, 32, 3), 0.5)).ambient.shape
    torch.Size([1, 3])
    """
    return fit(environment, degree=0)


def _one_colour(environment: Light) -> Lighting:
    return fit(environment, per_anchor_colour=False)


def _max_fraction(environment: Light) -> Lighting:
    return fit(environment, separation="max_fraction")


ORACLES: MappingProxyType[str, tuple[str, Oracle]] = MappingProxyType(
    {
        "top_fraction": ("SH2 and 128 lobes, sources: brightest 5 % of the sphere", fit),
        "max_fraction": ("SH2 and 128 lobes, sources: above 5 % of the maximum", _max_fraction),
        "one_colour": ("SH2 and 128 lobes of one colour", _one_colour),
        "sh2": ("harmonics of degree 2", lambda light: harmonic_light(light, 2)),
        "sh6": ("harmonics of degree 6", lambda light: harmonic_light(light, SMOOTH_DEGREE)),
        "sg": ("128 lobes and constant ambient light", lobes_and_constant),
    }
)
"""Name of a representation: what it is, and its oracle."""
