"""Light transport of a sphere as a matrix: panorama in, picture of the lit sphere out.

A convex object that is lit by a distant environment and seen by a fixed camera is a linear map from
the panorama's texels to the picture's pixels. This file holds the three reflection kernels (Lambert,
GGX, mirror), the sampling of a sphere's picture, and the dense matrices that follow from both. They
are the plain, exact form; `mixlight.render` has a faster one for large pictures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mixlight.sphere import equirect

_CHUNK_ELEMENTS = 1 << 16
"""Kernel values that are worked on at once while a matrix is built: they fit into the processor's cache."""

_BLOCK_ELEMENTS = 1 << 20
"""Matrix entries that are computed at once before they are added up to pixels (float64: 8 MB)."""

_RIM_RADIUS = 0.9
"""Pixels of a sphere's picture that reach beyond this radius are sampled by angle."""


@dataclass(frozen=True)
class Material:
    """One of the materials a test sphere is made of; the same in every channel."""

    name: str
    """Name used in results and pictures."""
    kind: Literal["diffuse", "ggx", "mirror"]
    """Reflection kernel."""
    reflectance: float
    """Albedo of the diffuse kernel; normal-incidence reflectance of the other two (no Fresnel term)."""
    alpha: float = 0.0
    """GGX roughness alpha (the square of the artist's roughness); used by `ggx` only."""


MATERIALS: tuple[Material, ...] = (
    Material("diffuse", "diffuse", 0.8),
    Material("matte", "ggx", 0.8, alpha=0.3271**2),
    Material("mirror", "mirror", 0.8),
)
"""The three spheres of protocol M: gray diffuse, matte silver, mirror silver, in this order.

Reflectance and roughness are those that protocol S names (base colour .8, roughness .3271), so that
the two protocols differ in exposure and tone-mapping alone.
"""

VIEW: tuple[float, float, float] = (0.0, 0.0, 1.0)
"""Direction from a test sphere to its camera: +Z, for the camera looks along -Z like the photo's."""


@dataclass(frozen=True)
class SphereSamples:
    """Surface points under the pixels of a sphere's picture, made by `sphere_normals`."""

    normals: Float[Tensor, "samples 3"]
    """Outward unit normals, those of one pixel behind one another."""
    pixel: Int[Tensor, " samples"]
    """The pixel of each sample, as its number among the True of `mask`, in row order; ascending."""
    weight: Float[Tensor, " samples"]
    """Share of each sample in its pixel; they sum to 1 for each pixel."""
    mask: Bool[Tensor, "resolution resolution"]
    """True where the pixel's centre lies on the disc."""


