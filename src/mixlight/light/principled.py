"""Blender's Principled surface for the materials of protocol S: metal, and paint under a clear coat.

Both keep energy that a single bounce between microfacets would lose. The formulas are those that Blender 4
and 5 render by; where Blender looks a table up, the integral itself is taken.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light.reflection import ggx_kernel

_NODES = 129
"""Entries of a table over the cosine of the view, evenly spaced in its square root: dense at the rim."""

_FACETS = 48, 24
"""Microfacets of the integral over visible normals: from upright to steep, and around half a turn."""


def schlick(cosine: Float[Tensor, "*shape"], facing: float) -> Float[Tensor, "*shape"]:
    """Reflectance of a metal: f + (1 - f) (1 - c)^5, from `facing` f at normal incidence to 1 at the rim.

    Convention: c is the cosine between a ray and the facet that mirrors it.

    >>> round(schlick(torch.tensor(0.5), 0.8).item(), 5)
    0.80625
    """
    return facing + (1 - facing) * (1 - cosine.clamp(0, 1)) ** 5


def dielectric(cosine: Float[Tensor, "*shape"], ior: float) -> Float[Tensor, "*shape"]:
    """Fresnel's reflectance of a clear dielectric for unpolarised light that comes from outside.

    With g = sqrt(ior² - 1 + c²):

        F = ((g - c) / (g + c))² / 2 * (1 + ((c (g + c) - 1) / (c (g - c) + 1))²)

    Convention: c is the cosine between a ray and the facet. Face on, an index of 1.5 gives .04.

    >>> round(dielectric(torch.tensor(1.0), 1.5).item(), 4)
    0.04
    """
    c = cosine.clamp(0, 1)
    g = (ior * ior - 1 + c * c).sqrt()
    return ((g - c) / (g + c)) ** 2 / 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2)


def single_bounce_albedo(
    cos_view: Float[Tensor, "*shape"], alpha: float, ior: float | None = None
) -> Float[Tensor, "*shape"]:
    """What share of an even light a GGX surface of reflectance 1 (or a dielectric's) shows after one bounce.

    The integral over the microfacets that the viewer sees (Heitz's distribution of visible normals, by Dupuy
    and Benyoub's spherical caps), on an even grid.

    Convention: 1 minus this is what is lost to a second bounce; face on and at alpha .107, 1.4 %.

    Args:
        cos_view: Cosine between normal and view.
        alpha: GGX roughness.
        ior: Index of a dielectric whose Fresnel term weighs each facet; none if not given.

    Source: Heitz, Sampling the GGX Distribution of Visible Normals, 2018; Dupuy and Benyoub, Sampling Visible
    GGX Normals with Spherical Caps, 2023.

    >>> round(single_bounce_albedo(torch.tensor(1.0), 0.3271**2).item(), 3)
    0.986
    """
    v_z = cos_view.double().clamp(1e-6, 1)[..., None, None]
    v_x = (1 - v_z * v_z).clamp(min=0).sqrt()
    steps = [
        (torch.arange(count, dtype=torch.float64, device=cos_view.device) + 0.5) / count for count in _FACETS
    ]
    # Steep facets are few, but they decide what is lost: the grid is dense there.
    height, weight = 1 - steps[0] ** 3, 3 * steps[0] ** 2
    azimuth = math.pi * steps[1][:, None]
    # The view as the stretched surface sees it, a cap of directions about it, and the facets half-way.
    length = ((alpha * v_x) ** 2 + v_z**2).sqrt()
    s_x, s_z = alpha * v_x / length, v_z / length
    c_z = (1 - height) * (1 + s_z) - s_z
    c_r = (1 - c_z * c_z).clamp(min=0).sqrt()
    m_x, m_y, m_z = alpha * (c_r * azimuth.cos() + s_x), alpha * c_r * azimuth.sin(), c_z + s_z
    length = (m_x**2 + m_y**2 + m_z**2).sqrt().clamp(min=1e-30)
    m_x, m_z = m_x / length, m_z / length
    half = v_x * m_x + v_z * m_z  # cosine between view and facet
    l_z = 2 * half * m_z - v_z
    # What is not hidden from the light, of what the viewer sees: G2 / G1 of height-correlated Smith.
    share = (1 + _smith(v_z, alpha)) / (1 + _smith(v_z, alpha) + _smith(l_z.clamp(min=1e-9), alpha))
    if ior is not None:
        share = share * dielectric(half, ior)
    return (torch.where(l_z > 0, share, 0.0) * weight).mean((-1, -2)).to(cos_view.dtype)


def metal_kernel(
    cos_light: Float[Tensor, "*#shape"],
    cos_view: Float[Tensor, "*#shape"],
    light_dot_view: Float[Tensor, "*#shape"],
    alpha: float,
    colour: float,
) -> Float[Tensor, "*shape"]:
    """Radiance that Blender's rough metal sends out per incident radiance and steradian [1/sr].

    One bounce with Schlick's reflectance, scaled for what further bounces add:

        k = ggx * schlick(h.v) * (1 + M (1 - E) / E),   M = F E' / (1 - F (1 - E'))

    with E the share that one bounce shows from this view, E' its mean over views, and F = (20 colour + 1)/21
    the mean of Schlick's reflectance.

    Convention: as `ggx_kernel`. Light, view and normal in one line, alpha .107, colour .8: k = 5.623.

    Source: Kulla and Conty, Revisiting Physically Based Shading at Imageworks, 2017; Turquin, Practical
    multiple scattering compensation for microfacet models, 2019.

    >>> one = torch.tensor(1.0)
    >>> round(metal_kernel(one, one, one, 0.3271**2, 0.8).item(), 3)
    5.623
    """
    half = ((1 + light_dot_view) / 2).clamp(0, 1).sqrt()
    scale = _further_bounces(cos_view, alpha, (20 * colour + 1) / 21)
    return ggx_kernel(cos_light, cos_view, light_dot_view, alpha, 1.0) * schlick(half, colour) * scale


def paint_kernel(
    cos_light: Float[Tensor, "*#shape"],
    cos_view: Float[Tensor, "*#shape"],
    light_dot_view: Float[Tensor, "*#shape"],
    alpha: float,
    colour: float,
    ior: float,
) -> Float[Tensor, "*shape"]:
    """Radiance that Blender's non-metal sends out per incident radiance and steradian [1/sr].

    A rough clear coat over a Lambertian ground, which gets what the coat does not reflect to this viewer:

        k = coat + (1 - A(v)) colour / pi * max(n.l, 0)

    with coat = ggx * dielectric(h.v) * (1 + M (1 - E) / E) as for metal, and A the share of an even light
    that the coat shows from this view.

    Convention: as `ggx_kernel`. Under radiance 1 from everywhere the surface shows A + (1 - A) colour: of .8
    face on, .8079.

    >>> one = torch.tensor(1.0)
    >>> round(paint_kernel(one, one, one, 0.364**2, 0.8, 1.5).item(), 3)
    0.426
    """
    half = ((1 + light_dot_view) / 2).clamp(0, 1).sqrt()
    scale = _further_bounces(cos_view, alpha, _mean_dielectric(ior))
    coat = ggx_kernel(cos_light, cos_view, light_dot_view, alpha, 1.0) * dielectric(half, ior) * scale
    shown = scale * _look_up(cos_view, alpha, ior)
    return coat + (1 - shown) * (colour / math.pi) * cos_light.clamp(min=0)


def _smith(cosine: Tensor, alpha: float) -> Tensor:
    """Smith's lambda of GGX."""
    return ((1 + alpha * alpha * (1 / (cosine * cosine) - 1)).sqrt() - 1) / 2


