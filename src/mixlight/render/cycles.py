"""Blender's Cycles as the renderer of insertions: the same scene as in Mitsuba, in a program of its own.

Blender runs in a separate process (`mixlight.blender.program`); the scene is handed over in
a temporary folder.
"""

import json
import tempfile
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float

from mixlight.blender import program
from mixlight.image import exr
from mixlight.render.insertion import InsertionScene, Region, Renders
from mixlight.render.mitsuba import MAX_DEPTH
from mixlight.render.model import Part
from mixlight.sphere import frames

__all__ = ["check", "render"]

_SCRIPT = Path(__file__).with_name("cycles_script.py")

TIMEOUT = 3600.0
"""Seconds after which Blender is given up."""


def check() -> None:
    """See that a Blender is there, before any work is done.

    Raises:
        BlenderMissing: there is none; the message holds the commands that install it.
    """
    program.find_blender()


def render(scene: InsertionScene, region: Region, *, samples: int, runs: int = 1, seed: int = 0) -> Renders:
    """Render a region of the photo in Cycles; arguments and result as for `mixlight.render.mitsuba.render`.

    Raises:
        BlenderMissing: there is no Blender.
        BlenderError: Blender failed; the message ends with its own last lines.
    """
    with tempfile.TemporaryDirectory(prefix="mixlight-") as name:
        folder = Path(name)
        _write(scene, region, folder, samples, runs, seed)
        program.run(_SCRIPT, [folder], timeout=TIMEOUT)
        found = {kind: np.load(folder / f"{kind}.npy") for kind in ("scene", "ground", "coverage")}
    for kind, picture in found.items():
        if picture.shape[1:3] != (region.height, region.width):
            raise program.BlenderError(
                f"expected a {kind} of {region.width} x {region.height} pixels from Blender, "
                f"received {picture.shape[2]} x {picture.shape[1]}"
            )
    return Renders(
        found["scene"][..., :3].astype(np.float64),
        found["ground"][..., :3].astype(np.float64),
        found["coverage"].mean(0)[..., 3].clip(0, 1).astype(np.float64),
    )


def _write(scene: InsertionScene, region: Region, folder: Path, samples: int, runs: int, seed: int) -> None:
    """The scene as files, in Blender's axes."""
    rolled = frames.convert_panorama(scene.environment.detach().float().cpu(), "mixlight", "blender")
    exr.write(folder / "environment.exr", rolled.numpy())
    ground = scene.ground
    exr.write(folder / "ground.exr", ground.albedo.astype(np.float32))
    x, y, z = ground.centre
    h = ground.half_side
    corners = np.array([[x - h, y, z + h], [x + h, y, z + h], [x + h, y, z - h], [x - h, y, z - h]])
    _arrays(
        folder, "ground", corners, np.tile([0.0, 1.0, 0.0], (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]),
        np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
    )  # fmt: skip
    camera = scene.camera
    job = {
        "width": camera.width,
        "height": camera.height,
        "region": [region.left, region.top, region.right, region.bottom],
        "fov_x": camera.fov_x,
        "axes": _axes(camera.axes.T).T.tolist(),
        "bounces": MAX_DEPTH - 2,
        "samples": samples,
        "runs": runs,
        "seed": seed,
        "parts": [_part(folder, f"part_{i}", part) for i, part in enumerate(scene.parts)],
    }
    (folder / "scene.json").write_text(json.dumps(job), encoding="utf-8")


def _part(folder: Path, name: str, part: Part) -> dict[str, object]:
    uv = None if part.uv is None else np.stack([part.uv[:, 0], 1 - part.uv[:, 1]], -1)
    _arrays(folder, name, part.positions, part.normals, part.triangles, uv)
    material = part.material
    color = np.array(material.base_color)
    if material.base_texture is not None:
        exr.write(folder / f"{name}.base.exr", (material.base_texture * color).astype(np.float32))
    if material.surface_texture is not None:
        values = material.surface_texture * np.array([material.metallic, material.roughness])
        padded = np.concatenate([values, np.zeros_like(values[..., :1])], -1)
        exr.write(folder / f"{name}.surface.exr", padded.astype(np.float32))
    return {
        "name": name,
        "uv": uv is not None,
        "base_color": color.tolist(),
        "metallic": material.metallic,
        "roughness": material.roughness,
        "base_texture": material.base_texture is not None,
        "surface_texture": material.surface_texture is not None,
    }


def _arrays(
    folder: Path,
    name: str,
    positions: Float[np.ndarray, "vertices 3"],
    normals: Float[np.ndarray, "vertices 3"],
    triangles: np.ndarray,
    uv: Float[np.ndarray, "vertices 2"] | None,
) -> None:
    np.save(folder / f"{name}.positions.npy", _axes(positions))
    np.save(folder / f"{name}.normals.npy", _axes(normals))
    np.save(folder / f"{name}.triangles.npy", triangles)
    if uv is not None:
        np.save(folder / f"{name}.uv.npy", uv)


def _axes(vectors: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3"]:
    """Vectors in Blender's axes."""
    ours = torch.from_numpy(np.ascontiguousarray(vectors, dtype=np.float64))
    return np.asarray(frames.convert_directions(ours, "mixlight", "blender").numpy())
