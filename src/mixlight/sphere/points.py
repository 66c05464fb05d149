"""Anchors: points spread evenly over the sphere, their neighbours, and the nearest one to a direction."""

import math
from collections.abc import Iterator
from functools import lru_cache

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mixlight.sphere._tables import place

_CHUNK = 1 << 22
"""Dot products held at once."""

_TILE = 16
"""Side of the tiles of pixels that `anchor_map` decides at once where it can."""


def vogel(
    count: int, *, dtype: torch.dtype = torch.float32, device: torch.device | str | None = None
) -> Float[Tensor, "count 3"]:
    """Return the points of the golden-angle (Vogel) spiral, evenly spread from the zenith to the nadir.

    Point i has height y = 1 - (2 i + 1) / count and azimuth phi = i pi (3 - sqrt 5), measured from -Z to the
    right: d = (r sin(phi), y, -r cos(phi)), r = sqrt(1 - y^2).

    Args:
        count: Number of points N.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [N, 3] unit vectors, top first. For N = 128 the nearest neighbour is 15.7 to 17.3 degrees away.

    Convention: +X right, +Y up, -Z forward. With N = 1 the only point is -Z.

    Raises:
        ValueError: count below 1.

    Source: H. Vogel, A better way to construct the sunflower head, 1979, carried over to the sphere.

    >>> vogel(2)[0]
    tensor([ 0.0000,  0.5000, -0.8660])
    """
    if count < 1:
        raise ValueError(f"expected at least 1 point, received {count}")
    i = torch.arange(count, dtype=torch.float64, device="cpu")
    height = 1 - (2 * i + 1) / count
    azimuth = i * (math.pi * (3 - math.sqrt(5)))
    radius = (1 - height**2).sqrt()
    points = torch.stack((radius * azimuth.sin(), height, -radius * azimuth.cos()), -1)
    return place(points, dtype, device)


def neighbours(points: Float[Tensor, "count 3"], k: int = 6) -> Int[Tensor, "count k"]:
    """Return the k nearest other points of each point, nearest first.

    Args:
        points: [N, 3] unit vectors.
        k: Number of neighbours, 1 to N - 1.

    Returns:
        [N, k] int64 indices; the point itself is left out; of equally near points the lower index first.

    Raises:
        ValueError: k below 1 or above N - 1.

    >>> neighbours(vogel(128))[0]
    tensor([3, 2, 5, 1, 8, 6])
    """
    count = len(points)
    if not 1 <= k < count:
        raise ValueError(f"expected 1 <= k <= {count - 1} for {count} points, received k = {k}")
    exact = points.detach().double()
    cosine = exact @ exact.T
    cosine.fill_diagonal_(-math.inf)
    # Rounding must not decide between points that are equally near.
    return (cosine * 2**40).round().argsort(dim=1, descending=True, stable=True)[:, :k].contiguous()


