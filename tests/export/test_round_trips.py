"""Every target that can be read back returns the same light, within its format's precision."""

import json
import tempfile
from pathlib import Path

import pytest
import torch
from hypothesis import given, settings

from mixlight.export.maps import read_map, write_exr, write_hdr
from mixlight.export.probe import Probe, make_probe
from mixlight.export.registry import TARGETS
from mixlight.export.rig import Rig, make_rig
from mixlight.image.exr import MAX_HALF
from mixlight.light import harmonics
from mixlight.light.lights import Light
from mixlight.sphere import equirect
from mixlight.sphere.frames import FRAMES
from tests.export.rigs import Recipe, lighting, recipes
from tests.tolerances import HALF_FILE, RGBE_FILE, TOLERANCE

PROBES = ["arcore", "arkit", "webxr"]
WITH_MAP = ["three", "gltf", "usd", "unity", "unreal", "filament"]
READABLE = [*WITH_MAP, "cubemap", *PROBES]

TEXT = {"three": "lights.json", "gltf": "lights.gltf", "usd": "lighting.usda"}
"""The file that `read` reads beside the map."""

COLOUR = {"three": 4.5e-3}
"""Relative to the brightest channel: Object JSON has 8-bit colours. All others are float32."""


def test_every_target_that_can_be_read_is_tested_here() -> None:
    of_light = [name for name, target in TARGETS.items() if target.of == "light"]
    assert {name for name in of_light if TARGETS[name].read} == set(READABLE)


def round_trip(name: str, rig: Rig) -> object:
    target = TARGETS[name]
    assert target.read is not None
    with tempfile.TemporaryDirectory() as folder:
        target.write(rig, Path(folder))
        return target.read(Path(folder))


def assert_same_light(found: Light, expected: Light, colour: float = 2e-6) -> None:
    torch.testing.assert_close(found.direction, expected.direction, rtol=0, atol=2e-6)
    peak = float(expected.irradiance.max())
    torch.testing.assert_close(found.irradiance, expected.irradiance, rtol=0, atol=colour * peak)
    assert found.angular_diameter == pytest.approx(expected.angular_diameter, abs=2e-6)


def assert_same_words(found: Rig, rig: Rig) -> None:
    assert (found.map_kind, found.lights_on) == (rig.map_kind, rig.lights_on)
    assert found.exposure_gain == pytest.approx(rig.exposure_gain, rel=1e-7)
    torch.testing.assert_close(found.ambient, rig.ambient, **TOLERANCE[torch.float32])
    torch.testing.assert_close(found.sh, rig.sh, **TOLERANCE[torch.float32])


@pytest.mark.parametrize("name", WITH_MAP)
@settings(max_examples=4)
@given(recipe=recipes())
def test_a_rig_comes_back(name: str, recipe: Recipe) -> None:
    rig = recipe.rig()
    found = round_trip(name, rig)
    assert isinstance(found, Rig)
    torch.testing.assert_close(found.environment, rig.environment.clamp(max=MAX_HALF), **HALF_FILE)
    assert_same_words(found, rig)
    assert len(found.lights) == len(rig.lights)
    for there, here in zip(found.lights, rig.lights, strict=True):
        assert_same_light(there, here, COLOUR.get(name, 2e-6))


@pytest.mark.parametrize("name", PROBES)
@settings(max_examples=4)
@given(recipe=recipes())
def test_a_probe_comes_back(name: str, recipe: Recipe) -> None:
    rig = recipe.rig()
    found, expected = round_trip(name, rig), make_probe(rig)
    assert isinstance(found, Probe)
    torch.testing.assert_close(found.harmonics, expected.harmonics, **TOLERANCE[torch.float32])
    assert (found.on, found.name, found.exposure_gain) == (expected.on, rig.name, rig.exposure_gain)
    assert (found.main is None) == (expected.main is None)
    if found.main is not None and expected.main is not None:
        assert found.main.name == expected.main.name
        assert_same_light(found.main, expected.main)


@settings(max_examples=4)
@given(recipe=recipes())
def test_a_cube_comes_back(recipe: Recipe) -> None:
    rig = recipe.rig()
    found = round_trip("cubemap", rig)
    assert isinstance(found, Rig)
    assert_same_words(found, rig)
    for there, here in zip(found.lights, rig.lights, strict=True):
        assert_same_light(there, here)
    # The map is sampled twice, on other grids: what is as small as a texel blurs, and its energy stays.
    energy = equirect.integrate(rig.environment)
    torch.testing.assert_close(equirect.integrate(found.environment), energy, rtol=2e-3, atol=1e-4)
    # So does what matte surfaces see of it, up to where in a texel of these coarse maps a lobe lay.
    blur = harmonics.project(found.environment) - rig.ambient
    assert float(blur.abs().max()) < 0.15 * float(rig.ambient[0].max())


@pytest.mark.parametrize("write", [write_exr, write_hdr])
@pytest.mark.parametrize("frame", FRAMES)
def test_a_map_file_comes_back_from_every_frame(write: object, frame: str, tmp_path: Path) -> None:
    rig = fixed_rig()
    path = tmp_path / ("map.exr" if write is write_exr else "map.hdr")
    write(path, rig, frame)  # type: ignore[operator]
    environment, header = read_map(path)
    assert (header["frame"], header["map"]) == (frame, "residual")
    if write is write_exr:
        torch.testing.assert_close(environment, rig.environment, **HALF_FILE)
    else:
        error = (environment - rig.environment).abs() / rig.environment.amax(-1, keepdim=True)
        assert float(error.max()) <= RGBE_FILE["rtol"]


def fixed_rig() -> Rig:
    return make_rig(lighting(1), height=32, lights=2)


@pytest.mark.parametrize("name", READABLE)
def test_the_same_rig_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
    contents = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        files = TARGETS[name].write(fixed_rig(), folder)
        contents.append({path.relative_to(folder): path.read_bytes() for path in files})
    assert contents[0] == contents[1]


@pytest.mark.parametrize("name", READABLE)
def test_files_of_two_rigs_are_told_apart(name: str, tmp_path: Path) -> None:
    """A full map beside lights that are on would light a scene twice: no reader takes it."""
    one, other = tmp_path / "one", tmp_path / "other"
    for folder, residual in ((one, True), (other, False)):
        folder.mkdir()
        TARGETS[name].write(make_rig(lighting(1), height=16, residual=residual), folder)
    read = TARGETS[name].read
    assert read is not None
    if name in PROBES:
        path = one / f"{name}.json"
        document = json.loads(path.read_text())
        document["main_light"]["enabled"] = False
        path.write_text(json.dumps(document))
    else:
        for path in other.rglob("*.exr"):
            path.rename(one / path.relative_to(other))
    with pytest.raises(ValueError, match="expected"):
        read(one)


@pytest.mark.parametrize("name", READABLE)
def test_foreign_and_broken_files_are_refused_by_name(name: str, tmp_path: Path) -> None:
    read = TARGETS[name].read
    assert read is not None
    with pytest.raises(OSError, match="No such file"):
        read(tmp_path)
    TARGETS[name].write(fixed_rig(), tmp_path)
    path = tmp_path / TEXT.get(name, f"{name}.json")
    whole = path.read_text()
    for text in ("", "{}", "[1]", "null", whole[: len(whole) // 2], whole.replace("mixlight", "other")):
        path.write_text(text)
        with pytest.raises(ValueError, match=path.name):
            read(tmp_path)
