"""Files and folders appear whole or not at all."""

import os
import stat
from pathlib import Path

import pytest

from mixlight.image.atomic import atomic_folder, atomic_path


def names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


@pytest.mark.parametrize("durable", [False, True])
def test_the_file_appears_when_the_block_ends(tmp_path: Path, durable: bool) -> None:
    target = tmp_path / "a.exr"
    with atomic_path(target, durable=durable) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".exr"
        assert temporary.exists()
        temporary.write_bytes(b"new")
        assert not target.exists()
    assert target.read_bytes() == b"new"
    assert names(tmp_path) == ["a.exr"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_after_a_failure_the_old_file_stands(tmp_path: Path, error: type[BaseException]) -> None:
    target = tmp_path / "a.txt"
    target.write_text("old")

    def fail() -> None:
        with atomic_path(target) as temporary:
            temporary.write_text("half of the n")
            raise error

    with pytest.raises(error):
        fail()
    assert target.read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


def test_a_writer_that_replaces_or_removes_the_file(tmp_path: Path) -> None:
    with atomic_path(tmp_path / "a") as temporary:
        temporary.unlink()
        temporary.write_text("x")
    assert (tmp_path / "a").read_text() == "x"
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "b") as temporary:
        temporary.unlink()
    assert names(tmp_path) == ["a"]


def test_permissions_follow_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        with atomic_path(tmp_path / "a"):
            pass
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real" / "a")
    with atomic_path(tmp_path / "link") as temporary:
        temporary.write_text("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "a").read_text() == "new"


def test_names_of_the_greatest_length(tmp_path: Path) -> None:
    target = tmp_path / ("n" * 251 + ".txt")
    with atomic_path(target) as temporary:
        temporary.write_text("x")
    assert target.exists()


def test_folders_that_cannot_take_the_file_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"none/a\.txt"), atomic_path(tmp_path / "none" / "a.txt"):
        pass
    with pytest.raises(IsADirectoryError), atomic_path(tmp_path):
        pass
    (tmp_path / "file").write_text("x")
    with pytest.raises(NotADirectoryError, match=r"file/a\.txt"), atomic_path(tmp_path / "file" / "a.txt"):
        pass


def tree(folder: Path) -> dict[str, str]:
    return {str(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_a_folder_takes_the_older_ones_place_and_what_has_no_successor_stays(tmp_path: Path) -> None:
    old = tmp_path / "a"
    for name in ("ours.txt", "same.txt", "deep/same.txt", "deep/mine.txt", "other/mine.txt"):
        (old / name).parent.mkdir(parents=True, exist_ok=True)
        (old / name).write_text("old")
    (old / "file").mkdir()
    (old / "file" / "x").write_text("old")
    with atomic_folder(old, ["ours.txt"]) as fresh:
        (fresh / "deep").mkdir()
        for name in ("same.txt", "deep/same.txt", "file"):
            (fresh / name).write_text("new")
        assert tree(old)["same.txt"] == "old"
    assert tree(old) == {
        "deep/mine.txt": "old", "deep/same.txt": "new", "file": "new", "other/mine.txt": "old",
        "same.txt": "new",
    }  # fmt: skip
    assert names(tmp_path) == ["a"]


def test_a_link_to_a_folder_is_carried_over_as_a_link(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "x").write_text("mine")
    (tmp_path / "a" / "link").symlink_to(tmp_path / "far")
    with atomic_folder(tmp_path / "a"):
        pass
    assert (tmp_path / "a" / "link").is_symlink()
    assert (tmp_path / "far" / "x").read_text() == "mine"


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    for bad in (tmp_path / "file", tmp_path / "none" / "a"):
        with pytest.raises(OSError) as caught, atomic_folder(bad):
            raise AssertionError
        assert caught.value.filename == str(bad)
    assert names(tmp_path) == ["file"]
