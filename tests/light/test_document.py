import copy
import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.image import exr
from mixlight.light import document
from mixlight.light.fit import fit
from mixlight.light.lighting import Lighting
from mixlight.light.lights import merge
from mixlight.light.separate import luminance

PHOTO = {
    "name": "room [1] { x }.jpg",
    "width": 4000,
    "height": 3000,
    "source": "ldr",
    "camera": {"pitch_deg": -8.25, "roll_deg": 0.5, "fov_deg": 60.0, "fov_source": "default"},
}
MODEL = {"name": "default", "metrics": {"diffuse_rmse": 0.1}, "licence": "Apache-2.0"}


def validator() -> Any:
    return jsonschema.Draft202012Validator(document.schema())


def example() -> dict[str, Any]:
    energy = torch.zeros(128, 3)
    energy[7], energy[50] = torch.tensor([1.0, 2.0, 3.0]), 0.1
    ambient = torch.linspace(-1, 1, 27).reshape(9, 3)
    return document.to_document(Lighting(ambient, energy, exposure_gain=0.5), PHOTO, MODEL)


def lightings() -> st.SearchStrategy[Lighting]:
    def make(drawn: tuple[int, int, int, float]) -> Lighting:
        seed, degree, count, decades = drawn
        generator = torch.Generator().manual_seed(seed)
        ambient = torch.randn((degree + 1) ** 2, 3, generator=generator)
        energy = 10 ** (decades * torch.randn(count, 3, generator=generator))
        energy[torch.rand(count, generator=generator) < 0.7] = 0
        return Lighting(ambient, energy)

    return st.tuples(st.integers(0, 99), st.integers(0, 6), st.integers(1, 200), st.floats(0, 3)).map(make)


class TestShape:
    def test_the_schema_is_one(self) -> None:
        jsonschema.Draft202012Validator.check_schema(document.schema())

    def test_golden(self) -> None:
        found = example()
        assert list(found) == [
            "format", "version", "frame", "exposure_gain", "ambient", "sources", "lights", "photo", "model",
        ]  # fmt: skip
        assert (found["format"], found["version"], found["frame"]) == ("mixlight/lighting", 1, "mixlight")
        assert found["exposure_gain"] == 0.5
        ambient = found["ambient"]
        assert {k: v for k, v in ambient.items() if k != "coefficients"} == {
            "kind": "radiance", "basis": "real-sh", "order": "l*l+l+m", "degree": 2,
        }  # fmt: skip
        assert len(ambient["coefficients"]) == 9
        assert ambient["coefficients"][0] == [-1.0, -0.9230769, -0.84615386]
        assert found["sources"] == {
            "anchors": "vogel", "count": 128, "sharpness": 0.0025,
            "energy": [[7, 1.0, 2.0, 3.0], [50, 0.1, 0.1, 0.1]],
        }  # fmt: skip
        assert [light["name"] for light in found["lights"]] == ["light_1", "light_2"]
        assert found["lights"][0]["irradiance"] == pytest.approx([1, 2, 3])
        assert found["lights"][0]["angular_diameter_deg"] == pytest.approx(8.105, abs=1e-3)
        assert (found["photo"], found["model"]) == (PHOTO, MODEL)

    @given(lighting=lightings())
    def test_any_lighting_is_valid_and_comes_back_bit_by_bit(self, lighting: Lighting) -> None:
        made = json.loads(document.dumps(document.to_document(lighting)))
        validator().validate(made)
        again = document.from_document(made)
        assert torch.equal(again.ambient, lighting.ambient)
        assert torch.equal(again.energy, lighting.energy)

    def test_double_precision_comes_back(self) -> None:
        generator = torch.Generator().manual_seed(0)
        lighting = Lighting(
            torch.randn(9, 3, generator=generator).double() / 3,
            torch.rand(16, 3, generator=generator).double() / 3,
        )
        again = document.from_document(document.to_document(lighting), torch.float64)
        assert torch.equal(again.ambient, lighting.ambient)
        assert torch.equal(again.energy, lighting.energy)

    def test_lights_are_the_merged_ones_brightest_first(self, room: Tensor) -> None:
        lighting = fit(room)
        found = document.to_document(lighting)["lights"]
        assert len(found) == len(merge(lighting))
        strengths = [float(luminance(torch.tensor(light["irradiance"]))) for light in found]
        assert strengths == sorted(strengths, reverse=True)

    def test_only_lit_anchors_are_listed(self, room: Tensor) -> None:
        lighting = fit(room)
        found = document.to_document(lighting)["sources"]["energy"]
        assert [entry[0] for entry in found] == lighting.active.tolist()

    def test_shares_nothing_with_the_callers(self) -> None:
        photo: dict[str, Any] = copy.deepcopy(PHOTO)
        made = document.to_document(Lighting(torch.zeros(9, 3), torch.zeros(8, 3)), photo)
        photo["camera"]["fov_deg"] = 1.0
        assert made["photo"] == PHOTO

    @pytest.mark.parametrize("what", ["photo", "model"])
    @pytest.mark.parametrize("value", [math.nan, {1, 2}, torch.zeros(1)])
    def test_no_json(self, what: str, value: object) -> None:
        lighting = Lighting(torch.zeros(9, 3), torch.zeros(8, 3))
        with pytest.raises(ValueError, match=f"{what}: expected what JSON can hold"):
            document.to_document(lighting, **{what: {"x": value}})

    def test_a_batch(self) -> None:
        with pytest.raises(ValueError, match="single lighting"):
            document.to_document(Lighting(torch.zeros(2, 9, 3), torch.zeros(2, 8, 3)))


