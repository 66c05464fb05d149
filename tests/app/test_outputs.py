import os
from pathlib import Path

import pytest

from mixlight.app.outputs import replaced_folder


def _tree(folder: Path) -> dict[str, str]:
    return {str(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*")) if p.is_file()}


def _write_half(folder: Path) -> None:
    with replaced_folder(folder) as fresh:
        (fresh / "lighting.json").write_text("new")
        raise ValueError("half done")


def test_a_new_folder_appears_only_when_it_is_complete(tmp_path: Path) -> None:
    with replaced_folder(tmp_path / "a") as fresh:
        (fresh / "lighting.json").write_text("1")
        assert not (tmp_path / "a").exists()
    assert _tree(tmp_path) == {"a/lighting.json": "1"}


def test_a_failure_leaves_nothing_and_the_older_result_as_it_was(tmp_path: Path) -> None:
    for before in ({}, {"a/lighting.json": "old", "a/notes.txt": "mine"}):
        for name, text in before.items():
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_text(text)
        with pytest.raises(ValueError, match="half done"):
            _write_half(tmp_path / "a")
        assert _tree(tmp_path) == before
        assert {p.name for p in tmp_path.iterdir()} == ({"a"} if before else set())


def test_a_second_run_replaces_its_own_files_and_carries_others_over(tmp_path: Path) -> None:
    with replaced_folder(tmp_path / "a") as fresh:
        (fresh / "lighting.json").write_text("old")
        (fresh / "fit.json").write_text("old")
    (tmp_path / "a" / "notes.txt").write_text("mine")
    (tmp_path / "a" / "deep").mkdir()
    (tmp_path / "a" / "deep" / "scene.blend").write_text("mine too")
    with replaced_folder(tmp_path / "a") as fresh:
        (fresh / "lighting.json").write_text("new")
    assert _tree(tmp_path) == {
        "a/deep/scene.blend": "mine too",
        "a/lighting.json": "new",
        "a/notes.txt": "mine",
    }


def test_a_file_in_the_way_is_refused_and_kept(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("mine")
    with pytest.raises(NotADirectoryError), replaced_folder(tmp_path / "a"):
        raise AssertionError
    assert _tree(tmp_path) == {"a": "mine"}


def test_the_longest_of_names_is_taken(tmp_path: Path) -> None:
    for _ in range(2):
        with replaced_folder(tmp_path / ("x" * 255)) as fresh:
            (fresh / "lighting.json").write_text("1")
    assert _tree(tmp_path) == {f"{'x' * 255}/lighting.json": "1"}


def test_the_folder_has_the_usual_permissions(tmp_path: Path) -> None:
    mask = os.umask(0o022)
    try:
        with replaced_folder(tmp_path / "a"):
            pass
    finally:
        os.umask(mask)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o755
