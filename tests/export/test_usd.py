"""The USD target without USD; tests/interop/test_usd.py opens it with USD itself."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.export import _usda, usd
from mixlight.export.maps import read_map
from mixlight.export.rig import Rig, make_rig
from mixlight.light.lights import Light
from tests.interop.rigs import random_lighting
from tests.tolerances import HALF_FILE


def lamp(name: str = "lamp", towards: tuple[float, float, float] = (0.0, 1.0, 0.0)) -> Light:
    direction = torch.nn.functional.normalize(torch.tensor(towards), dim=0)
    return Light(name, direction, torch.tensor([2.0, 1.0, 0.5]), math.radians(8))


def rig_of(*lights: Light, residual: bool = True) -> Rig:
    none = torch.zeros(9, 3)
    return Rig(torch.ones(4, 8, 3), lights, residual, none, none)


def test_golden() -> None:
    root = _usda.parse(usd.to_usda(rig_of(lamp()))).prims[0]
    dome, light = root.children
    assert (root.kind, root.name, dome.kind, light.kind, light.name) == (
        *("Xform", "mixlight", "DomeLight", "DistantLight", "lamp"),
    )
    assert dome.attributes["inputs:texture:file"] == "./environment.exr"
    assert dome.attributes["inputs:texture:format"] == "latlong"
    assert light.attributes["inputs:intensity"] == 2.0
    assert light.attributes["inputs:color"] == (1.0, 0.5, 0.25)
    assert light.attributes["inputs:angle"] == 8.0
    assert light.attributes["inputs:normalize"] is True
    assert light.attributes["xformOp:transform"][2] == (0.0, 1.0, 0.0, 0.0)
    assert "visibility" not in light.attributes


@given(st.tuples(*[st.floats(-1, 1, width=32)] * 3).filter(lambda v: math.hypot(*v) > 1e-3))
def test_matrices_are_rotations(towards: tuple[float, float, float]) -> None:
    root = _usda.parse(usd.to_usda(rig_of(lamp(towards=towards)))).prims[0]
    matrix = torch.tensor(root.children[1].attributes["xformOp:transform"], dtype=torch.float64)
    turn = matrix[:3, :3]
    torch.testing.assert_close(turn @ turn.T, torch.eye(3, dtype=torch.float64), rtol=0, atol=1e-6)
    assert float(torch.linalg.det(turn)) == pytest.approx(1, abs=1e-6)


def test_lights_whose_light_is_in_the_map_are_invisible(tmp_path: Path) -> None:
    rig = rig_of(lamp(), residual=False)
    light = _usda.parse(usd.to_usda(rig)).prims[0].children[1]
    assert light.attributes["visibility"] == "invisible"
    usd.write(rig, tmp_path)
    again = usd.read(tmp_path)
    assert (again.map_kind, again.lights_on, len(again.lights)) == ("full", False, 1)


@given(st.integers(0, 10_000), st.booleans(), st.sampled_from([1.0, 0.37]))
def test_what_is_written_is_read(
    tmp_path_factory: pytest.TempPathFactory, seed: int, residual: bool, gain: float
) -> None:
    folder = tmp_path_factory.mktemp("usd")
    rig = make_rig(random_lighting(seed).exposed(gain), height=16, residual=residual, name="a room")
    usd.write(rig, folder)
    again = usd.read(folder)
    torch.testing.assert_close(again.environment, rig.environment, **HALF_FILE)
    for name in ("ambient", "sh"):
        assert torch.equal(getattr(again, name), getattr(rig, name))
    assert (again.exposure_gain, again.name, again.map_kind) == (rig.exposure_gain, "a room", rig.map_kind)
    for ours, theirs in zip(rig.lights, again.lights, strict=True):
        assert theirs.name == ours.name
        torch.testing.assert_close(theirs.direction, ours.direction)
        torch.testing.assert_close(theirs.irradiance, ours.irradiance)
        assert theirs.angular_diameter == pytest.approx(ours.angular_diameter, abs=1e-6)


def test_names_that_usd_does_not_allow_come_back(tmp_path: Path) -> None:
    names = ["a-b", "a b", "1st", 'quote " \\ and\nline', "environment", "Lampe über dem Tisch"]
    usd.write(rig_of(*(lamp(name) for name in names)), tmp_path)
    layer = _usda.parse((tmp_path / usd.FILE_NAME).read_text(encoding="utf-8"))
    prims = [prim.name for prim in layer.prims[0].children]
    assert len(set(prims)) == len(prims)
    assert [light.name for light in usd.read(tmp_path).lights] == names


def test_a_black_light(tmp_path: Path) -> None:
    usd.write(rig_of(replace(lamp(), irradiance=torch.zeros(3))), tmp_path)
    assert usd.read(tmp_path).lights[0].irradiance.tolist() == [0, 0, 0]


def test_the_map_is_rolled_by_half(tmp_path: Path) -> None:
    environment = torch.arange(32.0).view(1, 8, 4)[..., :3].expand(4, 8, 3)
    none = torch.zeros(9, 3)
    usd.write(Rig(environment, (), True, none, none), tmp_path)
    assert read_map(tmp_path / "environment.exr")[1]["frame"] == "usd"
    torch.testing.assert_close(usd.read(tmp_path).environment, environment, **HALF_FILE)


def test_blenders_layer_has_a_quarter_and_a_half() -> None:
    text = usd.to_blender_usda(rig_of(lamp(), lamp()))
    assert "subLayers = [@./lighting.usda@]" in text
    assert text.count("inputs:intensity = 0.5") == text.count("inputs:angle = 4.0") == 2
    assert 'over "lamp"' in text
    assert 'over "lamp_"' in text


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("normalize = true", "normalize = false", "normalize: expected true, received False"),
        ('map = "residual"', 'map = "full"', "mixlight.map: expected 'residual', received 'full'"),
        ('upAxis = "Y"', 'upAxis = "Z"', "upAxis: expected 'Y', received 'Z'"),
        ("int version = 1", "int version = 2", "version: expected 1"),
        ("DomeLight", "SphereLight", "DomeLight and DistantLights alone"),
        ("inputs:intensity = 2", "inputs:intensity = -2", "intensity: expected"),
        ("mixlight = {", "other = {", "customLayerData.mixlight: expected an object, received None"),
        ('["xformOp:transform"]', '["xformOp:transform", "xformOp:rotateX"]', "xformOpOrder"),
    ],
)
def test_a_changed_layer_is_refused(tmp_path: Path, old: str, new: str, expected: str) -> None:
    usd.write(rig_of(lamp()), tmp_path)
    path = tmp_path / usd.FILE_NAME
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(ValueError) as raised:
        usd.read(tmp_path)
    assert str(raised.value).startswith(str(path))
    assert expected in str(raised.value)


def test_a_folder_without_a_layer(tmp_path: Path) -> None:
    usd.write(rig_of(), tmp_path)
    (tmp_path / usd.FILE_NAME).unlink()
    with pytest.raises(FileNotFoundError):
        usd.read(tmp_path)
