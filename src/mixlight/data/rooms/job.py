"""A scene as files: what the script inside Blender reads, and what it leaves.

`scene.json` holds everything but arrays, `arrays.npz` the meshes, one a material, `sky.exr` the outside.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms.mesh import Emission, Mesh, Part
from mixlight.data.rooms.plan import Surface
from mixlight.data.rooms.scene import RoomScene
from mixlight.image import exr
from mixlight.image.errors import file_error
from mixlight.sphere import frames

__all__ = ["Settings", "read_raw", "write_job"]

_NOISY = "noisy-"
_UNSEEN = 1e9
"""Cycles' depth, in metres, where nothing is hit is ten times that."""


@dataclass(frozen=True)
class Settings:
    """How rooms are rendered."""

    width: int = 1024
    """Pixels across a panorama, which is half as high."""
    samples: int = 16
    """Light paths a pixel."""
    denoise: bool = True
    """Take the noise off each light group."""
    bounces: int = 10
    """Longest light path."""
    diffuse: int = 6
    """Most diffuse reflections on one path."""
    clamp: float = 0.0
    """Limit of a path's light. 0 sets none: any limit makes the sum of the groups differ from the whole."""

    def __post_init__(self) -> None:
        if self.width < 16 or self.width % 4:
            raise ValueError(f"width: expected a multiple of 4 from 16 on, received {self.width}")
        if self.samples < 1:
            raise ValueError(f"samples: expected at least 1, received {self.samples}")


def write_job(scene: RoomScene, settings: Settings, folder: Path) -> None:
    """Write a scene into an existing, empty folder.

    Raises:
        OSError: the folder cannot be written to.
    """
    arrays: dict[str, np.ndarray] = {}
    meshes: list[dict[str, Any]] = []
    for (material, smooth), group in _by_material(scene.parts).items():
        prefix = f"m{len(meshes)}"
        arrays |= {f"{prefix}.{name}": value for name, value in _arrays(group, material).items()}
        meshes.append({"name": group[0].name, "material": _material(material), "smooth": smooth})
    job = {
        "name": scene.name,
        "groups": scene.groups,
        "meshes": meshes,
        "library": None if scene.library is None else str(scene.library),
        "placements": [
            {
                "name": placement.name,
                "matrix": np.asarray(placement.matrix).tolist(),
                "surfaces": [asdict(surface) for surface in placement.surfaces],
            }
            for placement in scene.placements
        ],
        "sun": None if scene.sun is None else asdict(scene.sun),
        "portals": [
            {"matrix": portal.matrix.tolist(), "width": portal.width, "height": portal.height}
            for portal in scene.portals
        ],
        "cameras": [{"position": camera.position, "turn": camera.turn} for camera in scene.cameras],
        "render": asdict(settings) | {"seed": scene.seed * 7919 % 2**31},
    }
    np.savez(folder / "arrays.npz", **arrays)  # type: ignore[arg-type]
    exr.write(folder / "sky.exr", frames.convert_panorama(scene.sky, "mixlight", "blender").numpy())
    (folder / "scene.json").write_text(json.dumps(job), encoding="utf-8")


def read_raw(
    path: Path, groups: Sequence[str]
) -> tuple[dict[str, Float[np.ndarray, "height width 3"]], Float[np.ndarray, "height width"]]:
    """Read what the script inside Blender wrote of one camera: light groups, and metres to what is seen.

    The denoiser takes some per cent of a noisy picture's light away with the noise. As each group's noisy
    picture is right on average, every channel is scaled so that it holds as much light as before; by a
    quarter at most, as a single stray path may mislead.

    What denoising leaves below 0 is 0; where nothing is seen the depth is infinite.

    Raises:
        ValueError: not such a file, a group is missing, or a value is not finite.
    """
    import OpenEXR

    try:
        parts = OpenEXR.File(str(path), separate_channels=True).parts
        planes = {name: channel.pixels for part in parts for name, channel in part.channels.items()}
    except (RuntimeError, ValueError) as error:
        raise file_error(path, "Blender's panorama", error) from None
    for name in (*(f"{group}.{c}" for group in groups for c in "RGB"), "depth.V"):
        if name not in planes:
            raise file_error(path, f"light groups {', '.join(groups)} and depth", f"none of {name}")
    found = {}
    for group in groups:
        pixels = _picture(planes, group)
        if not np.isfinite(pixels).all():
            raise file_error(path, f"finite light in {group}", "NaN or infinity")
        pixels = np.maximum(pixels, 0.0)
        if f"{_NOISY}{group}.R" in planes:
            pixels *= _lost(_picture(planes, _NOISY + group), pixels)
        found[group] = pixels
    depth = planes["depth.V"]
    return found, np.where(depth < _UNSEEN, depth, np.inf).astype(np.float32)


