"""Filament's WebAssembly build in Chromium: a matte sphere under the exported harmonics and lights."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from mixlight.export import filament
from mixlight.export.rig import Rig, make_rig
from mixlight.image.color import srgb_to_linear
from mixlight.light import harmonics
from tests.interop import images
from tests.interop.rigs import random_lighting, sphere_normals
from tests.interop.web import Web, pack
from tests.render.glb import document, write_glb

pytestmark = pytest.mark.interop

ALBEDO = 0.25
SIZE = 96


def sphere(folder: Path) -> NDArray[np.uint8]:
    """A unit sphere of a matte material without the shine of glass (an index of refraction of 1)."""
    across, down = np.meshgrid(np.arange(65) / 64 * 2 * np.pi, np.arange(33) / 32 * np.pi)
    level = np.sin(down)
    points = np.stack([level * np.sin(across), np.cos(down), -level * np.cos(across)], -1).astype(np.float32)
    at = np.arange(33 * 65).reshape(33, 65)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    corners = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([b, d, c], -1).reshape(-1, 3)])
    found, blob = document(points.reshape(-1, 3), corners.ravel())
    # The normals of a unit sphere are its points; glTF wants bounds of positions.
    (primitive,) = found["meshes"][0]["primitives"]
    primitive |= {"attributes": {"POSITION": 0, "NORMAL": 0}, "material": 0}
    found["accessors"][0] |= {"min": [-1, -1, -1], "max": [1, 1, 1]}
    found["extensionsUsed"] = ["KHR_materials_ior"]
    found["materials"] = [
        {
            "doubleSided": True,
            "extensions": {"KHR_materials_ior": {"ior": 1.0}},
            "pbrMetallicRoughness": {
                "baseColorFactor": [ALBEDO, ALBEDO, ALBEDO, 1], "metallicFactor": 0, "roughnessFactor": 1,
            },
        }
    ]  # fmt: skip
    return np.frombuffer(write_glb(folder / "sphere.glb", found, blob).read_bytes(), np.uint8)


def shown(web: Web, rig: Rig, folder: Path, *, behind: bool = False, size: int = SIZE) -> NDArray[np.uint8]:
    filament.write(rig, folder)
    about: dict[str, Any] = json.loads((folder / filament.FILE).read_text())
    return np.asarray(
        web.run(
            "filament_stage.js",
            glb=pack(sphere(folder)),
            sh=about["harmonics"]["ambient"]["coefficients"],
            lights=[entry["filament"] for entry in about["lights"] if entry["enabled"]],
            size=size,
            behind=behind,
        )
    )


@pytest.mark.parametrize("behind", [False, True])
@pytest.mark.parametrize("lights", [0, 1])
def test_a_matte_sphere_shows_our_irradiance(web: Web, tmp_path: Path, lights: int, behind: bool) -> None:
    """The harmonics' order, signs, axes and scale, and the light's direction and intensity, at once."""
    rig = make_rig(random_lighting(4), lights=lights, height=64)
    picture = shown(web, rig, tmp_path, behind=behind)
    normals, inside = sphere_normals(SIZE, behind=behind)
    irradiance = harmonics.irradiance(rig.ambient.double(), normals)
    for light in rig.lights:
        cosine = (normals @ light.direction.double()).clamp_min(0)
        irradiance = irradiance + cosine[..., None] * light.irradiance
    expected = ALBEDO * irradiance / torch.pi
    found = torch.from_numpy(srgb_to_linear(picture[..., :3].astype(np.float32) / 255)).double()
    dark = expected.amax(-1) < 0.95  # white is where the picture's 8 bits end
    assert float((inside & dark).double().mean()) > 0.3
    error = (found - expected)[inside & dark]
    assert float(error.abs().max()) < 0.02
    assert float(error.abs().mean()) < 0.004


def test_a_picture_for_the_docs(web: Web, tmp_path: Path) -> None:
    rig = make_rig(random_lighting(4), lights=1)
    picture = np.concatenate([shown(web, rig, tmp_path, behind=b, size=160) for b in (False, True)], axis=1)
    images.hold("filament", np.ascontiguousarray(picture[..., :3]))
