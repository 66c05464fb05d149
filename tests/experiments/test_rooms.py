"""Equal trainings but for their data: the tables they get, what is refused, and what the numbers say."""

import argparse
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.rooms import CELLS, Condition, Run, _run, check_equal, summarise, write_tables
from experiments.tables import results
from experiments.tables.rooms import rooms as written
from mixlight.data.panoramas import read_table, select
from mixlight.training.config import read_config
from tests.data.rooms.lit import lit_plan, write_room

SCENES = [f"scene{k // 8}" for k in range(96)]
REAL, ROOMS, BOTH = Condition(92, 0, ()), Condition(0, 50, ("set",)), Condition(92, 50, ("set",))


def a_run(condition: Condition = REAL, seed: int = 0, factor: float = 1.0, noise: float = 0.0) -> Run:
    generator = np.random.default_rng(len(condition.tables) * 10 + seed)
    difficulty = np.exp(np.random.default_rng(9).normal(-1.5, 0.6, (12, 6))).repeat(8, 0)
    cells = difficulty * factor * np.exp(noise * generator.standard_normal((96, 6)))
    return Run(f"run{seed}", condition, seed, {"steps": 300, "tables": "a"}, "abc", 0.3, 150, cells)


@pytest.fixture
def sets(tmp_path: Path) -> Path:
    """A set of four training rooms with two cameras, one for validation; a kept table of three and one."""
    for name, groups, cameras in (("set", 5, 2), ("kept", 4, 1)):
        rows = ["scene,file,split,category,group"]
        for g in range(groups):
            split = "val" if g == groups - 1 else "train"
            for c in range(cameras):
                file = tmp_path / name / f"{g}-{c}.exr"
                file.parent.mkdir(exist_ok=True)
                file.touch()
                rows.append(f"{name}-{g}-{c},{g}-{c}.exr,{split},room,{name}-{g}")
        (tmp_path / name / "rooms.csv").write_text("\n".join(rows) + "\n")
    return tmp_path


def arguments(folder: Path, **changed: object) -> argparse.Namespace:
    given = {
        "rooms": folder / "set",
        "name": None,
        "keep": folder / "kept" / "rooms.csv",
        "real": folder / "panoramas.csv",
        "sizes": [2, 4],
        "seeds": [0, 1],
        "with_kept": False,
        "out": folder / "out",
    }
    return argparse.Namespace(**given | changed)


def test_tables_are_nested_and_share_their_validation(sets: Path) -> None:
    write_tables(arguments(sets))
    small, large = (read_table(sets / "out" / f"set-{size}.csv") for size in (2, 4))
    assert [r.group for r in select(small, "train")] == ["set-0", "set-0", "set-1", "set-1"]
    assert {r.scene for r in select(small, "train")} < {r.scene for r in select(large, "train")}
    assert [r.scene for r in select(small, "val")] == [r.scene for r in select(large, "val")] == ["kept-3-0"]
    assert len(select(large, "train")) == 8  # the set's own validation room is in neither


def test_the_kept_rooms_can_be_trained_on_too(sets: Path) -> None:
    write_tables(arguments(sets, with_kept=True, sizes=[2]))
    found = read_table(sets / "out" / "set-and-rooms-2.csv")
    assert sum(r.scene.startswith("kept") for r in select(found, "train")) == 3
    assert len(select(found, "train")) == 7


def test_trainings_differ_in_their_data_and_rooms_keep_their_share(sets: Path) -> None:
    commands = write_tables(arguments(sets))
    assert len(commands) == 2 * 2 * 2
    configs = {}
    for command in commands:
        words = shlex.split(command)
        assert words[:3] == ["mixlight", "train", "experiments/quick.toml"]
        overrides = dict(w.split("=", 1) for k, w in enumerate(words) if words[k - 1] == "--set")
        import tomllib

        values = {key: tomllib.loads(f"v = {text}")["v"] for key, text in overrides.items()}
        root = Path(__file__).parents[2]
        configs[words[words.index("--out") + 1]] = read_config(root / words[2], values)
    rooms, both = configs["runs/set-4_rooms_1"], configs["runs/set-4_both_1"]
    assert rooms.seed == both.seed == 1
    assert (rooms.members, rooms.camera_views) == (
        1,
        0,
    )  # one training each, whatever the model in the box is
    assert rooms.tables == both.tables == (str(sets / "panoramas.csv"), str(sets / "out" / "set-4.csv"))
    assert {key for key, weight in rooms.sampling.weights.items() if weight} == {"room"}
    assert both.sampling.weights["indoor"] == 2.0
    for size, panoramas in ((2, 4), (4, 8)):
        weight = configs[f"runs/set-{size}_both_0"].sampling.weights["room"]
        assert weight * panoramas == pytest.approx(3.0)  # the kept table has three training panoramas
    same = replace(rooms, sampling=both.sampling, tables=both.tables)
    assert same == both


