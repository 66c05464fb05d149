"""Sets of functions on the sphere in which light is expanded, by name: what the study compares.

- ``constant``: one harmonic, the same light from everywhere.
- ``sh2``, ``sh6``: the harmonics up to degree 2 (9) and 6 (49).
- ``sg9``: 9 smooth Gaussians of s = 0.2423 on golden-angle axes, which cover the sphere as evenly as 9 can;
  each integrates to 1, so that a coefficient is an energy.

Smooth Gaussians are not orthogonal: `project` solves for the coefficients that are best in the mean square.
"""

import math
from functools import lru_cache
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import gaussians, harmonics
from mixlight.sphere import equirect
from mixlight.sphere.points import vogel

Functions = Literal["constant", "sh2", "sh6", "sg9"]

NAMES: tuple[str, ...] = get_args(Functions)

SMOOTH = 0.2423
"""Sharpness s of the smooth Gaussians: about half of the peak is left where two of them meet."""

SMOOTH_COUNT = 9
"""Their number: as many coefficients as harmonics of degree 2 have."""

_DEGREES = {"constant": 0, "sh2": 2, "sh6": 6}


def count(name: Functions) -> int:
    """Number of functions.

    Raises:
        ValueError: no such set.

    >>> [count(name) for name in ("constant", "sh2", "sh6", "sg9")]
    [1, 9, 49, 9]
    """
    _check(name)
    return SMOOTH_COUNT if name == "sg9" else harmonics.count(_DEGREES[name])


def maps(name: Functions, height: int) -> Float[Tensor, "height width k"]:
    """Value of each function at each texel of a panorama; a light's map is ``maps @ coefficients``.

    Convention: a Gaussian's map sums to exactly 1 over solid angle, on any height.

    Raises:
        ValueError: no such set, or a height below 1.

    >>> [round(float(maps(name, 16)[4, 8].max()), 3) for name in ("sg9", "constant")]
    [0.592, 0.282]
    """
    _check(name)
    return _maps(name, height).clone()


def project(
    panorama: Float[Tensor, "*batch height width channels"], name: Functions
) -> Float[Tensor, "*batch k channels"]:
    """Coefficients of the expansion that is nearest to the panorama in the mean square over the sphere.

    Args:
        panorama: radiance, 2:1.
        name: the set of functions.

    Convention: exact for what the functions span. A panorama of 1 everywhere has the ``constant`` sqrt(4 pi).

    Raises:
        ValueError: no such set, or the panorama is not 2:1.

    >>> project(torch.ones(16, 32, 1), "constant")
    tensor([[3.5449]])
    """
    _check(name)
    if name != "sg9":
        return harmonics.project(panorama, _DEGREES[name])
    height, width = panorama.shape[-3:-1]
    if width != 2 * height:
        raise ValueError(f"panorama: expected a width of twice the height, received {width} x {height}")
    table = _least_squares(height).to(panorama.device)
    found: Tensor = table @ panorama.flatten(-3, -2).to(table.dtype)
    return found.to(panorama.dtype)


def products(name: Functions, cosine: bool = False) -> Float[Tensor, "k k"]:
    """Inner products of the functions over the sphere; with ``cosine`` those of their irradiance over pi.

    An expansion's squared error over all directions is ``d @ products @ d`` for an error d of its
    coefficients; with ``cosine`` it is that of the picture of a white diffuse sphere. In float64.

    Raises:
        ValueError: no such set.

    >>> products("sh2").diagonal().sum(), products("sh2", cosine=True).diagonal()[:5]
    (tensor(9., dtype=torch.float64), tensor([1.0000, 0.4444, 0.4444, 0.4444, 0.0625], dtype=torch.float64))
    """
    table = to_harmonics(name)
    if cosine:
        degree = harmonics.degree_of(table[..., None])
        factors = [harmonics.cosine_factor(band) / math.pi for band in range(degree + 1)]
        table = table * torch.tensor(factors, dtype=torch.float64)[harmonics.degrees(degree)]
    return table @ table.T


def to_harmonics(name: Functions) -> Float[Tensor, "k harmonics"]:
    """Each function's own coefficients in harmonics (of degree 6 for the smooth Gaussians, which have next to
    nothing beyond); in float64.

    >>> to_harmonics("sg9").shape
    torch.Size([9, 49])
    """
    _check(name)
    if name != "sg9":
        return torch.eye(count(name), dtype=torch.float64)
    degree = harmonics.MAX_DEGREE
    factors = gaussians.band_factors(SMOOTH, degree)[harmonics.degrees(degree)]
    return harmonics.basis(vogel(SMOOTH_COUNT, dtype=torch.float64), degree) * factors


@lru_cache(maxsize=16)
def _maps(name: Functions, height: int) -> Tensor:
    if name == "sg9":
        return gaussians.lobe_maps(vogel(SMOOTH_COUNT), SMOOTH, height).permute(1, 2, 0).float().contiguous()
    return harmonics.basis(equirect.pixel_directions(height), _DEGREES[name])


@lru_cache(maxsize=8)
def _least_squares(height: int) -> Tensor:
    """[9, texels]: from a panorama to the coefficients of the smooth Gaussians."""
    table = _maps("sg9", height).flatten(0, 1).double()
    weighted = table * equirect.solid_angle(height, dtype=torch.float64).flatten()[:, None]
    solution: Tensor = torch.linalg.solve(weighted.T @ table, weighted.T)
    return solution


def _check(name: str) -> None:
    if name not in NAMES:
        raise ValueError(f"functions: expected one of {', '.join(NAMES)}, received {name!r}")
