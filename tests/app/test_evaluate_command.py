"""`mixlight evaluate`: tables, resuming, predictions of others, and bad input."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mixlight.image import exr
from mixlight.sphere.frames import convert_panorama
from tests.app.conftest import Run
from tests.synthetic import room

FILES = {"results.json", "samples.csv", "samples.json", "scores.jsonl", "table.md", "table.tex"}


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """Two indoor test rooms, one outdoors, one to train on."""
    rows = ["scene,file,category,split,group"]
    for k, (category, split) in enumerate(
        [("outdoor", "test"), ("indoor", "test"), ("indoor", "test"), ("indoor", "train")]
    ):
        exr.write(tmp_path / f"room{k}.exr", room(32, k).numpy(), {})
        rows.append(f"room{k},room{k}.exr,{category},{split},group{k}")
    path = tmp_path / "table.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def quick(table: Path, out: Path, *more: object) -> tuple[object, ...]:
    """Protocol L without networks."""
    return (
        "evaluate",
        "--panoramas",
        table,
        "--protocol",
        "L",
        "--out",
        out,
        "--method",
        "photo-mean",
        *more,
    )


def test_an_evaluation_writes_tables_with_floors_and_ceilings(run: Run, table: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    status, printed, complaints = run(
        "evaluate", "--panoramas", table, "--protocol", "M", "--category", "outdoor", "--out", out,
        "--method", "double=oracle:shh",
    )  # fmt: skip
    assert (status, complaints) == (0, "")
    assert printed == f"protocol M, 8 photos, 10 methods -> {out}/\n"
    assert {path.name for path in out.iterdir()} == FILES
    results = json.loads((out / "results.json").read_text())
    assert results["protocol"]["letter"] == "M"
    assert results["renderer"]["kind"] == "matrix"
    assert results["counts"] == {"outdoor": {"photos": 8, "panoramas": 1, "groups": 1}}
    assert results["provenance"]["seed"] == 0
    methods = ["training-mean", "training-mean-geometric", "photo-mean", "photo-extended"]
    methods += [f"oracle:{name}" for name in ("top_fraction", "max_fraction", "sh2", "gardner19", "emlight")]
    cells = results["tables"]["outdoor"]
    assert list(cells) == [*methods, "double"]
    assert cells["oracle:top_fraction"]["diffuse_rmse"]["mean"] < cells["photo-mean"]["diffuse_rmse"]["mean"]


def test_indoor_and_outdoor_are_tables_apart_with_intervals(run: Run, table: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(*quick(table, out, "--without-floors"))[0] == 0
    results = json.loads((out / "results.json").read_text())
    assert list(results["tables"]) == ["indoor", "outdoor"]
    assert results["counts"]["indoor"] == {"photos": 16, "panoramas": 2, "groups": 2}
    assert results["renderer"] is None
    cell = results["tables"]["indoor"]["photo-mean"]["energy_log2"]
    assert cell["n"] == 16
    assert cell["mean_95"][0] <= cell["mean"] <= cell["mean_95"][1]
    with (out / "samples.csv").open() as file:
        samples = list(csv.DictReader(file))
    assert len(samples) == len(json.loads((out / "samples.json").read_text())["rows"]) == 24
    values = [float(row["energy_log2"]) for row in samples if row["category"] == "indoor"]
    assert cell["mean"] == pytest.approx(np.mean(values), abs=1e-4)
    assert "## outdoor: 8 photos of 1 panoramas" in (out / "table.md").read_text()


def test_a_second_run_takes_what_is_there(run: Run, table: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    first = json.loads(run(*quick(table, out, "--json", "--without-floors"))[1])
    assert (first["ok"], first["scored"]) == (True, 24)
    before = json.loads((out / "results.json").read_text())["tables"]
    again = json.loads(run(*quick(table, out, "--json", "--without-floors"))[1])
    assert again["scored"] == 0
    assert json.loads((out / "results.json").read_text())["tables"] == before
    more = json.loads(run(*quick(table, out, "--json", "--without-floors", "--method", "oracle:sh2"))[1])
    assert more["scored"] == 24
    fresh = json.loads(run(*quick(table, out, "--json", "--without-floors", "--fresh"))[1])
    assert fresh["scored"] == 24


def test_one_category_and_a_folder_of_panoramas(run: Run, table: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(*quick(table, out, "--category", "outdoor", "--without-floors"))
    assert list(json.loads((out / "results.json").read_text())["tables"]) == ["outdoor"]
    folder = tmp_path / "panoramas"
    folder.mkdir()
    exr.write(folder / "hall.exr", room(32, 7).numpy(), {})
    status, _, complaints = run(*quick(folder, tmp_path / "other"))
    assert (status, complaints) == (0, "")
    methods = json.loads((tmp_path / "other/results.json").read_text())["methods"]
    assert "training-mean" not in methods  # nothing to train on in a plain folder
    assert "photo-extended" in methods


def predict(table: Path, photos: Path, folder: Path, frame: str = "mixlight") -> list[Path]:
    """Writes a map for each photo, as another system would: constant light of the photo's mean."""
    written = []
    with (photos / "photos.csv").open() as file:
        for row in csv.DictReader(file):
            pixels = np.asarray(Image.open(photos / row["file"]), dtype=np.float32) / 255
            linear = torch.from_numpy(pixels**2.2).mean((0, 1)).expand(32, 64, 3).contiguous()
            linear = linear.clone()
            linear[10, 5] = 30.0
            path = folder / Path(row["file"]).with_suffix(".exr")
            path.parent.mkdir(parents=True, exist_ok=True)
            exr.write(path, convert_panorama(linear, "mixlight", frame).numpy(), {})
            written.append(path)
    return written


