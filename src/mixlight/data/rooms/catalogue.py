"""What a room may hold: the kinds of things, and the library of objects where one is installed."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms.plan import Item, Point3
from mixlight.data.rooms.shapes import placement

__all__ = ["KINDS", "Catalogue", "CatalogueError", "Entry", "Kind", "library_folder"]

VERSION = 1
"""Of the catalogue's file. Another version is refused: the set would not be the one that was asked for."""


class CatalogueError(ValueError):
    """The library's folder is damaged or of another version; the message says what to run."""


@dataclass(frozen=True)
class Kind:
    """What a thing is, as far as its place goes."""

    place: Literal["floor", "wall", "ceiling", "top"]
    """Where it belongs: on the floor, hung on a wall, on the ceiling, or on top of another thing."""
    carries: bool = False
    """Its top is flat and things stand on it."""
    tall: bool = False
    """It reaches so high that its top is nobody's place for small things."""


_FLOOR = Kind("floor")
_CARRIES = Kind("floor", carries=True)
_TALL = Kind("floor", tall=True)
_WALL = Kind("wall")
_TOP = Kind("top")

KINDS: dict[str, Kind] = {
    # to sit and lie on
    "sofa": _FLOOR,
    "armchair": _FLOOR,
    "chair": _FLOOR,
    "office_chair": _FLOOR,
    "stool": _FLOOR,
    "bar_stool": _FLOOR,
    "bench": _FLOOR,
    "ottoman": _FLOOR,
    "bed": _FLOOR,
    "child_bed": _FLOOR,
    # tables
    "table": _CARRIES,
    "round_table": _CARRIES,
    "coffee_table": _CARRIES,
    "side_table": _CARRIES,
    "nightstand": _CARRIES,
    "desk": _CARRIES,
    "console": _CARRIES,
    "bar_table": _CARRIES,
    "workbench": _CARRIES,
    "display_table": _CARRIES,
    # storage
    "shelf": _TALL,
    "low_shelf": _CARRIES,
    "wardrobe": _TALL,
    "sideboard": _CARRIES,
    "dresser": _CARRIES,
    "cabinet": _TALL,
    "display_cabinet": _TALL,
    "filing_cabinet": _CARRIES,
    "drawer_unit": _CARRIES,
    "tv_stand": _CARRIES,
    "shoe_rack": _CARRIES,
    "coat_stand": _TALL,
    "locker": _TALL,
    # kitchen and bathroom
    "kitchen": _FLOOR,
    "island": _CARRIES,
    "fridge": _TALL,
    "cooker": _FLOOR,
    "washing_machine": _CARRIES,
    "toilet": _FLOOR,
    "basin": _FLOOR,
    "vanity": _FLOOR,
    "bath": _FLOOR,
    "shower": _TALL,
    "towel_rail": _WALL,
    "hamper": _FLOOR,
    # shops and workshops
    "shop_rack": _TALL,
    "clothes_rack": _TALL,
    "counter": _CARRIES,
    "pallet": _FLOOR,
    "crate": _FLOOR,
    "tool_cabinet": _CARRIES,
    "machine": _FLOOR,
    "ladder": _TALL,
    "barrel": _FLOOR,
    "tool_board": _WALL,
    # large things that are there by themselves
    "piano": _FLOOR,
    "plant": _FLOOR,
    "floor_vase": _FLOOR,
    "rug": _FLOOR,
    "speaker": _FLOOR,
    "sports": _FLOOR,
    "toy": _FLOOR,
    "bicycle": _FLOOR,
    "water_cooler": _TALL,
    "fan": _FLOOR,
    "easel": _FLOOR,
    "screen_divider": _TALL,
    "person": _FLOOR,
    "pet": _FLOOR,
    # clutter of the floor
    "bin": _FLOOR,
    "basket": _FLOOR,
    "box": _FLOOR,
    "bag": _FLOOR,
    "shoes": _FLOOR,
    "book_pile": _FLOOR,
    "cable": _FLOOR,
    "heater": _FLOOR,
    "cleaning": _FLOOR,
    "laundry": _FLOOR,
    # on walls
    "picture": _WALL,
    "mirror": _WALL,
    "wall_shelf": _WALL,
    "wall_cabinet": _WALL,
    "clock": _WALL,
    "board": _WALL,
    "wall_tv": _WALL,
    "radiator": _WALL,
    "hooks": _WALL,
    "air_conditioner": _WALL,
    "extinguisher": _WALL,
    "water_heater": _WALL,
    "hood": _WALL,
    "sign": _WALL,
    "paper_roll": _WALL,
    # on ceilings
    "smoke_detector": Kind("ceiling"),
    "vent": Kind("ceiling"),
    # on top of things
    "tv": _TOP,
    "monitor": _TOP,
    "keyboard": _TOP,
    "laptop": _TOP,
    "printer": _TOP,
    "phone": _TOP,
    "papers": _TOP,
    "office_clutter": _TOP,
    "books": _TOP,
    "book": _TOP,
    "cup": _TOP,
    "bottle": _TOP,
    "glass": _TOP,
    "bowl": _TOP,
    "plate": _TOP,
    "food": _TOP,
    "pot": _TOP,
    "appliance": _TOP,
    "microwave": _TOP,
    "kitchen_clutter": _TOP,
    "vase": _TOP,
    "small_plant": _TOP,
    "flowers": _TOP,
    "frame": _TOP,
    "ornament": _TOP,
    "candle_holder": _TOP,
    "small_box": _TOP,
    "electronics": _TOP,
    "stereo": _TOP,
    "bath_clutter": _TOP,
    "towel": _TOP,
    "clothes": _TOP,
    "cushion": _TOP,
    "blanket": _TOP,
    "small_toy": _TOP,
    "tool": _TOP,
    "can": _TOP,
    "goods": _TOP,
    "till": _TOP,
    "tray": _TOP,
}
"""Every kind of thing, by name; order matters only to people."""


