import json
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mixlight.app import preview
from mixlight.image import exr, radiance
from mixlight.light import document
from mixlight.light.lighting import Lighting
from mixlight.light.transport import MATERIALS
from mixlight.sphere import frames
from tests.app.conftest import Run


def _shown(linear: float) -> object:
    return pytest.approx(int(preview.encode(np.full(3, linear, np.float32))[0]), abs=1)


def _levels(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image).astype(int)


def test_a_uniform_map_shows_flat_spheres_of_the_right_brightness(run: Run, tmp_path: Path) -> None:
    """Under radiance 1 from everywhere a diffuse sphere shows its albedo, a mirror its reflectance."""
    radiance.write(tmp_path / "white.hdr", np.ones((32, 64, 3), np.float32))
    out = tmp_path / "spheres.exr"
    status, said, err = run("render", tmp_path / "white.hdr", "--out", out, "--size", 64)
    assert (status, err) == (0, "")
    assert str(out) in said
    linear, _ = exr.read(out)
    assert linear.shape == (64, 192, 3)
    assert linear[32, 32].tolist() == pytest.approx([MATERIALS[0].reflectance] * 3, rel=0.01)
    assert linear[32, 160].tolist() == pytest.approx([MATERIALS[2].reflectance] * 3, rel=0.01)


def test_the_mirror_shows_what_is_behind_the_photographer_and_right_is_right(
    run: Run, tmp_path: Path
) -> None:
    """A map that is red behind (+Z) and blue at the right (+X)."""
    rgb = np.full((64, 128, 3), 0.01, np.float32)
    rgb[20:44, :10, 0] = rgb[20:44, -10:, 0] = 1.0
    rgb[20:44, 90:102, 2] = 1.0
    exr.write(tmp_path / "card.exr", rgb)
    assert run("render", tmp_path / "card.exr", "--out", tmp_path / "s.exr", "--size", 64)[0] == 0
    mirror = exr.read(tmp_path / "s.exr")[0][:, 128:]
    assert mirror[32, 32, 0] > 0.5
    assert mirror[32, 32, 2] < 0.1
    # +X is reflected where the normal is half-way between +X and +Z: sin 45 of the radius to the right.
    assert mirror[32, 32 + 22, 2] > 0.5
    assert mirror[32, 32 - 22, 2] < 0.1


def test_a_light_and_its_own_map_show_alike(run: Run, tmp_path: Path) -> None:
    ambient, energy = torch.zeros(9, 3), torch.zeros(128, 3)
    ambient[0], energy[40] = 1.0, 2.0
    lighting = Lighting(ambient, energy)
    document.save(document.to_document(lighting, None, None), tmp_path / "lighting.json")
    ours = {"software": "mixlight 0", "frame": "mixlight"}
    exr.write(tmp_path / "map.exr", lighting.environment(128).numpy(), ours)
    rolled = frames.convert_panorama(lighting.environment(128), "mixlight", "blender").numpy()
    exr.write(tmp_path / "blender.exr", rolled, ours | {"frame": "blender"})
    shown = []
    for name in ("lighting.json", "map.exr", "blender.exr"):
        status, said, _ = run(
            "render", tmp_path / name, "--out", tmp_path / f"{name}.png", "--json", "--size", 64
        )
        assert status == 0
        assert json.loads(said)["gain"] == 1.0
        shown.append(_levels(tmp_path / f"{name}.png"))
    assert np.abs(shown[0] - shown[1]).max() <= 2
    assert (shown[1] == shown[2]).all()


def test_a_foreign_map_is_exposed_by_its_median_unless_told(run: Run, tmp_path: Path) -> None:
    radiance.write(tmp_path / "bright.hdr", np.full((32, 64, 3), 1024.0, np.float32))
    status, said, _ = run(
        "render", tmp_path / "bright.hdr", "--out", tmp_path / "s.png", "--json", "--size", 64
    )
    assert status == 0
    assert json.loads(said)["gain"] == pytest.approx(0.18 / 1024, rel=1e-4)
    auto = _levels(tmp_path / "s.png")
    assert auto[auto.shape[0] // 2, auto.shape[1] // 6, 0] == _shown(0.18 * MATERIALS[0].reflectance)
    run("render", tmp_path / "bright.hdr", "--out", tmp_path / "s.png", "--exposure-ev", -10, "--size", 64)
    told = _levels(tmp_path / "s.png")
    assert told[told.shape[0] // 2, told.shape[1] // 6, 0] == _shown(MATERIALS[0].reflectance)


def test_bad_lights_end_in_one_line_and_no_file(run: Run, tmp_path: Path) -> None:
    (tmp_path / "text.json").write_text("{")
    (tmp_path / "other.json").write_text('{"format": "something else"}')
    (tmp_path / "notes.txt").write_text("nothing")
    before = {p.name for p in tmp_path.iterdir()}
    for name in ("text.json", "other.json", "missing.json", "missing.hdr", "notes.txt"):
        status, out, err = run("render", tmp_path / name, "--out", tmp_path / "spheres.png")
        assert (status, out) == (1, "")
        assert err.startswith(f"mixlight: {tmp_path / name}: ")
        assert err.count("\n") == 1
    assert {p.name for p in tmp_path.iterdir()} == before


def test_an_unwritable_picture_is_said_before_any_work(run: Run, panorama: Path, tmp_path: Path) -> None:
    status, _, err = run("render", panorama, "--out", tmp_path / "none" / "spheres.png")
    assert status != 0
    assert str(tmp_path / "none" / "spheres.png") in err
    assert err.count("\n") == 1