class TestFile:
    def test_the_map_from_the_text_alone_is_the_exr(self, room: Tensor, tmp_path: Path) -> None:
        lighting = fit(room)
        exr.write(tmp_path / "environment.exr", lighting.environment(128).numpy(), {})
        document.save(lighting, tmp_path / "lighting.json")
        stored, _ = exr.read(tmp_path / "environment.exr")
        rebuilt = document.load(tmp_path / "lighting.json").environment(128)
        assert torch.equal(rebuilt.half().float(), torch.from_numpy(stored))

    def test_rows_of_numbers_stand_on_one_line(self) -> None:
        text = document.dumps(example())
        assert "      [7, 1.0, 2.0, 3.0],\n" in text
        assert '    "name": "room [1] { x }.jpg",\n' in text
        assert text.endswith("}\n")
        assert json.loads(text) == example()

    def test_a_document_can_be_saved_too(self, tmp_path: Path) -> None:
        document.save(example(), tmp_path / "a.json")
        assert document.read(tmp_path / "a.json") == example()

    def test_a_broken_document_leaves_the_old_file(self, tmp_path: Path) -> None:
        document.save(example(), tmp_path / "a.json")
        before = (tmp_path / "a.json").read_bytes()
        with pytest.raises(ValueError, match="version"):
            document.save({**example(), "version": 7}, tmp_path / "a.json")
        assert (tmp_path / "a.json").read_bytes() == before
        assert os.listdir(tmp_path) == ["a.json"]

    @pytest.mark.parametrize(
        ("content", "message"),
        [
            (b"", "Expecting value"),
            (b"\xff\xfe\xff", "decode"),
            (b"[1, 2]", "expected an object"),
            (b"{}", "format: expected 'mixlight/lighting', received None"),
            (b'{"format": NaN}', "expected finite numbers, received NaN"),
            (b"[" * 100_000, "nesting"),
        ],
    )
    def test_what_is_no_document(self, content: bytes, message: str, tmp_path: Path) -> None:
        path = tmp_path / "light.json"
        path.write_bytes(content)
        with pytest.raises(ValueError, match=message) as caught:
            document.load(path)
        assert str(path) in str(caught.value)

    def test_no_file(self, tmp_path: Path) -> None:
        with pytest.raises(FileNotFoundError):
            document.load(tmp_path / "none.json")
        with pytest.raises(OSError, match="none"):
            document.save(example(), tmp_path / "none" / "a.json")


Change = Callable[[dict[str, Any]], object]

