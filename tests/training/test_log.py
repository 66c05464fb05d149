"""The log: strict JSON lines, cut at the step from which a run goes on."""

import json
import math
import sys
import types
from pathlib import Path
from typing import Any

import pytest

from mixlight.training.log import FILE_NAME, RunLog


def records(folder: Path) -> list[dict[str, Any]]:
    def refuse(word: str) -> None:
        pytest.fail(f"{word} is no JSON")

    lines = (folder / FILE_NAME).read_text("utf-8").splitlines()
    return [json.loads(line, parse_constant=refuse) for line in lines]


def test_records_are_appended_as_strict_json(tmp_path: Path) -> None:
    log = RunLog(tmp_path)
    log.write({"step": 1, "kind": "train", "loss": 0.5, "note": "größer"})
    log.write({"step": 2, "kind": "train", "loss": math.nan, "norm": math.inf})
    log.close()
    assert records(tmp_path) == [
        {"step": 1, "kind": "train", "loss": 0.5, "note": "größer"},
        {"step": 2, "kind": "train", "loss": None, "norm": None},
    ]


def test_a_run_that_goes_on_drops_what_it_will_do_again(tmp_path: Path) -> None:
    log = RunLog(tmp_path)
    for step in (10, 20, 30):
        log.write({"step": step, "kind": "train"})
    with (tmp_path / FILE_NAME).open("a") as file:
        file.write('[1]\n{"kind": "train"}\n{"step": 15, "ki')  # what a kill may leave
    again = RunLog(tmp_path, 20)
    again.write({"step": 25, "kind": "train"})
    assert [record["step"] for record in records(tmp_path)] == [10, 20, 25]


def test_a_fresh_run_begins_a_fresh_log(tmp_path: Path) -> None:
    RunLog(tmp_path).write({"step": 0, "kind": "start"})
    RunLog(tmp_path).write({"step": 10, "kind": "train"})
    assert [record["step"] for record in records(tmp_path)] == [10]


def test_tensorboard_is_asked_for_by_its_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch.utils.tensorboard", None)
    with pytest.raises(ImportError, match=r'pip install "mixlight\[tensorboard\]"'):
        RunLog(tmp_path, tensorboard=True)


def test_numbers_go_to_tensorboard_under_their_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[object, ...]] = []

    class Writer:
        def __init__(self, folder: str, purge_step: int) -> None:
            seen.append((Path(folder).name, purge_step))

        def add_scalar(self, *arguments: object) -> None:
            seen.append(arguments)

        def close(self) -> None:
            seen.append(("closed",))

    module = types.SimpleNamespace(SummaryWriter=Writer)
    monkeypatch.setitem(sys.modules, "torch.utils.tensorboard", module)  # type: ignore[arg-type]
    log = RunLog(tmp_path, 4, tensorboard=True)
    log.write({"step": 5, "kind": "train", "loss": 0.5, "note": "words"})
    log.close()
    assert seen == [("tensorboard", 5), ("train/loss", 0.5, 5), ("closed",)]
