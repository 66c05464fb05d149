"""Resizing of panoramas with the energy kept. Use these functions through `equirect`."""

import math
from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.sphere import _separable
from mixlight.sphere.grid import grid_size


@lru_cache(maxsize=64)
def _row_bands(height: int, out_height: int) -> _separable.Bands:
    with torch.inference_mode(False):
        # -cos of the polar angle: its differences are solid angles.
        edges = [
            -(torch.arange(count + 1, dtype=torch.float64, device="cpu") * (math.pi / count)).cos()
            for count in (out_height, height)
        ]
        return _separable.overlap(edges[0], edges[1])


@lru_cache(maxsize=64)
def _column_bands(width: int, out_width: int) -> _separable.Bands:
    with torch.inference_mode(False):
        edges = [
            torch.arange(count + 1, dtype=torch.float64, device="cpu") / count for count in (out_width, width)
        ]
        return _separable.overlap(edges[0], edges[1])


def resize(
    panorama: Float[Tensor, "*batch height width channels"], height: int, width: int | None = None
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Resize with the energy kept: each new texel is the solid-angle-weighted mean of what it covers.

    The overlap of two texels is the product of an interval of -cos(polar angle) and one of azimuth, so the
    mean is separable. Works up (blocky, on purpose: nothing is invented) and down, for any pair of sizes.

    Args:
        panorama: [..., H, W, C].
        height: Rows of the result.
        width: Columns of the result; 2 height if not given.

    Returns:
        [..., height, width, C] with the same `integrate`, to rounding.

    Convention: two rows over a hemisphere with 0 above and 1 below, reduced to one row, give 0.5.

    Raises:
        ValueError: height or width below 1.

    >>> resize(torch.tensor([[[0.0]], [[0.0]], [[0.0]], [[1.0]]]), 2, 1).flatten()
    tensor([0.0000, 0.2929])
    """
    height, width = grid_size(height, width)
    if panorama.shape[-3:-1] == (height, width):
        return panorama.clone()
    rows = _row_bands(panorama.shape[-3], height)
    return _separable.apply(panorama, rows, _column_bands(panorama.shape[-2], width))


def prefilter(
    panorama: Float[Tensor, "*batch height width channels"], spacing: float
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Reduce a panorama whose texels are finer than the rays that will sample it, so that none is skipped.

    Args:
        panorama: [..., H, W, C].
        spacing: Angle between neighbouring rays in radians.

    Returns:
        `resize` of the panorama by the largest whole factor that leaves its texels no wider than `spacing`,
        up to a row; the panorama itself where that factor is 1.

    Convention: H = 512 and a spacing of pi / 128 give 128 rows.

    >>> prefilter(torch.ones(512, 1024, 1), math.pi / 128).shape
    torch.Size([128, 256, 1])
    """
    height = panorama.shape[-3]
    factor = int(spacing * height / math.pi + 1e-9)
    return panorama if factor < 2 else resize(panorama, max(2, height // factor))
