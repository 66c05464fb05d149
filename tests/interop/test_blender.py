"""Blender itself: the exported script, the extension, and the USD stage through Blender's import."""

import json
import math
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image
from torch import Tensor

from mixlight.blender.program import run
from mixlight.export import blender as target
from mixlight.export import usd
from mixlight.export.rig import Rig, make_rig
from mixlight.image import exr
from mixlight.light.document import save
from mixlight.light.lights import Light
from mixlight.sphere import equirect
from mixlight.sphere.calibration import CARD_AXES, CARD_COLOURS, CARD_RADIANCE
from mixlight.sphere.frames import convert_directions
from tests.interop import images
from tests.interop.blenders import VERSIONS, blender_python
from tests.interop.rigs import card_rig, picture_lighting, random_lighting, sphere_normals, uniform_rig

pytestmark = pytest.mark.interop

HERE = Path(__file__).parent
LIGHTING = random_lighting(11)
TURN = 0.7
ALBEDO = 0.8
TOWARDS = torch.nn.functional.normalize(torch.tensor([0.4, 0.7, -0.3]), dim=0)
"""Where the Sun of the patch stands, in our frame."""


def sun_rig() -> Rig:
    """One Sun of irradiance pi, and nothing else."""
    black = torch.zeros(16, 32, 3)
    none = torch.zeros(9, 3)
    return Rig(black, (Light("sun", TOWARDS, torch.full((3,), math.pi), 0.14),), True, none, none)


