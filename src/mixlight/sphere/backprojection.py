"""A pinhole picture laid back onto the sphere: the inverse of `mixlight.sphere.camera.view`."""

import math

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.sphere import _separable, camera
from mixlight.sphere.frames import rotation
from mixlight.sphere.grid import polar_rows

__all__ = ["lay_on_sphere"]

_RAYS = 1 << 18
"""Rays followed at once."""


def lay_on_sphere(
    picture: Float[Tensor, "picture_height picture_width channels"],
    fov_x: float,
    height: int,
    *,
    yaw: float = 0.0,
    pitch: float = 0.0,
    roll: float = 0.0,
    feather: float = 0.0,
    supersample: int = 2,
) -> tuple[Float[Tensor, "height width channels"], Float[Tensor, "height width"]]:
    """Show a panorama what a pinhole camera at its centre has seen, antialiased, with soft edges.

    A picture finer than the rays is first reduced to their spacing (means over pixels' areas), then each
    texel is the mean of supersample^2 bilinear look-ups, each weighted by its distance to the picture's edge:
    1 inside, falling to 0 at the edge by the smooth step 3t² - 2t³.

    Args:
        picture: [h, w, C] linear light.
        fov_x: Horizontal field of view in radians, in (0, pi), from outer edge to outer edge.
        height: Rows of the panorama.
        yaw: Radians, positive to the right.
        pitch: Radians, positive upwards.
        roll: Radians, positive clockwise (see `mixlight.sphere.frames.rotation`).
        feather: Width of the soft edge as a share of the picture's shorter half-side, 0 (hard) to 1 (up to
            the centre).
        supersample: Rays along each side of a texel.

    Returns:
        The picture times its weight, and the weight: [height, 2 height, C] and [height, 2 height]. A panorama
        L with the picture in it is ``premultiplied + (1 - weight) * L``.

    Convention: +X right, +Y up, -Z forward. With yaw = pitch = roll = 0 the picture's centre lies at the
        centre of the panorama; a picture of ones gives the weight itself.

    Raises:
        ValueError: fov_x outside (0, pi), an empty picture, feather outside [0, 1], height or supersample
            below 1.

    >>> laid, weight = lay_on_sphere(torch.full((6, 8, 3), 0.5), math.radians(60), 64)
    >>> laid[32, 64], weight[32, 64], weight[32, 0]
    (tensor([0.5000, 0.5000, 0.5000]), tensor(1.), tensor(0.))
    """
    rows, columns = picture.shape[:2]
    if not 0 <= feather <= 1:
        raise ValueError(f"feather: expected a share from 0 to 1, received {feather}")
    if height < 1 or supersample < 1:
        raise ValueError(
            f"expected a height and a supersample of at least 1, received {height} and {supersample}"
        )
    camera.vertical_fov(fov_x, rows, columns)  # refuses what is no camera
    half_width = math.tan(fov_x / 2)
    half_height = half_width * rows / columns
    picture = _reduced(picture, fov_x, math.pi / (supersample * height))
    matrix = rotation(yaw, pitch, roll, dtype=torch.float64)
    softness = feather * min(half_width, half_height)

    width, channels = 2 * height, picture.shape[-1]
    laid = picture.new_zeros(height, width, channels)
    weight = picture.new_zeros(height, width)
    fine = supersample * width
    sine, cosine = polar_rows(supersample * height)
    azimuth = ((torch.arange(fine, dtype=torch.float64) + 0.5) / fine - 0.5) * (2 * math.pi)
    band = max(1, _RAYS // (fine * supersample))
    for start in range(0, height, band):
        stop = min(start + band, height)
        some = slice(supersample * start, supersample * stop)
        s, y = sine[some, None].double(), cosine[some, None].double()
        rays = torch.stack((s * azimuth.sin(), y.expand(-1, fine), -s * azimuth.cos()), -1)
        right, up, back = (rays @ matrix).unbind(-1)
        ahead = (back < 0).nonzero(as_tuple=True)
        depth = -back[ahead]
        u, v = right[ahead] / depth, up[ahead] / depth
        edge = torch.minimum(half_width - u.abs(), half_height - v.abs())
        inside = edge > 0
        if not bool(inside.any()):
            continue
        u, v, edge = u[inside], v[inside], edge[inside]
        soft = (edge / softness).clamp(max=1) if softness > 0 else torch.ones_like(edge)
        soft = (soft * soft * (3 - 2 * soft)).to(picture)
        value = _look_up(picture, u / half_width, v / half_height) * soft[:, None]
        texel = (ahead[0][inside] // supersample + start) * width + ahead[1][inside] // supersample
        laid.view(-1, channels).index_add_(0, texel, value)
        weight.view(-1).index_add_(0, texel, soft)
    count = supersample**2
    return laid / count, weight / count


def _reduced(picture: Tensor, fov_x: float, spacing: float) -> Tensor:
    """The picture with pixels no finer than rays that are `spacing` apart, where these are closest in it."""
    rows, columns = picture.shape[:2]
    # In the picture's plane rays are `spacing` apart at its centre, and further apart elsewhere.
    factor = spacing * columns / (2 * math.tan(fov_x / 2))
    if factor <= 1:
        return picture
    return _separable.apply(picture, *(_means(side, math.ceil(side / factor)) for side in (rows, columns)))


def _means(count: int, out_count: int) -> _separable.Bands:
    """Means over equal intervals of a side; a pixel that two of them share counts in both."""
    edges = [
        torch.arange(cells + 1, dtype=torch.float64, device="cpu") / cells for cells in (out_count, count)
    ]
    return _separable.overlap(edges[0], edges[1])


def _look_up(picture: Tensor, across: Tensor, upwards: Tensor) -> Tensor:
    """Bilinear values at positions in [-1, 1] of the frame; constant in the outer half of the last pixels."""
    rows, columns = picture.shape[:2]
    x = ((across + 1) / 2 * columns - 0.5).clamp(0, columns - 1)
    y = ((1 - upwards) / 2 * rows - 0.5).clamp(0, rows - 1)
    left, top = x.floor().long(), y.floor().long()
    right, below = (left + 1).clamp(max=columns - 1), (top + 1).clamp(max=rows - 1)
    a, b = (x - left).to(picture)[:, None], (y - top).to(picture)[:, None]
    upper = picture[top, left] * (1 - a) + picture[top, right] * a
    lower = picture[below, left] * (1 - a) + picture[below, right] * a
    return upper * (1 - b) + lower * b
