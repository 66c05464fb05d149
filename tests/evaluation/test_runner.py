"""Runs that score every method on every photo, go on where they were, and keep what is finished."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.floors import photo_mean_light
from mixlight.evaluation.log import Row, ScoreLog
from mixlight.evaluation.methods import Method
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.evaluation.runner import Outcome, run
from mixlight.image import exr
from mixlight.light.fit import fit
from tests.synthetic import room

SMALL = replace(PROTOCOLS["L"], azimuths=2, photo_height=24, photo_width=32, map_height=32)


def store(folder: Path, scene: str, panorama: Tensor, group: str = "", split: str = "test") -> PanoramaRecord:
    exr.write(folder / f"{scene}.exr", panorama.numpy(), {})
    return PanoramaRecord(scene, folder / f"{scene}.exr", split, "indoor", group or scene)


@pytest.fixture
def records(tmp_path: Path) -> list[PanoramaRecord]:
    return [store(tmp_path, f"room{k}", room(32, k)) for k in range(2)]


class Counted:
    """A method that counts how often it is asked."""

    def __init__(self, name: str, answer: Callable[[EvaluationSample], Tensor], version: str = "1") -> None:
        self.calls: list[str] = []

        def counted(sample: EvaluationSample) -> Tensor:
            self.calls.append(sample.name)
            return answer(sample)

        self.method = Method(name, "network", counted, lambda sample_name: version)


def twice(sample: EvaluationSample) -> Tensor:
    return 2 * sample.environment


def test_every_method_is_scored_on_every_photo_in_order(
    records: list[PanoramaRecord], tmp_path: Path
) -> None:
    methods = [Counted("double", twice).method, Counted("photo", photo_mean_light).method]
    ticks: list[int] = []
    outcome = run(SMALL, records, methods, ScoreLog(tmp_path / "log"), progress=ticks.append)
    assert [(row.method, row.sample) for row in outcome.rows] == [
        (name, f"room{k}_az{azimuth}")
        for name in ("double", "photo")
        for k in range(2)
        for azimuth in ("000", "180")
    ]
    assert outcome.failures == []
    assert sum(ticks) == outcome.scored == 8
    assert all(row.cells["energy_log2"] == pytest.approx(1, abs=1e-4) for row in outcome.rows[:4])
    assert all(math.isnan(row.cells["active_anchors"]) for row in outcome.rows)


def test_a_lighting_tells_its_active_anchors(records: list[PanoramaRecord], tmp_path: Path) -> None:
    method = Method("fit", "oracle", lambda sample: fit(sample.environment), lambda name: "")
    (row, *_) = run(SMALL, records, [method], ScoreLog(tmp_path / "log")).rows
    assert row.cells["active_anchors"] > 0


def test_a_run_goes_on_where_it_was(records: list[PanoramaRecord], tmp_path: Path) -> None:
    log = tmp_path / "log"
    first = Counted("double", twice)
    before = run(SMALL, records[:1], [first.method], ScoreLog(log))
    again, other = Counted("double", twice), Counted("photo", photo_mean_light)
    after = run(SMALL, records, [again.method, other.method], ScoreLog(log))
    assert again.calls == ["room1_az000", "room1_az180"]
    assert len(other.calls) == 4
    assert after.rows[:2] == before.rows
    assert run(SMALL, records, [again.method, other.method], ScoreLog(log)).scored == 0
    assert len(again.calls) == 2


def scored_again(
    records: list[PanoramaRecord], log: Path, version: str = "1", protocol: object = SMALL
) -> list[str]:
    method = Counted("double", twice, version)
    run(protocol, records, [method.method], ScoreLog(log))  # type: ignore[arg-type]
    return method.calls


def test_what_a_score_depends_on_is_known(records: list[PanoramaRecord], tmp_path: Path) -> None:
    log = tmp_path / "log"
    assert len(scored_again(records, log)) == 4
    assert scored_again(records, log) == []
    assert len(scored_again(records, log, version="2")) == 4
    assert len(scored_again(records, log, protocol=replace(SMALL, map_height=16))) == 4
    store(tmp_path, "room1", room(32, 5))
    assert scored_again(records, log) == ["room1_az000", "room1_az180"]
    assert scored_again(records, log) == []


def test_a_line_that_was_cut_off_is_scored_again_and_harms_no_other(
    records: list[PanoramaRecord], tmp_path: Path
) -> None:
    log = tmp_path / "log"
    whole = run(SMALL, records, [Counted("double", twice).method], ScoreLog(log)).rows
    text = log.read_bytes()
    log.write_bytes(text[:-20])
    assert scored_again(records, log) == ["room1_az180"]
    assert scored_again(records, log) == []
    assert run(SMALL, records, [Counted("double", twice).method], ScoreLog(log)).rows == whole
    log.write_bytes(b"\xff{nonsense}\n[]\n" + text)
    assert scored_again(records, log) == []


def failing(name: str, bad: str, answer: Callable[[EvaluationSample], Tensor]) -> Counted:
    def method(sample: EvaluationSample) -> Tensor:
        if sample.name != bad:
            return twice(sample)
        return answer(sample)

    return Counted(name, method)


@pytest.mark.parametrize(
    "answer",
    [
        lambda sample: torch.full((32, 64, 3), math.nan),
        lambda sample: torch.ones(32, 32, 3),
        lambda sample: (_ for _ in ()).throw(FileNotFoundError(2, "No such file", "x.exr")),
    ],
    ids=["NaN", "1:1", "missing"],
)
def test_a_bad_answer_fails_alone_and_what_is_finished_is_kept(
    records: list[PanoramaRecord], tmp_path: Path, answer: Callable[[EvaluationSample], Tensor]
) -> None:
    log = tmp_path / "log"
    bad, good = failing("bad", "room0_az180", answer), Counted("photo", photo_mean_light)
    outcome = run(SMALL, records, [bad.method, good.method], ScoreLog(log))
    assert [failure.source for failure in outcome.failures] == ["bad: room0_az180"]
    assert len(outcome.rows) == 7
    mended = Counted("bad", twice)
    assert run(SMALL, records, [mended.method, good.method], ScoreLog(log)).failures == []
    assert mended.calls == ["room0_az180"]


def test_a_bad_panorama_fails_alone(records: list[PanoramaRecord], tmp_path: Path) -> None:
    square = tmp_path / "square.exr"
    exr.write(square, torch.ones(32, 32, 3).numpy(), {})
    missing = PanoramaRecord("missing", tmp_path / "none.exr", "test", "indoor", "missing")
    bad = PanoramaRecord("square", square, "test", "indoor", "square")
    outcome = run(
        SMALL, [bad, missing, *records], [Counted("double", twice).method], ScoreLog(tmp_path / "l")
    )
    assert [failure.source for failure in outcome.failures] == [str(square), str(missing.path)]
    assert "2:1" in str(outcome.failures[0].error) or "twice" in str(outcome.failures[0].error)
    assert len(outcome.rows) == 4


def test_black_views_are_left_out_and_said(tmp_path: Path) -> None:
    half = torch.zeros(128, 256, 3)
    half[:, 128:160] = 1.0
    outcome = run(
        SMALL, [store(tmp_path, "half", half)], [Counted("a", twice).method], ScoreLog(tmp_path / "log")
    )
    assert [row.sample for row in outcome.rows] == ["half_az000"]
    assert outcome.left_out == ["half_az180"]
    assert isinstance(outcome, Outcome)


def test_bad_input(records: list[PanoramaRecord], tmp_path: Path) -> None:
    log, method = ScoreLog(tmp_path / "log"), Counted("a", twice).method
    with pytest.raises(ValueError, match="got 0 and 1"):
        run(SMALL, [], [method], log)
    with pytest.raises(ValueError, match="'a' twice"):
        run(SMALL, records, [method, method], log)
    with pytest.raises(ValueError, match="expected a renderer for the spheres of protocol M"):
        run(PROTOCOLS["M"], records, [method], log)
    leak = [store(tmp_path, "x", room(32), "home"), store(tmp_path, "y", room(32), "home", "train")]
    with pytest.raises(ValueError, match="'home' in both test and train"):
        run(SMALL, leak, [method], log)
    assert not (tmp_path / "log").exists()


def test_a_log_keeps_what_is_not_defined(tmp_path: Path) -> None:
    row = Row("a_az000", "a", "a", "indoor", 0.0, 1.0, "m", {"x": math.nan, "y": 0.5})
    ScoreLog(tmp_path / "log").add(row, "p")
    found = ScoreLog(tmp_path / "log").find("a_az000", "m", "p")
    assert found is not None
    assert math.isnan(found.cells["x"])
    assert found.cells["y"] == 0.5
    assert ScoreLog(tmp_path / "log").find("a_az000", "m", "other") is None
