"""The Mitsuba target without Mitsuba; tests/interop/test_mitsuba.py renders it."""

import math
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import torch

from mixlight.export import mitsuba
from mixlight.export.maps import read_map
from mixlight.export.rig import Rig, make_rig
from mixlight.light.lights import Light
from tests.interop.rigs import random_lighting
from tests.tolerances import HALF_FILE


@pytest.mark.parametrize("residual", [True, False])
def test_the_scene_names_the_map_and_the_lights_that_are_on(tmp_path: Path, residual: bool) -> None:
    rig = make_rig(random_lighting(2), height=16, residual=residual)
    assert sorted(mitsuba.write(rig, tmp_path)) == sorted(tmp_path.iterdir())
    root = ET.parse(tmp_path / mitsuba.FILE_NAME).getroot()
    kinds = [emitter.get("type") for emitter in root.iter("emitter")]
    assert kinds == ["envmap"] + ["directional"] * (len(rig.lights) if residual else 0)
    assert (tmp_path / mitsuba.FILE_NAME).read_text().count('type="directional"') == len(rig.lights)
    environment, header = read_map(tmp_path / "environment.exr")
    assert header["frame"] == "mitsuba"
    torch.testing.assert_close(environment, rig.environment, **HALF_FILE)


def test_golden() -> None:
    none = torch.zeros(9, 3)
    light = Light("light_1", torch.tensor([0.0, 1.0, 0.0]), torch.tensor([2.0, 1.0, 0.5]), math.radians(8))
    root = ET.fromstring(mitsuba.to_xml(Rig(torch.ones(4, 8, 3), (light,), True, none, none)))
    emitter = root.findall("emitter")[1]
    assert emitter.get("id") == "light_1"
    vector, rgb = emitter
    assert [float(vector.get(axis, "")) for axis in "xyz"] == [0, -1, 0]  # the way it travels
    assert rgb.get("value") == "2.0, 1.0, 0.5"


@pytest.mark.parametrize("residual", [True, False])
def test_names_cannot_leave_their_place(residual: bool) -> None:
    none = torch.zeros(9, 3)
    light = Light('"/><x y="--><!--', torch.tensor([0.0, 1.0, 0.0]), torch.ones(3), 0.1)
    root = ET.fromstring(mitsuba.to_xml(Rig(torch.ones(4, 8, 3), (light,), residual, none, none)))
    assert {element.tag for element in root.iter()} <= {
        "scene",
        "default",
        "emitter",
        "string",
        "vector",
        "rgb",
    }
