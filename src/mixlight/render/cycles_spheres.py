"""The test spheres in Blender's Cycles, as the papers rendered them: one at a time, lit by the map alone.

Blender runs in a separate process (`mixlight.blender.program`), many maps at once. What it rendered is kept
in the user's cache folder, so that an evaluation that is run again renders only what is new.
"""

from __future__ import annotations

import hashlib
import json
import math
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.blender import program
from mixlight.image.atomic import atomic_path
from mixlight.image.cache import cache_folder
from mixlight.light.reflection import Material
from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.sphere_samples import picture_samples

__all__ = ["CyclesSpheres", "Job", "render"]

_SCRIPT = Path(__file__).with_name("cycles_spheres_script.py")

_FORMAT = 1
"""Raised whenever the same job would give another picture, so that old pictures are not found any more."""

TIMEOUT = 24 * 3600.0
"""Seconds after which Blender is given up."""

_WORLD = ((0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
"""Our frame to that of a Blender world whose environment texture is our panorama, loaded as it is: Blender
has the texture's centre, our -Z, at +X."""


@dataclass(frozen=True)
class Job:
    """What Cycles is asked for, the maps aside."""

    camera: SphereCamera
    """Who looks, and the size of the picture."""
    materials: tuple[Material, ...]
    """One sphere each."""
    samples: int = 1024
    """Paths a pixel."""
    seed: int = 0
    """Of the paths."""

    def __post_init__(self) -> None:
        """Check it.

        Raises:
            ValueError: No material, no sample, or a negative seed.
        """
        if not self.materials or self.samples < 1 or self.seed < 0:
            raise ValueError(
                "expected a material, at least one sample and a seed of at least 0, "
                f"got {len(self.materials)}, {self.samples} and {self.seed}"
            )


class CyclesSpheres:
    """Renders spheres under environment maps in Cycles, as `mixlight.render.spheres.SphereRenderer` does.

    Convention: camera, frame and mask as there; a pixel is the mean over the part of it that the sphere
    covers. A map is bilinear between the centres of its texels. Nothing is denoised.
    """

    def __init__(
        self,
        job: Job,
        *,
        cache: Path | None = None,
        blender: Path | None = None,
        threads: int = 0,
    ) -> None:
        """Find Blender and ask for its version (about two seconds).

        Args:
            job: What to render.
            cache: Folder of pictures that were rendered before; the user's cache folder if not given.
            blender: A Python with `bpy` or a Blender program; what `find_blender` finds if not given.
            threads: That Cycles may use; 0: all.

        Raises:
            BlenderMissing: There is no Blender; the message holds the commands that install it.
            BlenderError: It does not run.
        """
        self.job = job
        self.blender = program.find_blender() if blender is None else blender
        self.cache = cache_folder("cycles") if cache is None else cache
        self.threads = threads
        self.version = _version(self.blender)
        self.mask: Bool[Tensor, "height width"] = picture_samples(job.camera, rim=False).mask

    def render(
        self, environment: Float[Tensor, "*batch height width 3"]
    ) -> Float[Tensor, "*batch spheres rows columns 3"]:
        """Pictures of all spheres in linear radiance, in the map's units; 0 outside `mask`.

        Raises:
            ValueError: If the map is not 2:1, or holds values that are negative or not finite.
            BlenderError: Blender failed; the message ends with its own last lines. What was rendered before
                is kept.
        """
        if environment.ndim < 3 or environment.shape[-2] != 2 * environment.shape[-3]:
            raise ValueError(
                f"expected an environment of shape [..., H, 2 H, 3], got {tuple(environment.shape)}"
            )
        if not bool((environment.isfinite() & (environment >= 0)).all()):
            raise ValueError("expected radiance of at least 0, got values that are negative or not finite")
        maps = environment.detach().float().cpu().reshape(-1, *environment.shape[-3:]).numpy()
        keys = [self._key(values) for values in maps]
        missing = {key: values for key, values in zip(keys, maps, strict=True) if self._kept(key) is None}
        if missing:
            self.cache.mkdir(parents=True, exist_ok=True)
            pictures, _ = render(self.job, list(missing.values()), blender=self.blender, threads=self.threads)
            for key, picture in zip(missing, pictures, strict=True):
                with atomic_path(self.cache / f"{key}.npy") as temporary, temporary.open("wb") as file:
                    np.save(file, picture)
        found = []
        for key in keys:
            kept = self._kept(key)
            if kept is None:
                raise OSError(f"expected {self.cache / key}.npy, which was just written, found none")
            found.append(torch.from_numpy(kept))
        result = torch.stack(found) * self.mask[..., None]
        return result.reshape(*environment.shape[:-3], *result.shape[1:]).to(environment)

    def _key(self, values: Float[np.ndarray, "height width 3"]) -> str:
        """Name of a map's pictures: everything that they depend on."""
        said = json.dumps([_FORMAT, self.version, _described(self.job), values.shape])
        return hashlib.sha256(said.encode() + np.ascontiguousarray(values).tobytes()).hexdigest()[:40]

    def _kept(self, key: str) -> Float[np.ndarray, "spheres rows columns 3"] | None:
        """What was rendered before; a file that is no picture is rendered anew."""
        try:
            picture = np.load(self.cache / f"{key}.npy")
        except (OSError, ValueError, EOFError):
            return None
        size = (len(self.job.materials), self.job.camera.height, self.job.camera.width, 3)
        return picture if picture.shape == size else None


def render(
    job: Job,
    maps: Sequence[Float[np.ndarray, "height width 3"]],
    *,
    blender: Path | None = None,
    threads: int = 0,
) -> tuple[Float[np.ndarray, "maps spheres rows columns 3"], dict[str, Any]]:
    """Render spheres under maps in one Blender process.

    Args:
        job: What to render.
        maps: Our frame, linear.
        blender: A Python with `bpy` or a Blender program; what `find_blender` finds if not given.
        threads: That Cycles may use; 0: all.

    Returns:
        The mean radiance over the covered part of each pixel, 0 where nothing is covered, and a report:
        Blender's `version`, and `seconds` and `processor_seconds` (of all threads) of each picture.

    Raises:
        BlenderMissing: There is no Blender.
        BlenderError: Blender failed; the message ends with its own last lines.
    """
    camera = job.camera
    with tempfile.TemporaryDirectory(prefix="mixlight-") as name:
        folder = Path(name)
        np.save(folder / "maps.npy", np.stack(maps).astype(np.float32))
        world = torch.tensor(_WORLD, dtype=torch.float64)
        # An orthographic camera only has to stand outside the sphere.
        place = camera.axes[2] * (camera.distance if math.isfinite(camera.distance) else 8.0)
        seen_by = {
            "width": camera.width,
            "height": camera.height,
            "fov_x": camera.fov_x,
            "span": max(camera.width, camera.height) / camera.radius,
            "axes": (camera.axes @ world.T).tolist(),
            "position": (world @ place).tolist(),
        }
        described = {
            "camera": seen_by,
            "materials": [_shader(material) for material in job.materials],
            "samples": job.samples,
            "seed": job.seed,
            "threads": threads,
        }
        (folder / "job.json").write_text(json.dumps(described), encoding="utf-8")
        program.run(_SCRIPT, [folder], timeout=TIMEOUT, blender=blender)
        pictures = np.load(folder / "pictures.npy")
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    expected = (len(maps), len(job.materials), camera.height, camera.width, 4)
    if pictures.shape != expected:
        raise program.BlenderError(
            f"expected pictures of shape {expected} from Blender, received {pictures.shape}"
        )
    covered = pictures[..., 3:]
    return np.where(covered > 0, pictures[..., :3] / np.maximum(covered, 1e-6), 0.0), report


def _shader(material: Material) -> dict[str, Any]:
    """Blender's node for a material, and its inputs."""
    colour = [material.reflectance] * 3 + [1.0]
    roughness = math.sqrt(material.alpha)
    if material.kind in ("paint", "metal"):
        inputs = {
            "Base Color": colour,
            "Metallic": float(material.kind == "metal"),
            "Roughness": roughness,
            "IOR": material.ior,
            "Specular IOR Level": 0.5,
        }
        return {"shader": "ShaderNodeBsdfPrincipled", "distribution": "MULTI_GGX", "inputs": inputs}
    if material.kind == "diffuse":
        inputs = {"Color": colour, "Roughness": 0.0}
        return {"shader": "ShaderNodeBsdfDiffuse", "distribution": None, "inputs": inputs}
    inputs = {"Color": colour, "Roughness": roughness}
    return {"shader": "ShaderNodeBsdfAnisotropic", "distribution": "GGX", "inputs": inputs}


def _described(job: Job) -> dict[str, Any]:
    """A job as JSON can hold it."""
    described = asdict(job)
    if math.isinf(job.camera.distance):
        described["camera"]["distance"] = None
    return described


def _version(blender: Path) -> str:
    with tempfile.TemporaryDirectory(prefix="mixlight-") as name:
        script, answer = Path(name) / "version.py", Path(name) / "version.txt"
        script.write_text(
            "import sys, bpy\nopen(sys.argv[-1], 'w', encoding='utf-8').write(bpy.app.version_string)\n",
            encoding="utf-8",
        )
        program.run(script, [answer], timeout=300, blender=blender)
        return answer.read_text(encoding="utf-8")