def _further_bounces(cos_view: Tensor, alpha: float, mean_reflectance: float) -> Tensor:
    """1 + M (1 - E) / E of `metal_kernel`."""
    mean = _mean_albedo(alpha)
    more = mean_reflectance * mean / (1 - mean_reflectance * (1 - mean))
    single = _look_up(cos_view, alpha, None)
    return 1 + more * (1 - single) / single


def _look_up(cos_view: Tensor, alpha: float, ior: float | None) -> Tensor:
    """`single_bounce_albedo` by linear interpolation in the square root of the cosine."""
    table = _table(alpha, ior).to(cos_view)
    place = cos_view.clamp(0, 1).sqrt() * (_NODES - 1)
    low = place.long().clamp(max=_NODES - 2)
    return torch.lerp(table[low], table[low + 1], place - low)


@lru_cache(maxsize=16)
def _table(alpha: float, ior: float | None) -> Tensor:
    """`single_bounce_albedo` at `_NODES` cosines (read-only)."""
    cosines = (torch.arange(_NODES, dtype=torch.float64) / (_NODES - 1)) ** 2
    # At cosine 0 the integral has no limit that a grid could find; the rim has no area either.
    parts = [single_bounce_albedo(part, alpha, ior) for part in cosines.clamp(min=1e-4).split(64)]
    return torch.cat(parts)


@lru_cache(maxsize=16)
def _mean_albedo(alpha: float) -> float:
    """E' = 2 * integral of E(c) c dc."""
    nodes, weights = np.polynomial.legendre.leggauss(32)
    cosine = torch.from_numpy((nodes + 1) / 2)
    return float((single_bounce_albedo(cosine, alpha) * cosine * torch.from_numpy(weights)).sum())


@lru_cache(maxsize=16)
def _mean_dielectric(ior: float) -> float:
    """2 * integral of F(c) c dc."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    cosine = torch.from_numpy((nodes + 1) / 2)
    return float((dielectric(cosine, ior) * cosine * torch.from_numpy(weights)).sum())
