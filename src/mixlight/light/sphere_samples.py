"""Which points of a sphere lie under the pixels of its picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mixlight.light.sphere_camera import SphereCamera

_RIM_RADIUS = 0.9
"""Pixels of a sphere's picture that reach beyond this radius are sampled by angle."""


@dataclass(frozen=True)
class SphereSamples:
    """Points under the pixels of a sphere's picture, made by `sphere_normals` or `picture_samples`."""

    normals: Float[Tensor, "samples 3"]
    """Outward unit normals, those of one pixel behind one another."""
    pixel: Int[Tensor, " samples"]
    """The pixel of each sample, as its number among the True of `mask`, in row order; ascending."""
    weight: Float[Tensor, " samples"]
    """Share of each sample in its pixel; they sum to 1 for each pixel."""
    mask: Bool[Tensor, "height width"]
    """True where the pixel's centre lies on the disc."""
    camera: SphereCamera
    """Whose picture it is."""


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
    camera = SphereCamera.orthographic(resolution)
    return picture_samples(camera, supersample, rim=rim, dtype=dtype, device=device)


def picture_samples(
    camera: SphereCamera,
    supersample: int = 1,
    *,
    rim: bool = True,
    rim_step: float = math.inf,
    dtype: torch.dtype = torch.float64,
    device: torch.device | str | None = None,
) -> SphereSamples:
    """Sample the normals of a sphere as any camera sees it, for the mean over each pixel.

    As `sphere_normals`, with the angle of incidence in the place of the normal's angle: what lies inside the
    outline counts, near the rim pixels are sampled evenly in that angle.

    Convention: normals in our frame. From (0, 0, 1) and afar it is `sphere_normals`.

    Args:
        camera: Where from, and the size of the picture; it may be smaller than the sphere.
        supersample: Samples per inner pixel and axis, at least 1.
        rim: Whether rim pixels are sampled by angle.
        rim_step: Largest step between a rim pixel's samples in the angle of incidence, in radians; what shows
            small lights sharply (a mirror) wants half a texel of its map, and sees by twice the step.
        dtype: Floating type of the result; computed in float64.
        device: Device of the result.

    Raises:
        ValueError: If `supersample` is below 1, or `rim_step` not above 0.

    >>> samples = picture_samples(SphereCamera.perspective((16, 2, 0), 85, 36, 96, 54), rim=False)
    >>> samples.mask.shape, samples.mask.sum().item()
    (torch.Size([54, 96]), 616)
    """
    if supersample < 1:
        raise ValueError(f"expected a supersample of at least 1, got {supersample}")
    if not rim_step > 0:
        raise ValueError(f"expected a rim_step above 0, got {rim_step}")
    # Exactly symmetric, and exactly 0 in the middle, which a linspace is not.
    across, down = (
        (2 * torch.arange(size + 1, dtype=torch.float64) - size) / (2 * camera.radius)
        for size in (camera.width, camera.height)
    )
    mask = torch.hypot((across[:-1] + across[1:]) / 2, ((down[:-1] + down[1:]) / 2)[:, None]) < 1
    i, j = mask.nonzero(as_tuple=True)
    box = torch.stack((across[j], across[j + 1], -down[i + 1], -down[i]), -1)  # left, right, bottom, top
    outer = torch.hypot(box[:, :2].abs().amax(1), box[:, 2:].abs().amax(1)) > _RIM_RADIUS
    on_axis = (box[:, 0] * box[:, 1] < 0) | (box[:, 2] * box[:, 3] < 0)
    polar = outer & ~on_axis & rim

    parts = [_grid_samples(box[~polar], supersample, camera)]
    numbers = [(~polar).nonzero()]
    angles, spanned = max(10, supersample), _span(box, camera)
    coarse = polar
    while bool(coarse.any()):
        # Pixels that this many angles do for; the others get twice as many.
        wide = coarse & (spanned > angles * rim_step)
        now = coarse & ~wide
        if bool(now.any()):
            parts.append(_rim_samples(box[now], angles, max(4, supersample), camera))
            numbers.append(now.nonzero())
        coarse, angles = wide, 2 * angles
    normals = torch.cat([part[0].flatten(0, 1) for part in parts])
    weight = torch.cat([part[1].flatten() for part in parts])
    pixel = torch.cat(
        [n.expand(-1, part[1].shape[1]).flatten() for n, part in zip(numbers, parts, strict=True)]
    )
    kept = weight > 0
    order = pixel[kept].argsort(stable=True)
    normals, pixel, weight = (x[kept][order] for x in (normals, pixel, weight))
    return SphereSamples(
        (normals @ camera.axes).to(device, dtype),
        pixel.to(device),
        weight.to(device, dtype),
        mask.to(device),
        camera,
    )


