import json
import math
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import torch
from PIL import Image

import mixlight
from mixlight.app import photos
from mixlight.image import exr, radiance
from mixlight.light import document
from mixlight.light.lighting import Lighting
from mixlight.network.estimator import Estimate, Estimator
from tests.app.conftest import Run, picture
from tests.tolerances import HALF_FILE, RGBE_FILE

pytestmark = pytest.mark.usefixtures("small_previews")

FILES = {"environment.exr", "environment.hdr", "lighting.json", "preview.png"}


class FakeEstimator:
    """Remembers what it was given, and answers with one lamp to the right and a little ambient light."""

    card: dict[str, Any] = {"name": "fake"}  # noqa: RUF012 (never written to)

    def __init__(self) -> None:
        self.seen: list[tuple[torch.Tensor, float]] = []

    def estimate(self, photo: torch.Tensor, fov_x: float) -> Estimate:
        self.seen.append((photo, fov_x))
        ambient, energy = torch.zeros(9, 3), torch.zeros(128, 3)
        ambient[0] = 0.5
        energy[64] = torch.tensor([2.0, 1.5, 1.0])
        energy[3] = 1e-7
        return Estimate(Lighting(ambient, energy), pitch=-0.1, roll=0.02, view=torch.zeros(96, 128, 3))


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> FakeEstimator:
    estimator = FakeEstimator()
    monkeypatch.setattr(Estimator, "load", lambda _: estimator)
    return estimator


