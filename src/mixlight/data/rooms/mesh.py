"""Meshes as plain arrays: what every wall, chair and lamp becomes before Blender sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from mixlight.data.rooms.plan import Surface

__all__ = ["Emission", "Mesh", "Part"]


@dataclass(frozen=True)
class Mesh:
    """Triangles and quads in the frame of the thing they belong to, in metres."""

    vertices: Float[np.ndarray, "vertices 3"]
    faces: Int[np.ndarray, "faces 4"]
    """Corner indices, counter-clockwise seen from outside; a triangle repeats -1 in its last place."""
    uv: Float[np.ndarray, "faces 4 2"] | None = None
    """Texture coordinates of every corner in metres (so that patterns keep their size)."""
    smooth: bool = False


@dataclass(frozen=True)
class Emission:
    """A face that shines, in physical units."""

    group: str
    """Light group."""
    radiance: tuple[float, float, float]
    """Linear Rec.709, in W/(m² sr) of a unit where 683 lm are 1 (so 1.0 is 683 cd/m²)."""
    two_sided: bool = False
    reflectance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Diffuse reflectance of the face itself, which is what shows of a lamp that is off."""


@dataclass(frozen=True)
class Part:
    """A mesh of one material, placed in the room frame."""

    mesh: Mesh
    material: Surface | Emission
    name: str = "part"
