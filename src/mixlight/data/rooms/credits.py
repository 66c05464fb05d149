"""Whose work is in a set of rooms: kept up while it grows, and written beside it."""

from __future__ import annotations

from collections.abc import Iterable

from mixlight.data.rooms.attribution import attribution
from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.plan import Plan
from mixlight.data.rooms.room_set import DOCUMENT, RoomSet
from mixlight.data.rooms.store import read_document
from mixlight.image.atomic import atomic_path

__all__ = ["ATTRIBUTION", "Credits"]

ATTRIBUTION = "ATTRIBUTION.txt"
_LIBRARY = "library:"


class Credits:
    """What the rooms of a set have taken from others.

    Args:
        rooms: the set; its rooms so far are looked through.
        catalogue: the library that its furniture is of.

    Raises:
        ValueError: a room's JSON is damaged, or names furniture that the library does not hold.
        OSError: a room cannot be read.
    """

    def __init__(self, rooms: RoomSet, catalogue: Catalogue | None) -> None:
        self._rooms, self._catalogue = rooms, catalogue
        self._pieces: set[str] = set()
        self._skies: set[str] = set()
        for seed in rooms.rooms():
            plan = read_document(rooms.room(seed) / DOCUMENT)["plan"]
            self._note((item["piece"] for item in plan["items"]), plan["sky"]["file"])

    def add(self, plan: Plan) -> None:
        """Count a room in."""
        self._note((item.piece for item in plan.items), plan.sky.file)

    def write(self) -> None:
        """Write ATTRIBUTION.txt into the set's folder, atomically.

        Raises:
            OSError: it cannot be written.
        """
        entries = [self._catalogue.entry(piece) for piece in sorted(self._pieces)] if self._catalogue else []
        with atomic_path(self._rooms.folder / ATTRIBUTION) as temporary:
            temporary.write_text(attribution(entries, skies=self._skies), encoding="utf-8")

    def _note(self, pieces: Iterable[str], sky: str | None) -> None:
        self._pieces.update(piece for piece in pieces if piece.startswith(_LIBRARY))
        if sky is not None:
            self._skies.add(sky)
