"""One space while it is furnished: choosing things, and putting them against walls, free, around, on top."""

from __future__ import annotations

from collections.abc import Sequence

from mixlight.data.rooms.furnish.floor import Floor
from mixlight.data.rooms.furnish.tabletops import Tabletops
from mixlight.data.rooms.furnish.walls import Walls
from mixlight.data.rooms.palette import choose

__all__ = ["Room"]


class Room(Walls, Floor, Tabletops):
    """One space of a plan, with every way of furnishing it."""

    def fill(self, kinds: Sequence[tuple[str, float]], share: float, *, free: float = 0.2) -> None:
        """More things, by chance, until `share` of the floor is under furniture or nothing more finds a
        place; `free` of them away from the walls.
        """
        misses = 0
        while self.covered < share * self.area and misses < 10:
            kind = choose(self.rng, kinds)
            if self.chance(free):
                placed = self.free(kind, margin=0.35, tries=6)
            else:
                placed = self.against(kind, corner=0.35, tries=8)
            misses += placed is None
