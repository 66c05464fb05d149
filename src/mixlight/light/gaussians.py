"""Spherical Gaussians as light sources: lobes of given energy on given axes.

A lobe of energy v on the unit axis u has at the unit direction d the radiance::

    L(d) = v q exp((d.u - 1) / s),    q = 1 / (2 pi s (1 - exp(-2 / s)))

with the sharpness s (small is sharp). Its integral over the sphere is v (radiance times steradian, per
channel), which is also, to within s, the irradiance on a surface that faces it.
"""

import math
from functools import lru_cache
from typing import overload

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light._lobe_grid import CHUNK, LobeGrid, falloff
from mixlight.light.harmonics import basis, cosine_factor, count, degrees

SHARPNESS = 0.0025
"""The sources' sharpness: an angular diameter of 8.10 degrees, a full width at half maximum of 6.75
degrees."""


@overload
def normaliser(sharpness: float) -> float: ...
@overload
def normaliser(sharpness: Tensor) -> Tensor: ...
def normaliser(sharpness: float | Tensor) -> float | Tensor:
    """Peak radiance q of a lobe of energy 1, so that it integrates to 1 over the sphere (per steradian).

    Source: the paper's eq. for SG with r = 1, corrected: its exp(-2 s) for exp(-2 / s) makes q 200.5 times
        too large at s = 0.0025.

    Raises:
        ValueError: the sharpness is not above 0.

    >>> round(normaliser(0.0025), 4)
    63.662
    """
    if isinstance(sharpness, Tensor):
        if not bool((sharpness > 0).all()):
            raise ValueError(
                f"sharpness: expected values above 0, received a minimum of {float(sharpness.min())}"
            )
        return -1 / (2 * math.pi * sharpness * torch.expm1(-2 / sharpness))
    _check_sharpness(sharpness)
    return -1 / (2 * math.pi * sharpness * math.expm1(-2 / sharpness))


def cone_half_angle(sharpness: float) -> float:
    """Half-angle in radians of the uniform cone of a lobe's energy and peak radiance, acos(1 - s), for s up
    to 2.

    >>> round(math.degrees(2 * cone_half_angle(0.0025)), 3)
    8.105
    """
    _check_sharpness(sharpness)
    if sharpness > 2:
        raise ValueError(
            f"sharpness: expected at most 2 (a cone over the whole sphere), received {sharpness}"
        )
    return math.acos(1 - sharpness)


def fwhm(sharpness: float) -> float:
    """Full width at half maximum of a lobe in radians, 2 acos(1 - s ln 2); 2 pi where it nowhere falls to a
    half.

    >>> round(math.degrees(fwhm(0.0025)), 3)
    6.747
    """
    _check_sharpness(sharpness)
    return 2 * math.acos(max(-1.0, 1 - sharpness * math.log(2)))


