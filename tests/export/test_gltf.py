"""What is written as glTF, without other programs; tests/interop/test_gltf.py has validator and loader."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mixlight.export import gltf
from mixlight.export.maps import read_map
from mixlight.export.rig import make_rig
from mixlight.light.lighting import Lighting
from mixlight.sphere import calibration_card
from tests.export.rigs import lighting
from tests.export.test_three import Change, with_value, without
from tests.interop.rigs import card_rig

EXTENSION = "KHR_lights_punctual"
LIGHT = ("extensions", EXTENSION, "lights", 0)
NODE = ("nodes", 0)


class TestRotation:
    @pytest.mark.parametrize(
        ("towards", "expected"),
        [
            ((0, 0, 1), (0, 0, 0, 1)),
            ((0, 0, -1), (0, 1, 0, 0)),
            ((0, 1, 0), (-math.sqrt(0.5), 0, 0, math.sqrt(0.5))),
            ((1, 0, 0), (0, math.sqrt(0.5), 0, math.sqrt(0.5))),
        ],
    )
    def test_golden(self, towards: tuple[float, ...], expected: tuple[float, ...]) -> None:
        assert gltf.light_rotation(towards) == pytest.approx(expected, abs=1e-15)

    @given(st.floats(-math.pi, math.pi), st.floats(0, 1), st.sampled_from([-1.0, 1.0]))
    def test_turns_z_towards_the_light(self, azimuth: float, share: float, side: float) -> None:
        """Against SciPy, and as near to -Z, where the axis is lost, as can be."""
        aside = share**8
        z = side * math.sqrt(1 - aside * aside)
        towards = [aside * math.cos(azimuth), aside * math.sin(azimuth), z]
        quaternion = gltf.light_rotation(towards)
        assert math.hypot(*quaternion) == pytest.approx(1, abs=1e-12)
        turned = Rotation.from_quat(quaternion).apply([0.0, 0.0, 1.0])
        np.testing.assert_allclose(turned, towards, atol=1e-12)
        assert quaternion[2] == 0.0  # the shortest turn has no roll


class TestWrite:
    def test_files_and_readme(self, tmp_path: Path) -> None:
        paths = gltf.write(make_rig(lighting(1), height=16), tmp_path)
        assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in paths)
        lines = (tmp_path / "README.txt").read_text().splitlines()
        assert len(lines) == 3
        assert EXTENSION in lines[0]

    def test_document_golden(self) -> None:
        energy = torch.zeros(128, 3)
        energy[0] = torch.tensor([4.0, 2.0, 0.0])
        rig = make_rig(Lighting(torch.zeros(9, 3), energy), height=16, name="lab")
        document = gltf.to_gltf(rig)
        (light,) = document["extensions"][EXTENSION]["lights"]
        (node,) = document["nodes"]
        assert document["asset"]["version"] == "2.0"
        assert document["extensionsUsed"] == [EXTENSION]
        assert (light["type"], light["name"]) == ("directional", "light_1")
        assert (light["color"], light["intensity"]) == ([1.0, 0.5, 0.0], 4.0)
        assert node["extensions"] == {EXTENSION: {"light": 0}}
        assert document["scenes"][0]["nodes"] == [0]
        assert document["scenes"][0]["extras"]["mixlight"]["format"] == "mixlight/gltf"
        json.dumps(document, allow_nan=False)

    def test_lights_that_the_map_holds_have_no_node(self) -> None:
        document = gltf.to_gltf(make_rig(lighting(2), residual=False, height=16))
        assert "nodes" not in document
        assert "nodes" not in document["scenes"][0]
        lights = document["extensions"][EXTENSION]["lights"]
        assert {light["extras"]["enabled"] for light in lights} == {False}

    def test_without_lights_there_is_no_extension(self, tmp_path: Path) -> None:
        rig = make_rig(lighting(2), lights=0, height=16)
        assert gltf.to_gltf(rig).keys() == {"asset", "scene", "scenes"}
        gltf.write(rig, tmp_path)
        assert gltf.read(tmp_path).lights == ()

    def test_a_black_light_is_valid(self) -> None:
        """Colours lie between 0 and 1 and intensities are positive or 0: no 0/0."""
        rig = make_rig(lighting(2), height=16)
        dark = [dict(light, irradiance=[0.0, 0.0, 0.0]) for light in rig.document()["lights"]]
        light = gltf._punctual(dark[0])
        assert (light["color"], light["intensity"]) == ([1.0, 1.0, 1.0], 0.0)

    def test_the_map_is_in_our_frame(self, tmp_path: Path) -> None:
        gltf.write(card_rig(64), tmp_path)
        environment, header = read_map(tmp_path / "environment.exr")
        assert header["frame"] == "mixlight"
        torch.testing.assert_close(environment, calibration_card(64), rtol=1e-3, atol=1e-4)


def twice(*path: str | int) -> Change:
    """The first entry of a list once more at its end."""

    def change(document: dict[str, Any]) -> None:
        entry: Any = document
        for step in path:
            entry = entry[step]
        entry.append(entry[0])

    return change


CHANGES: list[tuple[Callable[[dict[str, Any]], object], str]] = [
    (with_value("1.0", "asset", "version"), "asset.version: expected '2.0', received '1.0'"),
    (with_value([], "scenes"), "scenes: expected a list of 1 entries, received 0"),
    (without("scenes", 0, "extras"), "scenes[0].extras: expected an object, received None"),
    (
        with_value("full", "scenes", 0, "extras", "mixlight", "map"),
        "map: expected 'residual', received 'full'",
    ),
    (without("scenes", 0, "extras", "mixlight", "harmonics"), "harmonics: expected an object, received None"),
    (with_value("spot", *LIGHT, "type"), "lights[0].type: expected 'directional', received 'spot'"),
    (with_value(-2, *LIGHT, "intensity"), "lights[0].intensity: expected a finite number of at least 0"),
    (with_value([1, 1], *LIGHT, "color"), "lights[0].color: expected a list of 3 entries, received 2"),
    (without(*LIGHT, "extras"), "lights[0].extras: expected an object, received None"),
    (with_value(99, *NODE, "extensions", EXTENSION, "light"), "light: expected a whole number from 0 to"),
    (with_value([0, 0, 0, 2], *NODE, "rotation"), "nodes[0]: expected a unit rotation"),
    (with_value([0, 0, 1], *NODE, "rotation"), "rotation: expected a list of 4 entries, received 3"),
    (twice("nodes"), "expected a unit rotation, and one node for each light"),
    (with_value([], "nodes"), "nodes: expected one for each of"),
    (with_value({"nodes": []}, *NODE), "light: expected a whole number"),
]


@pytest.mark.parametrize(("change", "complaint"), CHANGES)
def test_broken_files_are_refused_by_entry(tmp_path: Path, change: Change, complaint: str) -> None:
    gltf.write(make_rig(lighting(4), height=16), tmp_path)
    path = tmp_path / "lights.gltf"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match="expected") as error:
        gltf.read(tmp_path)
    assert str(path) in str(error.value)
    assert complaint in str(error.value)


def test_the_nodes_turn_counts_as_in_other_programs(tmp_path: Path) -> None:
    """Whoever turns a node in an editor moves the light."""
    gltf.write(make_rig(lighting(4), height=16), tmp_path)
    path = tmp_path / "lights.gltf"
    document = json.loads(path.read_text())
    document["nodes"][0]["rotation"] = [0.0, 1.0, 0.0, 0.0]
    path.write_text(json.dumps(document))
    assert gltf.read(tmp_path).lights[0].direction.tolist() == [0.0, 0.0, -1.0]
