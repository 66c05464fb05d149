"""One space while it is furnished: choosing things, and putting them against walls, free, around, on top."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

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

    def scatter(
        self,
        kinds: Iterable[tuple[str, float, int]],
        full: float,
        *,
        walls: float = 1.0,
        corner: float = 0.25,
    ) -> None:
        """Some of each kind: up to a largest number, each of them with a probability.

        Args:
            kinds: kind, probability, largest number.
            full: none where this share of the floor is under furniture.
            walls: share that stands against a wall; the others stand free.
            corner: how often in a corner, of those against a wall.
        """
        for kind, often, most in kinds:
            for _ in range(self.rng.randint(0, most)):
                if self.chance(often) and not self.full(full):
                    if walls == 1.0 or self.chance(walls):
                        self.against(kind, corner=corner)
                    else:
                        self.free(kind)
