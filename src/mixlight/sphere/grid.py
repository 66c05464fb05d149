"""The grid of the equirectangular panorama: its pixels' directions, their solid angles, and places on it.

A panorama is [..., H, W, C], W = 2 H, row 0 at the top (+Y), seen from the inside, its centre at -Z. A
direction (x, y, z) lies at u = 1/2 + atan2(x, -z) / 2 pi, v = acos(y) / pi; the centre of pixel (i, j) is at
u = (j + 1/2) / W, v = (i + 1/2) / H (`docs/conventions.md`). Use these functions through `equirect`.
"""

import math
from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.sphere import _bilinear
from mixlight.sphere._tables import place


def grid_size(height: int, width: int | None) -> tuple[int, int]:
    """Fill in the width of a 2:1 grid; refuse an empty one."""
    width = 2 * height if width is None else width
    if height < 1 or width < 1:
        raise ValueError(f"expected a grid of at least 1 x 1, received height {height}, width {width}")
    return height, width


@lru_cache(maxsize=16)
def polar_rows(height: int) -> tuple[Tensor, Tensor]:
    """Sine and cosine of the polar angle of each row's centre, float64 on the CPU (read only)."""
    with torch.inference_mode(False):
        angle = (torch.arange(height, dtype=torch.float64, device="cpu") + 0.5) * (math.pi / height)
        return angle.sin(), angle.cos()


def pixel_directions(
    height: int,
    width: int | None = None,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, "height width 3"]:
    """Return the unit direction through the centre of each pixel.

    Args:
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [H, W, 3], x, y, z.

    Convention: +X right, +Y up, -Z forward and at the centre of the image; row 0 is the top. With H = 2 the
    pixel (0, 2) looks up, forward and right: (0.5, 0.7071, -0.5).

    Raises:
        ValueError: height or width below 1.

    >>> pixel_directions(2)[0, 2]
    tensor([ 0.5000,  0.7071, -0.5000])
    """
    height, width = grid_size(height, width)
    sine, cosine = polar_rows(height)
    azimuth = (torch.arange(width, dtype=torch.float64, device="cpu") + 0.5) * (2 * math.pi / width) - math.pi
    result = torch.empty((height, width, 3), dtype=dtype, device="cpu")
    result[..., 0] = torch.outer(sine, azimuth.sin()).to(dtype)
    result[..., 1] = cosine.to(dtype)[:, None]
    result[..., 2] = torch.outer(sine, -azimuth.cos()).to(dtype)
    return place(result, dtype, device)


def row_solid_angle(
    height: int,
    width: int | None = None,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, " height"]:
    """Return the exact solid angle of one texel of each row: the first column of `solid_angle`.

    Args:
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [H] steradians. Weighting by it as [H, 1] costs no memory, which counts on large maps.

    Convention: row 0 is the top. With H = 2, W = 4 each texel has pi / 2.

    Raises:
        ValueError: height or width below 1.

    >>> row_solid_angle(2)
    tensor([1.5708, 1.5708])
    """
    height, width = grid_size(height, width)
    # cos a - cos b as a product: exact near the poles too, where the cosines would cancel.
    rows = (4 * math.pi / width * math.sin(math.pi / (2 * height))) * polar_rows(height)[0]
    return place(rows, dtype, device)


def solid_angle(
    height: int,
    width: int | None = None,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, "height width"]:
    """Return the exact solid angle of each texel, in steradians.

    Omega_i = 2 pi / W (cos(i pi / H) - cos((i + 1) pi / H)); the sum over the map is 4 pi.

    Args:
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [H, W] steradians, the same along a row.

    Convention: row 0 is the top. With H = 2, W = 4 each of the eight texels has pi / 2.

    Raises:
        ValueError: height or width below 1.

    >>> round(solid_angle(128).sum().item(), 4)
    12.5664
    """
    height, width = grid_size(height, width)
    return row_solid_angle(height, width, dtype=dtype, device=device)[:, None].repeat(1, width)


def directions_to_uv(directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 2"]:
    """Return where on the panorama a direction lies, as fractions of its width and height.

    u = 1/2 + atan2(x, -z) / 2 pi, v = acos(y / |d|) / pi; computed so that it is exact at the poles.

    Args:
        directions: [..., 3], of any length but zero (a zero vector has no direction and gives NaN).

    Returns:
        [..., 2], u in [0, 1) rightwards, v in [0, 1] downwards. u = 1/2 on the poles, where it is free.

    Convention: pixel (i, j) has its centre at u = (j + 1/2) / W, v = (i + 1/2) / H. +X is at (0.75, 0.5).

    >>> directions_to_uv(torch.tensor([1.0, 0.0, 0.0]))
    tensor([0.7500, 0.5000])
    """
    wide = directions.to(torch.promote_types(directions.dtype, torch.float32))
    azimuth, angle = _bilinear.polar(*_bilinear.planes(wide))
    u = (azimuth / (2 * math.pi) + 0.5).clamp(min=0)
    return torch.stack((torch.where(u >= 1, u - 1, u), angle / math.pi), -1)


def uv_to_directions(uv: Float[Tensor, "*batch 2"]) -> Float[Tensor, "*batch 3"]:
    """Return the unit direction at a place of the panorama; the inverse of `directions_to_uv`.

    d = (sin(pi v) sin(phi), cos(pi v), -sin(pi v) cos(phi)), phi = 2 pi (u - 1/2).

    Args:
        uv: [..., 2], u as a fraction of the width (any number, it wraps), v of the height (0 top, 1 bottom).

    Returns:
        [..., 3] unit vectors.

    Convention: the centre of the image (0.5, 0.5) is -Z.

    >>> uv_to_directions(torch.tensor([0.75, 0.25]))
    tensor([7.0711e-01, 7.0711e-01, 3.0909e-08])
    """
    azimuth, angle = (uv[..., 0] - 0.5) * (2 * math.pi), uv[..., 1] * math.pi
    sine = angle.sin()
    return torch.stack((sine * azimuth.sin(), angle.cos(), -sine * azimuth.cos()), -1)
