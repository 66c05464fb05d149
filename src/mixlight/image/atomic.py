"""Files that appear whole or not at all."""

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

__all__ = ["atomic_path"]


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
