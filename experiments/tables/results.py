"""The results that the tables are made from: JSON files of experiments/results."""

import functools
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parents[1] / "results"

Json = Mapping[str, Any]
Table = Callable[[], str]
"""Writes a table in Markdown, and what it stands on."""
Tables = Mapping[str, Table]


def read(name: str) -> Json | None:
    """The result of that name (`ablations/sparse` for a file in a folder); None if it is not there yet."""
    path = FOLDER / f"{name}.json"
    if not path.is_file():
        return None
    found: Json = json.loads(path.read_text(encoding="utf-8"))
    return found


def measured(name: str) -> Callable[[Callable[[Json], str]], Table]:
    """Makes a table of a function of the result of that name; it is empty where there is no result yet."""

    def decorate(write: Callable[[Json], str]) -> Table:
        @functools.wraps(write)
        def table() -> str:
            found = read(name)
            return "" if found is None else write(found)

        return table

    return decorate


def made_on(provenance: Json) -> str:
    """Commit, machine and versions of a result."""
    return (
        f"commit `{provenance['commit'][:10]}`; {provenance['machine']}; "
        f"Python {provenance['python']}, torch {provenance['torch']}"
    )
