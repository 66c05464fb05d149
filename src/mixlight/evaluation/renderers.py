"""Who draws the three spheres of a protocol: exact light transport, or Blender as the papers used it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol, runtime_checkable

from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.image.cache import cache_folder
from mixlight.light.reflection import MATERIALS, Material
from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.surfaces import PRINCIPLED
from mixlight.render.cycles_spheres import CyclesSpheres, Job
from mixlight.render.rings import Interpolation
from mixlight.render.spheres import SphereRenderer

__all__ = [
    "SCENES",
    "BlenderRenderer",
    "Kind",
    "Renderer",
    "Scene",
    "SceneRenderer",
    "SphereScene",
    "blender",
    "matrix",
    "scene_of",
]

Kind = Literal["matrix", "blender"]
"""`matrix` is exact and fast; `blender` is Cycles."""

Scene = Literal["M", "S"]
"""Camera, materials and picture size: protocol M's orthographic set, or protocol S's perspective one."""

SCENES: tuple[Scene, ...] = ("M", "S")


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


@dataclass(frozen=True)
class SphereScene:
    """What is rendered, whoever renders it."""

    camera: SphereCamera
    """Who looks; the picture is cut to the sphere."""
    frame: tuple[int, int]
    """Rows and columns of the whole picture, which shows nothing but the sphere."""
    materials: tuple[Material, ...]
    """Of the diffuse, the matte and the mirror sphere."""
    interpolation: Interpolation
    """What a map is between its texels' centres."""


def scene_of(scene: Scene) -> SphereScene:
    """Camera and materials of a protocol's scene.

    Convention: the sphere of protocol S has radius 1 and Blender's camera stands at (0, -16, 2), in a world
        whose environment texture is the map as it is. Blender has the texture's centre at +X: in our frame
        the camera stands at (16, 2, 0), to the right of the photo's view, and sees the sphere from there.

    Raises:
        ValueError: no such scene.

    >>> scene_of("S").frame, scene_of("S").camera.width
    ((540, 960), 282)
    """
    if scene == "M":
        return SphereScene(SphereCamera.orthographic(64), (64, 64), MATERIALS, "constant")
    if scene == "S":
        camera = SphereCamera.perspective((16.0, 2.0, 0.0), 85.0, 36.0, 960, 540)
        return SphereScene(camera.cropped(), (540, 960), PRINCIPLED, "linear")
    raise ValueError(f"expected a scene out of {', '.join(SCENES)}, got {scene!r}")


class SceneRenderer:
    """`Renderer` by light transport (`mixlight.render.spheres.SphereRenderer`)."""

    def __init__(self, spheres: SphereRenderer, frame: tuple[int, int] | None = None) -> None:
        """Take the spheres; `frame` is the whole picture's size where theirs is a part of it."""
        self.spheres = spheres
        self.frame = frame or (spheres.camera.height, spheres.camera.width)

    @property
    def about(self) -> dict[str, object]:
        """Kind, picture size, and how finely a mirror's rim is sampled (radians)."""
        return {
            "kind": "matrix",
            "frame": list(self.frame),
            "map_height": self.spheres.height,
            "rim_step": round(self.spheres.rim_step, 6),
        }

    @property
    def mask(self) -> Bool[Tensor, "height width"]:
        """Which pixels show the sphere."""
        return self.spheres.mask

    def render(
        self, maps: Float[Tensor, "batch map_height map_width 3"]
    ) -> Float[Tensor, "batch 3 height width 3"]:
        """Pictures of the three spheres in the maps' units."""
        return self.spheres.render(maps)


class BlenderRenderer:
    """`Renderer` by Cycles in a Blender of its own (`mixlight.render.cycles_spheres.CyclesSpheres`)."""

    def __init__(self, spheres: CyclesSpheres, frame: tuple[int, int]) -> None:
        """Take the spheres; `frame` is the whole picture's size."""
        self.spheres = spheres
        self.frame = frame

    @property
    def about(self) -> dict[str, object]:
        """Kind, picture size, Blender's version, samples and seed."""
        return {
            "kind": "blender",
            "frame": list(self.frame),
            "blender": self.spheres.version,
            "samples": self.spheres.job.samples,
            "seed": self.spheres.job.seed,
        }

    @property
    def mask(self) -> Bool[Tensor, "height width"]:
        """Which pixels show the sphere."""
        return self.spheres.mask

    def render(
        self, maps: Float[Tensor, "batch map_height map_width 3"]
    ) -> Float[Tensor, "batch 3 height width 3"]:
        """Pictures of the three spheres in the maps' units."""
        return self.spheres.render(maps)


def matrix(scene: Scene, *, cache: Path | None = None) -> Renderer:
    """The exact renderer of a protocol's scene.

    Args:
        scene: which one.
        cache: folder where its tables are kept between runs; the user's cache folder if not given.

    Raises:
        ValueError: no such scene.

    >>> renderer = matrix("M")
    >>> renderer.frame, int(renderer.mask.sum())
    ((64, 64), 3228)
    """
    found = scene_of(scene)
    spheres = SphereRenderer(
        camera=found.camera,
        materials=found.materials,
        interpolation=found.interpolation,
        cache=cache_folder("spheres") if cache is None else cache,
    )
    return SceneRenderer(spheres, found.frame)


def blender(scene: Scene, samples: int = 1024, *, cache: Path | None = None) -> Renderer:
    """Blender itself as the renderer of a protocol's scene.

    Args:
        scene: which one.
        samples: paths a pixel.
        cache: folder of what was rendered before; the user's cache folder if not given.

    Raises:
        ValueError: no such scene, or no sample.
        BlenderMissing: there is no Blender; the message holds the commands that install it.
        BlenderError: it does not run.
    """
    found = scene_of(scene)
    return BlenderRenderer(
        CyclesSpheres(Job(found.camera, found.materials, samples), cache=cache), found.frame
    )
