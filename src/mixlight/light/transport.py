"""Light transport of a sphere as a matrix: panorama in, picture of the lit sphere out.

A convex object that is lit by a distant environment and seen by a fixed camera is a linear map from
the panorama's texels to the picture's pixels. These dense matrices are the plain form of it;
`mixlight.render` has a faster one for large pictures. Materials and kernels stand in
`mixlight.light.reflection`, the picture's sampling in `mixlight.light.sphere_samples`; both are
available here too.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mixlight.light.reflection import (
    MATERIALS,
    VIEW,
    Material,
    diffuse_kernel,
    ggx_kernel,
    reflect,
)
from mixlight.light.sphere_samples import SphereSamples, sphere_normals
from mixlight.light.surfaces import kernel, mirror_reflectance
from mixlight.sphere import equirect

__all__ = [
    "MATERIALS",
    "VIEW",
    "Material",
    "SphereSamples",
    "diffuse_kernel",
    "diffuse_matrix",
    "ggx_kernel",
    "ggx_matrix",
    "mirror_matrix",
    "mirror_taps",
    "reflect",
    "sphere_matrix",
    "sphere_normals",
]

_CHUNK_ELEMENTS = 1 << 16
"""Kernel values that are worked on at once while a matrix is built: they fit into the processor's cache."""

_BLOCK_ELEMENTS = 1 << 20
"""Matrix entries that are computed at once before they are added up to pixels (float64: 8 MB)."""