@dataclass(frozen=True)
class Stage:
    """What one Blender rendered."""

    version: str
    folder: Path

    def exr(self, name: str) -> Tensor:
        return torch.from_numpy(exr.read(self.folder / f"{name}.exr")[0])

    def png(self, name: str) -> NDArray[np.uint8]:
        with Image.open(self.folder / f"{name}.png") as image:
            return np.asarray(image.convert("RGB"))

    def lights(self, name: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = json.loads((self.folder / f"{name}.json").read_text())
        return found


@pytest.fixture(scope="module", params=VERSIONS)
def stage(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Stage:
    """All pictures of one Blender, from one process."""
    version: str = request.param
    program = blender_python(version)
    folder = tmp_path_factory.mktemp(f"blender-{version}")
    rigs = {
        "card": card_rig(64),
        "residual": make_rig(LIGHTING, height=64),
        "full": make_rig(LIGHTING, height=64, residual=False),
        "sun": sun_rig(),
        "uniform": uniform_rig(0.18, 8),
        "picture": make_rig(picture_lighting(), height=256),
    }
    for name, rig in rigs.items():
        for module in (target, usd):
            place = folder / module.__name__.rpartition(".")[2] / name
            place.mkdir(parents=True)
            module.write(rig, place)

    def shot(name: str, kind: str, **options: Any) -> dict[str, Any]:
        suffix = "png" if "transform" in options else "exr"
        return {"file": str(folder / f"{name}.{suffix}"), "kind": kind, **options}

    def sphere(name: str) -> dict[str, Any]:
        return shot(name, "sphere", size=32, samples=48, albedo=ALBEDO)

    def script(name: str, *shots: dict[str, Any], **more: Any) -> dict[str, Any]:
        lights = str(folder / f"{name} lights.json")
        return {"load": ["script", str(folder / "blender" / name)], "shots": shots, "lights": lights} | more

    def stage_of(name: str, file: str, *shots: dict[str, Any]) -> dict[str, Any]:
        lights = str(folder / f"{name} {Path(file).stem}.json")
        return {"load": ["usd", str(folder / "usd" / name / file)], "shots": shots, "lights": lights}

    facing = convert_directions(TOWARDS, "mixlight", "blender").tolist()
    jobs = [
        script("card", shot("card", "panorama", size=64)),
        script("card", shot("turned card", "panorama", size=64), turn=TURN),
        script("residual", shot("residual", "panorama", size=64), sphere("residual sphere")),
        script("residual", sphere("turned sphere"), turn=TURN, lights=str(folder / "turned lights.json")),
        script("full", sphere("full sphere")),
        script("sun", shot("patch", "patch", size=8, albedo=0.5, towards=facing)),
        script(
            "uniform",
            shot("uniform", "view", size=4, samples=1),
            shot("standard", "view", size=4, samples=1, transform="Standard"),
            shot("raw", "view", size=4, samples=1, transform="Raw"),
        ),
        stage_of("card", usd.BLENDER_FILE_NAME, shot("usd card", "panorama", size=64)),
        stage_of("residual", usd.BLENDER_FILE_NAME, sphere("usd sphere")),
        stage_of("residual", usd.FILE_NAME),
        stage_of("full", usd.BLENDER_FILE_NAME),
    ]
    if version == VERSIONS[-1]:  # the docs' pictures are dear, and one Blender's are enough
        still_life = {"kind": "still_life", "size": 192, "samples": 32, "transform": "Standard"}
        jobs += [
            script("picture", shot("picture", **still_life)),
            stage_of("picture", usd.BLENDER_FILE_NAME, shot("usd picture", **still_life)),
        ]
    (folder / "jobs.json").write_text(json.dumps(jobs))
    run(HERE / "blender_stage.py", [folder / "jobs.json"], timeout=1800, blender=program)
    return Stage(version, folder)


def held(picture: Tensor, expected: Tensor, *, mean: float) -> None:
    """The same panorama, up to what pixels average along edges; never turned or mirrored."""
    assert picture.shape == expected.shape
    assert float((picture - expected).abs().mean()) < mean
    for other in (picture.flip(-2), picture.flip(-3), picture.roll(16, -2), picture.roll(-16, -2)):
        assert float((other - expected).abs().mean()) > 3 * mean


@pytest.mark.parametrize("name", ["card", "usd card"])
def test_the_world_shows_the_card_the_right_way_round(stage: Stage, name: str) -> None:
    seen = stage.exr(name)
    held(seen, card_rig(64).environment, mean=0.06)
    for axis, (x, y, z) in CARD_AXES.items():
        # Beside the poles, where Cycles wraps the map from top to bottom, and above the patch's letters.
        colour = equirect.sample(seen, torch.tensor([x, y if y else 0.1, z + 0.1 * y]))
        assert colour.tolist() == pytest.approx([CARD_RADIANCE * c for c in CARD_COLOURS[axis]], abs=0.02), (
            axis
        )


def test_a_turn_of_the_empty_turns_the_map_to_the_left(stage: Stage) -> None:
    # What was at the right by the angle is ahead now.
    held(stage.exr("turned card"), equirect.rotate_azimuth(card_rig(64).environment, TURN), mean=0.07)


def test_world_radiance_is_pixel_value(stage: Stage) -> None:
    expected = make_rig(LIGHTING, height=64).environment
    # Cycles wraps the map from top to bottom too, which shows in the half row at each pole.
    error = (stage.exr("residual") - expected).abs()[1:-1]
    assert float(error.max()) < 0.01 * float(expected.max())
    assert float(error.mean()) < 1e-3 * float(expected.mean())


def test_view_transforms(stage: Stage) -> None:
    assert float(stage.exr("uniform").mean()) == pytest.approx(0.18, rel=5e-4)  # half floats
    assert np.unique(stage.png("standard")).tolist() == [118]  # the sRGB code of .18
    assert np.unique(stage.png("raw")).tolist() == [46]  # .18 * 255


def test_a_sun_of_pi_on_albedo_half_shows_half(stage: Stage) -> None:
    patch = stage.exr("patch")
    assert float(patch.mean()) == pytest.approx(0.5, rel=1e-3)
    assert float((patch - 0.5).abs().max()) < 5e-3


def irradiance(size: int, turn: float = 0.0) -> tuple[Tensor, Tensor]:
    """What the library says of the sphere, and where it says it."""
    normals, mask = sphere_normals(size)
    # A light turned to the left by an angle lights a normal as the unturned one lights it turned back.
    sine, cosine = math.sin(turn), math.cos(turn)
    x, y, z = normals.unbind(-1)
    turned = torch.stack([cosine * x - sine * z, y, sine * x + cosine * z], -1)
    return LIGHTING.irradiance(turned.float()) * (ALBEDO / math.pi), mask


@pytest.mark.parametrize(
    ("name", "turn", "noise"),
    [
        ("residual sphere", 0.0, 0.02),
        ("full sphere", 0.0, 0.08),
        ("turned sphere", TURN, 0.02),
        ("usd sphere", 0.0, 0.02),
    ],
)
def test_a_matte_sphere_is_lit_as_the_library_says(
    stage: Stage, name: str, turn: float, noise: float
) -> None:
    expected, mask = irradiance(32, turn)
    seen, expected = stage.exr(name)[mask], expected[mask]
    assert seen.mean(0).tolist() == pytest.approx(expected.mean(0).tolist(), rel=0.01)
    assert float((seen - expected).abs().mean() / expected.mean()) < noise
    for channel in range(3):
        both = torch.stack([seen[:, channel], expected[:, channel]])
        assert float(torch.corrcoef(both)[0, 1]) > (0.95 if noise > 0.05 else 0.99)


def test_residual_and_lights_equal_the_full_map(stage: Stage) -> None:
    _, mask = irradiance(32)
    residual, full = stage.exr("residual sphere")[mask], stage.exr("full sphere")[mask]
    assert full.mean(0).tolist() == pytest.approx(residual.mean(0).tolist(), rel=0.01)


@pytest.mark.parametrize("name", ["residual", "full"])
def test_suns_have_the_names_directions_and_strengths_of_the_rig(stage: Stage, name: str) -> None:
    rig = make_rig(LIGHTING, height=64, residual=name == "residual")
    found = stage.lights(f"{name} lights")
    assert [sun["name"] for sun in found] == [light.name for light in rig.lights]
    for sun, light in zip(found, rig.lights, strict=True):
        assert sun["kind"] == "SUN"
        towards = convert_directions(light.direction, "mixlight", "blender").tolist()
        assert sun["direction"] == pytest.approx(towards, abs=2e-6)
        assert sun["irradiance"] == pytest.approx(light.irradiance.tolist(), rel=1e-6)
        assert sun["angle"] == pytest.approx(light.angular_diameter, abs=1e-6)
        assert sun["hidden"] == [not rig.lights_on] * 2


def test_blender_reads_the_usd_stage_made_for_it_as_the_same_lights(stage: Stage) -> None:
    native = stage.lights("residual lights")
    imported = stage.lights(f"residual {Path(usd.BLENDER_FILE_NAME).stem}")
    assert [sun["name"] for sun in imported] == [sun["name"] for sun in native]
    for ours, theirs in zip(native, imported, strict=True):
        assert theirs["direction"] == pytest.approx(ours["direction"], abs=1e-6)
        assert theirs["irradiance"] == pytest.approx(ours["irradiance"], rel=1e-6)
        assert theirs["angle"] == pytest.approx(ours["angle"], abs=1e-6)
    assert stage.lights(f"full {Path(usd.BLENDER_FILE_NAME).stem}") == []  # invisible ones are left out


def test_why_blenders_import_needs_a_layer_of_its_own(stage: Stage) -> None:
    # When this fails, Blender reads DistantLights as UsdLux says, and the layer has to go.
    native, imported = stage.lights("residual lights"), stage.lights(f"residual {Path(usd.FILE_NAME).stem}")
    for ours, theirs in zip(native, imported, strict=True):
        assert theirs["irradiance"] == pytest.approx([4 * part for part in ours["irradiance"]], rel=1e-6)
        assert theirs["angle"] == pytest.approx(2 * ours["angle"], abs=1e-6)


@pytest.mark.parametrize("stage", VERSIONS[-1:], indirect=True)
@pytest.mark.parametrize("name", ["blender", "usd"])
def test_picture(stage: Stage, name: str) -> None:
    images.hold(name, stage.png("picture" if name == "blender" else "usd picture"), tolerance=3.0)


# -------------------------------------------------------------------------------------------- the extension

CHECKS = re.findall(r"^def (check_\w+)", (HERE / "blender_extension_stage.py").read_text(), re.MULTILINE)


@pytest.fixture(scope="module", params=VERSIONS)
def extension(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, str | None]:
    """What each check inside Blender said: None, or how it failed. Blender's settings are the test's own."""
    program = blender_python(request.param)
    folder = tmp_path_factory.mktemp(f"extension-{request.param}")
    for name, residual in (("residual", True), ("full", False)):
        place = folder / name
        place.mkdir()
        target.write(make_rig(LIGHTING, height=32, residual=residual), place)
    estimate = folder / "estimate"
    estimate.mkdir()
    save(LIGHTING, estimate / "lighting.json")
    save(LIGHTING, folder / "alone.json")
    exr.write(estimate / "environment.exr", LIGHTING.environment(32).numpy())
    np.save(folder / "residual.npy", make_rig(LIGHTING, height=32).environment.numpy())
    np.save(folder / "full.npy", LIGHTING.environment(32).numpy())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BLENDER_USER_RESOURCES", str(folder / "user"))
        run(HERE / "blender_extension_stage.py", [folder], timeout=600, blender=program)
    result: dict[str, str | None] = json.loads((folder / "checks.json").read_text())
    return result


@pytest.mark.parametrize("check", CHECKS)
def test_the_extension(extension: dict[str, str | None], check: str) -> None:
    assert extension[check] is None, extension[check]


@pytest.mark.parametrize("version", VERSIONS)
def test_blenders_own_validator_passes_the_extension(version: str, tmp_path: Path) -> None:
    python = blender_python(version)
    archive = tmp_path / target.EXTENSION_NAME
    target.write_extension(archive)
    scripts = python.parents[1] / "lib/python3.11/site-packages/bpy" / version / "scripts"
    validator = scripts / "addons_core/bl_pkg/cli/blender_ext.py"
    command = [str(python), "-I", str(validator), "validate", str(archive)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
