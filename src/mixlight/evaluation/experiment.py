"""An ablation as a file: which variants, compared on what. One TOML file, one table."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, get_args

from mixlight.data.panoramas import SPLITS
from mixlight.evaluation.representations import PARTS, Part, Representation

__all__ = ["Experiment", "Level", "Variant", "read_experiment"]

Level = Literal["representation", "network"]


@dataclass(frozen=True)
class Variant:
    """One row of the table."""

    name: str
    """As the table calls it."""
    overrides: Mapping[str, Any] = field(default_factory=dict)
    """Dotted keys of the training config (level `network`)."""
    representation: Representation = field(default_factory=Representation)
    """What holds the light (level `representation`)."""


@dataclass(frozen=True)
class Experiment:
    """A table of variants that differ in one thing each."""

    question: str
    """What the table answers."""
    level: Level
    """`representation`: the true light through its own parameters, without a network. `network`: networks
    trained under one budget."""
    variants: tuple[Variant, ...]
    """The rows, in order."""
    reference: str
    """The variant that the others are compared with, view by view."""
    tables: tuple[str, ...]
    """CSV tables of the panoramas that are scored; relative paths are relative to the file."""
    splits: tuple[str, ...] = ("test",)
    """Which splits of them."""
    categories: tuple[str, ...] = ("indoor",)
    """Which categories."""
    azimuths: int = 8
    """Views of each panorama."""
    parts: tuple[Part, ...] = ("whole",)
    """What lights the spheres: the whole light, or its ambient part or its sources alone, against the same
    part of the truth."""
    keep_views: bool = False
    """Whether the results hold the errors of every view, for figures."""
    config: str = ""
    """Training config that variants override (level `network`), relative to the file."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds of each variant (level `network`)."""

    def __post_init__(self) -> None:
        if self.level not in get_args(Level):
            raise ValueError(f"expected a level representation or network, got {self.level!r}")
        names = [variant.name for variant in self.variants]
        if not names or len(set(names)) != len(names):
            raise ValueError(f"expected variants of different names, got {names}")
        if self.reference not in names:
            raise ValueError(f"expected a reference out of {', '.join(names)}, got {self.reference!r}")
        for name, known in (("splits", SPLITS), ("parts", PARTS)):
            wrong = sorted(set(getattr(self, name)) - set(known))
            if wrong or not getattr(self, name):
                raise ValueError(f"expected {name} out of {', '.join(known)}, got {wrong or 'none'}")
        if self.azimuths < 1:
            raise ValueError(f"expected azimuths of at least 1, got {self.azimuths}")
        if not self.tables or not self.categories:
            raise ValueError("expected tables and categories, got none")
        if self.level == "network" and not self.config:
            raise ValueError("expected the training config that the variants override, got none")
        if self.level == "network" and (not self.seeds or len(set(self.seeds)) != len(self.seeds)):
            raise ValueError(f"expected different seeds, got {list(self.seeds)}")


def read_experiment(path: str | Path) -> Experiment:
    """Reads a TOML file; what it does not say keeps its default.

    Each `[[variant]]` has a `name`, and beside it either the keys of a representation, or a table `set` of
    keys of the training config.

    Raises:
        ValueError: not TOML, an unknown or missing key, or a value of the wrong type or outside its range;
            the message names the file.
        FileNotFoundError: no such file.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: expected a TOML experiment, found no such file")
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: expected TOML, {error}") from error
    try:
        return _experiment(values, path.parent)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: {error}") from error


def _experiment(values: dict[str, Any], folder: Path) -> Experiment:
    rows = values.pop("variant", [])
    known = {f.name: f for f in fields(Experiment) if f.name != "variants"}
    _check_keys(values, known)
    missing = sorted(name for name, f in known.items() if f.default is MISSING and name not in values)
    if missing:
        raise ValueError(f"missing key {missing[0]}")
    level = values["level"]
    for name in ("tables", "splits", "categories", "parts", "seeds"):
        if name in values:
            if not isinstance(values[name], list):
                raise ValueError(f"expected a list for {name}, got {values[name]!r}")
            values[name] = tuple(values[name])
    values["tables"] = tuple(str((folder / table).resolve()) for table in values["tables"])
    if values.get("config"):
        values["config"] = str((folder / values["config"]).resolve())
    return Experiment(**values, variants=tuple(_variant(row, level) for row in rows))


def _variant(row: Any, level: str) -> Variant:
    if not isinstance(row, dict) or not isinstance(row.get("name"), str):
        raise ValueError(f"expected a name for each variant, got {row!r}")
    rest = {key: value for key, value in row.items() if key != "name"}
    if level == "network":
        _check_keys(rest, {"set"}, row["name"])
        return Variant(row["name"], _dotted(rest.get("set", {})))
    _check_keys(rest, {f.name for f in fields(Representation)}, row["name"])
    return Variant(row["name"], representation=Representation(**rest))


def _check_keys(values: Mapping[str, Any], known: Any, where: str = "") -> None:
    wrong = sorted(set(values) - set(known))
    if wrong:
        place = f" of {where}" if where else ""
        raise ValueError(f"unknown key {wrong[0]}{place}; expected one of {', '.join(known)}")


def _dotted(table: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    """Nested tables as dotted keys.

    >>> _dotted({"model": {"ambient": "sg9"}, "loss": {"scores": 0.0}})
    {'model.ambient': 'sg9', 'loss.scores': 0.0}
    """
    flat: dict[str, Any] = {}
    for key, value in table.items():
        flat |= _dotted(value, f"{where}{key}.") if isinstance(value, dict) else {f"{where}{key}": value}
    return flat