def evaluate(
    axes: Float[Tensor, "count 3"],
    energy: Float[Tensor, "*batch count channels"],
    sharpness: float | Tensor,
    directions: Float[Tensor, "*points 3"],
) -> Float[Tensor, "... channels"]:
    """Radiance of all lobes together at unit directions; shape [*batch, *points, channels].

    Args:
        axes: unit vectors towards the light.
        energy: integrated radiance v of each lobe.
        sharpness: s, one number for all lobes or a tensor with one for each.
        directions: unit vectors.

    Convention: a lobe of energy 1 and s = 0.0025 has the radiance q = 63.662 on its axis and half of it 3.37
        degrees away. The exponent is taken from the chord, d.u - 1 = -|d - u|^2 / 2, which in single
        precision is exact where the cosine has lost its digits. Differentiable in every argument.

    Raises:
        ValueError: the sharpness is not above 0, or the counts differ.

    >>> up = torch.tensor([[0.0, 1.0, 0.0]])
    >>> evaluate(up, torch.ones(1, 1), 0.0025, up)
    tensor([[63.6620]])
    """
    _check_counts(axes, energy)
    dtype = torch.promote_types(energy.dtype, directions.dtype)
    spread = _per_lobe(sharpness, len(axes), energy.device)
    scaled = energy.to(dtype) * normaliser(spread).to(dtype)[:, None]
    inverse = (1 / spread).to(dtype)
    points = directions.to(dtype).reshape(-1, 3)
    parts = []
    for some in torch.split(points, max(1, CHUNK // max(1, len(axes)))):
        chord = torch.cdist(some, axes.to(dtype), compute_mode="donot_use_mm_for_euclid_dist")
        parts.append(falloff(-0.5 * chord.square() * inverse) @ scaled)
    flat = torch.cat(parts, -2)
    return flat.reshape(*energy.shape[:-2], *directions.shape[:-1], energy.shape[-1])


def evaluate_map(
    axes: Float[Tensor, "count 3"],
    energy: Float[Tensor, "*batch count channels"],
    sharpness: float | Tensor,
    height: int,
    conserve: bool = True,
) -> Float[Tensor, "*batch height width channels"]:
    """Radiance of all lobes at the texel centres of a panorama [*batch, height, 2 height, channels].

    Lobes of zero energy cost nothing (unless energy wants a gradient), and rows far from a lobe neither; the
    work goes in bands of rows, so that memory stays near the result's own size.

    Args:
        axes: unit vectors towards the light.
        energy: integrated radiance v of each lobe.
        sharpness: s, one number for all lobes or a tensor with one for each.
        height: rows of the panorama.
        conserve: rescale each lobe on this map so that its sum of radiance times solid angle is its energy
            exactly. On a coarse map a lobe is narrower than a texel, and values at texel centres alone would
            miss it: on 16x32 a lobe of s = 0.0025 would sum to between .21 and 2.3 of its energy, on
            128x256 to between .99997 and 1.0004 (on the pole itself, 1.010).

    Convention: row 0 is +Y, the image centre is -Z. Differentiable in every argument.

    Raises:
        ValueError: the sharpness is not above 0, the counts differ, or height is below 1.

    >>> panorama = evaluate_map(torch.tensor([[0.0, 0.0, -1.0]]), torch.ones(1, 3), 0.0025, height=128)
    >>> from mixlight.sphere.equirect import integrate
    >>> integrate(panorama)
    tensor([1.0000, 1.0000, 1.0000])
    """
    _check_counts(axes, energy)
    if height < 1:
        raise ValueError(f"height: expected at least 1, received {height}")
    batch, channels = energy.shape[:-2], energy.shape[-1]
    dtype = torch.promote_types(energy.dtype, torch.float32)
    spread = _per_lobe(sharpness, len(axes), energy.device)
    if not energy.requires_grad:
        lit = (energy != 0).any(-1).reshape(-1, len(axes)).any(0)
        axes, energy, spread = axes[lit], energy[..., lit, :], spread[lit]
    if len(axes) == 0:
        return energy.new_zeros(*batch, height, 2 * height, channels)
    grid = LobeGrid(axes, spread, height, dtype)
    scaled = energy.to(dtype) * _peak(grid, spread, conserve).to(dtype)[:, None]
    bands = []
    for rows, near, table in grid.bands():
        flat = table.flatten(1).T @ scaled[..., near, :]
        bands.append(flat.reshape(*batch, rows.stop - rows.start, 2 * height, channels))
    return torch.cat(bands, -3).to(energy.dtype)


def lobe_maps(
    axes: Float[Tensor, "count 3"],
    sharpness: float | Tensor,
    height: int,
    conserve: bool = True,
) -> Float[Tensor, "count height width"]:
    """One panorama for each lobe, of energy 1: the dense matrix form of `evaluate_map`, for small maps and
    training.

    ``evaluate_map(axes, energy, s, height) == einsum("nhw,nc->hwc", lobe_maps(axes, s, height), energy)``.

    >>> from mixlight.sphere.equirect import solid_angle
    >>> maps = lobe_maps(torch.tensor([[0.0, 1.0, 0.0]]), 0.0025, height=16)
    >>> round(float((maps[0].double() * solid_angle(16, dtype=torch.float64)).sum()), 5)
    1.0
    """
    if height < 1:
        raise ValueError(f"height: expected at least 1, received {height}")
    dtype = torch.promote_types(axes.dtype, torch.float32)
    spread = _per_lobe(sharpness, len(axes), axes.device)
    grid = LobeGrid(axes, spread, height, dtype)
    return grid.table() * _peak(grid, spread, conserve).to(dtype)[:, None, None]


def band_factors(sharpness: float, degree: int) -> Float[Tensor, " degrees"]:
    """Factors a_l by which a lobe's harmonics of degree l fall short of a point light's, for l = 0 to
    ``degree``.

    a_l = I_{l + 1/2}(1 / s) / I_{1/2}(1 / s), about exp(-s l (l + 1) / 2), with I the modified Bessel
    functions; in float64. A point light of energy v on the axis u has the coefficients v B_lm(u), a lobe v
    a_l B_lm(u).

    >>> band_factors(0.0025, 2)
    tensor([1.0000, 0.9975, 0.9925], dtype=torch.float64)
    """
    _check_sharpness(sharpness)
    return torch.tensor(_bessel_ratios(float(sharpness), degree), dtype=torch.float64)


def to_harmonics(
    axes: Float[Tensor, "count 3"],
    energy: Float[Tensor, "*batch count channels"],
    sharpness: float,
    degree: int = 2,
) -> Float[Tensor, "*batch k channels"]:
    """Exact radiance coefficients of the lobes, as `mixlight.light.harmonics.project` would find them on a
    fine map.

    >>> to_harmonics(torch.tensor([[0.0, 1.0, 0.0]]), torch.ones(1, 1), 0.0025, degree=1)[:, 0]
    tensor([0.2821, 0.4874, 0.0000, 0.0000])
    """
    _check_counts(axes, energy)
    count(degree)
    factors = band_factors(sharpness, degree)[degrees(degree)].to(energy)
    return (basis(axes.to(energy), degree) * factors).T @ energy


def irradiance(
    axes: Float[Tensor, "count 3"],
    energy: Float[Tensor, "*batch count channels"],
    sharpness: float,
    normals: Float[Tensor, "*points 3"],
) -> Float[Tensor, "... channels"]:
    """Irradiance of the lobes on surfaces with the given unit normals; shape [*batch, *points, channels].

    The lobe's extent is taken into account: light fades over about 10 degrees where a surface turns away, and
    is not cut off at 90. It is the lobe's convolution with the clamped cosine, E(c) = v sum of (2l + 1) / (4
    pi) A_l a_l P_l(c) in c = n.u, summed to where it has converged (within 1e-7 v for s from 1e-4 on).

    Convention: v = 1 on the surface that faces it gives 1 - s = .9975 for s = 0.0025; edge-on it gives
        sqrt(s / 2 pi) = .0199.

    Raises:
        ValueError: the sharpness is not above 0, or the counts differ.

    >>> irradiance(torch.tensor([[0.0, 1.0, 0.0]]), torch.ones(1, 1), 0.0025, torch.tensor([0.0, 1.0, 0.0]))
    tensor([0.9975])
    """
    _check_counts(axes, energy)
    series = _irradiance_series(float(sharpness))
    dtype = torch.promote_types(energy.dtype, normals.dtype)
    parts = []
    for some in torch.split(normals.to(dtype).reshape(-1, 3), max(1, CHUNK // max(1, len(axes)))):
        cosine = (some @ axes.to(dtype).T).clamp(-1, 1)
        later = latest = torch.zeros_like(cosine)  # Clenshaw's recurrence for Legendre sums
        for band in range(len(series) - 1, -1, -1):
            step = (2 * band + 1) / (band + 1) * cosine * later - (band + 1) / (band + 2) * latest
            later, latest = step + series[band], later
        parts.append(later.clamp_min(0) @ energy.to(dtype))
    flat = torch.cat(parts, -2)
    return flat.reshape(*energy.shape[:-2], *normals.shape[:-1], energy.shape[-1])


@lru_cache(maxsize=32)
def _bessel_ratios(sharpness: float, degree: int) -> tuple[float, ...]:
    """a_0 ... a_degree by Miller's downward recurrence a_{l-1} = a_{l+1} + (2l + 1) s a_l, scaled to a_0 =
    1.
    """
    start = degree + 20 + math.ceil(math.sqrt(80 / sharpness))
    values = [0.0] * (start + 2)
    values[start] = 1e-300
    for band in range(start, 0, -1):
        values[band - 1] = values[band + 1] + (2 * band + 1) * sharpness * values[band]
        if values[band - 1] > 1e200:
            for index in range(band - 1, start + 1):
                values[index] *= 1e-250
    return tuple(value / values[0] for value in values[: degree + 1])


@lru_cache(maxsize=32)
def _irradiance_series(sharpness: float) -> tuple[float, ...]:
    _check_sharpness(sharpness)
    degree = min(512, 8 + math.ceil(math.sqrt(32 / sharpness)))
    ratios = _bessel_ratios(sharpness, degree)
    return tuple(
        (2 * band + 1) / (4 * math.pi) * cosine_factor(band) * ratios[band] for band in range(degree + 1)
    )


def _peak(grid: LobeGrid, sharpness: Tensor, conserve: bool) -> Tensor:
    """[n]: the radiance of a lobe of energy 1 at its brightest texel."""
    if conserve:
        return 1 / grid.integral()
    return normaliser(sharpness) * torch.exp(grid.peak)


def _per_lobe(value: float | Tensor, size: int, device: torch.device) -> Tensor:
    """[size], in float64."""
    normaliser(value)  # refuses what is no sharpness
    return torch.as_tensor(value, dtype=torch.float64, device=device).expand(size)


def _check_sharpness(sharpness: float) -> None:
    if not (sharpness > 0 and math.isfinite(sharpness)):
        raise ValueError(f"sharpness: expected a number above 0, received {sharpness!r}")


def _check_counts(axes: Tensor, energy: Tensor) -> None:
    if axes.shape[-1] != 3 or axes.ndim != 2 or energy.ndim < 2 or energy.shape[-2] != len(axes):
        raise ValueError(
            "axes and energy: expected [count, 3] and [..., count, channels], received "
            f"{tuple(axes.shape)} and {tuple(energy.shape)}"
        )
