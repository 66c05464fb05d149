"""`mixlight rooms stats`: the table, JSON, the plot, another reference, and sets that are none."""

import json
from pathlib import Path

import pytest
import torch

from mixlight.data.rooms import stats_plot
from mixlight.data.rooms.stats import LABELS, measure
from mixlight.image import radiance
from tests.app.conftest import Run
from tests.synthetic import room


@pytest.fixture
def rooms(tmp_path: Path) -> Path:
    """Three plain rooms of two groups."""
    folder = tmp_path / "rooms"
    folder.mkdir()
    rows = ["file,split,category,group"]
    for k in range(3):
        radiance.write(folder / f"{k}.hdr", (room(64, k) * 0.01).numpy())
        rows.append(f"{k}.hdr,train,room,room-{k // 2}")
    (folder / "rooms.csv").write_text("\n".join(rows) + "\n")
    return folder


@pytest.fixture
def real(tmp_path: Path) -> Path:
    """A table whose indoor training panoramas are two; the others must not count."""
    rows = ["file,split,category"]
    for k, (split, category) in enumerate(
        [("train", "indoor"), ("train", "indoor"), ("test", "indoor"), ("train", "outdoor")]
    ):
        radiance.write(tmp_path / f"real{k}.hdr", room(64, 10 + k).numpy())
        rows.append(f"real{k}.hdr,{split},{category}")
    (tmp_path / "panoramas.csv").write_text("\n".join(rows) + "\n")
    return tmp_path / "panoramas.csv"


def test_the_table_names_every_statistic_and_counts(run: Run, rooms: Path) -> None:
    status, out, err = run("rooms", "stats", rooms)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "3 panoramas of 2 rooms, beside 25 real training interiors"
    for label in LABELS.values():
        assert sum(line.startswith(label) for line in lines) == 1
    inside = out.count("inside the quartiles")
    assert inside + out.count("LOW") + out.count("HIGH") == len(LABELS)
    assert lines[-1].startswith(f"{inside} of 7 medians")


def test_json_holds_the_quantiles(run: Run, rooms: Path) -> None:
    status, out, _ = run("rooms", "stats", rooms, "--json")
    line = json.loads(out)
    assert status == 0
    assert (line["ok"], line["rooms"], line["panoramas"]) == (True, 2, 3)
    assert line["quantiles"] == [0.1, 0.25, 0.5, 0.75, 0.9]
    assert list(line["statistics"]) == list(LABELS)
    assert len(line["reference"]["panoramas"]) == 25
    verdicts = [entry["median"] for entry in line["statistics"].values()]
    assert verdicts.count("inside") == line["inside"]
    medians = sorted(measure(room(64, k)).upper_share for k in range(3))
    assert line["statistics"]["upper_share"]["rooms"][2] == pytest.approx(medians[1], abs=0.002)


def test_against_another_table(run: Run, rooms: Path, real: Path) -> None:
    status, out, _ = run("rooms", "stats", rooms, "--against", real, "--json")
    line = json.loads(out)
    assert status == 0
    assert line["reference"]["panoramas"] == ["real0", "real1"]
    low, high = (measure(room(64, 10 + k)).top_share for k in range(2))
    assert line["statistics"]["top_share"]["reference"][2] == pytest.approx((low + high) / 2, abs=0.002)


def test_a_table_without_interiors_is_no_reference(run: Run, rooms: Path) -> None:
    status, out, err = run("rooms", "stats", rooms, "--against", rooms / "rooms.csv", "--json")
    assert status == 1
    assert "category indoor" in err
    assert not json.loads(out)["ok"]


def test_the_plot(run: Run, rooms: Path, tmp_path: Path) -> None:
    status, _, err = run("rooms", "stats", rooms, "--plot", tmp_path / "plot.png")
    assert (status, err) == (0, "")
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")


def test_no_plot_without_matplotlib_and_before_any_work(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stats_plot, "find_spec", lambda name: None)
    status, out, err = run("rooms", "stats", tmp_path / "nothing", "--plot", tmp_path / "plot.png")
    assert (status, out) == (2, "")
    assert "mixlight[figures]" in err


def test_a_plot_that_is_no_png(run: Run, rooms: Path) -> None:
    status, _, err = run("rooms", "stats", rooms, "--plot", "plot.pdf")
    assert status == 2
    assert ".png" in err


def test_a_bad_room_is_named_and_the_others_are_measured(run: Run, rooms: Path) -> None:
    radiance.write(rooms / "2.hdr", torch.zeros(64, 128, 3).numpy())
    status, out, err = run("rooms", "stats", rooms)
    assert status == 1
    assert err.count("\n") == 1
    assert "2.hdr" in err
    assert out.startswith("2 panoramas of 1 rooms")


@pytest.mark.parametrize("as_json", [False, True])
def test_no_set(run: Run, tmp_path: Path, as_json: bool) -> None:
    status, out, err = run("rooms", "stats", tmp_path, *(["--json"] if as_json else []))
    assert status == 1
    assert "rooms.csv" in err
    assert err.count("\n") == 1
    assert bool(out) == as_json


@pytest.mark.parametrize("recipes", ["0", "-1", "many"])
def test_recipes_are_a_count(run: Run, rooms: Path, recipes: str) -> None:
    status, _, err = run("rooms", "stats", rooms, "--recipes", recipes)
    assert status == 2
    assert "whole number" in err