def _picture(planes: Mapping[str, np.ndarray], name: str) -> Float[np.ndarray, "height width 3"]:
    return np.stack([planes[f"{name}.{c}"] for c in "RGB"], -1)


def _lost(
    before: Float[np.ndarray, "height width 3"], after: Float[np.ndarray, "height width 3"]
) -> Float[np.ndarray, " 3"]:
    """Light before over light after, within a quarter of 1; rows weigh as much as they span of the sphere."""
    rows = np.sin((np.arange(len(before)) + 0.5) * (np.pi / len(before)))
    had, has = (np.einsum("hwc,h->c", picture, rows, dtype=np.float64) for picture in (before, after))
    ratio = np.divide(had, has, out=np.ones(3), where=(has > 0) & np.isfinite(had))
    return np.asarray(ratio.clip(0.8, 1.25), np.float32)


def _by_material(parts: Iterable[Part]) -> dict[tuple[Surface | Emission, bool], list[Part]]:
    """Parts of one material and smoothness: one object each keeps Blender quick."""
    found: dict[tuple[Surface | Emission, bool], list[Part]] = {}
    for part in parts:
        if len(part.mesh.faces):
            found.setdefault((part.material, part.mesh.smooth), []).append(part)
    return found


def _material(material: Surface | Emission) -> Mapping[str, Any]:
    return asdict(material)


def _arrays(parts: Iterable[Part], material: Surface | Emission) -> dict[str, np.ndarray]:
    """Vertices, the faces' corners end to end, where each face starts among them, and texture coordinates."""
    vertices, corners, sizes, uvs = [], [], [], []
    before = 0
    for part in parts:
        mesh = part.mesh
        used = mesh.faces >= 0
        uv = _box_uv(mesh) if mesh.uv is None else mesh.uv
        if isinstance(material, Surface) and material.kind == "picture":
            uv = _unit(uv, used)
        vertices.append(mesh.vertices)
        corners.append(mesh.faces[used] + before)
        sizes.append(used.sum(1))
        uvs.append(uv[used])
        before += len(mesh.vertices)
    counts = np.concatenate(sizes)
    return {
        "vertices": np.concatenate(vertices).astype(np.float32),
        "corners": np.concatenate(corners).astype(np.int32),
        "starts": (np.cumsum(counts) - counts).astype(np.int32),
        "uv": np.concatenate(uvs).astype(np.float32),
    }


def _box_uv(mesh: Mesh) -> Float[np.ndarray, "faces 4 2"]:
    """Metres along the two axes that a face looks along least."""
    points = mesh.vertices[mesh.faces]
    normals = np.abs(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]))
    axes = np.array([[1, 2], [0, 2], [0, 1]])[normals.argmax(1)]
    return np.asarray(np.take_along_axis(points, axes[:, None, :].repeat(4, 1), axis=2))


def _unit(uv: Float[np.ndarray, "faces 4 2"], used: np.ndarray) -> Float[np.ndarray, "faces 4 2"]:
    """The coordinates of one picture, from 0 to 1 across it."""
    low, high = uv[used].min(0), uv[used].max(0)
    return np.asarray((uv - low) / np.maximum(high - low, 1e-6))