@dataclass(frozen=True)
class Entry:
    """One object of the library."""

    name: str
    """Of the object in the .blend file."""
    kind: str
    """One of `KINDS`."""
    size: Point3
    """Extent along x, y and z in metres; its origin is the middle of its footprint, at its underside."""
    top: float | None = None
    """Height in metres at which things stand on it, where that is not its highest point."""
    elevation: float | None = None
    """Height above the floor in metres at which it usually hangs."""
    textured: bool = False
    """It has images of its own, so its colours stay."""
    faces: int = 0
    title: str = ""
    creator: str = ""
    licence: str = ""
    source: str = ""


@dataclass(frozen=True)
class Catalogue:
    """The library of objects: a .blend file and what is in it.

    Raises:
        CatalogueError: two objects of one name, or a kind that is none of `KINDS`.
    """

    blend: Path
    entries: tuple[Entry, ...]
    origin: dict[str, Any] = field(default_factory=dict)
    """What it was made from: package, version, date, program."""

    def __post_init__(self) -> None:
        unknown = sorted({entry.kind for entry in self.entries} - KINDS.keys())
        if unknown:
            raise CatalogueError(f"expected kinds that mixlight knows, received {', '.join(unknown)}")
        if len(self._by_name) != len(self.entries):
            raise CatalogueError("expected every object once, received two of one name")

    @cached_property
    def _by_name(self) -> dict[str, Entry]:
        return {entry.name: entry for entry in self.entries}

    @cached_property
    def _by_kind(self) -> dict[str, tuple[Entry, ...]]:
        kinds: dict[str, list[Entry]] = {}
        for entry in self.entries:
            kinds.setdefault(entry.kind, []).append(entry)
        return {kind: tuple(entries) for kind, entries in kinds.items()}

    def of(self, kind: str) -> tuple[Entry, ...]:
        """The objects of a kind, in the catalogue's order; none if it has none."""
        return self._by_kind.get(kind, ())

    def entry(self, piece: str) -> Entry:
        """The object that an item's `piece` ("library:NAME") names.

        Raises:
            CatalogueError: it is not in this library.
        """
        name = piece.removeprefix("library:")
        if name not in self._by_name:
            raise CatalogueError(
                f"expected an object of the library, received {piece!r}: the room is of another library"
            )
        return self._by_name[name]

    def matrix(self, item: Item) -> Float[np.ndarray, "4 4"]:
        """Where the item's object goes in the room frame: object coordinates to metres in the room.

        Raises:
            CatalogueError: the item is no object of this library.
        """
        entry = self.entry(item.piece)
        scale = [wanted / own for wanted, own in zip(item.size, entry.size, strict=True)]
        return placement(item.position, item.turn, scale)

    def used(self, items: Iterable[Item]) -> tuple[Entry, ...]:
        """The objects that some items use, each once, in the catalogue's order (for the attribution)."""
        pieces = {item.piece.removeprefix("library:") for item in items if item.piece.startswith("library:")}
        return tuple(entry for entry in self.entries if entry.name in pieces)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Write catalogue.json into the folder of the .blend file, and return its path."""
        path = Path(folder) / "catalogue.json"
        document = {
            "version": VERSION,
            "blend": self.blend.name,
            "origin": self.origin,
            "objects": [asdict(entry) for entry in self.entries],
        }
        path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        return path

    @staticmethod
    def load(folder: str | os.PathLike[str]) -> Catalogue:
        """Read the library in a folder.

        Raises:
            CatalogueError: there is none, it is damaged, or it is of another version.
        """
        path = Path(folder) / "catalogue.json"
        again = "run `mixlight rooms assets` to make it anew"
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            if document["version"] != VERSION:
                raise CatalogueError(
                    f"{path}: expected version {VERSION}, received {document['version']}; {again}"
                )
            entries = tuple(Entry(**{**entry, "size": tuple(entry["size"])}) for entry in document["objects"])
            blend = path.parent / str(document["blend"])
            catalogue = Catalogue(blend, entries, document["origin"])
        except FileNotFoundError:
            raise CatalogueError(f"expected a library in {path.parent}, received none; {again}") from None
        except (KeyError, TypeError, AttributeError, json.JSONDecodeError, UnicodeDecodeError) as error:
            raise CatalogueError(f"{path}: damaged ({error!r}); {again}") from None
        if not blend.is_file():
            raise CatalogueError(f"{blend}: missing; {again}")
        return catalogue

    @staticmethod
    def find() -> Catalogue | None:
        """The library in `library_folder`; None where none was installed.

        Raises:
            CatalogueError: there is one, but damaged or of another version.
        """
        folder = library_folder()
        return Catalogue.load(folder) if (folder / "catalogue.json").exists() else None


def library_folder() -> Path:
    """Where `mixlight rooms assets` puts the library: mixlight/rooms in $XDG_DATA_HOME (~/.local/share)."""
    data = os.environ.get("XDG_DATA_HOME", "")
    # The XDG rules say to ignore what is not absolute.
    base = Path(data) if os.path.isabs(data) else Path.home() / ".local" / "share"
    return base / "mixlight" / "rooms"
