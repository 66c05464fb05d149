"""What a benchmark ran on, and its result as JSON, from which the tables of the documentation are made."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.provenance import PACKAGES
from mixlight.image.atomic import atomic_path


def save(path: Path, document: dict[str, Any]) -> None:
    """Writes a result, all or nothing."""
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


HEAD = ("", "ours", "against", "seconds", "ratio (quartiles)", "limit", "")
"""Of the table of ratios."""


def cells(name: str, row: Mapping[str, Any]) -> list[str]:
    """One row of the table of ratios."""
    low, high = row["quartiles"]
    ours, reference = row["seconds"]
    return [
        name,
        row["ours"],
        row["against"],
        f"{ours:.3f} / {reference:.3f}",
        f"{_ratio(row['ratio'])} ({_ratio(low)} to {_ratio(high)})",
        f"{row['limit']:g}",
        "met" if row["ratio"] <= row["limit"] else "not met",
    ]


def basis(about: Mapping[str, Any]) -> str:
    """Commit, machine and versions, in one line."""
    versions = ", ".join(f"{name} {about[name]}" for name in PACKAGES)
    return f"Commit `{about['commit']}`; {about['machine']}; Python {about['python']}, {versions}."


def _ratio(value: float) -> str:
    return f"{value:.2f}" if value >= 0.1 else f"{value:.2g}"
