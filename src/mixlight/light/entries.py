"""Checks of what a JSON file holds, one entry at a time, with complaints that name the entry.

Each function returns what it was given, so that a reader checks and takes in one step.
"""

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

__all__ = ["entries", "equal", "fail", "keys", "load", "mapping", "number", "rgb", "text", "whole"]


def load(path: str | os.PathLike[str]) -> Any:
    """The JSON of a file; NaN and infinity, which JSON does not know, are refused.

    Raises:
        ValueError: the file holds no JSON; the message names the file.
        OSError: the file cannot be read.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "a.json").write_text('{"a": 1.5}')
    ...     load(Path(folder, "a.json"))
    {'a': 1.5}
    """
    try:
        return json.loads(Path(path).read_bytes(), parse_constant=_refuse)
    except RecursionError:
        raise ValueError(f"{os.fspath(path)}: expected JSON, received endless nesting") from None
    except UnicodeDecodeError as error:
        raise ValueError(f"{os.fspath(path)}: expected JSON, received no text: {error}") from error
    except ValueError as error:  # also of json
        raise ValueError(f"{os.fspath(path)}: {error}") from error


def fail(where: str, expected: str, received: object) -> NoReturn:
    """Raise the error for an entry.

    >>> fail("lights[0].name", "a text", 3)
    Traceback (most recent call last):
    ValueError: lights[0].name: expected a text, received 3
    """
    shown = repr(received)
    raise ValueError(
        f"{where}: expected {expected}, received {shown if len(shown) <= 60 else shown[:57] + '...'}"
    )


def equal(value: object, where: str, expected: str | int) -> None:
    """Exactly this text or number."""
    if value != expected or isinstance(value, bool):
        fail(where, repr(expected), value)


def mapping(value: object, where: str) -> Mapping[str, Any]:
    """An object."""
    if not isinstance(value, Mapping):
        fail(where, "an object", value)
    return value


def keys(value: Mapping[str, Any], where: str, expected: Sequence[str]) -> None:
    """An object with these entries and no others."""
    missing = [key for key in expected if key not in value]
    unknown = [key for key in value if key not in expected]
    if missing or unknown:
        fail(where, f"the entries {', '.join(expected)}", sorted(map(str, value)))


def entries(value: object, where: str, length: int | None = None) -> Sequence[Any]:
    """A list, of this length where one is given."""
    if not isinstance(value, list | tuple):
        fail(where, "a list", value)
    if length is not None and len(value) != length:
        raise ValueError(f"{where}: expected a list of {length} entries, received {len(value)}")
    return value


def text(value: object, where: str) -> str:
    """A text."""
    if not isinstance(value, str):
        fail(where, "a text", value)
    return value


def whole(value: object, where: str, minimum: int, maximum: int) -> int:
    """A whole number from the minimum to the maximum."""
    if isinstance(value, bool) or not isinstance(value, int) or not minimum <= value <= maximum:
        fail(where, f"a whole number from {minimum} to {maximum}", value)
    return value


def rgb(value: object, where: str, minimum: float | None = None) -> list[float]:
    """Three finite numbers, a colour or a direction."""
    return [
        number(part, f"{where}[{place}]", minimum=minimum)
        for place, part in enumerate(entries(value, where, 3))
    ]


def number(
    value: object,
    where: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
    below: float | None = None,
) -> float:
    """A finite number within these limits.

    >>> number(0.5, "intensity", above=0)
    0.5
    """
    limits = [
        f"{words} {limit:g}"
        for words, limit in (
            ("of at least", minimum),
            ("above", above),
            ("of at most", maximum),
            ("below", below),
        )
        if limit is not None
    ]
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not _finite(value)
        or (minimum is not None and value < minimum)
        or (above is not None and value <= above)
        or (maximum is not None and value > maximum)
        or (below is not None and value >= below)
    ):
        fail(where, " ".join(["a finite number", " and ".join(limits)]).rstrip(), value)
    return value


def _finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number of hundreds of digits
        return False


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"expected finite numbers, received {constant}")
