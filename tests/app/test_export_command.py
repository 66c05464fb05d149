"""`mixlight export`: targets side by side, each all or none, and every wrong call in one line."""

import json
from pathlib import Path

import pytest
import torch

from mixlight.export import registry
from mixlight.light.document import save
from mixlight.light.lighting import Lighting
from tests.app.conftest import Run


@pytest.fixture
def lighting(tmp_path: Path) -> Path:
    energy = torch.zeros(128, 3)
    energy[20], energy[60], energy[100] = 3.0, 2.0, 1.0
    path = tmp_path / "lighting.json"
    save(Lighting(torch.eye(9)[:, :1].expand(-1, 3).contiguous(), energy), path)
    return path


def export(run: Run, *arguments: object) -> tuple[int, str, str]:
    return run("export", *arguments, "--height", "16")


def test_every_target_gets_its_folder_and_a_line(run: Run, lighting: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    status, said, err = export(run, lighting, "--for", "three,unity", "--for", "arcore", "--out", out)
    assert (status, err) == (0, "")
    assert said.splitlines() == [
        f"{lighting} -> {out / name}/  (residual map, 3 lights on)" for name in ("three", "unity", "arcore")
    ]
    assert sorted(path.name for path in out.iterdir()) == ["arcore", "three", "unity"]
    assert json.loads((out / "unity/unity.json").read_text())["map"] == "residual"


@pytest.mark.parametrize(
    ("options", "count", "kind", "on"),
    [
        ([], 3, "residual", True),
        (["--lights", "2"], 2, "residual", True),
        (["--lights", "all", "--residual"], 3, "residual", True),
        (["--lights", "0"], 0, "full", False),
        (["--no-residual"], 3, "full", False),
    ],
)
def test_the_file_says_what_was_done_with_the_lights(
    run: Run, lighting: Path, tmp_path: Path, options: list[str], count: int, kind: str, on: bool
) -> None:
    status, said, err = export(run, lighting, "--for", "unity", "--json", "--out", tmp_path / "o", *options)
    assert (status, err) == (0, "")
    line = json.loads(said)
    assert (line["ok"], line["targets"], line["failed"]) == (True, ["unity"], {})
    assert (line["map"], line["lights"]) == (kind, count)
    document = json.loads((tmp_path / "o/unity/unity.json").read_text())
    assert document["map"] == kind
    assert [light["enabled"] for light in document["lights"]] == [on] * count


def test_one_target_that_fails_stops_no_other(
    run: Run, lighting: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from mixlight.export import unity

    def refuse(rig: object, folder: Path) -> list[Path]:
        (folder / "half").write_text("half")
        raise ValueError("expected a better light, received this one")

    monkeypatch.setattr(unity, "write", refuse)
    out = tmp_path / "o"
    status, said, err = export(run, lighting, "--for", "unity,arkit", "--json", "--out", out)
    assert status == 1
    assert err == "mixlight: unity: expected a better light, received this one\n"
    line = json.loads(said)
    assert (line["ok"], line["targets"], list(line["failed"])) == (False, ["arkit"], ["unity"])
    assert [path.name for path in out.iterdir()] == ["arkit"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--for", "maya"], "--for: expected targets out of blender, three"),
        (["--for", ""], "--for: expected targets out of"),
        (["--for", "usd", "--lights", "-1"], "--lights: expected a whole number of at least 0, or all"),
        (["--for", "usd", "--lights", "many"], "--lights: expected a whole number of at least 0, or all"),
        (["--for", "usd", "--height", "15"], "--height: expected an even number from 16 to 4096"),
        ([], "--for"),
    ],
)
def test_a_wrong_call_is_said_in_one_line_and_nothing_is_done(
    run: Run, lighting: Path, tmp_path: Path, options: list[str], message: str
) -> None:
    status, said, err = run("export", lighting, "--out", tmp_path / "o", *options)
    assert (status, said) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "o").exists()


def test_no_lighting_and_unwritable_folders_are_refused_before_any_work(
    run: Run, lighting: Path, tmp_path: Path
) -> None:
    status, _, err = run("export", "--for", "usd", "--out", tmp_path / "o")
    assert (status, err.count("\n")) == (2, 1)
    assert "expected a lighting.json to export for usd" in err
    (tmp_path / "file").write_text("mine")
    for bad in (tmp_path / "file", tmp_path / "file" / "below"):
        status, _, err = export(run, lighting, "--for", "usd", "--out", bad)
        assert (status, err.count("\n")) == (2, 1)
        assert err.startswith(f"mixlight: --out {bad}: expected a folder")
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"format": "other"}', "not json", '{"version": NaN}'])
def test_foreign_json_is_refused_by_name(run: Run, tmp_path: Path, text: str) -> None:
    path = tmp_path / "foreign.json"
    path.write_text(text)
    for options in ([], ["--json"]):
        status, said, err = export(run, path, "--for", "usd,three", "--out", tmp_path / "o", *options)
        assert status == 1
        assert err.startswith(f"mixlight: {path}: ")
        assert err.count("\n") == 1
        if options:
            assert json.loads(said)["ok"] is False
    status, _, err = export(run, tmp_path / "missing.json", "--for", "usd", "--out", tmp_path / "o")
    assert (status, err) == (1, f"mixlight: {tmp_path / 'missing.json'}: No such file or directory\n")
    assert not (tmp_path / "o").exists()


def test_help_names_every_target(run: Run) -> None:
    status, said, _ = run("export", "--help")
    assert status == 0
    for name in registry.TARGETS:
        assert name in said