def _grid_samples(box: Tensor, count: int, camera: SphereCamera) -> tuple[Tensor, Tensor]:
    """Normals [pixels, count², 3] in the camera's axes and weights on a regular grid in each box; weight 0
    off the disc.
    """
    step = (torch.arange(count, dtype=torch.float64) + 0.5) / count
    x = box[:, 0, None] + step * (box[:, 1] - box[:, 0])[:, None]
    y = box[:, 2, None] + step * (box[:, 3] - box[:, 2])[:, None]
    x = x[:, None, :].expand(-1, count, -1).flatten(1)
    y = y[:, :, None].expand(-1, -1, count).flatten(1)
    weight = (x.square() + y.square() < 1).double()
    if math.isinf(camera.distance):
        z = (1 - x.square() - y.square()).clamp(min=0).sqrt()
    else:
        place = torch.hypot(x, y)
        lean = camera.lean(camera.incidence_at(place.clamp(max=1)))
        scale = lean.sin() / place.clamp(min=1e-12)
        x, y, z = x * scale, y * scale, lean.cos()
    return torch.stack((x, y, z), -1), weight / weight.sum(1, keepdim=True)


def _span(box: Tensor, camera: SphereCamera) -> Tensor:
    """Range of the angle of incidence in boxes that cross no axis."""
    near, far = (pick(box.reshape(-1, 2, 2).abs(), -1) for pick in (torch.amin, torch.amax))
    inner, outer = (camera.incidence_at(place.norm(dim=-1).clamp(max=1)) for place in (near, far))
    return outer - inner


def _rim_samples(box: Tensor, angles: int, azimuths: int, camera: SphereCamera) -> tuple[Tensor, Tensor]:
    """Normals and weights, even in the angle of incidence and azimuth, in boxes that cross no axis."""
    sign = torch.stack((box[:, 0] + box[:, 1], box[:, 2] + box[:, 3]), -1).sign()
    (x0, x1), (y0, y1) = (
        box[:, k : k + 2].abs().sort(dim=1).values[..., None].unbind(1) for k in (0, 2)
    )  # the box, turned into the first quadrant
    inner = camera.incidence_at(torch.hypot(x0, y0))
    outer = camera.incidence_at(torch.hypot(x1, y1).clamp(max=1))
    step = (torch.arange(angles, dtype=torch.float64) + 0.5) / angles
    angle = inner + step * (outer - inner)
    radius = camera.place(angle)
    # The arc of this radius inside the box.
    begin = torch.maximum((x1 / radius).clamp(max=1).acos(), (y0 / radius).clamp(max=1).asin())
    end = torch.minimum((x0 / radius).clamp(max=1).acos(), (y1 / radius).clamp(max=1).asin())
    arc = (end - begin).clamp(min=0)
    step = (torch.arange(azimuths, dtype=torch.float64) + 0.5) / azimuths
    azimuth = begin[..., None] + step * arc[..., None]
    weight = (arc * camera.area(angle))[..., None].expand_as(azimuth)
    lean = camera.lean(angle)[..., None]
    x = sign[:, 0, None, None] * lean.sin() * azimuth.cos()
    y = sign[:, 1, None, None] * lean.sin() * azimuth.sin()
    normals = torch.stack((x, y, lean.cos().expand_as(x)), -1).flatten(1, 2)
    weight = weight.flatten(1)
    return normals, weight / weight.sum(1, keepdim=True)
