"""`mixlight rooms assets`: what it says when it works and when it cannot."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mixlight.app.cli import main
from mixlight.data.rooms import assets
from tests.data.rooms.test_assets import collection, debian, fake_run


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    blender = tmp_path / "blender"
    blender.write_text("#!/bin/sh\n")
    blender.chmod(0o755)
    monkeypatch.setenv("MIXLIGHT_BLENDER_PYTHON", str(blender))
    monkeypatch.setattr(assets, "run", fake_run)
    path = tmp_path / "sweethome3d-furniture_1.8-1_all.deb"
    path.write_bytes(debian(collection()))
    return path


def test_the_library_is_made_where_the_user_keeps_data(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert main(["rooms", "assets", "--deb", str(package)]) == 0
    folder = tmp_path / "data" / "mixlight" / "rooms"
    assert (folder / "catalogue.json").is_file()
    out, err = capsys.readouterr()
    assert f"1 pieces of furniture -> {folder}" in out
    assert err == ""


def test_json_is_one_line(package: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "elsewhere"
    assert main(["rooms", "assets", "--deb", str(package), "--out", str(folder), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer == {"ok": True, "library": str(folder), "objects": 1, "kinds": {"bed": 1}}


def test_a_wrong_file_is_one_clear_line(
    package: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    package.write_bytes(b"no package")
    assert main(["rooms", "assets", "--deb", str(package), "--out", str(tmp_path / "x")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert "expected a Debian package" in err
    assert not (tmp_path / "x").exists()


def test_a_missing_file_is_one_clear_line(
    package: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    package.unlink()
    assert main(["rooms", "assets", "--deb", str(package), "--out", str(tmp_path / "x")]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_without_blender_nothing_is_fetched(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MIXLIGHT_BLENDER_PYTHON", str(tmp_path / "none"))

    def fetch(_: Path) -> Path:
        raise AssertionError("fetched")

    monkeypatch.setattr(assets, "fetch", fetch)
    assert main(["rooms", "assets", "--out", str(tmp_path / "x")]) == 1
    assert "expected Blender" in capsys.readouterr().err
