"""Bilinear look-up on the equirectangular grid: the four texels around a direction and their weights.

One fused gather (`embedding_bag`) serves every caller; a supersampled pixel is simply a longer bag.
"""

import math

import torch
import torch.nn.functional as functional
from jaxtyping import Float, Int
from torch import Tensor

CHUNK = 1 << 20
"""Rays looked up at once: bounds the memory of the index tables (48 bytes a ray) on large maps."""


def polar(directions: Float[Tensor, "*n 3"]) -> tuple[Float[Tensor, "*n"], Float[Tensor, "*n"]]:
    """Azimuth atan2(x, -z) in [-pi, pi] and polar angle in [0, pi] of directions of any length.

    The polar angle is atan2(hypot(x, z), y): unlike acos(y) it keeps full precision at the poles, where its
    gradient is finite (0) too.
    """
    if directions.dtype in (torch.float16, torch.bfloat16):
        directions = directions.float()
    x, y, z = directions.unbind(-1)
    squared = x * x + z * z
    # Exactly on the axis azimuth is free: we choose 0, and keep 0/0 out of the gradients.
    axial = squared < torch.finfo(squared.dtype).tiny
    forward = torch.where(axial, 1.0, -z)
    side = torch.where(axial, 0.0, x)
    across = torch.where(axial, 0.0, torch.where(axial, 1.0, squared).sqrt())
    return torch.atan2(side, forward), torch.atan2(across, torch.where(axial & (y == 0), torch.nan, y))


def taps(
    directions: Float[Tensor, "*n 3"], height: int, width: int
) -> tuple[Int[Tensor, "*n 4"], Float[Tensor, "*n 4"]]:
    """Flat texel indices and weights of the four texels around each direction; weights sum to 1.

    Columns wrap. The row above row 0 is row 0 seen across the pole, i.e. shifted by half the width; the same
    holds below the last row.
    """
    azimuth, angle = polar(directions)
    column = azimuth * (width / (2 * math.pi)) + (width / 2 - 0.5)
    row = angle * (height / math.pi) - 0.5
    left, top = column.detach().floor(), row.detach().floor()
    along, down = column - left, row - top
    # Integers are clamped after the conversion, so that NaN directions give NaN values and not a wild index.
    c0 = left.long().clamp_(-1, width - 1)
    c0 += width * (c0 < 0)
    c1 = c0 + 1
    c1 -= width * (c1 == width)
    r0 = top.long().clamp_(-1, height - 1)
    r1 = r0 + 1
    half = width // 2
    index = torch.empty((*c0.shape, 4), dtype=torch.int64, device=c0.device)
    over_top, over_bottom = r0 < 0, r1 == height
    if bool((over_top | over_bottom).any()):
        for slot, (r, c, over) in enumerate(
            ((r0, c0, over_top), (r0, c1, over_top), (r1, c0, over_bottom), (r1, c1, over_bottom))
        ):
            index[..., slot] = r.clamp(0, height - 1) * width + (c + half * over) % width
    else:
        start = r0 * width
        index[..., 0] = start + c0
        index[..., 1] = start + c1
        start += width
        index[..., 2] = start + c0
        index[..., 3] = start + c1
    lower = torch.stack(((1 - along) * down, along * down), -1)
    weight = torch.cat((torch.stack((1 - along, along), -1) - lower, lower), -1)
    return index, weight


def gather(
    values: Float[Tensor, "batch texels channels"],
    index: Int[Tensor, "rays taps"],
    weight: Float[Tensor, "rays taps"],
) -> Float[Tensor, "batch rays channels"]:
    """Weighted sum of the texels of each ray, the same rays in every map of the batch."""
    precise = torch.promote_types(values.dtype, torch.float32)
    weight = weight.to(precise)
    sums = [
        functional.embedding_bag(index, texels.to(precise), mode="sum", per_sample_weights=weight)
        for texels in values
    ]
    return torch.stack(sums).to(values.dtype)


def lookup(
    panorama: Float[Tensor, "*maps height width channels"], rays: Float[Tensor, "*n group 3"]
) -> Float[Tensor, "*out channels"]:
    """Mean over each group of rays of the panorama along them, the same rays in every map: [*maps, *n, C]."""
    maps, (height, width, channels) = panorama.shape[:-3], panorama.shape[-3:]
    require_even(width)
    shape, group = rays.shape[:-2], rays.shape[-2]
    texels = panorama.reshape(-1, height * width, channels)
    flat, step = rays.reshape(-1, group, 3), max(1, CHUNK // group)
    parts = []
    for start in range(0, max(len(flat), 1), step):
        index, weight = taps(flat[start : start + step], height, width)
        parts.append(gather(texels, index.flatten(1), weight.flatten(1) / group))
    result = torch.cat(parts, 1) if len(parts) > 1 else parts[0]
    return result.view(*maps, *shape, channels)


def require_even(width: int) -> None:
    """Refuse a width whose half is no whole number of columns: the poles are crossed by that half."""
    if width % 2:
        raise ValueError(f"expected a panorama of even width, received {width}")
