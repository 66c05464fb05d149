"""Files of game engines, held against each engine's own formulas as they are documented."""

import json
import math
import re
from pathlib import Path

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.export import filament, unity, unreal
from mixlight.export.rig import Rig, make_rig
from mixlight.image import exr, radiance
from mixlight.light.lights import Light
from mixlight.sphere.calibration import CARD_AXES, CARD_COLOURS, CARD_RADIANCE, calibration_card
from tests.export.rigs import lighting

# Where an engine looks for a direction in its own axes: the fraction of the map's width, and of its height.
LOOKS = {
    "unity": lambda x, y, z: (0.5 - math.atan2(z, x) / (2 * math.pi), math.acos(y) / math.pi),
    "unreal": lambda x, y, z: (0.5 + math.atan2(x, -y) / (2 * math.pi), math.acos(z) / math.pi),
    # cmgen: an unmirrored cube has u = 1/2 + atan2(x, z) / 2 pi, and the cube is mirrored in x by default.
    "filament": lambda x, y, z: (0.5 + math.atan2(-x, z) / (2 * math.pi), math.acos(y) / math.pi),
}
AXES = {
    "unity": lambda x, y, z: (x, y, -z),
    "unreal": lambda x, y, z: (-z, x, y),
    "filament": lambda x, y, z: (x, y, z),
}
MODULES = {"unity": unity, "unreal": unreal, "filament": filament}


def written(engine: str, rig: Rig, folder: Path) -> dict[str, object]:
    MODULES[engine].write(rig, folder)
    document: dict[str, object] = json.loads((folder / f"{engine}.json").read_text())
    return document


@pytest.mark.parametrize("suffix", ["exr", "hdr"])
@pytest.mark.parametrize("engine", MODULES)
def test_the_engine_finds_each_axis_of_the_card(engine: str, suffix: str, tmp_path: Path) -> None:
    card = calibration_card(64)
    written(engine, Rig(card, (), False, torch.zeros(9, 3), torch.zeros(9, 3)), tmp_path)
    read = exr.read if suffix == "exr" else radiance.read
    pixels, _ = read(tmp_path / f"environment.{suffix}")
    for name, axis in CARD_AXES.items():
        u, v = LOOKS[engine](*AXES[engine](*axis))
        row, column = min(int(v * 64), 63), int(u * 128) % 128
        colour = [CARD_RADIANCE * part for part in CARD_COLOURS[name]]
        assert pixels[row, column].tolist() == pytest.approx(colour, abs=0.05), name


@pytest.mark.parametrize("engine", MODULES)
@pytest.mark.parametrize("residual", [True, False])
def test_lights_point_and_shine_as_the_rig_says(engine: str, residual: bool, tmp_path: Path) -> None:
    rig = make_rig(lighting(7), height=16, residual=residual)
    document = written(engine, rig, tmp_path)
    assert document["map"] == ("residual" if residual else "full")
    lights = document["lights"]
    assert isinstance(lights, list)
    for entry, light in zip(lights, rig.lights, strict=True):
        assert entry["direction"] == pytest.approx(AXES[engine](*light.direction.tolist()), abs=1e-6)
        assert entry["irradiance"] == pytest.approx(light.irradiance.tolist(), rel=1e-6)
        assert entry["enabled"] is residual


@given(azimuth=st.floats(-3.1, 3.1), height=st.floats(-0.999, 0.999))
def test_unreals_rotator_shines_away_from_the_light(azimuth: float, height: float) -> None:
    level = math.sqrt(1 - height**2)
    towards = [level * math.cos(azimuth), level * math.sin(azimuth), height]
    turn = unreal.rotator(towards)
    pitch, yaw = math.radians(turn["pitch"]), math.radians(turn["yaw"])
    forward = (math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch))
    assert forward == pytest.approx([-part for part in towards], abs=1e-5)


def test_filaments_lights_travel_and_add_up(tmp_path: Path) -> None:
    rig = make_rig(lighting(7), height=16)
    lights = written("filament", rig, tmp_path)["lights"]
    assert isinstance(lights, list)
    for entry, light in zip(lights, rig.lights, strict=True):
        native = entry["filament"]
        assert native["direction"] == pytest.approx([-part for part in light.direction.tolist()], abs=1e-6)
        assert max(native["color"]) == 1
        shown = [native["intensity"] * part for part in native["color"]]
        assert shown == pytest.approx(light.irradiance.tolist(), rel=1e-6)
        assert math.radians(2 * native["sunAngularRadius"]) == pytest.approx(light.angular_diameter, abs=1e-5)


def test_filament_takes_a_light_without_light(tmp_path: Path) -> None:
    dark = Light("dark", torch.tensor([0.0, 1.0, 0.0]), torch.zeros(3), 0.1)
    rig = Rig(torch.ones(8, 16, 3), (dark,), True, torch.zeros(9, 3), torch.zeros(9, 3))
    lights = written("filament", rig, tmp_path)["lights"]
    assert isinstance(lights, list)
    assert (lights[0]["filament"]["intensity"], lights[0]["filament"]["color"]) == (0, [1, 1, 1])


def test_filaments_text_is_that_of_cmgen(tmp_path: Path) -> None:
    rig = make_rig(lighting(7), height=16)
    document = written("filament", rig, tmp_path)
    lines = (tmp_path / "sh.txt").read_text().splitlines()
    number = r" ?-?\d+\.\d{15}"
    shape = rf"\({number}, {number}, {number}\); // L\d-?\d, irradiance, pre-scaled base"
    assert len(lines) == 9
    assert all(re.fullmatch(shape, line) for line in lines)
    values = [float(word) for line in lines for word in re.findall(r"-?\d+\.\d{15}", line)]
    harmonics = document["harmonics"]
    assert isinstance(harmonics, dict)
    assert values == pytest.approx(harmonics["ambient"]["coefficients"], rel=1e-6)


def test_what_runs_elsewhere_names_the_entries_that_we_write(tmp_path: Path) -> None:
    """The C# and Python that ship read entries by name: each of them must be in the file."""
    for engine, script in (("unity", "Editor/MixLightImport.cs"), ("unreal", "open_in_unreal.py")):
        folder = tmp_path / engine
        folder.mkdir()
        document = written(engine, make_rig(lighting(7), height=16), folder)
        text = (folder / script).read_text()
        assert f"mixlight/{engine}" in text
        lights = document["lights"]
        assert isinstance(lights, list)
        if engine == "unity":
            fields = set(re.findall(r"public (?:string|int|float|bool|float\[\]) (\w+);", text))
            known = {*document, *lights[0], *document["harmonics"]["ambient"]}  # type: ignore[index]
        else:
            fields = set(re.findall(r"(?:rig|light)(?:\.get\()?\[?\"(\w+)\"", text))
            known = {*document, *lights[0]}
        assert fields
        assert fields <= known
    compile((tmp_path / "unreal/open_in_unreal.py").read_text(), "open_in_unreal.py", "exec")