def nearest(points: Float[Tensor, "count 3"], directions: Float[Tensor, "*batch 3"]) -> Int[Tensor, "*batch"]:
    """Return the index of the nearest point to each direction.

    Args:
        points: [N, 3] unit vectors.
        directions: [..., 3], of any length but zero.

    Returns:
        [...] int64. Compared in the wider of the two dtypes; of equally near points the lower index.

    >>> nearest(vogel(128), torch.tensor([0.0, 1.0, 0.0]))
    tensor(0)
    """
    dtype = torch.promote_types(torch.promote_types(points.dtype, directions.dtype), torch.float32)
    points = points.detach().to(dtype)
    flat = directions.detach().reshape(-1, 3)
    rows = max(1, _CHUNK // len(points))
    parts = [
        (flat[start : start + rows].to(dtype) @ points.T).argmax(-1) for start in range(0, len(flat), rows)
    ]
    return torch.cat(parts).view(directions.shape[:-1]) if parts else flat.new_empty(0, dtype=torch.int64)


def anchor_map(
    count: int, height: int, width: int | None = None, *, device: torch.device | str | None = None
) -> Int[Tensor, "height width"]:
    """Return the index of the nearest Vogel point to each pixel of a panorama.

    Args:
        count: Number of Vogel points N.
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        device: Device of the result.

    Returns:
        [H, W] int64, a fresh tensor (the tables of recent sizes are kept).

    Convention: row 0 is the top, the centre of the image is -Z.

    Raises:
        ValueError: count, height or width below 1.

    >>> anchor_map(128, 128)[0, 0], anchor_map(128, 128)[-1, 0]
    (tensor(0), tensor(127))
    """
    width = 2 * height if width is None else width
    if height < 1 or width < 1:
        raise ValueError(f"expected a grid of at least 1 x 1, received height {height}, width {width}")
    return place(_anchor_map(count, height, width), torch.int64, device)


@lru_cache(maxsize=8)
def _anchor_map(count: int, height: int, width: int) -> Int[Tensor, "height width"]:
    """`nearest` at every pixel, in 16 or 32 bits, tile by tile.

    A tile of angular radius rho around a centre whose nearest point is at angle delta can only be near points
    within delta + 2 rho of that centre. Most tiles are left with one point and need no look at their pixels.
    """
    with torch.inference_mode(False):
        points = vogel(count, dtype=torch.float64, device="cpu")
        small = torch.int16 if count <= 1 << 15 else torch.int32
        down, across = -(-height // _TILE), -(-width // _TILE)
        # Pixels of the last tiles that would lie beyond the rim repeat the rim; they are cut off at the end.
        row = torch.arange(down * _TILE, device="cpu").clamp(max=height - 1).view(down, _TILE)
        column = torch.arange(across * _TILE, device="cpu").clamp(max=width - 1).view(across, _TILE)
        angle = (row.double() + 0.5) * (math.pi / height)
        azimuth = (column.double() + 0.5) * (2 * math.pi / width)
        middle = angle.mean(1)
        centre = _directions(middle[:, None], azimuth.mean(1)[None, :]).flatten(0, 1)
        half = (angle[:, -1] - angle[:, 0]) / 2
        # Down a meridian, then along a parallel: longer than the great circle.
        radius = half[:, None] + angle.sin().amax(1)[:, None] * (azimuth[:, -1] - azimuth[:, 0]) / 2
        result = torch.empty(down * across, _TILE, _TILE, dtype=small, device="cpu")
        step = max(1, _CHUNK // count)
        for start in range(0, len(centre), step):
            distance = (centre[start : start + step] @ points.T).clamp(-1, 1).acos()
            reach = distance.amin(1) + 2 * radius.flatten()[start : start + step] + 1e-6
            possible = distance <= reach[:, None]
            choices = possible.sum(1)
            for k in sorted(set(choices.tolist())):
                tiles = (choices == k).nonzero()[:, 0]
                candidates = possible[tiles].nonzero()[:, 1].view(-1, k)
                if k == 1:
                    result[start + tiles] = candidates[:, :, None].to(small)
                    continue
                for some, those in _chunks(start + tiles, candidates, max(1, _CHUNK // (k * _TILE**2))):
                    pixels = _directions(
                        angle[some // across][:, :, None], azimuth[some % across][:, None, :]
                    )
                    best = (pixels.flatten(1, 2) @ points[those].transpose(1, 2)).argmax(2)
                    result[some] = those.gather(1, best).view(-1, _TILE, _TILE).to(small)
        rows = result.view(down, across, _TILE, _TILE).transpose(1, 2).reshape(down * _TILE, across * _TILE)
        return rows[:height, :width].contiguous()


def _chunks(tiles: Tensor, candidates: Tensor, step: int) -> Iterator[tuple[Tensor, Tensor]]:
    for start in range(0, len(tiles), step):
        yield tiles[start : start + step], candidates[start : start + step]


def _directions(angle: Tensor, azimuth: Tensor) -> Tensor:
    """Unit directions of polar angles and of azimuths counted from the left rim of the panorama."""
    sine, cosine = angle.sin(), angle.cos()
    return torch.stack((sine * -azimuth.sin(), cosine + 0 * azimuth, sine * azimuth.cos()), -1)
