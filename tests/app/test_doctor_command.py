"""`mixlight doctor` and the test of the weights behind it."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from mixlight.app import cli, doctor_command, health, self_test
from mixlight.app.health import Check
from mixlight.network.weights import ASSETS


@pytest.fixture
def assets(tmp_path: Path) -> Path:
    """A copy of what ships, to be damaged."""
    folder = tmp_path / "assets"
    (folder / "examples").mkdir(parents=True)
    for path in (*ASSETS.glob("*.safetensors"), ASSETS / self_test.FILE):
        shutil.copy(path, folder)
    shutil.copy(ASSETS / "examples" / self_test.PHOTO, folder / "examples")
    return folder


def test_the_reference_is_of_the_weights_that_ship() -> None:
    expected = json.loads((ASSETS / self_test.FILE).read_text())
    now = {path.name: self_test.digest(path) for path in sorted(ASSETS.glob("*.safetensors"))}
    assert expected["weights"] == now, "weights changed: run `python scripts/write_self_test.py`"


@pytest.mark.slow
def test_what_ships_is_whole_and_gives_its_light() -> None:
    checks = list(self_test.weights(ASSETS))
    assert [check.state for check in checks] == ["ok"] * (len(list(ASSETS.glob("*.safetensors"))) + 1)
    assert checks[-1].name == f"light of {self_test.PHOTO}"


def test_a_single_flipped_bit_is_found(assets: Path) -> None:
    path = assets / "default.safetensors"
    data = bytearray(path.read_bytes())
    data[-1000] ^= 1
    path.write_bytes(data)
    checks = list(self_test.weights(assets))
    found = {check.name: check for check in checks}
    assert found["default.safetensors"].state == "broken"
    assert found["default.safetensors"].command == self_test.REINSTALL
    assert found["efficientnet_lite0_imagenet.safetensors"].state == "ok"
    assert not any(name.startswith("light of") for name in found), "what damaged weights give says nothing"


def test_missing_files_are_told(assets: Path) -> None:
    (assets / "default.safetensors").unlink()
    assert next(c for c in self_test.weights(assets) if c.name.startswith("default")).state == "missing"
    (assets / self_test.FILE).write_text("{")
    (only,) = self_test.weights(assets)
    assert (only.name, only.state) == (self_test.FILE, "missing")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "factor", "state"),
    [("ambient", 1.001, "ok"), ("ambient", 1.03, "broken"), ("sources", -1.0, "broken")],
)
def test_light_may_differ_by_little_only(assets: Path, kind: str, factor: float, state: str) -> None:
    expected = json.loads((assets / self_test.FILE).read_text())
    expected["light"][kind] = [factor * value for value in expected["light"][kind]]
    (assets / self_test.FILE).write_text(json.dumps(expected))
    assert list(self_test.weights(assets))[-1].state == state


@pytest.mark.slow
def test_a_photo_that_is_not_there_is_a_finding(assets: Path) -> None:
    (assets / "examples" / self_test.PHOTO).unlink()
    last = list(self_test.weights(assets))[-1]
    assert last.state == "broken"
    assert self_test.PHOTO in last.detail


@pytest.fixture
def few_checks(monkeypatch: pytest.MonkeyPatch) -> list[Check]:
    """Checks made up, so that the table and the status can be looked at quickly."""
    checks = [
        Check("core", "torch", "ok", "2.13.0"),
        Check("extra", "onnx", "missing", "without onnx", 'pip install "mixlight[onnx]"'),
        Check("program", "Blender", "missing", "none", "python3.11 -m venv"),
    ]
    monkeypatch.setattr(doctor_command, "_checks", lambda: iter(checks))
    return checks


def test_what_is_optional_does_not_fail(few_checks: list[Check], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == "MixLight works."
    assert '$ pip install "mixlight[onnx]"' in [line.strip() for line in lines]


def test_a_broken_core_fails(few_checks: list[Check], capsys: pytest.CaptureFixture[str]) -> None:
    few_checks.insert(
        1, Check("weights", "default.safetensors", "broken", "not the file that shipped", "pip")
    )
    assert cli.main(["doctor"]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "MixLight does not work: default.safetensors."
    assert cli.main(["doctor", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["ok"] is False


def test_json_is_one_line(few_checks: list[Check], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["doctor", "--json"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    told = json.loads(line)
    assert told["ok"] is True
    assert [check["name"] for check in told["checks"]] == ["torch", "onnx", "Blender"]


@pytest.mark.slow
def test_everything_is_looked_at_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    none: list[Check] = []
    monkeypatch.setattr(health, "programs", lambda: none)  # they are looked at in test_health.py
    groups = [check.group for check in doctor_command._checks()]
    order = list(doctor_command._TITLES)
    assert groups == sorted(groups, key=order.index)
    assert {"core", "weights", "extra"} == set(groups)


def test_without_metadata_only_the_requirements_are_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> Any:
        raise health.metadata.PackageNotFoundError("mixlight")

    none: list[Check] = []
    monkeypatch.setattr(health, "requirements", missing)
    monkeypatch.setattr(health, "programs", lambda: none)
    monkeypatch.setattr(self_test, "weights", lambda assets: none)
    checks = list(doctor_command._checks())
    assert [check.name for check in checks] == ["mixlight", "Python", "metadata"]
    assert checks[-1].command == "pip install --editable ."
    assert not any(check.fatal for check in checks)