def sphere_normals(
    resolution: int,
    supersample: int = 1,
    *,
    rim: bool = True,
    dtype: torch.dtype = torch.float64,
    device: torch.device | str | None = None,
) -> SphereSamples:
    """Sample the normals of a sphere as an orthographic camera sees it, for the mean over each pixel.

    The disc touches the picture's four edges; a pixel counts as far as it lies on the disc. Inner pixels
    get a regular grid of `supersample`² samples. Close to the rim the normal turns ever faster (the last 1 %
    of the radius holds 8° of it) and a light behind the sphere shows as a hair-thin crescent, so pixels
    that reach beyond .9 of the radius are sampled evenly in the normal's angle (at least 10 samples) and in
    azimuth (at least 4) instead, and each sample is weighted by its area in the picture.

    Convention: the camera stands at +Z and looks along -Z, so the sphere shows its side that faces
    the photographer: the picture's centre has normal +Z, its right edge +X, its top edge +Y.

    Args:
        resolution: Width and height of the picture in pixels, at least 1.
        supersample: Samples per inner pixel and axis, at least 1.
        rim: Whether rim pixels are sampled by angle. Without, `sphere_normals(resolution, rim=False)` gives
            the normals at the pixels' centres.
        dtype: Floating type of the result; computed in float64.
        device: Device of the result.

    Raises:
        ValueError: If `resolution` or `supersample` is below 1.

    >>> samples = sphere_normals(32, rim=False)
    >>> samples.normals.shape, samples.mask.sum().item()
    (torch.Size([812, 3]), 812)
    >>> [round(x, 3) for x in samples.normals[0].tolist()]  # first pixel of the top row
    [-0.219, 0.969, 0.117]
    """
    if resolution < 1 or supersample < 1:
        raise ValueError(
            f"expected resolution and supersample of at least 1, got {resolution} and {supersample}"
        )
    # Exactly symmetric, and exactly 0 in the middle, which a linspace is not.
    edge = (2 * torch.arange(resolution + 1, dtype=torch.float64) - resolution) / resolution
    centre = (edge[:-1] + edge[1:]) / 2
    mask = torch.hypot(centre, centre[:, None]) < 1
    i, j = mask.nonzero(as_tuple=True)
    box = torch.stack((edge[j], edge[j + 1], -edge[i + 1], -edge[i]), -1)  # left, right, bottom, top
    outer = torch.hypot(box[:, :2].abs().amax(1), box[:, 2:].abs().amax(1)) > _RIM_RADIUS
    on_axis = (box[:, 0] * box[:, 1] < 0) | (box[:, 2] * box[:, 3] < 0)
    polar = outer & ~on_axis & rim

    parts = [_grid_samples(box[~polar], supersample)]
    numbers = [(~polar).nonzero()]
    if bool(polar.any()):
        parts.append(_rim_samples(box[polar], max(10, supersample), max(4, supersample)))
        numbers.append(polar.nonzero())
    normals = torch.cat([part[0].flatten(0, 1) for part in parts])
    weight = torch.cat([part[1].flatten() for part in parts])
    pixel = torch.cat(
        [n.expand(-1, part[1].shape[1]).flatten() for n, part in zip(numbers, parts, strict=True)]
    )
    kept = weight > 0
    order = pixel[kept].argsort(stable=True)
    normals, pixel, weight = (x[kept][order] for x in (normals, pixel, weight))
    return SphereSamples(
        normals.to(device, dtype), pixel.to(device), weight.to(device, dtype), mask.to(device)
    )