def test_a_room_that_cannot_be_read_is_left_out(sets: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = write_room(sets / "set" / "lit", lit_plan())
    rows = (sets / "set" / "rooms.csv").read_text().replace("set-0-0,0-0.exr", "set-0-0,lit/camera-0.exr")
    (sets / "set" / "rooms.csv").write_text(rows)
    write_tables(arguments(sets, sizes=[4]))
    before = (sets / "out" / "set-4.csv").read_text()
    assert "lit/camera-0.exr" in before
    files[0].write_bytes(files[0].read_bytes()[:5000])
    write_tables(arguments(sets, sizes=[4]))
    assert (sets / "out" / "set-4.csv").read_text().count("\n") == before.count("\n") - 1
    assert "left out" in capsys.readouterr().err


def test_too_few_rooms(sets: Path) -> None:
    with pytest.raises(SystemExit, match="at least 9 training rooms, got 4"):
        write_tables(arguments(sets, sizes=[9]))


def test_a_run_is_what_its_card_says() -> None:
    card = {
        "data": {"by_category": {"indoor": 25, "room": 540}, "tables": ["panoramas.csv", "new-180.csv"]},
        "config": {"seed": 2, "model": {"height": 96}},
        "commit": "abc",
        "validation": {"score": 0.3, "step": 150.0},
    }
    found = _run("x", card, {"new-180": "180 rooms"}, np.zeros((1, 6)))
    assert found.condition == Condition(25, 540, ("180 rooms",))
    assert found.condition.label == "real and rooms: 180 rooms"
    assert (found.seed, found.step, found.config["model.height"]) == (2, 150, 96)
    card["data"] = {"by_category": {"indoor": 25}, "tables": ["panoramas.csv", "new-180.csv"]}
    assert _run("x", card, {}, np.zeros((1, 6))).condition == Condition(25, 0, ())


def test_runs_that_differ_in_more_than_their_data_are_refused() -> None:
    first = a_run()
    check_equal([first, replace(a_run(BOTH), config={"steps": 300, "tables": "b", "seed": 4, "new": 1})])
    with pytest.raises(SystemExit, match="steps"):
        check_equal([first, replace(first, config={"steps": 600})])
    with pytest.raises(SystemExit, match="96 views, got 8"):
        check_equal([first, replace(first, cells=first.cells[:8])])


def test_the_summary_finds_what_was_put_in() -> None:
    runs = [a_run(condition, seed, factor, 0.05) for seed in range(3)
            for condition, factor in ((BOTH, 0.7), (REAL, 1.0), (ROOMS, 1.0))]  # fmt: skip
    rows = summarise(runs, SCENES)
    assert [row["label"] for row in rows] == ["real only", "rooms only: set", "real and rooms: set"]
    real, rooms, both = (row["cells"]["diffuse_rmse"] for row in rows)
    expected = np.mean([np.median(a_run(REAL, seed, 1.0, 0.05).cells[:, 0]) for seed in range(3)])
    assert real["error"] == pytest.approx(expected, abs=1e-4)
    assert len(real["seeds"]) == 3
    assert "ratio" not in real
    low, high = both["ratio_interval_95"]
    # Panoramas differ by far more than the two trainings do: only the pairing shows the gain.
    assert low < 0.7 < high < 0.8
    assert both["interval_95"][1] > real["interval_95"][0]
    assert rooms["ratio_interval_95"][0] < 1 < rooms["ratio_interval_95"][1]
    assert set(rows[0]["cells"]) == set(CELLS)


def test_an_interval_knows_the_seeds() -> None:
    """Where all panoramas are alike, only the spread of the seeds is left."""
    runs = [replace(a_run(REAL, k), cells=np.full((96, 6), value)) for k, value in enumerate((0.1, 0.2, 0.3))]
    (row,) = summarise(runs, SCENES)
    low, high = row["cells"]["mirror_rmse"]["interval_95"]
    assert row["cells"]["mirror_rmse"]["error"] == pytest.approx(0.2)
    assert 0.1 <= low < 0.15
    assert 0.25 < high <= 0.3
    one = summarise(runs[:1], SCENES)[0]["cells"]["mirror_rmse"]["interval_95"]
    assert one == [0.1, 0.1]


def test_a_seed_may_come_once() -> None:
    with pytest.raises(SystemExit, match="every seed once"):
        summarise([a_run(), a_run()], SCENES)


def test_the_table_of_the_docs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import json

    monkeypatch.setattr(results, "FOLDER", tmp_path)
    assert written() == ""
    result = {
        "split": "test",
        "views": 96,
        "panoramas": sorted(set(SCENES)),
        "categories": ["indoor"],
        "provenance": {"commit": "0123456789abcdef", "machine": "a computer", "protocol": "M"},
        "conditions": summarise([a_run(), a_run(BOTH, factor=0.5)], SCENES),
    }
    (tmp_path / "rooms.json").write_text(json.dumps(result))
    text = written()
    assert "96 photos of 12 panoramas (indoor); commit `0123456789`" in text
    assert "| real and rooms: set | 92 | 50 | 1 |" in text
    assert "0.50 (0.50–0.50)" in text
