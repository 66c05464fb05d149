"""What is written for three.js, without three.js; tests/interop/test_three.py runs it."""

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

from mixlight.export import three
from mixlight.export.maps import read_map
from mixlight.export.rig import make_rig
from mixlight.image import exr, radiance
from mixlight.image.color import srgb_to_linear
from mixlight.light.lighting import Lighting
from mixlight.sphere import calibration_card
from mixlight.sphere.calibration import CARD_COLOURS, CARD_RADIANCE
from tests.export.rigs import lighting
from tests.interop.rigs import card_rig

Change = Callable[[dict[str, Any]], object]


def light_of(colour: int, intensity: float) -> list[float]:
    """Irradiance as three makes it of Object JSON: the colour decoded from sRGB, times the intensity."""
    codes = np.array([colour >> 16, colour >> 8 & 255, colour & 255])
    return [float(part) for part in srgb_to_linear(codes / 255) * intensity]


class TestColour:
    @pytest.mark.parametrize(
        ("irradiance", "expected"),
        [
            ([2.0, 2.0, 2.0], (0xFFFFFF, 2.0)),
            ([0.0, 0.0, 0.0], (0xFFFFFF, 0.0)),
            ([0.0, 0.5, 0.0], (0x00FF00, 0.5)),
            ([1e-6, 1e-6, 1e-6], (0xFFFFFF, 1e-6)),
        ],
    )
    def test_golden(self, irradiance: list[float], expected: tuple[int, float]) -> None:
        assert three.colour_and_intensity(irradiance) == expected

    @given(
        st.lists(st.floats(0, 1), min_size=3, max_size=3).filter(lambda rgb: max(rgb) > 1e-3),
        st.floats(1e-3, 1e5),
    )
    def test_the_product_is_the_irradiance(self, rgb: list[float], strength: float) -> None:
        irradiance = [strength * part for part in rgb]
        colour, intensity = three.colour_and_intensity(irradiance)
        found, peak = light_of(colour, intensity), max(irradiance)
        assert max(found) == pytest.approx(peak, rel=1e-9)
        assert found == pytest.approx(irradiance, abs=0.0045 * peak)

    def test_on_average_it_is_much_nearer_than_a_colour_alone(self) -> None:
        generator = np.random.default_rng(7)
        chosen, plain = [], []
        for rgb in generator.uniform(0.05, 1, (200, 3)):
            peak = rgb.max()
            chosen.append(np.abs(light_of(*three.colour_and_intensity(rgb.tolist())) - rgb).max() / peak)
            share = rgb / peak
            encoded = np.where(share > 0.0031308, 1.055 * share ** (1 / 2.4) - 0.055, 12.92 * share)
            plain.append(np.abs(srgb_to_linear(np.rint(255 * encoded) / 255) - share).max())
        assert np.mean(chosen) < 4e-4
        assert np.mean(chosen) < np.mean(plain) / 6


