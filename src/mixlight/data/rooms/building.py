"""A building while it is drawn: what its walls hold already, and what is free."""

from __future__ import annotations

from dataclasses import dataclass, field

from mixlight.data.rooms.outline import Outline, Rectangle, bounds, cells, edges, holes_of, overlap
from mixlight.data.rooms.plan import Opening, Space
from mixlight.data.rooms.scheme import Palette

__all__ = ["Building"]


@dataclass
class Building:
    """A building while it is drawn."""

    palette: Palette
    outer: float
    """Thickness of the outer walls."""
    head: float
    """Height of the windows' upper edge over the floor."""
    spaces: list[Space] = field(default_factory=list)
    openings: list[Opening] = field(default_factory=list)

    def free(self, space: int, edge: int, start: float, end: float, gap: float = 0.08) -> bool:
        """Whether a piece of a wall is inside the edge and has no opening yet."""
        length = edges(self.spaces[space].outline)[edge].length
        if start < gap - 1e-9 or end > length - gap + 1e-9:
            return False
        return all(
            end + gap <= hole.start or start - gap >= hole.end
            for hole in holes_of(self.spaces, self.openings, space)
            if hole.edge == edge
        )

    def clear(self, rectangle: Rectangle, *, gap: float = 0.0) -> bool:
        """Whether no space comes into a rectangle, or nearer to it than `gap`."""
        return not any(_meets(space.outline, rectangle, gap) for space in self.spaces)

    def outdoors(self, space: int, edge: int, start: float, end: float, reach: float = 2.0) -> bool:
        """Whether there is open air behind a piece of a wall."""
        e = edges(self.spaces[space].outline)[edge]
        # From the wall's outer face on; all walls that stand there or beside are as thick as this one.
        return self.clear(e.rectangle(start, end, -reach, -self.outer - 0.002), gap=self.outer)


def _meets(outline: Outline, rectangle: Rectangle, gap: float) -> bool:
    if not overlap(bounds(outline), rectangle, gap):
        return False
    x0, y0, x1, y1 = rectangle
    grown = (x0 - gap, y0 - gap, x1 + gap, y1 + gap)
    return any(overlap(cell, grown) for cell in cells(outline))
