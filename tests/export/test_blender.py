"""The Blender target without Blender: files, extension archive, and the parts that need no bpy."""

import io
import json
import re
import tomllib
import zipfile
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

import mixlight
from mixlight.export import blender
from mixlight.export.maps import read_map
from mixlight.export.rig import Rig, make_rig
from mixlight.light import edit, harmonics
from mixlight.light.document import save, to_document
from mixlight.light.lighting import Lighting
from mixlight.sphere.points import vogel
from tests.tolerances import HALF_FILE

SOURCE = Path(blender.__file__).parent / "blender_extension"


def part(name: str) -> ModuleType:
    """A module of the extension that needs nothing of Blender's."""
    spec = spec_from_file_location(f"blender_extension_{name}", SOURCE / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


documents, synthesis = part("documents"), part("synthesis")


def lighting(seed: int = 0, degree: int = 2, sharpness: float = 0.0025) -> Lighting:
    generator = torch.Generator().manual_seed(seed)
    ambient = 0.3 * torch.randn((degree + 1) ** 2, 3, generator=generator)
    ambient[0] = 3.0
    energy = torch.zeros(128, 3)
    energy[torch.randperm(128, generator=generator)[:6]] = 4 * torch.rand(6, 3, generator=generator)
    energy[(seed * 7) % 128] = 1e-5  # too weak to be a light; stays in the map
    return Lighting(ambient, energy, sharpness=sharpness)


@pytest.fixture
def written(tmp_path: Path) -> tuple[Rig, Path]:
    rig = make_rig(lighting(), height=32)
    blender.write(rig, tmp_path)
    return rig, tmp_path


class TestWrite:
    def test_files(self, tmp_path: Path) -> None:
        paths = blender.write(make_rig(lighting(), height=32), tmp_path)
        assert sorted(paths) == sorted(tmp_path.iterdir())
        assert len((tmp_path / "README.txt").read_text().splitlines()) == 3

    def test_the_map_is_rolled_for_blender_and_says_so(self, written: tuple[Rig, Path]) -> None:
        rig, folder = written
        environment, header = read_map(folder / "environment.exr")
        assert (header["frame"], header["map"]) == ("blender", "residual")
        torch.testing.assert_close(environment, rig.environment, **HALF_FILE)

    def test_the_document_is_the_rigs(self, written: tuple[Rig, Path]) -> None:
        rig, folder = written
        assert json.loads((folder / "rig.json").read_text()) == rig.document("blender")

    def test_the_script_is_the_extensions_own_module(self, written: tuple[Rig, Path]) -> None:
        script = (written[1] / blender.SCRIPT_NAME).read_bytes()
        assert script == (SOURCE / "scene.py").read_bytes()
        compile(script, blender.SCRIPT_NAME, "exec")

    def test_a_full_map_has_its_lights_switched_off(self, tmp_path: Path) -> None:
        blender.write(make_rig(lighting(), height=16, residual=False), tmp_path)
        document = json.loads((tmp_path / "rig.json").read_text())
        assert document["map"] == "full"
        assert [light["enabled"] for light in document["lights"]] == [False] * len(document["lights"])


class TestExtension:
    def test_holds_every_file_of_the_folder_and_no_other(self) -> None:
        with zipfile.ZipFile(io.BytesIO(blender.extension_zip())) as archive:
            assert archive.testzip() is None
            assert sorted(archive.namelist()) == sorted(p.name for p in SOURCE.iterdir() if p.is_file())
            for name in archive.namelist():
                assert archive.read(name) == (SOURCE / name).read_bytes()

    def test_has_the_same_bytes_every_time(self, tmp_path: Path) -> None:
        blender.write_extension(tmp_path / "a.zip")
        assert (tmp_path / "a.zip").read_bytes() == blender.extension_zip()

    def test_the_manifest_follows_the_documented_schema(self) -> None:
        manifest = tomllib.loads((SOURCE / "blender_manifest.toml").read_text())
        required = ("schema_version", "id", "version", "name", "tagline", "maintainer", "type", "license")
        optional = (
            "tags",
            "permissions",
            "blender_version_max",
            "website",
            "copyright",
            "wheels",
            "platforms",
        )
        assert set(required) | {"blender_version_min"} <= set(manifest)
        assert set(manifest) <= {*required, "blender_version_min", *optional}
        assert manifest["schema_version"] == "1.0.0"
        assert re.fullmatch(r"[a-z][a-z0-9_]*", manifest["id"])
        assert "__" not in manifest["id"]
        assert manifest["type"] == "add-on"
        assert manifest["version"] == mixlight.__version__
        assert re.fullmatch(r"\d+\.\d+\.\d+", manifest["version"])
        assert manifest["blender_version_min"] == "4.2.0"  # the first with extensions
        for text in (manifest["tagline"], *manifest["permissions"].values()):
            assert 0 < len(text) <= 64
            assert text[-1].isalnum()  # no full stop
        assert all(entry.startswith("SPDX:") for entry in manifest["license"])
        assert set(manifest["permissions"]) <= {"files", "network", "clipboard", "camera", "microphone"}
        assert set(manifest["tags"]) <= {"Lighting", "Import-Export", "Render", "World"}

    def test_no_module_reaches_for_the_network_or_for_code_in_files(self) -> None:
        for path in SOURCE.glob("*.py"):
            text = path.read_text()
            assert not re.search(r"\b(urllib|requests|socket|subprocess|eval|exec|pickle)\b", text), path.name


class TestSynthesis:
    """NumPy in Blender and the library in torch say the same."""

    @given(st.integers(0, 10_000), st.integers(0, 6), st.sampled_from([0.0025, 0.02, 0.4]))
    def test_maps_are_the_librarys(self, seed: int, degree: int, sharpness: float) -> None:
        light = lighting(seed, degree, sharpness).to(torch.float64)
        document = to_document(light)
        full = torch.from_numpy(synthesis.full_map(document, 16))
        torch.testing.assert_close(full, light.environment(16), rtol=1e-7, atol=1e-9)
        residual = torch.from_numpy(synthesis.residual_map(document, 16))
        expected = make_rig(light, height=16).environment
        torch.testing.assert_close(residual.float(), expected, rtol=1e-5, atol=1e-6)

    def test_edited_lights_are_the_librarys(self) -> None:
        """Turned anchors, a light that is off, and one too weak to count but for its name."""
        light = edit.turn(lighting(5).to(torch.float64), 0.7)
        first, *_, last = edit.light_names(light)
        light = edit.strengthen(edit.switch(light, first, on=False), last, 1e-7)
        document = to_document(light)
        full = torch.from_numpy(synthesis.full_map(document, 16))
        torch.testing.assert_close(full, light.environment(16), rtol=1e-7, atol=1e-9)
        residual = torch.from_numpy(synthesis.residual_map(document, 16))
        expected = make_rig(light, height=16).environment
        torch.testing.assert_close(residual.float(), expected, rtol=1e-5, atol=1e-6)

    def test_harmonics_are_the_librarys(self) -> None:
        directions = vogel(50, dtype=torch.float64)
        found = torch.from_numpy(synthesis.harmonics(directions.numpy(), 6))
        torch.testing.assert_close(found, harmonics.basis(directions, 6), rtol=1e-12, atol=1e-12)

    def test_anchors_are_the_librarys(self) -> None:
        for count in (1, 2, 128):
            found = np.stack([synthesis.anchor(index, count) for index in range(count)])
            torch.testing.assert_close(torch.from_numpy(found), vogel(count, dtype=torch.float64))

    def test_golden(self) -> None:
        # One lobe of energy 1: its sum over the texels is 1, whatever their size.
        document = {"sources": {"count": 128, "sharpness": 0.0025}}
        lobe = synthesis.lobes_map(document, [[40, 1.0, 2.0, 0.0]], 8)
        weights = np.cos(np.arange(9) * np.pi / 8)
        weights = (weights[:-1] - weights[1:]) * np.pi / 8
        assert (lobe * weights[:, None, None]).sum((0, 1)) == pytest.approx([1, 2, 0])


class TestDocuments:
    def test_a_lighting_becomes_the_rig_that_export_writes(self) -> None:
        light = lighting(3)
        rig = documents.to_rig(to_document(light), separate=True)
        expected = make_rig(light, height=16).document("blender")
        assert rig["map"] == expected["map"] == "residual"
        for ours, theirs in zip(rig["lights"], expected["lights"], strict=True):
            assert ours["name"] == theirs["name"]
            assert ours["enabled"] is theirs["enabled"] is True
            assert ours["direction"] == pytest.approx(theirs["direction"], abs=1e-6)
            assert ours["irradiance"] == pytest.approx(theirs["irradiance"], rel=1e-6)
            assert ours["angular_diameter_deg"] == pytest.approx(theirs["angular_diameter_deg"], abs=1e-3)

    def test_all_in_the_map(self) -> None:
        rig = documents.to_rig(to_document(lighting(3)), separate=False)
        assert rig["map"] == "full"
        assert not any(light["enabled"] for light in rig["lights"])

    def test_without_lights_the_map_is_full(self) -> None:
        rig = documents.to_rig(to_document(Lighting(torch.ones(9, 3), torch.zeros(128, 3))), separate=True)
        assert (rig["map"], rig["lights"]) == ("full", [])

    @pytest.mark.parametrize(
        ("files", "expected"),
        [
            (["lighting.json"], "lighting.json"),
            (["lighting.json", "blender/rig.json"], "blender/rig.json"),
            (["lighting.json", "blender/rig.json", "rig.json"], "rig.json"),
        ],
    )
    def test_what_a_folder_means(self, tmp_path: Path, files: list[str], expected: str) -> None:
        (tmp_path / "blender").mkdir()
        for name in files:
            (tmp_path / name).touch()
        assert documents.resolve(tmp_path) == tmp_path / expected

    def test_a_folder_without_light(self, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match=r"expected a folder with rig.json or lighting.json"):
            documents.resolve(tmp_path)

    def test_what_the_library_writes_is_read(self, tmp_path: Path) -> None:
        save(lighting(5), tmp_path / "lighting.json")
        assert documents.is_rig(tmp_path / "lighting.json") is False
        assert documents.read_lighting(tmp_path / "lighting.json") == to_document(lighting(5))
        blender.write(make_rig(lighting(5), height=16), tmp_path)
        assert documents.is_rig(tmp_path / "rig.json") is True

    @pytest.mark.parametrize(
        ("path", "value"),
        [
            (("version",), 3),
            (("frame",), "blender"),
            (("ambient", "degree"), 3),
            (("ambient", "degree"), 2.5),
            (("ambient", "degree"), 2.0),
            (("ambient", "kind"), "irradiance"),
            (("ambient", "coefficients", 0), [1, 2]),
            (("ambient", "coefficients", 0), [1, 2, float("inf")]),
            (("sources", "sharpness"), 0),
            (("sources", "sharpness"), True),
            (("sources", "anchors"), "fibonacci"),
            (("sources", "energy", 0), [128, 1, 1, 1]),
            (("sources", "energy", 0), [0, 1, 1, -1]),
            (("sources", "energy", 0), 3),
            (("lights", 0, "direction"), [0, 0, 2]),
            (("lights", 0, "irradiance"), [0, 0, -2]),
            (("lights", 0, "name"), None),
            (("lights", 0), {}),
            (("ambient",), None),
        ],
    )
    def test_broken_documents_are_refused(self, tmp_path: Path, path: tuple[Any, ...], value: Any) -> None:
        document: Any = to_document(lighting(5))
        entry = document
        for key in path[:-1]:
            entry = entry[key]
        entry[path[-1]] = value
        file = tmp_path / "lighting.json"
        file.write_text(json.dumps(document))
        with pytest.raises(ValueError, match=r"lighting.json: "):
            documents.read_lighting(file)

    @pytest.mark.parametrize("text", ["", "[1]", "{}", "[" * 100_000, '{"format": "other"}'])
    def test_no_document(self, tmp_path: Path, text: str) -> None:
        (tmp_path / "a.json").write_text(text)
        with pytest.raises(ValueError, match=r"a.json: expected a"):
            documents.is_rig(tmp_path / "a.json")
