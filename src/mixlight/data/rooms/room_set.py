"""A folder of rendered rooms: what it was made with, which rooms are done, and the table that lists them.

`DIR/rooms.json` says how all its rooms were made; `DIR/room-SEED/` holds one room, and is there only when it
is whole; `DIR/rooms.csv` is what training reads.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mixlight.image.atomic import atomic_path

__all__ = ["DOCUMENT", "HEADER", "TABLE", "RoomSet", "SetError", "split_of"]

FORMAT, VERSION = "mixlight-rooms", 1
HEADER, TABLE, DOCUMENT = "rooms.json", "rooms.csv", "room.json"

_NAME = re.compile(r"room-(\d{5,})")
_CAMERA = re.compile(r"camera-(\d+)\.exr")
_COLUMNS = ("scene", "file", "seed", "split", "category", "group")


class SetError(ValueError):
    """A folder that holds something else than the set that was asked for; nothing in it was touched."""


def split_of(seed: int) -> str:
    """The side of the split that a room is on: every tenth is for validation.

    >>> split_of(18), split_of(19)
    ('train', 'val')
    """
    return "val" if seed % 10 == 9 else "train"


@dataclass(frozen=True)
class RoomSet:
    """The folder of a set."""

    folder: Path

    def open(self, made_with: Mapping[str, Any]) -> None:
        """Begin a set, or go on with one that was made alike.

        Args:
            made_with: everything beside the seed that decides what a room becomes, as plain values.

        Raises:
            SetError: the folder holds a set that was made otherwise, by another version, or is damaged.
            OSError: it cannot be made or written to.
        """
        wanted = json.loads(json.dumps(dict(made_with), allow_nan=False))
        path = self.folder / HEADER
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            if self.rooms():
                raise SetError(
                    f"{self.folder}: expected a set of rooms with its {HEADER}, found rooms without one"
                ) from None
            self.folder.mkdir(parents=True, exist_ok=True)
            header = {"format": FORMAT, "version": VERSION, **wanted}
            with atomic_path(path) as temporary:
                temporary.write_text(json.dumps(header, indent=1) + "\n", encoding="utf-8")
            return
        except ValueError:
            raise SetError(f"{path}: expected the description of a set of rooms, found no JSON") from None
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise SetError(f"{path}: expected the description of a set of rooms, found something else")
        if found.get("version") != VERSION:
            raise SetError(
                f"{self.folder}: expected rooms of version {VERSION}, found version {found.get('version')}; "
                "give another --out"
            )
        for key in sorted(wanted.keys() | found.keys() - {"format", "version"}):
            if wanted.get(key) != found.get(key):
                raise SetError(
                    f"{self.folder}: holds rooms made with {key} {_shown(found.get(key))}, expected "
                    f"{_shown(wanted.get(key))}; make them alike, or give another --out"
                )

    def room(self, seed: int) -> Path:
        """Folder of a room, whether it is there or not."""
        return self.folder / f"room-{seed:05d}"

    def rooms(self) -> dict[int, tuple[str, ...]]:
        """Seeds of the rooms that are done, in order, with the names of their panoramas."""
        found = {}
        for folder in self.folder.iterdir() if self.folder.is_dir() else ():
            name = _NAME.fullmatch(folder.name)
            if name and (folder / DOCUMENT).is_file():
                cameras = (_CAMERA.fullmatch(path.name) for path in folder.iterdir())
                files = {int(camera[1]): camera[0] for camera in cameras if camera}
                found[int(name[1])] = tuple(files[k] for k in sorted(files))
        return {seed: found[seed] for seed in sorted(found)}

    def write_table(self) -> None:
        """Write rooms.csv anew, atomically: a row a panorama, all those of a room in one group.

        Raises:
            OSError: it cannot be written.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(_COLUMNS)
        for seed, files in self.rooms().items():
            group = self.room(seed).name
            for file in files:
                scene = f"{group}-{Path(file).stem}"
                writer.writerow((scene, f"{group}/{file}", seed, split_of(seed), "room", group))
        with atomic_path(self.folder / TABLE) as temporary:
            temporary.write_text(text.getvalue(), encoding="utf-8")


def _shown(value: Any) -> str:
    return "none" if value is None else str(value)
