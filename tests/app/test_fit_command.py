import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from mixlight.image import exr, radiance
from mixlight.light import document
from tests.app.conftest import Run
from tests.tolerances import HALF_FILE

pytestmark = pytest.mark.usefixtures("small_previews")

FILES = {"environment.exr", "environment.hdr", "lighting.json", "preview.png", "fit.json"}


def test_a_panorama_becomes_the_five_files(run: Run, panorama: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    status, said, err = run("fit", panorama, "--out", out)
    assert (status, err) == (0, "")
    assert said.startswith(f"{panorama} -> {out / 'studio'}")
    assert {p.name for p in (out / "studio").iterdir()} == FILES
    text = json.loads((out / "studio" / "lighting.json").read_text())
    jsonschema.Draft202012Validator(document.schema()).validate(text)
    rebuilt = document.load(out / "studio" / "lighting.json").environment(128).numpy()
    half, attributes = exr.read(out / "studio" / "environment.exr")
    np.testing.assert_allclose(half, rebuilt, **HALF_FILE)
    assert attributes["frame"] == "mixlight"


def test_the_report_holds_energy_and_errors(run: Run, panorama: Path, tmp_path: Path) -> None:
    status, said, _ = run("fit", panorama, "--out", tmp_path / "out", "--json")
    assert status == 0
    report = json.loads((tmp_path / "out" / "studio" / "fit.json").read_text())
    assert report["format"] == "mixlight/fit"
    assert report["panorama"] == {"name": "studio.hdr", "width": 128, "height": 64}
    assert report["settings"] == {
        "separation": "top_fraction", "fraction": 0.05, "degree": 2, "anchors": 128,
    }  # fmt: skip
    energy = report["energy"]
    assert sum(energy["out"]) == pytest.approx(sum(energy["in"]), rel=5e-3)
    assert abs(energy["error"]) < 5e-3
    assert energy["clamping"] >= 0
    spheres = report["spheres"]
    for name in ("diffuse", "matte", "mirror"):
        assert 0 < spheres[name]["si_rmse"] <= spheres[name]["rmse"] + 1e-7
    assert spheres["diffuse"]["rmse"] < spheres["mirror"]["rmse"]
    # The median of two halves of 0.2 radiance, at an exposure that makes it middle grey.
    assert spheres["gain"] == pytest.approx(0.18 / 0.2, rel=0.05)
    line = json.loads(said)
    assert line["ok"]
    assert line["spheres"]["diffuse"] == spheres["diffuse"]


def test_the_light_is_found_where_the_lamp_is(run: Run, panorama: Path, tmp_path: Path) -> None:
    """The lamp's centre: column 96 of 128 is +X, row 26 of 64 is 16.9 degrees above the horizon."""
    assert run("fit", panorama, "--out", tmp_path / "out", "--separation", "max_fraction")[0] == 0
    light = json.loads((tmp_path / "out" / "studio" / "lighting.json").read_text())["lights"][0]
    elevation = math.radians(90 - 26 / 64 * 180)
    true = np.array([math.cos(elevation), math.sin(elevation), 0])
    assert np.degrees(np.arccos(np.clip(light["direction"] @ true, -1, 1))) < 10


def test_options_reach_the_fit(run: Run, panorama: Path, tmp_path: Path) -> None:
    status, _, _ = run(
        "fit",
        panorama,
        "--out",
        tmp_path / "out",
        "--degree",
        4,
        "--anchors",
        64,
        "--fraction",
        0.1,
        "--height",
        32,
    )
    assert status == 0
    text = json.loads((tmp_path / "out" / "studio" / "lighting.json").read_text())
    assert text["ambient"]["degree"] == 4
    assert len(text["ambient"]["coefficients"]) == 25
    assert text["sources"]["count"] == 64
    assert exr.read(tmp_path / "out" / "studio" / "environment.exr")[0].shape == (32, 64, 3)


def test_exr_and_odd_sizes_are_taken(run: Run, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    for height in (16, 37, 150):
        exr.write(
            tmp_path / f"p{height}.exr", rng.uniform(0.1, 2, (height, 2 * height, 3)).astype(np.float32)
        )
    status, _, err = run("fit", *tmp_path.glob("p*.exr"), "--out", tmp_path / "out")
    assert (status, err) == (0, "")
    for height in (16, 37, 150):
        energy = json.loads((tmp_path / "out" / f"p{height}" / "fit.json").read_text())["energy"]
        assert abs(energy["error"]) < 5e-3


def test_bad_panoramas_end_in_a_line_each(run: Run, panorama: Path, tmp_path: Path) -> None:
    import OpenEXR

    def raw_exr(name: str, pixels: np.ndarray) -> None:
        OpenEXR.File(
            {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": pixels}
        ).write(str(tmp_path / name))

    flat = np.full((16, 32, 3), 0.5, np.float32)
    for name, value in (("nan.exr", np.nan), ("inf.exr", np.inf), ("negative.exr", -1.0)):
        pixels = flat.copy()
        pixels[3, 4, 1] = value
        raw_exr(name, pixels)
    radiance.write(tmp_path / "wide.hdr", np.ones((10, 30, 3), np.float32))
    radiance.write(tmp_path / "black.hdr", np.zeros((16, 32, 3), np.float32))
    radiance.write(tmp_path / "large.hdr", np.ones((256, 512, 3), np.float32))
    (tmp_path / "empty.exr").touch()
    (tmp_path / "text.hdr").write_text("no panorama")
    (tmp_path / "cut.hdr").write_bytes(panorama.read_bytes()[:900])
    bad = {
        "missing.hdr": "No such file",
        "empty.exr": "received an empty file",
        "text.hdr": "expected a Radiance (.hdr) or OpenEXR (.exr) panorama",
        "cut.hdr": "expected",
        "wide.hdr": "expected a 2:1 panorama, received 30 x 10",
        "nan.exr": "received nan at row 3, column 4",
        "inf.exr": "received inf at row 3, column 4",
        "negative.exr": "received -1 at row 3, column 4",
        "black.hdr": "black",
        "large.hdr": "131072",
    }
    status, out, err = run(
        "fit",
        *(tmp_path / name for name in bad),
        panorama,
        "--out",
        tmp_path / "out",
        "--max-megapixels",
        0.1,
    )
    assert status == 1
    assert len(out.splitlines()) == 1
    lines = err.splitlines()
    assert len(lines) == len(bad) + 1
    for (name, says), line in zip(bad.items(), lines, strict=False):
        assert line.startswith(f"mixlight: {tmp_path / name}: ")
        assert says in line
    assert lines[-1] == f"mixlight: {len(bad)} of {len(bad) + 1} inputs failed"
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["studio"]