def test_photos_go_out_and_predictions_come_in(run: Run, table: Path, tmp_path: Path) -> None:
    photos, theirs = tmp_path / "photos", tmp_path / "theirs"
    status, printed, _ = run("evaluate", "--panoramas", table, "--protocol", "L", "--photos", photos)
    assert (status, printed) == (0, f"protocol L, 24 photos -> {photos}/\n")
    with (photos / "photos.csv").open() as file:
        (first, *_) = csv.DictReader(file)
    assert first == {
        "file": "room1_az000.png", "scene": "room1", "azimuth_deg": "0", "pitch_deg": "-8", "fov_deg": "60",
        "width": "256", "height": "192",
    }  # fmt: skip
    tables = []
    for frame in ("mixlight", "blender"):
        folder = theirs / frame
        assert len(predict(table, photos, folder, frame)) == 24
        out = tmp_path / f"out-{frame}"
        status, _, complaints = run(
            "evaluate", "--panoramas", table, "--protocol", "L", "--out", out, "--without-floors",
            "--predictions", f"theirs={folder}", "--frame", frame,
        )  # fmt: skip
        assert (status, complaints) == (0, "")
        tables.append(json.loads((out / "results.json").read_text())["tables"])
    assert list(tables[0]["indoor"]) == ["theirs"]
    assert tables[0]["indoor"]["theirs"]["strongest_angle_deg"]["n"] == 16
    for cell, values in tables[0]["indoor"]["theirs"].items():
        assert values == tables[1]["indoor"]["theirs"][cell]


def test_a_bad_prediction_stops_the_tables_and_keeps_the_rest(run: Run, table: Path, tmp_path: Path) -> None:
    photos, theirs, out = tmp_path / "photos", tmp_path / "theirs", tmp_path / "out"
    run("evaluate", "--panoramas", table, "--protocol", "L", "--photos", photos)
    paths = predict(table, photos, theirs)
    good = [path.read_bytes() for path in paths[:3]]
    paths[0].unlink()
    exr.write(paths[1], np.ones((32, 32, 3), np.float32), {})
    paths[2].write_bytes(b"no picture")
    call = quick(table, out, "--without-floors", "--predictions", theirs)
    status, printed, complaints = run(*call)
    assert (status, printed) == (1, "")
    lines = complaints.splitlines()
    assert len(lines) == 4
    assert all(line.startswith("mixlight: ") for line in lines)
    for name in ("room1_az000", "room1_az045", "room1_az090"):
        assert any(name in line for line in lines[:3])
    assert "3 failures: 45 scores are kept" in lines[3]
    assert {path.name for path in out.iterdir()} == {"scores.jsonl"}
    for path, data in zip(paths, good, strict=False):
        path.write_bytes(data)
    status, printed, _ = run(*call, "--json")
    assert (status, json.loads(printed)["scored"]) == (0, 3)
    assert {path.name for path in out.iterdir()} == FILES


def test_a_panorama_that_is_none_fails_alone(run: Run, table: Path, tmp_path: Path) -> None:
    exr.write(tmp_path / "room1.exr", np.ones((32, 32, 3), np.float32), {})
    status, _, complaints = run(*quick(table, tmp_path / "out", "--without-floors"))
    assert status == 1
    first, second = complaints.splitlines()
    assert "room1.exr" in first
    assert "1 failures: 16 scores are kept" in second


def replaced(table: Path, old: str, new: str) -> Path:
    table.write_text(table.read_text().replace(old, new))
    return table


@pytest.mark.parametrize(
    ("change", "arguments", "message"),
    [
        (("group3", "group1"), (), "expected a group on one side of the split"),
        (("room1.exr", "gone.exr"), (), "gone.exr"),
        (("split", "side"), (), "expected the columns file and split"),
        (None, ("--split", "val"), "expected panoramas of val/any category, found only"),
        (None, ("--category", "studio"), "expected panoramas of test/studio"),
        (None, ("--method", "nonsense"), "expected a method out of"),
        (None, ("--method", "photo-mean"), ""),
        (None, ("--frame", "maya", "--predictions", "."), "expected a frame out of mixlight"),
        (None, ("--predictions", "none"), "none: expected a folder of predicted maps"),
        (None, ("--method", "gone.safetensors"), "gone.safetensors"),
    ],
)
def test_wrong_calls_say_so_and_write_nothing(
    run: Run,
    table: Path,
    tmp_path: Path,
    change: tuple[str, str] | None,
    arguments: tuple[str, ...],
    message: str,
) -> None:
    if change is not None:
        replaced(table, *change)
    out = tmp_path / "out"
    status, printed, complaints = run(*quick(table, out, "--without-floors", *arguments))
    assert status != 0
    assert printed == ""
    assert len(complaints.splitlines()) == 1
    assert message in complaints
    assert not out.exists()


def test_one_group_on_two_sides_of_two_tables_is_refused(run: Run, table: Path, tmp_path: Path) -> None:
    other = tmp_path / "more.csv"
    other.write_text("scene,file,split,group\nextra,room3.exr,train,group1\n")
    status, _, complaints = run(*quick(table, tmp_path / "out", "--panoramas", other))
    assert status != 0
    assert "'group1' in both" in complaints


def test_a_folder_holds_one_protocol(run: Run, table: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(*quick(table, out, "--without-floors"))
    status, _, complaints = run(
        "evaluate", "--panoramas", table, "--protocol", "M", "--out", out, "--method", "photo-mean"
    )
    assert status == 2
    assert "received one with results of protocol L" in complaints


def test_an_out_that_is_a_file_is_refused(run: Run, table: Path, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("")
    status, _, complaints = run(*quick(table, tmp_path / "out"))
    assert status == 2
    assert "--out" in complaints
