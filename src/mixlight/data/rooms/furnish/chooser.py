"""What a room is furnished with: our own pieces in its style, and things of the library."""

from __future__ import annotations

import math
from random import Random
from typing import Any

from mixlight.data.rooms import pieces
from mixlight.data.rooms.catalogue import KINDS, Catalogue
from mixlight.data.rooms.pieces import Style
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["Chooser"]

_LIBRARY = 0.6
"""Share of things that come from the library where it has the kind."""


class Chooser:
    """Chooses things of a kind for a room of one style and height."""

    def __init__(self, rng: Random, style: Style, catalogue: Catalogue | None, height: float) -> None:
        self.rng, self.style, self.catalogue, self.height = rng, style, catalogue, height
        self._same: dict[str, Item] = {}

    def make(
        self,
        kind: str,
        *,
        width: float = math.inf,
        depth: float = math.inf,
        height: float = math.inf,
        own: bool | None = None,
    ) -> Item | None:
        """A thing of this kind, no larger than given (its height is always less than the room's); None if
        none of a few was small enough.

        `own`: True only our own pieces, False only the library's.
        """
        rng = self.rng
        height = min(height, self.height - 0.03)
        ours = bool(pieces.pieces_of(kind))
        found = self.catalogue.of(kind) if self.catalogue is not None and own is not True else ()
        entries = [e for e in found if e.size[0] <= width and e.size[1] <= depth and e.size[2] <= height]
        for _ in range(5):
            library = bool(entries) and (not ours or own is False or rng.random() < self._share(len(entries)))
            if library:
                return self._from_library(rng.choice(entries))
            if not ours or own is False:
                return None
            item = pieces.draw(kind, rng, self.style)
            if item.size[0] <= width and item.size[1] <= depth and item.size[2] <= height:
                return item
        return None

    def chosen(self, thing: str | Item | None, **limits: Any) -> Item | None:
        """A thing that was chosen before as it is, or one of this kind; see `make`."""
        return self.make(thing, **limits) if isinstance(thing, str) else thing

    def again(self, kind: str, **limits: Any) -> Item | None:
        """The same thing as the last time this was asked for in this room: chairs of one table match."""
        if kind not in self._same:
            item = self.make(kind, **limits)
            if item is None:
                return None
            self._same[kind] = item
        return self._same[kind]

    def forget(self, kind: str) -> None:
        """The next `again` draws anew."""
        self._same.pop(kind, None)

    def _share(self, count: int) -> float:
        # One or two models would be seen in every room.
        return _LIBRARY * count / (count + 1.5)

    def _from_library(self, entry: Any) -> Item:
        scale = self.rng.uniform(0.94, 1.06)
        size = tuple(round(extent * scale, 3) for extent in entry.size)
        surfaces: tuple[Surface, ...] = ()
        if not entry.textured and self.rng.random() < 0.5:
            surfaces = self._recolouring(entry.kind)
        parameters: dict[str, Any] = {}
        if entry.top is not None and KINDS[entry.kind].carries:
            x, y = size[0] / 2, size[1] / 2
            parameters["tops"] = [[-x, -y, x, y, round(entry.top * scale, 3), 1.0]]
        if entry.elevation:
            parameters["elevation"] = entry.elevation
        return Item(
            entry.kind,
            f"library:{entry.name}",
            (0.0, 0.0, 0.0),
            0.0,
            (size[0], size[1], size[2]),
            surfaces,
            parameters,
        )

    def _recolouring(self, kind: str) -> tuple[Surface, ...]:
        style, rng = self.style, self.rng
        if kind in ("sofa", "armchair", "ottoman", "chair", "office_chair", "bed"):
            return (rng.choice([style.upholstery, style.upholstery_2]), rng.choice([style.wood, style.metal]))
        if kind in (
            "table",
            "desk",
            "coffee_table",
            "shelf",
            "wardrobe",
            "sideboard",
            "dresser",
            "nightstand",
            "cabinet",
        ):
            return (style.wood, rng.choice([style.front, style.metal, style.wood]))
        if KINDS[kind].place == "top":
            return tuple(rng.sample(style.accents, 2))
        return ()
