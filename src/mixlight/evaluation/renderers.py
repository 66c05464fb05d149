"""Who draws the three spheres of a protocol: exact light transport, or Blender as the papers used it."""

from __future__ import annotations

from typing import Literal, Protocol, runtime_checkable

from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.render.spheres import SphereRenderer

__all__ = ["SCENES", "Kind", "Renderer", "Scene", "SceneRenderer", "matrix"]

Kind = Literal["matrix", "blender"]
"""`matrix` is exact and fast; `blender` is Cycles."""

Scene = Literal["M", "S"]
"""Camera, materials and picture size: protocol M's orthographic set, or protocol S's perspective one."""

SCENES: tuple[Scene, ...] = ("M", "S")

_RESOLUTION_M = 64


@runtime_checkable
class Renderer(Protocol):
    """Draws the diffuse, the matte and the mirror sphere, one at a time, under maps of 128x256.

    Convention: the map's centre is where the photo looks (our frame), values are used as they are: what is
        encoded stays encoded, nothing is clipped, and pixels off the sphere are 0.
    """

    @property
    def about(self) -> dict[str, object]:
        """What a results file says of the renderer: `kind`, and what its pictures depend on."""

    @property
    def frame(self) -> tuple[int, int]:
        """Rows and columns of the whole picture; `render` may cut it to the sphere (outside it is 0)."""

    @property
    def mask(self) -> Bool[Tensor, "height width"]:
        """Which pixels of the returned pictures show the sphere."""

    def render(
        self, maps: Float[Tensor, "batch map_height map_width 3"]
    ) -> Float[Tensor, "batch 3 height width 3"]:
        """Pictures of the three spheres in the maps' units."""


class SceneRenderer:
    """`Renderer` by light transport (`mixlight.render.spheres.SphereRenderer`)."""

    def __init__(self, spheres: SphereRenderer, frame: tuple[int, int] | None = None) -> None:
        """Take the spheres; `frame` is the whole picture's size where theirs is a part of it."""
        self.spheres = spheres
        self.frame = frame or (spheres.resolution, spheres.resolution)

    @property
    def about(self) -> dict[str, object]:
        """Kind and picture size."""
        return {"kind": "matrix", "frame": list(self.frame), "map_height": self.spheres.height}

    @property
    def mask(self) -> Bool[Tensor, "height width"]:
        """Which pixels show the sphere."""
        return self.spheres.mask

    def render(
        self, maps: Float[Tensor, "batch map_height map_width 3"]
    ) -> Float[Tensor, "batch 3 height width 3"]:
        """Pictures of the three spheres in the maps' units."""
        return self.spheres.render(maps)


def matrix(scene: Scene) -> Renderer:
    """The exact renderer of a protocol's scene.

    Raises:
        ValueError: no such scene.

    >>> renderer = matrix("M")
    >>> renderer.frame, int(renderer.mask.sum())
    ((64, 64), 3228)
    """
    if scene == "M":
        return SceneRenderer(SphereRenderer(resolution=_RESOLUTION_M))
    raise ValueError(f"expected a scene out of M, got {scene!r}")
