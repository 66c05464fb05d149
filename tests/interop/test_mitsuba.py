"""Mitsuba itself: directions, radiance and irradiance of the exported emitters."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.export import mitsuba as target
from mixlight.export.rig import Rig, make_rig
from mixlight.image.color import linear_to_srgb
from mixlight.light.lights import Light
from mixlight.sphere import camera, equirect
from mixlight.sphere.calibration import CARD_AXES, CARD_COLOURS, CARD_RADIANCE
from mixlight.sphere.points import vogel
from tests.interop import images
from tests.interop.rigs import card_rig, picture_lighting, random_lighting, sphere_normals

pytestmark = pytest.mark.interop

ALBEDO = 0.8


@pytest.fixture(scope="module")
def mi() -> Iterator[Any]:
    import mitsuba

    before = mitsuba.variant()
    mitsuba.set_variant("scalar_rgb")
    yield mitsuba
    if before:
        mitsuba.set_variant(before)


def emitters(mi: Any, rig: Rig, folder: Path) -> dict[str, Any]:
    """As README.txt says."""
    target.write(rig, folder)
    found = mi.load_file(str(folder / target.FILE_NAME)).emitters()
    return {f"emitter_{place}": emitter for place, emitter in enumerate(found)}


def radiance(mi: Any, rig: Rig, folder: Path, directions: Tensor) -> Tensor:
    """Radiance of the environment from some directions."""
    environment = mi.load_dict({"type": "scene", **emitters(mi, rig, folder)}).environment()
    seen = []
    for direction in directions.tolist():
        place = mi.SurfaceInteraction3f()
        place.wi = mi.Vector3f(*(-part for part in direction))
        seen.append([float(part) for part in environment.eval(place)])
    return torch.tensor(seen)


def picture(mi: Any, scene: dict[str, Any], samples: int) -> Tensor:
    return torch.from_numpy(np.array(mi.render(mi.load_dict(scene), spp=samples, seed=1))).float()


def orthographic(mi: Any, size: int) -> dict[str, Any]:
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0])
    film = {
        "type": "hdrfilm",
        "width": size,
        "height": size,
        "rfilter": {"type": "box"},
        "component_format": "float32",
    }
    return {"type": "orthographic", "to_world": to_world, "film": film}


def matte(value: float) -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": value}}


def test_the_card_lies_where_it_belongs(mi: Any, tmp_path: Path) -> None:
    seen = radiance(mi, card_rig(128), tmp_path, torch.tensor([*CARD_AXES.values()]))
    for axis, colour in zip(CARD_AXES, seen, strict=True):
        assert colour.tolist() == pytest.approx([CARD_RADIANCE * c for c in CARD_COLOURS[axis]], abs=0.01), (
            axis
        )


def test_every_direction_shows_the_maps_radiance(mi: Any, tmp_path: Path) -> None:
    rig = make_rig(random_lighting(8), height=64)
    directions = vogel(200)
    seen = radiance(mi, rig, tmp_path, directions)
    expected = equirect.sample(rig.environment, directions)
    assert float((seen - expected).abs().max()) < 0.02 * float(expected.max())
    # Mitsuba puts row i at v = i / (H - 1), up to half a row from where all others put it (.35 degrees on 256
    # rows, at the poles); with that taken into account nothing is left but half floats.
    u, v = equirect.directions_to_uv(directions).unbind(-1)
    shifted = torch.stack([u, (v * 63 + 0.5) / 64], -1)
    expected = equirect.sample(rig.environment, equirect.uv_to_directions(shifted))
    assert float((seen - expected).abs().max()) < 1e-3 * float(expected.max())


def test_a_camera_sees_the_card_unmirrored(mi: Any, tmp_path: Path) -> None:
    card = card_rig(128)
    film = {"type": "hdrfilm", "width": 48, "height": 48, "rfilter": {"type": "box"}}
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 0, 0], target=[0, 0, -1], up=[0, 1, 0])
    sensor = {"type": "perspective", "fov": 90, "to_world": to_world, "film": film}
    scene = {"type": "scene", "integrator": {"type": "path"}, "sensor": sensor}
    seen = picture(mi, scene | emitters(mi, card, tmp_path), 16)
    expected = camera.view(card.environment, 48, 48, math.pi / 2)
    error = float((seen - expected).abs().mean())
    assert error < 0.06
    assert float((seen.flip(-2) - expected).abs().mean()) > 3 * error


def test_a_light_of_pi_on_albedo_half_shows_half(mi: Any, tmp_path: Path) -> None:
    none = torch.zeros(9, 3)
    light = Light("light_1", torch.tensor([0.0, 0.0, 1.0]), torch.full((3,), math.pi), 0.14)
    rig = Rig(torch.zeros(16, 32, 3), (light,), True, none, none)
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": orthographic(mi, 4),
        "patch": {"type": "rectangle", "bsdf": matte(0.5)},
    }
    _black, sun = emitters(mi, rig, tmp_path).values()  # chosen between by chance, which would be noise
    seen = picture(mi, scene | {"sun": sun}, 4)
    assert seen.flatten().tolist() == pytest.approx([0.5] * seen.numel(), rel=1e-4)


@pytest.mark.parametrize(("residual", "noise"), [(True, 0.05), (False, 0.1)])
def test_a_matte_sphere_is_lit_as_the_library_says(
    mi: Any, tmp_path: Path, residual: bool, noise: float
) -> None:
    lighting = random_lighting(8)
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": orthographic(mi, 24),
        "ball": {"type": "sphere", "bsdf": matte(ALBEDO)},
    }
    rig = make_rig(lighting, height=64, residual=residual)
    seen = picture(mi, scene | emitters(mi, rig, tmp_path), 64)
    normals, mask = sphere_normals(24)
    expected = lighting.irradiance(normals.float())[mask] * (ALBEDO / math.pi)
    assert seen[mask].mean(0).tolist() == pytest.approx(expected.mean(0).tolist(), rel=0.01)
    assert float((seen[mask] - expected).abs().mean() / expected.mean()) < noise


def test_the_file_can_be_included_from_another_folder(mi: Any, tmp_path: Path) -> None:
    (tmp_path / "light").mkdir()
    rig = make_rig(random_lighting(8), height=16)
    target.write(rig, tmp_path / "light")
    main = tmp_path / "scene.xml"
    main.write_text(
        '<scene version="3.0.0"><default name="mixlight" value="light"/>'
        f'<include filename="light/{target.FILE_NAME}"/><shape type="sphere"/></scene>'
    )
    assert len(mi.load_file(str(main)).emitters()) == 1 + len(rig.lights)


def test_picture(mi: Any, tmp_path: Path) -> None:
    film = {"type": "hdrfilm", "width": 192, "height": 192, "rfilter": {"type": "gaussian"}}
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 2.0, 6.4], target=[0, 0.4, 0], up=[0, 1, 0])
    sensor = {"type": "perspective", "fov": 38, "to_world": to_world, "film": film}
    ground = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(3.5)
    materials = (
        matte(0.7),
        {"type": "roughconductor", "material": "none", "alpha": 0.09, "specular_reflectance": grey(0.8)},
        {"type": "conductor", "material": "none", "specular_reflectance": grey(0.9)},
    )
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 5},
        "sensor": sensor,
        "ground": {"type": "rectangle", "to_world": ground, "bsdf": matte(0.35)},
    }
    for place, material in enumerate(materials):
        center = [1.4 * place - 1.4, 0.6, 0]
        scene[f"ball_{place}"] = {"type": "sphere", "center": center, "radius": 0.6, "bsdf": material}
    rig = make_rig(picture_lighting(), height=256)
    seen = picture(mi, scene | emitters(mi, rig, tmp_path), 96).clamp(0, 1).numpy()
    images.hold("mitsuba", np.round(linear_to_srgb(seen) * 255).astype(np.uint8), tolerance=3.0)


def grey(value: float) -> dict[str, Any]:
    return {"type": "rgb", "value": value}