BROKEN: list[tuple[str, Change]] = [
    ("the document: expected the entries", lambda d: d.pop("lights")),
    ("the document: expected the entries", lambda d: d.update(extra=1)),
    ("format: expected", lambda d: d.update(format="mixlight/scene")),
    ("version: expected a whole number from 1 to 2, received 3", lambda d: d.update(version=3)),
    ("version: expected a whole number from 1 to 2, received True", lambda d: d.update(version=True)),
    ("frame: expected 'mixlight', received 'blender'", lambda d: d.update(frame="blender")),
    ("exposure_gain: expected a finite number above 0", lambda d: d.update(exposure_gain=0)),
    ("exposure_gain: expected a finite number above 0", lambda d: d.update(exposure_gain="1")),
    ("ambient: expected an object, received None", lambda d: d.update(ambient=None)),
    ("ambient.kind", lambda d: d["ambient"].update(kind="irradiance")),
    ("ambient.basis", lambda d: d["ambient"].update(basis="sh")),
    ("ambient.order", lambda d: d["ambient"].update(order="planar")),
    ("ambient.degree: expected a whole number from 0 to 6", lambda d: d["ambient"].update(degree=7)),
    (
        "ambient.coefficients: expected a list of 16 entries, received 9",
        lambda d: d["ambient"].update(degree=3),
    ),
    (
        r"ambient.coefficients\[4\]: expected a list of 3 entries",
        lambda d: d["ambient"]["coefficients"][4].pop(),
    ),
    (
        r"ambient.coefficients\[0\]\[1\]: expected a finite number, received None",
        lambda d: d["ambient"]["coefficients"].__setitem__(0, [0, None, 0]),
    ),
    ("ambient: expected the entries", lambda d: d["ambient"].update(extra=1)),
    ("sources.anchors: expected 'vogel'", lambda d: d["sources"].update(anchors="fibonacci")),
    ("sources.count: expected a whole number", lambda d: d["sources"].update(count=0)),
    ("sources.sharpness", lambda d: d["sources"].update(sharpness=-1)),
    ("sources.energy: expected a list", lambda d: d["sources"].update(energy={})),
    (r"sources.energy\[0\]: expected a list of 4", lambda d: d["sources"]["energy"][0].pop()),
    (r"sources.energy\[1\]\[0\]", lambda d: d["sources"]["energy"][1].__setitem__(0, -1)),
    (r"sources.energy\[1\]\[0\]", lambda d: d["sources"]["energy"][1].__setitem__(0, 3.5)),
    (
        r"sources.energy\[1\]\[2\]: expected a finite number of at least 0, received -1",
        lambda d: d["sources"]["energy"][1].__setitem__(3, -1),
    ),
    ("sources: expected the entries", lambda d: d["sources"].pop("count")),
    ("lights: expected a list", lambda d: d.update(lights=None)),
    (r"lights\[0\]: expected the entries", lambda d: d["lights"][0].update(colour=[1, 1, 1])),
    (r"lights\[0\].name: expected a name", lambda d: d["lights"][0].update(name="")),
    (r"lights\[1\].direction: expected a list of 3", lambda d: d["lights"][1].update(direction=[1, 0])),
    (r"lights\[0\].irradiance\[2\]", lambda d: d["lights"][0].update(irradiance=[1, 1, -1])),
    (r"lights\[0\].angular_diameter_deg", lambda d: d["lights"][0].update(angular_diameter_deg=400)),
    ("photo: expected an object", lambda d: d.update(photo="a.jpg")),
    ("photo.name: expected a text", lambda d: d["photo"].update(name=3)),
    ("photo.width: expected a whole number", lambda d: d["photo"].update(width=0)),
    ("photo.camera: expected an object", lambda d: d["photo"].update(camera=60)),
    ("photo.camera.pitch_deg", lambda d: d["photo"]["camera"].update(pitch_deg=91)),
    ("photo.camera.roll_deg", lambda d: d["photo"]["camera"].update(roll_deg=-181)),
    ("photo.camera.fov_deg: .* above 0 and below 180", lambda d: d["photo"]["camera"].update(fov_deg=180)),
    ("photo.camera.fov_source", lambda d: d["photo"]["camera"].update(fov_source=None)),
    ("model: expected an object", lambda d: d.update(model=[])),
    ("model.name: expected a text", lambda d: d["model"].update(name=1)),
]

BEYOND_THE_SCHEMA: list[tuple[str, Change]] = [
    (
        r"sources.energy\[1\]\[0\]: expected a whole number from 0 to 127, received 128",
        lambda d: d["sources"]["energy"][1].__setitem__(0, 128),
    ),
    (
        r"sources.energy\[1\]\[0\]: expected every anchor at most once, received 7",
        lambda d: d["sources"]["energy"][1].__setitem__(0, 7),
    ),
    (
        r"lights\[0\].direction: expected a vector of length 1",
        lambda d: d["lights"][0].update(direction=[1, 1, 0]),
    ),
    ("exposure_gain", lambda d: d.update(exposure_gain=math.inf)),
]


class TestCheck:
    def test_the_example_is_valid(self) -> None:
        validator().validate(example())
        document.from_document(example())

    @pytest.mark.parametrize(("message", "change"), BROKEN)
    def test_broken(self, message: str, change: Change) -> None:
        broken = example()
        change(broken)
        with pytest.raises(ValueError, match=message):
            document.from_document(broken)
        assert not validator().is_valid(broken), "the schema lets through what from_document refuses"

    @pytest.mark.parametrize(("message", "change"), BEYOND_THE_SCHEMA)
    def test_broken_beyond_what_a_schema_can_say(self, message: str, change: Change) -> None:
        broken = example()
        change(broken)
        with pytest.raises(ValueError, match=message):
            document.from_document(broken)

    def test_what_may_be_missing_or_more(self) -> None:
        loose = example()
        loose["photo"] = {"camera": {"fov_note": "guessed"}, "taken": "at noon"}
        loose["model"] = {}
        loose["lights"] = []
        loose["sources"]["energy"] = []
        validator().validate(loose)
        assert document.from_document(loose).active.tolist() == []
        loose["photo"] = loose["model"] = None
        validator().validate(loose)
        document.from_document(loose)

    def test_long_values_are_cut_short(self) -> None:
        with pytest.raises(ValueError) as caught:
            document.from_document({"format": "x" * 10_000})
        assert len(str(caught.value)) < 120
