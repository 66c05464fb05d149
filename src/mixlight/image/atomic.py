"""Files and folders that appear whole or not at all."""

import contextlib
import os
import secrets
import shutil
from collections.abc import Collection, Iterator
from pathlib import Path

__all__ = ["atomic_folder", "atomic_path"]


@contextlib.contextmanager
def atomic_path(path: str | os.PathLike[str], *, durable: bool = False) -> Iterator[Path]:
    """Gives a temporary name beside `path` that becomes `path` when the block ends, and vanishes when it
    fails.

    The temporary file lies in the same folder (a rename is atomic only within one file system), is hidden,
    keeps the suffix of `path` for writers that look at it, and exists empty from the start, so that a folder
    without write permission shows before any work is done. A symbolic link is followed: the file it points to
    is replaced.

    Convention: readers see either the old file or the complete new one; two writers may race, and the last
    rename stands.

    Args:
        path: the file to be made; its folder must exist.
        durable: flush to the disk before the rename, so that the file survives a power cut and not only a
            kill.

    Raises:
        OSError: the folder is missing or not writable, or `path` is a folder; the error names `path`.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with atomic_path(Path(folder) / "a.txt") as temporary:
    ...         _ = temporary.write_text("light")
    ...     [p.name for p in Path(folder).iterdir()]
    ['a.txt']
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise IsADirectoryError(21, "Is a directory, and cannot be replaced by a file", str(path))
    temporary = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(6)}.part{target.suffix}")
    try:
        # 0o666 less the umask: what open() would give. tempfile.mkstemp's 0o600 would lock other users out.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    try:
        yield temporary
        if durable:
            with open(temporary, "rb+") as file:
                os.fsync(file.fileno())
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def atomic_folder(folder: Path, ours: Collection[str] = ()) -> Iterator[Path]:
    """Gives a hidden new folder beside `folder`, which takes its place when the block ends and vanishes when
    it fails.

    An older `folder` stays untouched until the new one is complete. What lies in it and has no successor of
    its name in the new one is carried over, at any depth, whatever it is; except for top-level names that are
    `ours`: these are of an earlier result and go with it.

    Args:
        folder: the folder to be made; its parent must exist.
        ours: names that no other program would give to its files.

    Raises:
        OSError: the folder's parent cannot be written to, or `folder` is a file.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as parent:
    ...     with atomic_folder(Path(parent) / "a") as fresh:
    ...         _ = (fresh / "light.txt").write_text("on")
    ...     [str(p.relative_to(parent)) for p in Path(parent).rglob("*.txt")]
    ['a/light.txt']
    """
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(20, "Expected a folder or nothing, received a file", str(folder))
    short = folder.name[:50]  # the hidden names must fit where the long name just does
    fresh = folder.with_name(f".{short}.{os.getpid()}.new")
    stale = folder.with_name(f".{short}.{os.getpid()}.old")
    try:
        fresh.mkdir()
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(folder)) from None
    try:
        yield fresh
        if folder.exists():
            folder.rename(stale)
            try:
                fresh.rename(folder)
            except BaseException:
                stale.rename(folder)
                raise
            for entry in list(stale.iterdir()):
                if entry.name not in ours:
                    _carry_over(entry, folder / entry.name)
            shutil.rmtree(stale)
        else:
            fresh.rename(folder)
    except BaseException:
        shutil.rmtree(fresh, ignore_errors=True)
        raise


def _carry_over(old: Path, new: Path) -> None:
    if not os.path.lexists(new):
        old.rename(new)
    elif old.is_dir() and new.is_dir() and not old.is_symlink():
        for entry in list(old.iterdir()):
            _carry_over(entry, new / entry.name)
