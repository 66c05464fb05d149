"""Where things stand on things."""

from __future__ import annotations

from dataclasses import dataclass

from mixlight.data.rooms.catalogue import KINDS
from mixlight.data.rooms.plan import Item

__all__ = ["Top", "tops_of"]


@dataclass(frozen=True)
class Top:
    """A flat rectangle on an item, in the item's own frame."""

    x: float
    """Of its middle."""
    y: float
    width: float
    depth: float
    height: float
    """Above the item's underside."""
    clear: float
    """How tall a thing there may be."""

    @property
    def area(self) -> float:
        """In m²."""
        return self.width * self.depth


def tops_of(item: Item) -> list[Top]:
    """The flat places of an item: those it lists, else its whole top if its kind carries things.

    >>> tops_of(Item("table", "own:table", (0, 0, 0), 0.0, (1.2, 0.8, 0.75)))[0].height
    0.75
    """
    listed = item.parameters.get("tops")
    if listed is not None:
        return [
            Top((x0 + x1) / 2, (y0 + y1) / 2, x1 - x0, y1 - y0, height, clear)
            for x0, y0, x1, y1, height, clear in listed
            if x1 - x0 > 0.05 and y1 - y0 > 0.05
        ]
    if item.kind in KINDS and KINDS[item.kind].carries:
        width, depth, height = item.size
        return [Top(0.0, 0.0, width, depth, height, 1.0)]
    return []
