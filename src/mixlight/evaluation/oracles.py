"""The ceiling of a representation: the true light through its own parameters, with no network in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from jaxtyping import Float
from torch import Tensor

from mixlight.evaluation.representations import Representation
from mixlight.light import harmonics
from mixlight.light.fit import fit
from mixlight.light.lighting import Lighting

__all__ = ["ORACLES", "Oracle", "harmonic_light"]

Light = Float[Tensor, "height width 3"]
Oracle = Callable[[Light], Light | Lighting]
"""A true map to the same light in a representation: as a lighting, where it is one, else as a map."""


def harmonic_light(environment: Light, degree: int) -> Light:
    """The map's harmonics up to a degree, nothing else; negative values are clamped at 0.

    >>> import torch
    >>> x = torch.linspace(0.2, 0.4, 64)[:, None, None].expand(64, 128, 3)
    >>> round(float((harmonic_light(x, 6) - x).abs().max()), 3) < 0.01
    True
    """
    return harmonics.evaluate_map(harmonics.project(environment, degree), environment.shape[0]).clamp_min(0)


def _one_colour(environment: Light) -> Lighting:
    return fit(environment, per_anchor_colour=False)


def _max_fraction(environment: Light) -> Lighting:
    return fit(environment, separation="max_fraction")


ORACLES: Mapping[str, tuple[str, Oracle]] = MappingProxyType(
    {
        "top_fraction": ("SH2 and 128 lobes, sources: brightest 5 % of the sphere", fit),
        "max_fraction": ("SH2 and 128 lobes, sources: above 5 % of the maximum", _max_fraction),
        "one_colour": ("SH2 and 128 lobes of one colour", _one_colour),
        "sh2": ("harmonics of degree 2", lambda light: harmonic_light(light, 2)),
        "sh6": ("harmonics of degree 6", lambda light: harmonic_light(light, 6)),
        "gardner19": ("constant and 3 lamps", Representation("constant", "lamps").environment),
        "emlight": ("constant and 128 lobes of one colour", Representation("constant").environment),
        "sgg": ("9 smooth Gaussians and 128 lobes of one colour", Representation("sg9").environment),
        "shh": ("SH2, and SH6 of the sources", Representation("sh2", "sh6").environment),
        "sgh": ("9 smooth Gaussians, and SH6 of the sources", Representation("sg9", "sh6").environment),
    }
)
"""Name of a representation: what it is, and its oracle."""