def _grid_samples(box: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Normals [pixels, count², 3] and weights on a regular grid in each box; weight 0 off the disc."""
    step = (torch.arange(count, dtype=torch.float64) + 0.5) / count
    x = box[:, 0, None] + step * (box[:, 1] - box[:, 0])[:, None]
    y = box[:, 2, None] + step * (box[:, 3] - box[:, 2])[:, None]
    x = x[:, None, :].expand(-1, count, -1).flatten(1)
    y = y[:, :, None].expand(-1, -1, count).flatten(1)
    weight = (x.square() + y.square() < 1).double()
    z = (1 - x.square() - y.square()).clamp(min=0).sqrt()
    return torch.stack((x, y, z), -1), weight / weight.sum(1, keepdim=True)


def _rim_samples(box: Tensor, angles: int, azimuths: int) -> tuple[Tensor, Tensor]:
    """Normals and weights, even in the normal's angle and azimuth, in boxes that cross no axis."""
    sign = torch.stack((box[:, 0] + box[:, 1], box[:, 2] + box[:, 3]), -1).sign()
    (x0, x1), (y0, y1) = (
        box[:, k : k + 2].abs().sort(dim=1).values[..., None].unbind(1) for k in (0, 2)
    )  # the box, turned into the first quadrant
    inner, outer = torch.hypot(x0, y0).asin(), torch.hypot(x1, y1).clamp(max=1).asin()
    step = (torch.arange(angles, dtype=torch.float64) + 0.5) / angles
    angle = inner + step * (outer - inner)
    radius = angle.sin()
    # The arc of this radius inside the box.
    begin = torch.maximum((x1 / radius).clamp(max=1).acos(), (y0 / radius).clamp(max=1).asin())
    end = torch.minimum((x0 / radius).clamp(max=1).acos(), (y1 / radius).clamp(max=1).asin())
    arc = (end - begin).clamp(min=0)
    step = (torch.arange(azimuths, dtype=torch.float64) + 0.5) / azimuths
    azimuth = begin[..., None] + step * arc[..., None]
    weight = (arc * radius * angle.cos())[..., None].expand_as(azimuth)  # r dr = sin cos of the angle
    x = sign[:, 0, None, None] * radius[..., None] * azimuth.cos()
    y = sign[:, 1, None, None] * radius[..., None] * azimuth.sin()
    normals = torch.stack((x, y, angle.cos()[..., None].expand_as(x)), -1).flatten(1, 2)
    weight = weight.flatten(1)
    return normals, weight / weight.sum(1, keepdim=True)


def diffuse_kernel(
    cos_light: Float[Tensor, "*shape"], albedo: float = MATERIALS[0].reflectance
) -> Float[Tensor, "*shape"]:
    """Radiance that a Lambertian surface sends out per incident radiance and steradian [1/sr].

    k = albedo / pi * max(n.l, 0)

    Convention: the foreshortening n.l is part of the kernel: under radiance 1 from everywhere the
    surface shows exactly `albedo`. Albedo .8, light along the normal: k = .8 / pi = .2546.

    >>> round(diffuse_kernel(torch.tensor(1.0)).item(), 4)
    0.2546
    """
    return cos_light.clamp(min=0) * (albedo / math.pi)


def ggx_kernel(
    cos_light: Float[Tensor, "*#shape"],
    cos_view: Float[Tensor, "*#shape"],
    light_dot_view: Float[Tensor, "*#shape"],
    alpha: float = MATERIALS[1].alpha,
    colour: float = MATERIALS[1].reflectance,
) -> Float[Tensor, "*shape"]:
    """Radiance that a rough metal sends out per incident radiance and steradian [1/sr].

    With c_l = n.l, c_v = n.v, c_h = n.h the cosines of light, view and half vector:

        k = colour * D / (2 (c_v s(c_l) + c_l s(c_v))) * max(c_l, 0)
        D = alpha² / (pi (1 - (1 - alpha²) c_h²)²)
        s(c) = sqrt(alpha² + (1 - alpha²) c²)

    which is D G2 / (4 c_l c_v) * c_l with Smith's height-correlated masking and shadowing G2; one
    bounce, and no Fresnel term (`colour` at every angle).

    Convention: n.l is part of the kernel. Light, view and normal in one line, alpha .25, colour .8:
    D = 1 / (pi alpha²) = 5.093, k = .8 D / 4 = 1.0186.

    Source: Heitz, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, 2014.

    >>> one = torch.tensor(1.0)
    >>> round(ggx_kernel(one, one, one, alpha=0.25, colour=0.8).item(), 4)
    1.0186
    """
    alpha2 = alpha * alpha
    light = cos_light.clamp(min=0)
    view = cos_view.clamp(min=0)
    # (l + v)/|l + v| . n, squared, without forming the half vector. Where l + v vanishes, so does n.l.
    cos_half2 = (cos_light + cos_view) ** 2 / (2 + 2 * light_dot_view).clamp(min=1e-12)
    spread = (1 - (1 - alpha2) * cos_half2.clamp(max=1)) ** 2
    smith = (
        view * (alpha2 + (1 - alpha2) * light**2).sqrt() + light * (alpha2 + (1 - alpha2) * view**2).sqrt()
    )
    return light * (colour * alpha2 / (2 * math.pi)) / (spread * smith).clamp(min=1e-30)


def reflect(normals: Float[Tensor, "*n 3"], view: Float[Tensor, " 3"]) -> Float[Tensor, "*n 3"]:
    """Direction from which a mirror shows light to the viewer: 2 (n.v) n - v.

    Convention: all directions point away from the surface. Seen along +Z, the normal that leans by
    45° to the right shows what lies at +X.

    >>> half = math.sqrt(0.5)
    >>> d = reflect(torch.tensor([half, 0.0, half]), torch.tensor([0.0, 0.0, 1.0]))
    >>> [round(x, 4) for x in d.tolist()]
    [1.0, 0.0, 0.0]
    """
    return 2 * (normals @ view)[..., None] * normals - view


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

    def kernel(n: Tensor, light: Tensor) -> Tensor:
        return ggx_kernel(n @ light.T, (n @ view.to(n))[:, None], light @ view.to(n), alpha, colour)

    return _matrix(kernel, normals, height, width, supersample)


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
    width = _map_width(height, width)
    directions = reflect(normals.double(), view.double())
    if interpolation == "linear":
        index, weight = mirror_taps(directions, height, width)
    elif interpolation == "nearest":
        uv = equirect.directions_to_uv(directions)
        row = (uv[..., 1] * height).long().clamp(max=height - 1)
        index = (row * width + (uv[..., 0] * width).long() % width)[..., None]
        weight = torch.ones_like(index, dtype=torch.float64)
    else:
        raise ValueError(f"expected interpolation 'linear' or 'nearest', got {interpolation!r}")
    matrix = torch.zeros(*normals.shape[:-1], height * width, dtype=torch.float64, device=normals.device)
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
    width = _map_width(height, width)
    samples = sphere_normals(resolution, pixel_supersample)
    view = torch.tensor(VIEW, dtype=torch.float64)
    half = (resolution + 1) // 2
    i, j = samples.mask.nonzero(as_tuple=True)
    first_quarter = (i < half) & (j < half)
    chosen = first_quarter[samples.pixel]
    normals, weight = samples.normals[chosen], samples.weight[chosen]
    rows = (first_quarter.cumsum(0) - 1)[samples.pixel[chosen]]

    quarter = torch.zeros(int(first_quarter.sum()), height * width, dtype=torch.float64)
    for part in torch.split(torch.arange(len(normals)), max(1, _BLOCK_ELEMENTS // (height * width))):
        n = normals[part]
        if material.kind == "diffuse":
            values = diffuse_matrix(n, height, width, material.reflectance, texel_supersample)
        elif material.kind == "ggx":
            values = ggx_matrix(
                n, view, height, width, material.alpha, material.reflectance, texel_supersample
            )
        else:
            values = mirror_matrix(n, view, height, width, material.reflectance, interpolation)
        quarter.index_add_(0, rows[part], values * weight[part, None])

    # A pixel elsewhere sees what its mirror image in the first quarter sees in the mirrored panorama.
    number = torch.empty(half, half, dtype=torch.int64)
    number[i[first_quarter], j[first_quarter]] = torch.arange(len(quarter))
    table = quarter.to(dtype).reshape(-1, height, width)
    matrix = torch.empty(len(i), height, width, dtype=dtype)
    for below in (False, True):
        for right in (False, True):
            here = ((i >= half) == below) & ((j >= half) == right)
            row = resolution - 1 - i[here] if below else i[here]
            column = resolution - 1 - j[here] if right else j[here]
            axes = [axis for axis, flipped in ((1, below), (2, right)) if flipped]
            matrix[here] = (table.flip(axes) if axes else table)[number[row, column]]
    return matrix.reshape(len(i), -1).to(device), samples.mask.to(device)


def _map_width(height: int, width: int | None) -> int:
    width = 2 * height if width is None else width
    if height < 1 or width < 2 or width % 2:
        raise ValueError(f"expected a map of height >= 1 and even width >= 2, got {height} x {width}")
    return width


def _matrix(
    kernel: Callable[[Tensor, Tensor], Tensor],
    normals: Tensor,
    height: int,
    width: int | None,
    supersample: int,
) -> Tensor:
    """Kernel times solid angle, summed over the parts of each texel; `kernel([p, 3], [t, 3]) -> [p, t]`."""
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
        values = kernel(flat[start : start + step], lights) * solid_angle
        parts = values.reshape(-1, height, supersample, width, supersample)
        result[start : start + step] = parts.sum((2, 4)).reshape(-1, height * width)
    return result.reshape(*normals.shape[:-1], -1).to(normals.dtype)
