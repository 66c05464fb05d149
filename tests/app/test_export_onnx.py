"""`mixlight export --for onnx`: a model in place of a light."""

import json
from pathlib import Path
from typing import Any

import pytest

from mixlight.app import cli, export_command
from mixlight.export import onnx as export
from mixlight.export import onnx_precision
from mixlight.network.estimator import Estimator
from tests.export.small_network import small_estimator

pytest.importorskip("onnx")


@pytest.fixture
def small_default(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Every model is a small one; the list tells which were asked for."""
    asked: list[Any] = []

    def load(name: Any = "default") -> Estimator:
        asked.append(name)
        return small_estimator()

    monkeypatch.setattr(Estimator, "load", load)
    return asked


def test_the_precisions_are_those_of_the_export() -> None:
    assert export_command.PRECISIONS == onnx_precision.PRECISIONS == export.PRECISIONS


def test_the_model_is_written_without_any_light(
    small_default: list[Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    call = ["export", "--for", "onnx", "--out", str(tmp_path / "out"), "--precision", "int8", "--json"]
    assert cli.main(call) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["ok"], told["targets"], told["input"]) == (True, ["onnx"], None)
    names = {path.name for path in (tmp_path / "out" / "onnx").iterdir()}
    assert names == {"mixlight.onnx", "mixlight.mjs", "README.txt"}
    assert small_default == ["default"]
    import onnx

    said = {e.key: e.value for e in onnx.load(tmp_path / "out/onnx/mixlight.onnx").metadata_props}
    assert said["precision"] == "int8"


def test_an_unknown_model_is_told_in_one_line_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert cli.main(["export", "--for", "onnx", "--model", "nothing", "--out", str(out)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "unknown model 'nothing'" in line
    assert not out.exists() or not list(out.iterdir())


def test_an_unknown_precision_is_a_wrong_call(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        cli.main(["export", "--for", "onnx", "--precision", "int4", "--out", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert "int4" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
