"""What was scored already: a line for each sample and method, appended as it is finished."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

__all__ = ["Row", "ScoreLog", "fingerprint"]


@dataclass(frozen=True)
class Row:
    """The score of one method on one sample."""

    sample: str
    """Name of the sample (`mixlight.data.evaluation_set.sample_name`)."""
    scene: str
    """Of the panorama."""
    group: str
    """What the panorama belongs to; groups are what intervals are drawn over."""
    category: str
    """Of the panorama: a table of its own."""
    azimuth_deg: float
    """Where the photo looks."""
    gain: float
    """From the file's radiance to the photo's exposure."""
    method: str
    """Name of the method."""
    cells: Mapping[str, float]
    """What was measured; NaN where it is not defined."""


class ScoreLog:
    """A file of JSON lines in the folder of an evaluation.

    A line holds a row and the fingerprint of all that it depends on: panorama, protocol, renderer, method.
    Rows of another fingerprint stay in the file and are not seen. A line that was cut off by a kill is
    ignored, and what was lost with it is scored again.
    """

    def __init__(self, path: Path) -> None:
        """Reads what is there.

        Raises:
            OSError: the file cannot be read.
        """
        self.path = path
        self._rows: dict[tuple[str, str, str], Row] = {}
        if path.is_file():
            for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
                self._take(line)

    def _take(self, line: str) -> None:
        try:
            entry: dict[str, Any] = json.loads(line)
            print_ = entry.pop("fingerprint")
            cells = {k: math.nan if v is None else float(v) for k, v in entry.pop("cells").items()}
            row = Row(**entry, cells=cells)
        except (ValueError, KeyError, TypeError, AttributeError):
            return
        self._rows[row.sample, row.method, print_] = row

    def find(self, sample: str, method: str, fingerprint: str) -> Row | None:
        """The row of a sample and method, if what it depends on is still the same."""
        return self._rows.get((sample, method, fingerprint))

    def add(self, row: Row, fingerprint: str) -> None:
        """Appends a row; it is on its way to the disk when this returns.

        Raises:
            OSError: the disk refuses.
        """
        entry = asdict(row) | {
            "fingerprint": fingerprint,
            "cells": {k: None if math.isnan(v) else v for k, v in row.cells.items()},
        }
        line = (json.dumps(entry, allow_nan=False) + "\n").encode()
        # One write to the end of the file: a line of another process cannot come in between. A line that was
        # cut off before must not swallow this one.
        mode = os.O_RDWR | os.O_CREAT | os.O_APPEND
        file = os.open(self.path, mode, 0o666)
        try:
            size = os.fstat(file).st_size
            whole = size == 0 or os.pread(file, 1, size - 1) == b"\n"
            os.write(file, line if whole else b"\n" + line)
        finally:
            os.close(file)
        self._rows[row.sample, row.method, fingerprint] = row


def fingerprint(*parts: object) -> str:
    """A short digest of plain values.

    >>> fingerprint({"a": 1}, "b") == fingerprint({"a": 1}, "b"), fingerprint("a") == fingerprint("b")
    (True, False)
    """
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
