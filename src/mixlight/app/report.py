"""What the command line says: results on stdout, one clear line on stderr for each thing that went wrong."""

import json
import sys
from collections.abc import Mapping
from typing import Any

__all__ = ["UsageError", "complain", "describe", "print_json"]

_LIMIT = 400


class UsageError(ValueError):
    """The call is wrong as a whole, and nothing was done."""


def describe(error: BaseException, source: str | None = None) -> str:
    r"""One line that says what went wrong and, unless the error names it already, with which file.

    >>> describe(ValueError("expected 2:1,\nreceived 3:1"), "room.hdr")
    'room.hdr: expected 2:1, received 3:1'
    >>> describe(FileNotFoundError(2, "No such file or directory", "a.jpg"), "a.jpg")
    'a.jpg: No such file or directory'
    """
    if isinstance(error, OSError) and error.strerror:
        named = source if error.filename is None else str(error.filename)
        text = f"{named}: {error.strerror}" if named else error.strerror
    elif isinstance(error, MemoryError):
        text = "expected enough memory to hold it, received none"
    else:
        text = str(error) or type(error).__name__
    if source is not None and source not in text:
        text = f"{source}: {text}"
    line = " ".join(text.split())
    return line if len(line) <= _LIMIT else f"{line[: _LIMIT - 1]}…"


def complain(problem: object) -> None:
    """Print one line on stderr."""
    text = describe(problem) if isinstance(problem, BaseException) else " ".join(str(problem).split())
    print(f"mixlight: {text}", file=sys.stderr, flush=True)


def print_json(line: Mapping[str, Any]) -> None:
    """Print one line of JSON on stdout, at once, so that a reader can follow a long batch."""
    print(json.dumps(line, allow_nan=False), flush=True)
