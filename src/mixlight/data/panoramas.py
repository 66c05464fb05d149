"""Where panoramas come from: a CSV table or a plain folder of HDR files."""

from __future__ import annotations

import csv
import logging
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.image import exr, radiance
from mixlight.sphere import equirect

SPLITS = ("train", "val", "test")
HDR_SUFFIXES = (".hdr", ".pic", ".exr")
_RINGING = 0.01
_HALF_MAX = 65504.0
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class PanoramaRecord:
    """One row of a panorama table."""

    scene: str
    """Unique name of the scene."""
    path: Path
    """The HDR file."""
    split: str
    """`train`, `val` or `test`."""
    category: str
    """`indoor`, `studio`, `covered`, `outdoor` or `room` (rendered)."""
    group: str
    """Related places share a group; a group never stands on two sides of a split."""


def read_table(table: str | Path) -> list[PanoramaRecord]:
    """Reads a CSV with the columns `file` and `split`, and optionally `scene`, `category` and `group`.

    Paths are relative to the CSV's folder. `scene` defaults to the file's stem, `category` to `room`,
    `group` to the scene. Other columns are for people and are not looked at.

    Raises:
        ValueError: not UTF-8 or no CSV, a missing column or value, an unknown split, a scene listed twice, or
            a group on two sides of the split. The message names the table, and the line where there is one.
        FileNotFoundError: the table or one of its files is missing.
    """
    table = Path(table)
    if not table.is_file():
        raise FileNotFoundError(f"{table}: expected a CSV table of panoramas, found no such file")
    try:
        with table.open(newline="", encoding="utf-8-sig") as lines:
            rows = csv.DictReader(lines, restval="")
            missing = {"file", "split"} - set(rows.fieldnames or ())
            if missing:
                raise ValueError(
                    f"expected the columns file and split, missing {' and '.join(sorted(missing))}"
                )
            records = [_record(table.parent, row, rows.line_num) for row in rows]
        check_split(records)
    except (ValueError, csv.Error) as error:  # UnicodeDecodeError is a ValueError
        raise ValueError(f"{table}: {error}") from error
    except FileNotFoundError as error:
        raise FileNotFoundError(f"{table}: {error}") from error
    return records


def _record(folder: Path, row: dict[str, str], line: int) -> PanoramaRecord:
    name, split = row["file"], row["split"]
    if not name:
        raise ValueError(f"line {line}: expected the name of a file, got none")
    if split not in SPLITS:
        raise ValueError(f"line {line}: {name}: expected a split of {', '.join(SPLITS)}, got {split!r}")
    path = folder / name
    if not path.is_file():
        raise FileNotFoundError(f"line {line}: lists {name}, which does not exist")
    scene = row.get("scene") or path.stem
    return PanoramaRecord(scene, path, split, row.get("category") or "room", row.get("group") or scene)


def read_folder(folder: str | Path, split: str = "test", category: str = "indoor") -> list[PanoramaRecord]:
    """Lists every HDR file below a folder as one split, each scene a group of its own, in order of its name.

    A scene is named by the file's path below the folder, without its suffix. Hidden files are left out.

    Raises:
        ValueError: an unknown split, or two files that differ in their suffix only.
        FileNotFoundError: no folder, or no .hdr, .pic or .exr file in it.
    """
    if split not in SPLITS:
        raise ValueError(f"expected a split of {', '.join(SPLITS)}, got {split!r}")
    folder = Path(folder)
    paths = sorted(
        path
        for path in folder.rglob("*")
        if path.suffix.lower() in HDR_SUFFIXES and not path.name.startswith(".") and path.is_file()
    )
    if not paths:
        raise FileNotFoundError(f"{folder}: expected a folder with .hdr or .exr panoramas, found none")
    scenes = [path.relative_to(folder).with_suffix("").as_posix() for path in paths]
    records = [
        PanoramaRecord(scene, path, split, category, scene) for scene, path in zip(scenes, paths, strict=True)
    ]
    try:
        check_split(records)
    except ValueError as error:
        raise ValueError(f"{folder}: {error}") from error
    return records


def check_split(records: Iterable[PanoramaRecord]) -> None:
    """Refuses a scene that is listed twice and a group that stands on two sides of the split.

    Raises:
        ValueError: naming the scene or the group.
    """
    scenes: set[str] = set()
    sides: dict[str, str] = {}
    for record in records:
        if record.scene in scenes:
            raise ValueError(f"expected every scene once, got {record.scene!r} twice")
        scenes.add(record.scene)
        if sides.setdefault(record.group, record.split) != record.split:
            raise ValueError(
                f"expected a group on one side of the split, got {record.group!r} in both "
                f"{sides[record.group]} and {record.split}"
            )


def select(
    records: Iterable[PanoramaRecord], split: str, categories: Iterable[str] | None = None
) -> list[PanoramaRecord]:
    """Keeps the records of one split, and of the given categories where they are given.

    Raises:
        ValueError: an unknown split.
    """
    if split not in SPLITS:
        raise ValueError(f"expected a split of {', '.join(SPLITS)}, got {split!r}")
    wanted = None if categories is None else set(categories)
    return [r for r in records if r.split == split and (wanted is None or r.category in wanted)]


def read_radiance(path: str | Path) -> Float[Tensor, "height width 3"]:
    """Reads a panorama file as linear Rec.709 radiance, float32, at the file's own size.

    Two things that happen to sound panoramas when they are stored are undone, and logged: lossy codecs (DWAB)
    ring slightly below 0 beside edges, so values down to -1 % of the mean become 0; highlights beyond half
    precision are stored as +Inf in an .exr and become its largest number, 65504. Anything more is bad input.

    Raises:
        ValueError: not a .hdr, .pic or .exr, unreadable as such, not 2:1, not finite, or negative; the
            message names the file.
        OSError: the file is missing or may not be read.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in HDR_SUFFIXES:
        raise ValueError(f"{path}: expected a .hdr, .pic or .exr panorama, got {suffix or 'no suffix'}")
    pixels, _ = exr.read(path) if suffix == ".exr" else radiance.read(path)
    panorama = torch.from_numpy(pixels)
    # Flat, and once over: a panorama may hold a hundred million values.
    lowest, highest = (float(value) for value in panorama.flatten().aminmax())
    if suffix == ".exr" and highest == math.inf:
        count = int((panorama == math.inf).sum())
        _LOG.info("%s: %d values beyond half precision taken as %g", path, count, _HALF_MAX)
        panorama = panorama.clamp(max=_HALF_MAX)
    if lowest < 0 and lowest >= -_RINGING * float(panorama.mean()):
        _LOG.info("%s: values down to %g taken as 0", path, lowest)
        panorama = panorama.clamp(min=0)
    equirect.check(panorama, str(path))
    return panorama


def load_panorama(path: str | Path, max_height: int = 512) -> Float[Tensor, "height width 3"]:
    """Reads a panorama as `read_radiance` does, and makes it no taller than `max_height`, keeping its
    energy.
    """
    panorama = read_radiance(path)
    return equirect.resize(panorama, max_height) if panorama.shape[0] > max_height else panorama
