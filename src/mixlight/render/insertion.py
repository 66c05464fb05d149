"""What every renderer is given to set an object into a photo, and what it gives back.

The scene is the object, a patch of ground that carries the photo's own colours, and the light from all
around. A renderer makes three pictures of it, from which `mixlight.render.composite` makes the insertion:
the scene with the object, the ground without it, and how much of each pixel the object covers.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.render.model import Model, Part
from mixlight.render.scene_camera import Placement, SceneCamera
from mixlight.sphere import equirect

__all__ = ["Ground", "InsertionScene", "Region", "Renders", "ground_irradiance", "make_ground", "make_scene"]

PATCH = 5.0
"""Half a side of the ground patch, in sizes (largest sides) of the object."""

TEXELS = 512
"""Texels along a side of the ground patch."""

ALBEDO = (0.02, 0.9)
"""What a ground may reflect: it is not blacker than soot nor whiter than plaster."""


@dataclass(frozen=True)
class Region:
    """A rectangle of pixels: columns [left, right), rows [top, bottom)."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def width(self) -> int:
        """Columns."""
        return self.right - self.left

    @property
    def height(self) -> int:
        """Rows."""
        return self.bottom - self.top

    @property
    def slices(self) -> tuple[slice, slice]:
        """To cut the region out of a picture [rows, columns, ...]."""
        return slice(self.top, self.bottom), slice(self.left, self.right)


@dataclass(frozen=True, eq=False)
class Ground:
    """A square of ground around the object, with what it reflects."""

    centre: Float[np.ndarray, "3"]
    half_side: float
    albedo: Float[np.ndarray, "rows columns 3"]
    """Row 0 lies farthest away (-Z), column 0 to the left (-X)."""
    mean_albedo: Float[np.ndarray, "3"]
    """Of the ground around the point of contact."""
    mean_radiance: Float[np.ndarray, "3"]
    """What the photo shows there."""


@dataclass(frozen=True, eq=False)
class InsertionScene:
    """Object, ground, light and camera, in our frame, in camera heights."""

    camera: SceneCamera
    parts: tuple[Part, ...]
    """Placed: positions are the world's."""
    ground: Ground
    environment: Float[Tensor, "height width 3"]
    """Radiance from all around, in our frame, in the photo's exposure."""
    irradiance: Float[np.ndarray, "3"]
    """That of the free ground."""


@dataclass(frozen=True, eq=False)
class Renders:
    """The three pictures of a region, several independent ones of each kind where noise is to be measured."""

    scene: Float[np.ndarray, "runs rows columns 3"]
    """Radiance of the scene with the object; what shows neither object nor ground is black."""
    ground: Float[np.ndarray, "runs rows columns 3"]
    """Radiance of the ground without the object, with the same samples."""
    coverage: Float[np.ndarray, "rows columns"]
    """How much of each pixel the object covers."""


def ground_irradiance(environment: Float[Tensor, "height width 3"]) -> Float[Tensor, "3"]:
    """Irradiance of level ground under a map: the integral of radiance times max(y, 0).

    Convention: under a map of ones it is pi.

    >>> ground_irradiance(torch.ones(64, 128, 3))
    tensor([3.1416, 3.1416, 3.1416])
    """
    height = environment.shape[0]
    # Exact over each row of texels, of which one may cut the horizon: y is cos(polar angle).
    edges = torch.linspace(0, math.pi, height + 1, dtype=torch.float64).clamp(max=math.pi / 2)
    rows = (edges[1:].sin() ** 2 - edges[:-1].sin() ** 2) * (math.pi / environment.shape[1])
    total = torch.einsum("h,hwc->c", rows.to(environment.device), environment.double())
    return total.to(environment.dtype)


def make_ground(
    photo: Float[np.ndarray, "height width 3"],
    camera: SceneCamera,
    centre: Float[np.ndarray, "3"],
    size: float,
    irradiance: Float[np.ndarray, "3"],
) -> Ground:
    """The ground around a point, with the photo's colours on it.

    A matte ground of albedo a shows a E / pi, so a = pi photo / E, kept within `ALBEDO`. Where the photo
    does not reach, and farther away than it can be trusted, the ground has the mean of its surroundings.

    Args:
        photo: linear light.
        camera: that took it.
        centre: the point of contact, on y = -1.
        size: the largest side of the object, in camera heights.
        irradiance: of the free ground (`ground_irradiance`).

    Convention: a photo of .2 throughout, under an irradiance of pi, gives an albedo of .2.

    Raises:
        ValueError: a light that does not reach the ground.
    """
    if not (irradiance > 0).all():
        raise ValueError(
            "expected light that reaches the ground, in every channel, received an irradiance of "
            f"{[round(float(v), 6) for v in irradiance]}"
        )
    half = PATCH * size
    steps = (np.arange(TEXELS) + 0.5) / TEXELS * 2 - 1
    x, z = np.meshgrid(steps * half + centre[0], steps * half + centre[2])
    where, depth = camera.project(np.stack([x, np.full_like(x, centre[1]), z], -1))
    column, row = where[..., 0], where[..., 1]
    seen = (depth > 0) & (column >= 0) & (column < camera.width) & (row >= 0) & (row < camera.height)
    i = np.where(seen, row, 0).astype(int)
    j = np.where(seen, column, 0).astype(int)
    albedo = np.clip(photo[i, j] * math.pi / irradiance, *ALBEDO)
    distance = np.hypot(x - centre[0], z - centre[2]) / size
    near = seen & (distance < 1.0)
    radiance = photo[i[near], j[near]].mean(0) if near.any() else photo.mean((0, 1))
    mean = albedo[near].mean(0) if near.any() else np.clip(radiance * math.pi / irradiance, *ALBEDO)
    # Far from the object the photo no longer shows ground, but whatever stands on it.
    trust = np.where(seen, np.clip((3.0 - distance) / 1.5, 0, 1), 0)[..., None]
    return Ground(
        centre,
        half,
        trust * albedo + (1 - trust) * mean,
        np.asarray(mean),
        np.asarray(radiance, dtype=np.float64),
    )


def make_scene(
    photo: Float[np.ndarray, "height width 3"],
    camera: SceneCamera,
    model: Model,
    placement: Placement,
    environment: Float[Tensor, "rows columns 3"],
) -> InsertionScene:
    """Put object, ground and light together.

    Args:
        photo: linear light, of the camera's size.
        camera: that took it.
        model: what to insert.
        placement: where (`mixlight.render.scene_camera.place`).
        environment: radiance in our frame and in the photo's exposure, 2:1.

    Raises:
        ValueError: a photo of another size, what is no panorama, light that does not reach the ground.
    """
    if photo.shape[:2] != (camera.height, camera.width):
        raise ValueError(
            f"expected a photo of {camera.width} x {camera.height}, "
            f"received {photo.shape[1]} x {photo.shape[0]}"
        )
    equirect.check(environment, "environment")
    irradiance = ground_irradiance(environment).double().numpy()
    parts = tuple(
        Part(
            placement.apply(part.positions),
            part.normals @ placement.matrix.T,
            part.triangles,
            part.uv,
            part.material,
        )
        for part in model.parts
    )
    lower, upper = model.bounds
    size = float((upper - lower).max()) * placement.scale
    ground = make_ground(photo, camera, placement.point, size, irradiance)
    return InsertionScene(camera, parts, ground, environment, irradiance)
