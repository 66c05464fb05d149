"""`mixlight insert` with a renderer that needs no program; the real ones are in tests/interop."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from PIL import Image

from mixlight.app.cli import main
from mixlight.image import exr
from mixlight.image.ldr import read_photo
from mixlight.light import document
from mixlight.light.lighting import Lighting
from tests.render.plain_renderer import OBJECT, PlainRenderer


@pytest.fixture(autouse=True)
def renderer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mixlight.app.insert_command._renderer", lambda name: PlainRenderer())


@pytest.fixture
def lighting(tmp_path: Path) -> Path:
    ambient = torch.zeros(9, 3)
    ambient[0] = 3.0
    camera = {"pitch_deg": -20.0, "roll_deg": 0.0, "fov_deg": 60.0, "fov_source": "assumed"}
    record = {"name": "photo.png", "width": 160, "height": 120, "camera": camera}
    path = tmp_path / "lighting.json"
    document.save(document.to_document(Lighting(ambient, torch.zeros(128, 3)), record), path)
    return path


def _photo(folder: Path, name: str = "photo.png") -> Path:
    codes = np.random.default_rng(0).integers(60, 200, (120, 160, 3), np.uint8)
    path = folder / name
    if name.endswith(".exr"):
        exr.write(path, codes.astype(np.float32) / 255)
    elif name.startswith("deep"):
        cv2.imwrite(str(path), codes.astype(np.uint16) * 257)
    else:
        Image.fromarray(codes).save(path)
    return path


def _insert(*arguments: Any) -> int:
    return main(["insert", *(str(argument) for argument in arguments)])


def _read_layers(path: Path) -> dict[str, np.ndarray]:
    import OpenEXR

    file = OpenEXR.File(str(path), separate_channels=True)
    return {name: channel.pixels for name, channel in file.channels().items()}


@pytest.mark.parametrize("name", ["photo.png", "deep.png", "photo.jpg"])
def test_all_pixels_but_objects_and_shadows_are_the_photos_bit_for_bit(
    tmp_path: Path, lighting: Path, name: str
) -> None:
    photo, out, layers = _photo(tmp_path, name), tmp_path / "out.png", tmp_path / "layers.exr"
    assert not _insert(
        photo,
        "--object",
        "teapot",
        "--lighting",
        lighting,
        "--out",
        out,
        "--layers",
        layers,
        "--at",
        "0.5,0.8",
    )
    before, after = (np.asarray(cv2.imread(str(p), cv2.IMREAD_UNCHANGED)) for p in (photo, out))
    assert before.shape == after.shape
    assert before.dtype == after.dtype
    changed = (before != after).any(-1)
    found = _read_layers(layers)
    whole = np.zeros(before.shape[:2], bool)
    region = json_region(tmp_path, photo, lighting)
    mask = (found["mask.Y"] > 0) | np.any([found[f"shadow.{c}"] != 0 for c in "RGB"], axis=0)
    whole[region[1] : region[3], region[0] : region[2]] = mask
    assert not (changed & ~whole).any()
    assert 200 < changed.sum() < 0.5 * changed.size
    inside = np.zeros_like(whole)
    inside[region[1] : region[3], region[0] : region[2]] = found["mask.Y"] == 1
    np.testing.assert_allclose(read_photo(out).linear[inside], OBJECT, atol=0.005)


def json_region(folder: Path, photo: Path, lighting: Path) -> list[int]:
    """The region of the insertion above, as `--json` tells it."""
    import contextlib
    import io

    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        _insert(
            photo, "--object", "teapot", "--lighting", lighting, "--out", folder / "again.png",
            "--at", "0.5,0.8", "--json",
        )  # fmt: skip
    region: list[int] = json.loads(said.getvalue())["region"]
    return region


def test_layers_make_the_composite(tmp_path: Path, lighting: Path) -> None:
    photo, out, layers = _photo(tmp_path, "photo.exr"), tmp_path / "out.exr", tmp_path / "layers.exr"
    assert not _insert(
        photo,
        "--object",
        "chair",
        "--lighting",
        lighting,
        "--out",
        out,
        "--layers",
        layers,
        "--at",
        "0.5,0.8",
    )
    linear, comp = exr.read(photo)[0], exr.read(out)[0]
    found = _read_layers(layers)
    left, top, right, bottom = json_region_of(layers)
    here = linear[top:bottom, left:right]
    beauty, shadow = (np.stack([found[f"{k}.{c}"] for c in "RGB"], -1) for k in ("beauty", "shadow"))
    expected = beauty + (1 - found["mask.Y"])[..., None] * np.maximum(here + shadow, 0)
    np.testing.assert_allclose(comp[top:bottom, left:right], expected, atol=1e-6)
    np.testing.assert_array_equal(found["beauty.A"], found["mask.Y"])
    outside = np.ones(linear.shape[:2], bool)
    outside[top:bottom, left:right] = False
    np.testing.assert_array_equal(comp[outside], linear[outside])


def json_region_of(layers: Path) -> tuple[int, int, int, int]:
    """The data window of an EXR file."""
    import OpenEXR

    (left, top), (right, bottom) = OpenEXR.File(str(layers)).header()["dataWindow"]
    return int(left), int(top), int(right) + 1, int(bottom) + 1


def test_a_map_lights_as_well_as_numbers(tmp_path: Path, lighting: Path, model: Path) -> None:
    sky = tmp_path / "sky.exr"
    exr.write(sky, np.ones((32, 64, 3), np.float32))
    options = [
        "--object",
        "spheres",
        "--pitch-deg",
        "-20",
        "--roll-deg",
        "0",
        "--fov-deg",
        "60",
        "--model",
        model,
    ]
    assert not _insert(_photo(tmp_path), *options, "--lighting", sky, "--out", tmp_path / "a.png")
    assert not _insert(_photo(tmp_path), *options, "--lighting", lighting, "--out", tmp_path / "b.png")
    a, b = (np.asarray(Image.open(tmp_path / f"{name}.png"), float) for name in "ab")
    assert np.abs(a - b).max() <= 1


def test_light_and_pose_are_estimated_where_they_are_not_given(
    tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.png"
    assert not _insert(_photo(tmp_path), "--object", "teapot", "--model", model, "--out", out, "--json")
    said = json.loads(capsys.readouterr().out)
    assert said["camera"] == {
        "pitch_deg": pytest.approx(-8, abs=8),
        "roll_deg": pytest.approx(0, abs=8),
        "fov_deg": 60.0,
    }
    assert said["object_height"] > 0
    assert read_photo(out).size == (160, 120)


@pytest.mark.parametrize(
    ("options", "status", "says"),
    [
        (["--at", "0.5,0.1"], 1, "below the horizon"),
        (["--at", "0.5,1.5"], 1, "inside the photo"),
        (["--at", "nonsense"], 2, "two numbers such as 0.5,0.8"),
        (["--at", "nan,0.5"], 2, "two numbers"),
        (["--scale", "-1"], 2, "a number above 0"),
        (["--scale", "0"], 2, "a number above 0"),
        (["--scale", "900"], 1, "in front of the camera"),
        (["--camera-height", "0.01"], 1, "in front of the camera"),
        (["--object", "missing.glb"], 1, "missing.glb: No such file"),
        (["--object", "OTHER"], 1, "a glTF model"),
        (["--lighting", "OTHER"], 1, "Radiance"),
        (["--lighting", "missing.json"], 1, "missing.json"),
        (["--pitch-deg", "80"], 1, "ground below its horizon"),
        (["--samples", "3"], 2, "whole number"),
        (["--fov-deg", "200"], 2, "between 1 and 170"),
        (["--out", "OUT.jpg"], 2, "ends in .png or .exr"),
        (["--layers", "OUT.png"], 2, "ends in .exr"),
        (["--out", "none/OUT.png"], 1, "No such file"),
    ],
)
def test_bad_calls_end_in_one_line_and_leave_nothing(
    tmp_path: Path,
    lighting: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    status: int,
    says: str,
) -> None:
    photo = _photo(tmp_path)
    (tmp_path / "OTHER").write_text("hello")
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    call = ["--object", "teapot", "--lighting", lighting, "--out", "OUT.png", *options]
    try:
        received = _insert(photo, *call)
    except SystemExit as error:
        received = int(error.code or 0)
    complaint = capsys.readouterr().err
    assert received == status
    assert says in complaint
    assert len(complaint.splitlines()) == 1
    assert sorted(tmp_path.iterdir()) == before


def test_what_is_left_out_of_a_model_is_said(
    tmp_path: Path, lighting: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from tests.render.glb import document as gltf
    from tests.render.glb import write_glb

    found, blob = gltf()
    found["materials"] = [{"alphaMode": "BLEND"}]
    found["meshes"][0]["primitives"][0]["material"] = 0
    model = write_glb(tmp_path / "glass.glb", found, blob)
    assert not _insert(
        _photo(tmp_path), "--object", model, "--lighting", lighting, "--out", tmp_path / "o.png"
    )
    assert "not taken over: transparency" in capsys.readouterr().err