def test_a_photo_becomes_the_four_files(run: Run, photo: Path, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    status, said, err = run("estimate", photo, "--out", out, "--model", model)
    assert (status, err) == (0, "")
    assert said.startswith(f"{photo} -> {out / 'room'}")
    assert {p.name for p in (out / "room").iterdir()} == FILES
    assert [p.name for p in out.iterdir()] == ["room"]

    text = json.loads((out / "room" / "lighting.json").read_text())
    jsonschema.Draft202012Validator(document.schema()).validate(text)
    assert text["format"] == "mixlight/lighting"
    assert text["model"]["name"] == "untrained"
    assert text["photo"]["name"] == "room.jpg"
    assert text["photo"]["camera"]["fov_deg"] == 60
    assert text["photo"]["camera"]["fov_source"] == "assumed"
    assert "60 degrees are assumed" in text["photo"]["camera"]["fov_note"]
    assert text["lights"]
    with Image.open(out / "room" / "preview.png") as shown:
        assert shown.mode == "RGB"


def test_the_map_is_rebuilt_from_json_alone_to_half_float(
    run: Run, photo: Path, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    for height in (128, 48):
        assert run("estimate", photo, "--out", out, "--model", model, "--height", height)[0] == 0
        rebuilt = document.load(out / "room" / "lighting.json").environment(height).numpy()
        half, attributes = exr.read(out / "room" / "environment.exr")
        assert half.shape == (height, 2 * height, 3)
        np.testing.assert_allclose(half, rebuilt, **HALF_FILE)
        assert attributes["frame"] == "mixlight"
        assert attributes["exposure_gain"] == 1.0
        assert attributes["model"] == "untrained"
        rgbe, header = radiance.read(out / "room" / "environment.hdr")
        scale = rebuilt.max(-1, keepdims=True)
        assert (np.abs(rgbe - rebuilt) <= RGBE_FILE["rtol"] * scale + 1e-6).all()
        assert header["FRAME"] == "mixlight"
        assert header["MODEL"] == "untrained"


def test_a_second_run_gives_the_same_bytes(run: Run, photo: Path, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    contents = []
    for _ in range(2):
        assert run("estimate", photo, "--out", out, "--model", model)[0] == 0
        contents.append({p.name: p.read_bytes() for p in (out / "room").iterdir()})
    assert contents[0] == contents[1]


def test_photos_of_one_name_keep_apart(run: Run, photo: Path, fake: FakeEstimator, tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    Image.fromarray(picture(90, 70)).save(tmp_path / "b" / "room.png")
    status, said, _ = run("estimate", photo, tmp_path / "b" / "room.png", "--out", tmp_path / "out", "--json")
    assert status == 0
    lines = [json.loads(line) for line in said.splitlines()]
    assert [Path(line["out"]).name for line in lines] == ["room", "room-2"]
    assert all(line["ok"] and line["lights"] == 1 for line in lines)
    names = [json.loads((Path(line["out"]) / "lighting.json").read_text())["photo"]["name"] for line in lines]
    assert names == ["room.jpg", "room.png"]


def test_json_lines_are_as_documented(run: Run, photo: Path, fake: FakeEstimator, tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text()
    good, bad = (json.loads(line) for line in re.findall(r'^\{"input".*\}$', page, re.MULTILINE))
    _, said, _ = run("estimate", photo, tmp_path / "missing.jpg", "--out", tmp_path / "out", "--json")
    lines = [json.loads(line) for line in said.splitlines()]
    assert [list(line) for line in lines] == [list(good), list(bad)]
    assert lines[0]["camera"].keys() == good["camera"].keys()


def test_lobes_too_weak_for_the_json_are_not_in_the_map(
    run: Run, photo: Path, fake: FakeEstimator, tmp_path: Path
) -> None:
    assert run("estimate", photo, "--out", tmp_path / "out")[0] == 0
    sources = json.loads((tmp_path / "out" / "room" / "lighting.json").read_text())["sources"]["energy"]
    assert [index for index, *_ in sources] == [64]


def test_the_field_of_view_is_the_users_else_the_files_else_sixty(
    run: Run, fake: FakeEstimator, tmp_path: Path
) -> None:
    plain, told = tmp_path / "plain.jpg", tmp_path / "told.jpg"
    image = Image.fromarray(picture(100, 150))
    image.save(plain)
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA405] = 18  # FocalLengthIn35mmFilm: 36 mm wide at 18 mm is 90 degrees
    image.save(told, exif=exif)
    status, said, _ = run("estimate", plain, told, "--out", tmp_path / "out", "--json")
    assert status == 0
    cameras = [json.loads(line)["camera"] for line in said.splitlines()]
    assert [camera["fov_source"] for camera in cameras] == ["assumed", "exif"]
    # 35 mm equivalence goes by the diagonal (43.27 mm), and a 3:2 photo has the full 36 mm.
    assert cameras[1]["fov_deg"] == pytest.approx(90, abs=0.1)
    assert [math.degrees(fov) for _, fov in fake.seen] == pytest.approx([60, 90], abs=0.1)
    assert cameras[0]["pitch_deg"] == pytest.approx(math.degrees(-0.1), abs=1e-3)
    assert cameras[0]["roll_deg"] == pytest.approx(math.degrees(0.02), abs=1e-3)

    assert run("estimate", told, "--out", tmp_path / "out", "--fov-deg", 75)[0] == 0
    assert math.degrees(fake.seen[-1][1]) == pytest.approx(75)


@pytest.mark.parametrize("turn", [1, 3, 6, 8])
def test_the_estimator_sees_the_photo_upright_and_linear(
    run: Run, fake: FakeEstimator, tmp_path: Path, turn: int
) -> None:
    """EXIF orientation `turn` is undone: the picture's bright upper right corner comes out there."""
    upright = np.full((80, 120, 3), 55, np.uint8)
    upright[:40, 60:] = 188  # sRGB 188 is 0.503 of the light
    undo = {1: 0, 3: 2, 6: 1, 8: 3}[turn]
    exif = Image.Exif()
    exif[0x0112] = turn
    Image.fromarray(np.rot90(upright, undo)).save(tmp_path / "a.png", exif=exif)
    assert run("estimate", tmp_path / "a.png", "--out", tmp_path / "out")[0] == 0
    seen = fake.seen[0][0]
    assert seen.shape == (80, 120, 3)
    assert seen[20, 90].tolist() == pytest.approx([0.5029] * 3, abs=1e-3)
    assert float(seen[60, 30].max()) < 0.05


def _save_all_kinds(folder: Path) -> list[Path]:
    eight = picture(96, 128)
    paths = []
    for name, image, options in [
        ("rgb.png", Image.fromarray(eight), {}),
        ("gray.png", Image.fromarray(eight[..., 1]), {}),
        ("alpha.png", Image.fromarray(np.dstack([eight, eight[..., 0]])), {}),
        ("palette.png", Image.fromarray(eight).quantize(64), {}),
        ("sixteen.png", Image.fromarray(eight[..., 0].astype(np.uint16) * 257), {}),
        ("photo.webp", Image.fromarray(eight), {"quality": 90}),
        ("scan.tiff", Image.fromarray(eight), {}),
        ("gray.jpg", Image.fromarray(eight[..., 0]), {}),
        ("portrait.jpg", Image.fromarray(picture(200, 90)), {}),
        ("small.jpg", Image.fromarray(picture(64, 64)), {}),
    ]:
        image.save(folder / name, **options)
        paths.append(folder / name)
    linear = (eight.astype(np.float32) / 255) ** 2.2
    exr.write(folder / "linear.exr", linear)
    radiance.write(folder / "linear.hdr", linear * 3)
    return [*paths, folder / "linear.exr", folder / "linear.hdr"]


def test_every_kind_of_photo_is_taken(run: Run, fake: FakeEstimator, tmp_path: Path) -> None:
    paths = _save_all_kinds(tmp_path)
    status, said, err = run("estimate", *paths, "--out", tmp_path / "out", "--height", 32)
    assert (status, err) == (0, "")
    assert len(said.splitlines()) == len(paths)
    assert len(list((tmp_path / "out").iterdir())) == len(paths)
    assert all({p.name for p in folder.iterdir()} == FILES for folder in (tmp_path / "out").iterdir())
    assert all(photo.shape[-1] == 3 and photo.dtype == torch.float32 for photo, _ in fake.seen)


def test_estimate_is_a_function_too(photo: Path, model: Path) -> None:
    by_path = mixlight.estimate(photo, model=model)
    assert isinstance(by_path, Estimate)
    estimator = Estimator.load(model)
    read = mixlight.read_photo(photo)
    by_photo = mixlight.estimate(read, model=estimator)
    by_values = mixlight.estimate(torch.from_numpy(read.linear), model=estimator)
    for other in (by_photo, by_values):
        assert torch.equal(other.lighting.ambient, by_path.lighting.ambient)
        assert torch.equal(other.lighting.energy, by_path.lighting.energy)
    with pytest.raises(ValueError, match="between 1° and 170°, received 180°"):
        mixlight.estimate(photo, fov_x=math.pi, model=estimator)


def test_impossible_angles_are_refused() -> None:
    for bad in (0.0, -1.0, math.nan, math.inf, math.radians(1), math.radians(170)):
        with pytest.raises(ValueError, match="between 1° and 170°"):
            photos.check_fov(bad)
