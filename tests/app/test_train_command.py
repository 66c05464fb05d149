"""`mixlight train`: what reaches the training run, and how every failure ends in one line.

A whole run, killed and resumed through this command, is in `tests/training/test_resume.py`.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from mixlight.app import cli
from mixlight.training.config import TrainingConfig
from tests.app.conftest import Run


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text('tables = ["rooms.csv"]\nsteps = 5\n')
    return path


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch) -> list[tuple[TrainingConfig, Path, dict[str, Any]]]:
    """Calls of the training run, which does nothing."""
    calls: list[tuple[TrainingConfig, Path, dict[str, Any]]] = []

    def train(config: TrainingConfig, out: Path, **options: Any) -> Path:
        calls.append((config, out, options))
        return out / "model.safetensors"

    monkeypatch.setattr("mixlight.training.loop.train", train)
    return calls


def test_a_run_goes_to_a_folder_named_after_its_config(
    run: Run, config: Path, trained: list[tuple[TrainingConfig, Path, dict[str, Any]]]
) -> None:
    status, out, err = run("train", config)
    assert (status, err) == (0, "")
    assert out == f"{config} -> {Path('runs') / 'small' / 'model.safetensors'}\n"
    ((settings, folder, options),) = trained
    assert settings.steps == 5
    assert folder == Path("runs/small")
    assert options == {"resume": True, "cache": None}


def test_options_reach_the_run(
    run: Run, config: Path, tmp_path: Path, trained: list[tuple[TrainingConfig, Path, dict[str, Any]]]
) -> None:
    status, out, _ = run(
        "train", config, "--out", tmp_path / "out", "--cache", tmp_path / "cache", "--fresh", "--json",
        "--set", "steps=9", "--set", "optimiser.learning_rate = 5e-4", "--set", "optimiser.name=adam",
        "--set", "loss.spheres=[1, 0, 0]", "--set", "name = 'a = b'", "--set", "sampling.weights.outdoor=0",
    )  # fmt: skip
    assert status == 0
    assert json.loads(out) == {
        "input": str(config), "ok": True, "out": str(tmp_path / "out" / "model.safetensors"),
    }  # fmt: skip
    ((settings, folder, options),) = trained
    assert (settings.steps, settings.optimiser.learning_rate, settings.optimiser.name) == (9, 5e-4, "adam")
    assert (settings.loss.spheres, settings.name) == ((1.0, 0.0, 0.0), "a = b")
    assert settings.sampling.weights["outdoor"] == 0
    assert folder == tmp_path / "out"
    assert options == {"resume": False, "cache": tmp_path / "cache"}


@pytest.mark.parametrize("pair", ["steps", "=5", " = 5"])
def test_an_override_without_key_or_value_is_a_wrong_call(run: Run, config: Path, pair: str) -> None:
    status, out, err = run("train", config, "--set", pair)
    assert (status, out) == (cli.EXIT_USAGE, "")
    assert err == " ".join(f"mixlight: --set {pair}: expected KEY=VALUE".split()) + "\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--set", "steps=many"), "small.toml: expected a whole number for steps, got 'many'"),
        (("--set", "optimiser.rate=1"), "small.toml: unknown key optimiser.rate"),
        ((), "rooms.csv: expected a CSV table of panoramas, found no such file"),
    ],
)
def test_a_bad_run_ends_in_one_line(
    run: Run, config: Path, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    status, out, err = run("train", config, "--out", tmp_path / "out", *arguments)
    assert (status, out) == (1, "")
    assert says in err
    assert err.count("\n") == 1
    status, out, again = run("train", config, "--out", tmp_path / "out", "--json", *arguments)
    assert (status, again) == (1, err)
    line = json.loads(out)
    assert (line["input"], line["ok"]) == (str(config), False)
    assert says in line["error"]


@pytest.mark.parametrize(
    "error",
    [
        ValueError("expected light"),
        FloatingPointError("expected finite gradients"),
        ImportError('tensorboard = true needs `pip install "mixlight[tensorboard]"`'),
        PermissionError(13, "Permission denied", "out"),
    ],
)
def test_failures_of_a_run_are_told_in_one_line(
    run: Run, config: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("mixlight.training.loop.train", fail)
    status, out, err = run("train", config)
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert err.startswith("mixlight: ")


def test_a_missing_config_is_told(run: Run, tmp_path: Path) -> None:
    status, _, err = run("train", tmp_path / "gone.toml")
    assert status == 1
    assert err == f"mixlight: {tmp_path / 'gone.toml'}: expected a TOML config, found no such file\n"
