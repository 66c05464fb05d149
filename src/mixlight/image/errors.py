"""What goes wrong with an image file, in one line: the file, what was expected, what was received."""

import os
from pathlib import Path

__all__ = ["ImageFileError", "file_error", "one_line", "reworded", "shown"]


class ImageFileError(ValueError):
    """The bytes of a file are not the image that was asked for."""


def shown(source: str | os.PathLike[str] | bytes) -> str:
    """The name under which a source appears in messages.

    >>> shown("room.hdr"), shown(b"#?RADIANCE")
    ('room.hdr', '<10 bytes>')
    """
    return f"<{len(source)} bytes>" if isinstance(source, bytes) else one_line(Path(source), 4096)


def one_line(text: object, limit: int = 200) -> str:
    r"""`text` without line breaks, control characters or excess length, fit to be quoted in a message.

    >>> one_line("two\nlines")
    'two lines'
    """
    line = " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())
    return line if len(line) <= limit else line[: limit - 1] + "…"


def file_error(source: str | os.PathLike[str] | bytes, expected: str, received: object) -> ImageFileError:
    """The error for a file that holds something else than expected; the caller raises it.

    >>> str(file_error("a.hdr", "a Radiance picture", "PNG"))
    'a.hdr: expected a Radiance picture, received PNG'
    """
    return ImageFileError(f"{shown(source)}: expected {expected}, received {one_line(received)}")


def reworded(source: str | os.PathLike[str] | bytes, error: ValueError, subject: str = "") -> ImageFileError:
    """The error for a file from one of the form "...expected A, received B" that does not know the file.

    >>> str(reworded("a.hdr", ValueError("expected 3 scanlines, received 2"), "pixels: "))
    'a.hdr: expected pixels: 3 scanlines, received 2'
    """
    expected, _, received = str(error).partition("expected ")[2].partition(", received ")
    return file_error(source, subject + expected, received)
