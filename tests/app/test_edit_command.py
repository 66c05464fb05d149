import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
import torch

from mixlight.app import cli
from mixlight.image import exr, radiance
from mixlight.light import document
from mixlight.light.lighting import Lighting
from tests.app.conftest import Run
from tests.tolerances import HALF_FILE

PHOTO = {"name": "room.jpg", "camera": {"pitch_deg": -5.0, "roll_deg": 0.0, "fov_deg": 60.0}}


@pytest.fixture
def lighting() -> Lighting:
    ambient, energy = torch.zeros(9, 3), torch.zeros(128, 3)
    ambient[0], ambient[2] = 2.0, 0.5
    energy[40], energy[100] = torch.tensor([4.0, 3.0, 2.0]), torch.tensor([0.5, 1.0, 1.0])
    return Lighting(ambient, energy)


@pytest.fixture
def source(lighting: Lighting, tmp_path: Path) -> Path:
    path = tmp_path / "lighting.json"
    document.save(document.to_document(lighting, PHOTO, {"name": "net"}), path)
    return path


def test_every_change_at_once_and_the_source_stays(
    run: Run, source: Path, lighting: Lighting, tmp_path: Path
) -> None:
    before = source.read_bytes()
    out = tmp_path / "new.json"
    status, said, err = run(
        "edit", source, "--rotate-deg", "-90", "--exposure-ev", "1", "--temperature", "6504",
        "--light", "light_1=x2", "--light", "light_2=off", "--out", out,
    )  # fmt: skip
    assert (status, err) == (0, "")
    assert said == f"{source} -> {out}  (on: light_1; off: light_2)\n"
    assert source.read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["lighting.json", "new.json"]
    text = document.read(out)
    assert (text["photo"], text["model"]) == (PHOTO, {"name": "net"})
    again = document.from_document(text)
    assert math.degrees(again.turn) == pytest.approx(-90)
    torch.testing.assert_close(again.energy[40], lighting.energy[40] * 4)
    assert float(again.energy[100].sum()) == 0
    assert again.exposure_gain == 2
    # Ambient light from behind (+Z) comes from the right (+X) after a quarter turn to the left.
    assert again.ambient[3].tolist() == pytest.approx([1.0] * 3, abs=1e-5)


def test_a_folder_gets_the_maps_of_the_new_light(run: Run, source: Path, tmp_path: Path) -> None:
    out = tmp_path / "warm"
    (tmp_path / "warm").mkdir()
    (out / "preview.png").write_bytes(b"of an older light")
    (out / "notes.txt").write_text("mine")
    assert run("edit", source, "--temperature", "3000", "--height", "32", "--out", out)[0] == 0
    assert {p.name for p in out.iterdir()} == {
        "environment.exr", "environment.hdr", "lighting.json", "notes.txt",
    }  # fmt: skip
    half, attributes = exr.read(out / "environment.exr")
    rebuilt = document.load(out / "lighting.json").environment(32).numpy()
    np.testing.assert_allclose(half, rebuilt, **HALF_FILE)
    assert attributes["model"] == "net"
    assert "detail" not in attributes
    assert radiance.read(out / "environment.hdr")[0].shape == (32, 64, 3)


def test_off_and_on_again_through_files(run: Run, source: Path, lighting: Lighting, tmp_path: Path) -> None:
    dark, again = tmp_path / "dark.json", tmp_path / "again.json"
    assert run("edit", source, "--light", "light_1=off", "--out", dark)[0] == 0
    status, said, _ = run("edit", dark, "--light", "light_1=on", "--out", again, "--json")
    assert status == 0
    line = json.loads(said)
    assert (line["ok"], line["lights"], line["off"]) == (True, ["light_1", "light_2"], [])
    assert torch.equal(document.load(again).energy, lighting.energy)
    assert document.load(dark).total_energy().tolist() != lighting.total_energy().tolist()


def test_the_photos_pixels_are_no_longer_in_the_map_and_it_is_said(
    run: Run, lighting: Lighting, tmp_path: Path
) -> None:
    source = tmp_path / "a.json"
    photo = {**PHOTO, "detail": {"source": "photo", "share_of_sphere": 0.06, "opacity": 1.0}}
    document.save(document.to_document(lighting, photo), source)
    status, said, _ = run("edit", source, "--exposure-ev", "1", "--out", tmp_path / "b.json")
    assert status == 0
    assert "without the photo's own pixels" in said
    assert document.read(tmp_path / "b.json")["photo"] == PHOTO


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((), "expected something to change"),
        (("--rotate-deg", "nan"), "expected an angle in degrees, received 'nan'"),
        (("--rotate-deg", "left"), "expected an angle in degrees, received 'left'"),
        (("--exposure-ev", "inf"), "stops from -40 to 40, received 'inf'"),
        (("--temperature", "900"), "from 2000 to 15000 kelvin, received '900'"),
        (("--temperature", "nan"), "from 2000 to 15000 kelvin, received 'nan'"),
        *(
            (("--light", bad), f"NAME=off or NAME=xSTRENGTH with a strength above 0, received '{bad}'")
            for bad in ("light_1", "a=", "=on", "a=x", "a=x0", "a=x-2", "a=xnan", "a=2", "a=ON", "")
        ),
    ],
)  # fmt: skip
def test_a_wrong_call_is_refused_before_any_work(
    run: Run, source: Path, tmp_path: Path, options: tuple[str, ...], says: str
) -> None:
    status, said, err = run("edit", source, *options, "--out", tmp_path / "b.json")
    assert (status, said) == (cli.EXIT_USAGE, "")
    assert says in err
    assert err.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["lighting.json"]


