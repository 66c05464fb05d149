"""Bilinear look-up on the equirectangular grid: the four texels around a direction and their weights.

Directions travel as three planes x, y, z, which need no unit length: every step runs on contiguous memory.
"""

import functools
import math
from collections.abc import Callable

import torch
import torch.nn.functional as functional
from jaxtyping import Float, Int32
from torch import Tensor

Planes = tuple[Tensor, Tensor, Tensor]
"""x, y and z of many directions, each of one and the same shape."""

CHUNK = 1 << 17
"""Rays looked up at once on the CPU: their tables (about 50 bytes a ray) stay near the caches (measured)."""

CHUNK_GRAPH = 1 << 22
"""Rays looked up at once where each chunk costs a gradient of the whole map, or a launch on a GPU."""


def planes(directions: Float[Tensor, "*n 3"]) -> Planes:
    """Split directions into contiguous planes."""
    x, y, z = directions.unbind(-1)
    return x.contiguous(), y.contiguous(), z.contiguous()


def polar(
    x: Float[Tensor, "*n"], y: Float[Tensor, "*n"], z: Float[Tensor, "*n"]
) -> tuple[Float[Tensor, "*n"], Float[Tensor, "*n"]]:
    """Azimuth atan2(x, -z) in [-pi, pi] and polar angle in [0, pi] of directions of any length but zero.

    The polar angle is atan2(hypot(x, z), y): unlike acos(y) it keeps full precision at the poles. Exactly
    there the azimuth is free; we choose 0, and gradients are 0 rather than 0/0. A zero vector gives NaN.
    """
    squared = torch.addcmul(x * x, z, z)
    tiny = torch.finfo(squared.dtype).tiny
    if squared.numel() == 0 or not squared.min().item() < tiny:
        return torch.atan2(x, -z), torch.atan2(squared.sqrt(), y)
    axial = squared < tiny
    across = torch.where(axial, 0.0, torch.where(axial, 1.0, squared).sqrt())
    upright = torch.where(axial & (y == 0), torch.nan, y)
    return torch.atan2(torch.where(axial, 0.0, x), torch.where(axial, 1.0, -z)), torch.atan2(across, upright)


def taps(
    x: Float[Tensor, "*n"], y: Float[Tensor, "*n"], z: Float[Tensor, "*n"], height: int, width: int
) -> tuple[Int32[Tensor, "*n 4"], Float[Tensor, "*n 4"]]:
    """Flat texel indices and weights of the four texels around each direction; the weights sum to 1.

    Columns wrap. The row above row 0 is row 0 seen across the pole, i.e. shifted by half the width; the same
    holds below the last row.
    """
    azimuth, angle = polar(x, y, z)
    column = azimuth.mul_(width / (2 * math.pi)).add_(width / 2 - 0.5)
    row = angle.mul_(height / math.pi).add_(-0.5)
    left, top = column.detach().floor(), row.detach().floor()
    along, down = column - left, row - top
    # Clamped as integers, so that a NaN direction gives NaN weights and not a wild index.
    c0 = left.int().clamp_(-1, width - 1)
    c0 += (c0 >> 31) & width
    c1 = c0 + (1 - width)
    c1 += (c1 >> 31) & width
    r0 = top.int().clamp_(-1, height - 1)
    index = torch.empty((*r0.shape, 4), dtype=torch.int32, device=r0.device)
    start = r0.clamp(min=0) * width
    torch.add(start, c0, out=index[..., 0])
    torch.add(start, c1, out=index[..., 1])
    start = (r0 + 1).clamp_(max=height - 1) * width
    torch.add(start, c0, out=index[..., 2])
    torch.add(start, c1, out=index[..., 3])
    if r0.numel():
        for crosses, slots in ((r0 < 0, slice(0, 2)), (r0 == height - 1, slice(2, 4))):
            if bool(crosses.any()):
                over = index[..., slots][crosses]
                column = over % width
                index[..., slots][crosses] = over - column + (column + width // 2) % width
    both = along * down
    if both.requires_grad:
        return index, torch.stack((1 - along - down + both, along - both, down - both, both), -1)
    weight = torch.empty_like(index, dtype=both.dtype)
    weight[..., 3] = both
    torch.sub(along, both, out=weight[..., 1])
    torch.sub(1 - down, weight[..., 1], out=weight[..., 0])
    torch.sub(down, both, out=weight[..., 2])
    return index, weight


def gather(
    texels: Float[Tensor, "texels channels"], index: Int32[Tensor, "rays 4"], weight: Float[Tensor, "rays 4"]
) -> Float[Tensor, "rays channels"]:
    """Weighted sum of the four texels of each ray, in one fused pass; differentiable in texels and weight."""
    precise = torch.promote_types(texels.dtype, torch.float32)
    sums = functional.embedding_bag(
        index, texels.to(precise), mode="sum", per_sample_weights=weight.to(precise)
    )
    return sums.to(texels.dtype)


def render(
    panorama: Float[Tensor, "*batch height width channels"],
    out_height: int,
    out_width: int,
    supersample: int,
    rays: Callable[[int, int], Planes],
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Picture whose every pixel is the mean of supersample^2 look-ups, the same in every map of the batch.

    `rays(start, stop)` gives the planes, [stop - start, supersample * out_width], of those rows of the
    supersampled picture; a block of rows is done at a time.
    """
    batch, (height, width, channels) = panorama.shape[:-3], panorama.shape[-3:]
    require_even(width)
    check_supersample(supersample)
    maps = panorama.reshape(-1, height * width, channels)
    n = supersample
    graph = panorama.device.type != "cpu" or (torch.is_grad_enabled() and panorama.requires_grad)
    step = max(1, (CHUNK_GRAPH if graph else CHUNK) // (out_width * n * n))
    blocks: list[list[Tensor]] = [[] for _ in maps]
    for start in range(0, out_height, step):
        index, weight = taps(*rays(n * start, n * min(start + step, out_height)), height, width)
        index, weight = index.view(-1, 4), weight.view(-1, 4)
        for texels, parts in zip(maps, blocks, strict=True):
            picture = gather(texels, index, weight)
            if n > 1:
                fine = picture.view(-1, n, out_width, n, channels)
                # Sums of whole slices: reductions over short inner axes are many times slower.
                columns = functools.reduce(torch.add, fine.unbind(1))
                picture = functools.reduce(torch.add, columns.unbind(2)) / (n * n)
            parts.append(picture.reshape(-1, out_width, channels))
    if not blocks:
        return panorama.new_empty((*batch, out_height, out_width, channels))
    return torch.stack([torch.cat(parts) for parts in blocks]).view(*batch, out_height, out_width, channels)


def check_supersample(supersample: int) -> None:
    """Refuse a number of rays a side that is none."""
    if supersample < 1:
        raise ValueError(f"expected supersample of at least 1, received {supersample}")


def require_even(width: int) -> None:
    """Refuse a width whose half is no whole number of columns: the poles are crossed by that half."""
    if width % 2:
        raise ValueError(f"expected a panorama of even width, received {width}")
