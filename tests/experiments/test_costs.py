"""Tables of what things cost: written as the benchmarks leave their results."""

import json
from pathlib import Path

import pytest

from benchmarks.__main__ import as_json
from benchmarks.report import basis, cells, save
from benchmarks.rooms import costs
from benchmarks.timing import Result
from experiments.tables import results
from experiments.tables.costs import benchmarks, rooms_cost, spheres_cost
from mixlight.data.rooms.render import Outcome

ABOUT = {
    "commit": "abc",
    "machine": "a box, 2 cores",
    "python": "3.11",
    "mixlight": "1",
    "torch": "2",
    "numpy": "3",
    "seed": 3,
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(results, "FOLDER", tmp_path)
    return tmp_path


def test_a_ratio_is_met_up_to_its_limit(folder: Path) -> None:
    row = as_json(Result("a", "ours", "theirs", 1.3, (1.1, 1.2, 1.4), (2.0, 1.5)), ABOUT)
    assert cells("a", row) == ["a", "ours", "theirs", "2.000 / 1.500", "1.20 (1.10 to 1.40)", "1.3", "met"]
    assert cells("a", row | {"ratio": 1.31})[-1] == "not met"
    assert cells("f", row | {"ratio": 0.00194, "quartiles": [0.0015, 0.002]})[4] == "0.0019 (0.0015 to 0.002)"
    assert benchmarks() == ""
    save(folder / "benchmarks.json", {"rows": {"a": row}})
    text = benchmarks()
    assert "| a | ours | theirs | 2.000 / 1.500 | 1.20 (1.10 to 1.40) | 1.3 | met |" in text
    assert text.count(basis(ABOUT)) == 1


def test_a_room_costs_what_its_parts_cost(folder: Path) -> None:
    outcomes = [
        Outcome(seed, None, core_seconds={"build": 1.0 + seed, "render": 90.0, "denoise": 8.0})
        for seed in (0, 1)
    ]
    found = costs(outcomes, around=1.0)
    assert found["core_seconds"] == {"host": 0.5, "build": 1.5, "render": 90.0, "denoise": 8.0}
    assert found["panoramas_an_hour_and_core"] == 36.0
    assert found["share_not_cycles"] == 0.02
    save(
        folder / "rooms_cost.json",
        {"count": 2, "width": 512, "samples": 16, "provenance": ABOUT} | found,
    )
    text = rooms_cost()
    assert "`python -m benchmarks.rooms --seed 3 --count 2 --width 512`" in text
    assert "| light paths (Cycles) | 90.00 | 90.0 % |" in text
    assert "Not Cycles: 2.0 %; at most 5 % is wanted: met." in text
    with pytest.raises(SystemExit, match="expected a room, got none"):
        costs([], 1.0)


def test_spheres_against_cycles(folder: Path) -> None:
    sphere = {"our_error_percent": 0.161, "samples_for_it": 13991, "cycles_seconds": 2348.07}
    found = {
        "spheres": {"diffuse": sphere}, "maps_per_processor_second": 14.2, "ratio": 110054,
        "cycles_seconds_of_1024_samples": 358.0, "blender": "5.0.1", "provenance": ABOUT,
    }  # fmt: skip
    (folder / "spheres_cost.json").write_text(json.dumps(found))
    text = spheres_cost()
    assert "| diffuse | 0.16 % | 13991 | 2348 s |" in text
    assert "110,000 times as many as Cycles" in text