def mirror_taps(
    directions: Float[Tensor, "*n 3"], height: int, width: int | None = None
) -> tuple[Int[Tensor, "*n 4"], Float[Tensor, "*n 4"]]:
    """The four texels, and their weights, of a bilinear look-up in a panorama.

    Indices are row * width + column. Columns wrap; beyond a pole the neighbour of a texel is the one
    across the pole, half a turn away. The weights sum to 1.

    Convention: the panorama's centre is -Z. In a 2x4 panorama the direction -Z lies between four
    texels: indices 1, 2, 5, 6, weight .25 each.

    >>> index, weight = mirror_taps(torch.tensor([0.0, 0.0, -1.0]), 2)
    >>> index.tolist(), weight.tolist()
    ([1, 2, 5, 6], [0.25, 0.25, 0.25, 0.25])
    """
    width = _map_width(height, width)
    uv = equirect.directions_to_uv(directions)
    column, row = uv[..., 0] * width - 0.5, uv[..., 1] * height - 0.5
    left, upper = column.floor(), row.floor()
    indices, weights = [], []
    for r, row_share in ((upper.long(), 1 - (row - upper)), (upper.long() + 1, row - upper)):
        across_pole = (r < 0) | (r >= height)
        for c, share in ((left.long(), 1 - (column - left)), (left.long() + 1, column - left)):
            c = (c + across_pole * (width // 2)) % width
            indices.append(r.clamp(0, height - 1) * width + c)
            weights.append(row_share * share)
    return torch.stack(indices, -1), torch.stack(weights, -1)


def diffuse_matrix(
    normals: Float[Tensor, "*p 3"],
    height: int,
    width: int | None = None,
    albedo: float = MATERIALS[0].reflectance,
    supersample: int = 2,
) -> Float[Tensor, "*p texels"]:
    """Transport from a panorama's texels to the radiance of Lambertian surface points.

    Entry = sum over the texel's `supersample`² parts of kernel times the part's exact solid angle:
    the texel is taken as constant over its area.

    Convention: texel index = row * width + column; multiply with `panorama.reshape(-1, 3)`. Under a
    panorama of 1 every point shows `albedo`.

    >>> matrix = diffuse_matrix(torch.tensor([0.0, 0.0, 1.0]), 16)
    >>> matrix.shape, round(matrix.sum().item(), 3)
    (torch.Size([512]), 0.8)
    """
    return _matrix(lambda n, light: diffuse_kernel(n @ light.T, albedo), normals, height, width, supersample)


def ggx_matrix(
    normals: Float[Tensor, "*p 3"],
    view: Float[Tensor, " 3"],
    height: int,
    width: int | None = None,
    alpha: float = MATERIALS[1].alpha,
    colour: float = MATERIALS[1].reflectance,
    supersample: int = 2,
) -> Float[Tensor, "*p texels"]:
    """Transport from a panorama's texels to the radiance of points on rough metal, seen from `view`.

    Built as `diffuse_matrix`, with `ggx_kernel`. Under a panorama of 1 a surface shows a little less than
    `colour`, for what bounces twice between facets is lost: .733 of .8 at alpha .25, seen face on.

    >>> up = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)
    >>> round(ggx_matrix(up, up, 64, alpha=0.25, colour=0.8).sum().item(), 3)
    0.733
    """

    def seen(n: Tensor, light: Tensor) -> Tensor:
        return ggx_kernel(n @ light.T, (n @ view.to(n))[:, None], light @ view.to(n), alpha, colour)

    return _matrix(seen, normals, height, width, supersample)


def mirror_matrix(
    normals: Float[Tensor, "*p 3"],
    view: Float[Tensor, " 3"],
    height: int,
    width: int | None = None,
    colour: float = MATERIALS[2].reflectance,
    interpolation: Literal["linear", "nearest"] = "linear",
) -> Float[Tensor, "*p texels"]:
    """Dense transport from a panorama's texels to points of a mirror, seen from `view`.

    `linear` looks the panorama up bilinearly; `nearest` takes each texel as constant over its area.
    For large maps use `mirror_taps`, the sparse form.

    >>> n = torch.tensor([0.0, 0.0, 1.0])
    >>> round(mirror_matrix(n, n, 16).sum().item(), 4)
    0.8
    """
    index, weight = _mirror_entries(normals.double(), view.double(), height, width, interpolation)
    texels = height * _map_width(height, width)
    matrix = torch.zeros(*normals.shape[:-1], texels, dtype=torch.float64, device=normals.device)
    return matrix.scatter_add_(-1, index, weight * colour).to(normals.dtype)


def sphere_matrix(
    material: Material,
    resolution: int,
    height: int,
    width: int | None = None,
    *,
    pixel_supersample: int = 4,
    texel_supersample: int = 2,
    interpolation: Literal["linear", "nearest"] = "linear",
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> tuple[Float[Tensor, "pixels texels"], Bool[Tensor, "resolution resolution"]]:
    """Dense transport from a panorama to the picture of a sphere, and the mask of its pixels.

    Each pixel is the mean over its part of the disc. Both grids are symmetric left to right and top
    to bottom, so only a quarter of the rows is computed and the rest is mirrored.

    Convention: camera and picture as in `sphere_normals`; row p is the p-th True of the mask, texel
    index = row * width + column. `picture[mask] = matrix @ panorama.reshape(-1, 3)`. On a picture of
    32² pixels and a map of 32x64 texels the matrix is [812, 2048].

    Args:
        material: What the sphere is made of.
        resolution: Pixels along the picture's edge.
        height: Rows of the panorama.
        width: Columns of the panorama; twice the height if not given.
        pixel_supersample: Samples per inner pixel and axis. A mirror needs more than the others, 8 or so when
            a pixel covers many texels: its look-up has no extent of its own.
        texel_supersample: Parts per texel and axis (not used by a mirror).
        interpolation: How a mirror looks the panorama up, see `mirror_matrix`.
        dtype: Floating type of the result; computed in float64.
        device: Device of the result.

    >>> matrix, mask = sphere_matrix(MATERIALS[0], 8, 16)
    >>> matrix.shape, round(matrix.sum(-1).mean().item(), 4)
    (torch.Size([52, 512]), 0.8)
    """
    samples = sphere_normals(resolution, pixel_supersample)
    half = (resolution + 1) // 2
    i, j = samples.mask.nonzero(as_tuple=True)
    first_quarter = (i < half) & (j < half)
    chosen = first_quarter[samples.pixel]
    part = SphereSamples(
        samples.normals[chosen],
        (first_quarter.cumsum(0) - 1)[samples.pixel[chosen]],
        samples.weight[chosen],
        samples.mask,
        samples.camera,
    )
    shape = (int(first_quarter.sum()), height, _map_width(height, width))
    if material.is_mirror:
        quarter = _mirror_pixels(material, part, shape, interpolation)
    else:
        quarter = _dense_pixels(material, part, shape, texel_supersample)

    # A pixel elsewhere sees what its mirror image in the first quarter sees in the mirrored panorama.
    number = torch.empty(half, half, dtype=torch.int64)
    number[i[first_quarter], j[first_quarter]] = torch.arange(len(quarter))
    quarter = quarter.to(dtype).reshape(shape)
    matrix = torch.empty(len(i), *shape[1:], dtype=dtype)
    for below in (False, True):
        for right in (False, True):
            here = ((i >= half) == below) & ((j >= half) == right)
            row = resolution - 1 - i[here] if below else i[here]
            column = resolution - 1 - j[here] if right else j[here]
            axes = [axis for axis, flipped in ((1, below), (2, right)) if flipped]
            matrix[here] = (quarter.flip(axes) if axes else quarter)[number[row, column]]
    return matrix.flatten(1).to(device), samples.mask.to(device)


def _dense_pixels(
    material: Material, samples: SphereSamples, shape: tuple[int, int, int], texel_supersample: int
) -> Tensor:
    """Rows of a diffuse or GGX sphere: the kernel's matrix at every sample, added up to pixels."""
    pixels, height, width = shape
    view = torch.tensor(VIEW, dtype=torch.float64)

    def seen(n: Tensor, light: Tensor) -> Tensor:
        return kernel(material, n @ light.T, (n @ view)[:, None], light @ view)

    result = torch.zeros(pixels, height * width, dtype=torch.float64)
    for block in torch.split(torch.arange(len(samples.normals)), max(1, _BLOCK_ELEMENTS // (height * width))):
        normals = samples.normals[block]
        values = _matrix(seen, normals, height, width, texel_supersample)
        result.index_add_(0, samples.pixel[block], values * samples.weight[block, None])
    return result


def _mirror_pixels(
    material: Material,
    samples: SphereSamples,
    shape: tuple[int, int, int],
    interpolation: Literal["linear", "nearest"],
) -> Tensor:
    """Rows of a mirror sphere: the few texels of every sample, put straight into the pixels' rows."""
    pixels, height, width = shape
    view = torch.tensor(VIEW, dtype=torch.float64)
    index, share = _mirror_entries(samples.normals, view, height, width, interpolation)
    row = samples.pixel[:, None].expand_as(index)
    value = share * (samples.weight * mirror_reflectance(material, samples.normals @ view))[:, None]
    result = torch.zeros(pixels, height * width, dtype=torch.float64)
    return result.index_put_((row.flatten(), index.flatten()), value.flatten(), accumulate=True)


def _map_width(height: int, width: int | None) -> int:
    width = 2 * height if width is None else width
    if height < 1 or width < 2 or width % 2:
        raise ValueError(f"expected a map of height >= 1 and even width >= 2, got {height} x {width}")
    return width


def _mirror_entries(
    normals: Tensor, view: Tensor, height: int, width: int | None, interpolation: str
) -> tuple[Tensor, Tensor]:
    """Texels, and their weights, that mirror points show: [..., 4] for `linear`, [..., 1] for `nearest`."""
    width = _map_width(height, width)
    directions = reflect(normals, view)
    if interpolation == "linear":
        return mirror_taps(directions, height, width)
    if interpolation == "nearest":
        uv = equirect.directions_to_uv(directions)
        row = (uv[..., 1] * height).long().clamp(max=height - 1)
        index = (row * width + (uv[..., 0] * width).long() % width)[..., None]
        return index, torch.ones_like(index, dtype=normals.dtype)
    raise ValueError(f"expected interpolation 'linear' or 'nearest', got {interpolation!r}")


def _matrix(
    seen: Callable[[Tensor, Tensor], Tensor],
    normals: Tensor,
    height: int,
    width: int | None,
    supersample: int,
) -> Tensor:
    """Kernel times solid angle, summed over the parts of each texel; `seen([p, 3], [t, 3]) -> [p, t]`."""
    width = _map_width(height, width)
    if supersample < 1:
        raise ValueError(f"expected supersample of at least 1, got {supersample}")
    fine_height, fine_width = height * supersample, width * supersample
    device = normals.device
    lights = equirect.pixel_directions(fine_height, fine_width, dtype=torch.float64, device=device).reshape(
        -1, 3
    )
    solid_angle = equirect.solid_angle(fine_height, fine_width, dtype=torch.float64, device=device).reshape(
        -1
    )
    flat = normals.double().reshape(-1, 3)
    result = torch.empty(len(flat), height * width, dtype=torch.float64, device=device)
    step = max(1, _CHUNK_ELEMENTS // len(lights))
    for start in range(0, len(flat), step):
        values = seen(flat[start : start + step], lights) * solid_angle
        parts = values.reshape(-1, height, supersample, width, supersample)
        result[start : start + step] = parts.sum((2, 4)).reshape(-1, height * width)
    return result.reshape(*normals.shape[:-1], height * width).to(normals.dtype)