def test_nothing_is_edited_in_place(run: Run, source: Path, tmp_path: Path) -> None:
    (tmp_path / "link.json").symlink_to(source)
    for out in (source, tmp_path, tmp_path / "link.json"):
        status, _, err = run("edit", source, "--exposure-ev", "1", "--out", out)
        assert status == cli.EXIT_USAGE
        assert "expected another place" in err
    for out, says in (
        (tmp_path / "b.txt", "ends in .json, or a folder"),
        (tmp_path / "d.json", "a folder of"),
    ):
        if out.name == "d.json":
            out.mkdir()
        status, _, err = run("edit", source, "--exposure-ev", "1", "--out", out)
        assert status == cli.EXIT_USAGE
        assert says in err


@pytest.mark.parametrize("as_json", [False, True])
def test_an_unknown_light_names_the_known_ones(run: Run, source: Path, tmp_path: Path, as_json: bool) -> None:
    options = ["--json"] if as_json else []
    status, said, err = run("edit", source, "--light", "lamp=off", "--out", tmp_path / "b.json", *options)
    assert status == 1
    assert err == f"mixlight: {source}: expected a light out of light_1, light_2, received 'lamp'\n"
    assert (json.loads(said)["ok"] is False) if as_json else said == ""
    assert not (tmp_path / "b.json").exists()


@pytest.mark.parametrize("content", ["", "{}", '{"format": "mixlight/lighting", "version": 3}', "[NaN]"])
def test_what_is_no_light_ends_in_one_line(run: Run, tmp_path: Path, content: str) -> None:
    bad = tmp_path / "bad.json"
    bad.write_text(content)
    status, said, err = run("edit", bad, "--exposure-ev", "1", "--out", tmp_path / "out")
    assert (status, said) == (1, "")
    assert err.startswith(f"mixlight: {bad}: ")
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()
    assert run("edit", tmp_path / "none.json", "--exposure-ev", "1", "--out", tmp_path / "out")[0] == 1


def test_a_light_without_lights(run: Run, tmp_path: Path) -> None:
    source = tmp_path / "dark.json"
    document.save(Lighting(torch.zeros(9, 3), torch.zeros(128, 3)), source)
    status, said, _ = run("edit", source, "--rotate-deg", "30", "--out", tmp_path / "b.json")
    assert (status, "on: none" in said) == (0, True)
    status, _, err = run("edit", source, "--light", "light_1=on", "--out", tmp_path / "c.json")
    assert status == 1
    assert "there is none" in err


def test_the_python_of_the_docs_runs(source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[2] / "docs" / "editing.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    (tmp_path / "light" / "photo").mkdir(parents=True)
    source.rename(tmp_path / "light" / "photo" / "lighting.json")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "editing.md", "exec"), {})
    edited = document.load("edited.json")
    assert math.degrees(edited.turn) == pytest.approx(30)
    assert [group.name for group in edited.groups if group.off is not None] == ["light_2"]


def test_the_table_of_temperatures_is_the_librarys() -> None:
    from mixlight.image.temperature import white_point_gain

    page = (Path(__file__).parents[2] / "docs" / "editing.md").read_text()
    rows = re.findall(r"^\| (\d+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE)
    assert len(rows) == 7
    for kelvin, *gains in rows:
        assert [f"{gain:.3f}" for gain in white_point_gain(float(kelvin))] == gains


def test_edited_lights_go_to_other_programs_under_their_names(run: Run, source: Path, tmp_path: Path) -> None:
    """What is off is in neither map nor lights; the rest keeps its names although the order has changed."""
    from mixlight.export.rig import make_rig
    from mixlight.sphere import equirect

    out = tmp_path / "new.json"
    assert run("edit", source, "--light", "light_1=off", "--light", "light_2=x9", "--out", out)[0] == 0
    edited = document.load(out)
    rig = make_rig(edited, height=64)
    assert [light.name for light in rig.lights] == ["light_2"]
    expected = equirect.integrate(edited.environment(64)) - edited.energy.sum(0)
    torch.testing.assert_close(equirect.integrate(rig.environment), expected, rtol=1e-5, atol=1e-6)
