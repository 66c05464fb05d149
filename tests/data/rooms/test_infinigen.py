"""Infinigen's furniture: asked for, read, left out where a factory fails; infinigen itself is a stand-in."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from mixlight.app import cli
from mixlight.data.rooms import assets, infinigen
from mixlight.data.rooms.assets import AssetsError, install
from mixlight.data.rooms.catalogue import KINDS, Catalogue
from tests.data.rooms.test_assets import fake_run, package

__all__ = ["package"]


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, object]]:
    """A Python that is named, and what a run of it is asked for; sofas fail."""
    asked: list[dict[str, object]] = []

    def run(script: Path, arguments: list[Path], *, timeout: float, blender: Path) -> str:
        assert Path(script).name == "infinigen_furniture.py"
        assert blender == Path(sys.executable)
        listing, folder, report = arguments
        pieces = json.loads(Path(listing).read_text())
        asked.extend(pieces)
        made = {}
        for piece in pieces:
            file = Path(folder) / f"{piece['name']}.obj"
            file.write_text("v 0 0 0\n")
            made[piece["name"]] = {"file": str(file), "size": [0.5, 0.6, 0.9]}
            if piece["factory"] == "SofaFactory":
                made[piece["name"]] = {"error": "ValueError: no finite points"}
        Path(report).write_text(json.dumps({"version": "1.2", "pieces": made}))
        return ""

    monkeypatch.setenv(infinigen.VARIABLE, sys.executable)
    monkeypatch.setattr(infinigen, "run", run)
    return asked


def test_every_factory_is_of_a_known_kind() -> None:
    assert {kind for kind, _, _ in infinigen.FACTORIES} <= KINDS.keys()
    names = [factory for _, _, factory in infinigen.FACTORIES]
    assert len(set(names)) == len(names)


def test_pieces_of_every_factory(installed: list[dict[str, object]], tmp_path: Path) -> None:
    made = infinigen.make(2, tmp_path)
    assert len(installed) == 2 * len(infinigen.FACTORIES)
    assert {piece["seed"] for piece in installed} == {0, 1}
    assert len(made) == len(installed) - 2, "sofas are left out"
    chair = next(model for model in made if model.name == "infinigen-chairfactory-1")
    assert (chair.kind, chair.size, chair.licence) == ("chair", (0.5, 0.6, 0.9), "BSD-3-Clause")
    assert (chair.title, chair.source) == ("ChairFactory(1)", "infinigen 1.2")
    assert chair.file.is_file()


@pytest.mark.usefixtures("installed")
def test_it_joins_the_library_and_is_named(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assets, "run", fake_run)
    made = install(package, tmp_path / "rooms", more=lambda folder: infinigen.make(1, folder))
    assert made == Catalogue.load(tmp_path / "rooms")
    assert made.of("desk")[0].name == "infinigen-simpledeskfactory-0"
    assert made.origin["others"] == {"infinigen 1.2": len(infinigen.FACTORIES) - 1}
    text = (tmp_path / "rooms" / "ATTRIBUTION.txt").read_text()
    assert "infinigen 1.2, BSD-3-Clause <https://opensource.org/license/bsd-3-clause>:" in text


def test_nothing_made_is_an_error(
    installed: list[dict[str, object]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    only = tuple(entry for entry in infinigen.FACTORIES if entry[2] == "SofaFactory")
    monkeypatch.setattr(infinigen, "FACTORIES", only)
    with pytest.raises(AssetsError, match=r"infinigen made nothing .* no finite points"):
        infinigen.make(1, tmp_path)
    assert installed


def test_without_infinigen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv(infinigen.VARIABLE, raising=False)
    assert infinigen.infinigen_python() is None
    with pytest.raises(AssetsError, match="pip install --no-deps infinigen"):
        infinigen.make(1, tmp_path)
    monkeypatch.setenv(infinigen.VARIABLE, str(tmp_path / "python"))
    with pytest.raises(AssetsError, match="is no program"):
        infinigen.infinigen_python()


def test_the_command_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(infinigen.VARIABLE, raising=False)
    monkeypatch.setenv("MIXLIGHT_BLENDER_PYTHON", sys.executable)
    status = cli.main(["rooms", "assets", "--infinigen", "2", "--out", str(tmp_path / "library")])
    assert status == 1
    assert "expected infinigen" in capsys.readouterr().err
    assert not (tmp_path / "library").exists()
