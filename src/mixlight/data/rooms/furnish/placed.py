"""An item in its place, and where things are beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mixlight.data.rooms.plan import Item, Point2

__all__ = ["Placed", "in_room", "rounded"]


@dataclass(frozen=True)
class Placed:
    """An item in its place, and its number in the plan."""

    index: int
    item: Item
    edge: int | None = None
    """The wall that it stands against."""
    along: float = 0.0
    """Where on that wall its middle is, in metres."""

    @property
    def front(self) -> Point2:
        """Unit vector to where it faces."""
        return math.sin(self.item.turn), -math.cos(self.item.turn)


def in_room(base: Item, x: float, y: float) -> Point2:
    """A point of an item's own frame, in the room's.

    >>> in_room(Item("table", "own:table", (2.0, 1.0, 0.0), 0.0, (1.2, 0.8, 0.75)), 0.5, -0.25)
    (2.5, 0.75)
    """
    c, s = math.cos(base.turn), math.sin(base.turn)
    return base.position[0] + c * x - s * y, base.position[1] + s * x + c * y


def rounded(position: tuple[float, float, float]) -> tuple[float, float, float]:
    """To a tenth of a millimetre, as plans are stored."""
    x, y, z = position
    return round(x, 4), round(y, 4), round(z, 4)
