"""What a benchmark ran on, and its result as JSON, from which the tables of the documentation are made."""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mixlight.image.atomic import atomic_path
from mixlight.training.card import commit


def made_on() -> dict[str, Any]:
    """Commit, machine and versions."""
    return {
        "commit": commit(),
        "machine": f"{_processor()}, {os.cpu_count()} cores",
        "python": platform.python_version(),
        "versions": {name: importlib.metadata.version(name) for name in ("mixlight", "torch", "numpy")},
    }


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
    """What `made_on` says, in one line."""
    versions = ", ".join(f"{name} {version}" for name, version in about["versions"].items())
    return f"Commit `{about['commit']}`; {about['machine']}; Python {about['python']}, {versions}."


def _ratio(value: float) -> str:
    return f"{value:.2f}" if value >= 0.1 else f"{value:.2g}"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()
