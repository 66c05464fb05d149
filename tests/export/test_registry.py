"""The targets by name, and the promises that all of them keep."""

import subprocess
import sys
from pathlib import Path

import pytest

from mixlight.export.readme import write_readme
from mixlight.export.registry import TARGETS, Target, select, write_target
from mixlight.export.rig import make_rig
from tests.export.rigs import lighting

OF_LIGHT = [name for name, target in TARGETS.items() if target.of == "light"]


def test_the_targets_are_these() -> None:
    assert list(TARGETS) == [
        "blender", "three", "gltf", "usd", "unity", "unreal", "arcore", "arkit", "filament", "mitsuba",
        "webxr", "cubemap", "onnx",
    ]  # fmt: skip
    assert all(target.name == name and target.summary for name, target in TARGETS.items())


def test_the_list_of_targets_needs_no_torch_and_no_numpy() -> None:
    code = "import sys, mixlight.export.registry; sys.exit(bool({'torch', 'numpy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_names_are_chosen_once_and_in_their_order() -> None:
    assert [t.name for t in select(["usd, three", "usd"])] == ["usd", "three"]
    assert [t.name for t in select(["all"])] == OF_LIGHT
    assert [t.name for t in select(["onnx,all"])] == ["onnx", *OF_LIGHT]
    assert select([]) == []


@pytest.mark.parametrize("name", ["maya", "", "Blender", "three;usd", "../three"])
def test_an_unknown_name_names_the_known_ones(name: str) -> None:
    with pytest.raises(ValueError, match=r"expected targets out of blender, three, .* or all, received"):
        select([name])


@pytest.mark.parametrize("residual", [True, False])
@pytest.mark.parametrize("name", OF_LIGHT)
def test_each_target_writes_what_it_says_and_three_lines_on_how_to_load_it(
    name: str, residual: bool, tmp_path: Path
) -> None:
    rig = make_rig(lighting(3), height=16, residual=residual)
    paths = write_target(TARGETS[name], rig, tmp_path)
    folder = tmp_path / name
    assert {path for path in folder.rglob("*") if path.is_file()} == set(paths)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    lines = (folder / "README.txt").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 3
    assert all(line.strip() for line in lines)
    off = "switched off" in lines[1] or "written as 0" in lines[1]
    assert off == (not residual)
    unverified = "never run in" in lines[2] or "Unverified" in lines[2]
    assert unverified == (not TARGETS[name].verified)


class _Broken(Target):
    @property
    def write(self) -> object:  # type: ignore[override]
        def half(source: object, folder: Path) -> list[Path]:
            (folder / "half.txt").write_text("half")
            raise ValueError("expected more")

        return half


def test_a_target_that_fails_leaves_the_older_one_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "usd").mkdir()
    (tmp_path / "usd" / "mine.usda").write_text("mine")
    with pytest.raises(ValueError, match="expected more"):
        write_target(_Broken("usd", "", verified=True), "", tmp_path)
    assert [str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")] == ["usd", "usd/mine.usda"]


def test_a_second_run_replaces_its_files_and_leaves_others(tmp_path: Path) -> None:
    rig = make_rig(lighting(3), height=16)
    write_target(TARGETS["unity"], rig, tmp_path)
    (tmp_path / "unity/Editor/mine.cs").write_text("mine")
    (tmp_path / "unity/unity.json").write_text("old")
    write_target(TARGETS["unity"], rig, tmp_path)
    assert (tmp_path / "unity/Editor/mine.cs").read_text() == "mine"
    assert (tmp_path / "unity/unity.json").read_text() != "old"
    assert [path.name for path in tmp_path.iterdir()] == ["unity"]


@pytest.mark.parametrize("line", ["", " ", "two\nlines"])
def test_a_readme_has_three_lines(line: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="expected a line of text"):
        write_readme(tmp_path, make_rig(lighting(3), height=16), line, "checked")