class TestWrite:
    def test_files_and_readme(self, tmp_path: Path) -> None:
        paths = three.write(make_rig(lighting(1), height=16), tmp_path)
        assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in paths)
        lines = (tmp_path / "README.txt").read_text().splitlines()
        assert len(lines) == 3
        assert "loadLight" in lines[0]
        assert "r187" in lines[2]

    def test_the_maps_centre_is_plus_x_as_threes_loaders_want_it(self, tmp_path: Path) -> None:
        three.write(card_rig(64), tmp_path)
        for name, read in (("exr", exr.read), ("hdr", radiance.read)):
            pixels, _ = read(tmp_path / f"environment.{name}")
            for axis, column in (("+X", 64), ("-Z", 32), ("+Z", 96), ("-X", 0)):
                expected = [CARD_RADIANCE * part for part in CARD_COLOURS[axis]]
                assert pixels[31, column].tolist() == pytest.approx(expected, rel=0.01), (name, axis)
            environment, header = read_map(tmp_path / f"environment.{name}")
            assert header["frame"] == "three"
            torch.testing.assert_close(environment, calibration_card(64), rtol=0.01, atol=0.02)

    def test_object_json_golden(self) -> None:
        energy = torch.zeros(128, 3)
        energy[0] = 3.0  # the anchor nearest to +Y, on the side of -Z
        document = three.to_object(make_rig(Lighting(torch.zeros(9, 3), energy), height=16, name="lab"))
        group = document["object"]
        probe, light = group["children"]
        assert (document["metadata"]["type"], group["type"], group["name"]) == ("Object", "Group", "lab")
        assert (probe["type"], probe["name"], probe["intensity"]) == ("LightProbe", "ambient", 1)
        assert probe["sh"] == [0.0] * 27
        assert probe["userData"] == {
            "kind": "radiance", "basis": "real-sh", "order": "l*l+l+m", "degree": 2, "frame": "mixlight",
        }  # fmt: skip
        assert (light["name"], light["color"], light["intensity"]) == ("light_1", 0xFFFFFF, 3.0)
        assert light["position"] == pytest.approx([0, 9.921875, -10 * math.sqrt(1 - 0.9921875**2)], abs=1e-6)
        about = group["userData"]
        assert (about["format"], about["map"], about["frame"]) == ("mixlight/three", "residual", "three")
        assert "lights" not in about

    @pytest.mark.parametrize(("residual", "lights"), [(True, None), (False, None), (True, 0), (False, 2)])
    def test_lights_are_on_only_where_the_map_lacks_them(self, residual: bool, lights: int | None) -> None:
        rig = make_rig(lighting(2), lights=lights, residual=residual, height=32)
        group = three.to_object(rig)["object"]
        probe, *children = group["children"]
        assert {child["visible"] for child in children} == ({rig.lights_on} if rig.lights else set())
        assert group["userData"]["map"] == ("residual" if residual and rig.lights else "full")
        assert "visible" not in probe
        assert probe["sh"][:3] == pytest.approx(rig.ambient[0].tolist(), rel=1e-6)
        # The probe's mean and the lights that are on are all the light there is.
        mean = math.sqrt(4 * math.pi) * torch.tensor(probe["sh"][:3])
        for child in children:
            if child["visible"]:
                mean += torch.tensor(light_of(child["color"], child["intensity"]))
        every = math.sqrt(4 * math.pi) * rig.sh[0]
        torch.testing.assert_close(mean, every, rtol=0.02, atol=0)  # a merged light is v (u . d)

    def test_identifiers_are_the_rigs_own(self) -> None:
        one, other = (
            three.to_object(make_rig(lighting(3), height=16, name=name))["object"] for name in ("a", "b")
        )
        ids = [entry["uuid"] for group in (one, other) for entry in (group, *group["children"])]
        assert len(set(ids)) == len(ids)


def without(*path: str | int) -> Change:
    def change(document: dict[str, Any]) -> None:
        entry: Any = document
        for step in path[:-1]:
            entry = entry[step]
        del entry[path[-1]]

    return change


def with_value(value: object, *path: str | int) -> Change:
    def change(document: dict[str, Any]) -> None:
        entry: Any = document
        for step in path[:-1]:
            entry = entry[step]
        entry[path[-1]] = value

    return change


CHILDREN = ("object", "children")


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (without("object"), "object: expected an object, received None"),
        (with_value("Scene", "object", "type"), "object.type: expected 'Group', received 'Scene'"),
        (with_value({}, "object", "userData"), "object.userData.format: expected 'mixlight/three'"),
        (with_value(2, "object", "userData", "version"), "object.userData.version: expected 1, received 2"),
        (with_value("full", "object", "userData", "map"), "map: expected 'residual', received 'full'"),
        (
            with_value(0, "object", "userData", "exposure_gain"),
            "exposure_gain: expected a finite number above",
        ),
        (
            without("object", "userData", "harmonics", "all_light"),
            "all_light: expected a list, received None",
        ),
        (with_value([], *CHILDREN), "object.children: expected a LightProbe among them"),
        (with_value("PointLight", *CHILDREN, 1, "type"), "children[1].type: expected 'LightProbe' or"),
        (
            with_value([0.0] * 26, *CHILDREN, 0, "sh"),
            "children[0].sh: expected a list of 27 entries, received",
        ),
        (with_value("x", *CHILDREN, 0, "sh", 4), "sh[1][1]: expected a finite number, received 'x'"),
        (with_value(0x1000000, *CHILDREN, 1, "color"), "color: expected a whole number from 0 to 16777215"),
        (with_value(-1, *CHILDREN, 1, "intensity"), "intensity: expected a finite number of at least 0"),
        (with_value([0, 0, 0], *CHILDREN, 1, "position"), "expected a light in some direction"),
        (with_value([1e200, 1e200, 10**400], *CHILDREN, 1, "position"), "position[2]: expected a finite"),
        (with_value({}, *CHILDREN, 1, "userData"), "angular_diameter_deg: expected a finite number"),
        (with_value(None, *CHILDREN, 1, "name"), "name: expected a text, received None"),
    ],
)
def test_broken_files_are_refused_by_entry(tmp_path: Path, change: Change, complaint: str) -> None:
    three.write(make_rig(lighting(4), height=16), tmp_path)
    path = tmp_path / "lights.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match="expected") as error:
        three.read(tmp_path)
    assert str(path) in str(error.value)
    assert complaint in str(error.value)
