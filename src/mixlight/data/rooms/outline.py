"""Geometry of a plan: edges of an outline, what lies inside it, and the holes in a wall from both sides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from mixlight.data.rooms.plan import Opening, Plan, Point2, Space

__all__ = [
    "LINING",
    "Edge",
    "Hole",
    "Leaf",
    "Outline",
    "Rectangle",
    "area",
    "bounds",
    "cells",
    "contains",
    "contains_rectangle",
    "door_sweep",
    "edges",
    "holes",
    "leaves",
    "obstacles",
    "overlap",
]

Outline = tuple[Point2, ...]
"""Corners of a space, counter-clockwise."""
Rectangle = tuple[float, float, float, float]
"""x0, y0, x1, y1 in the room frame."""

LINING = 0.022
"""Thickness of a door's lining in metres."""

Leaf = tuple[Point2, float, float, float]
"""Hinge, heading from it, sense of the swing (1: counter-clockwise), width."""

_SAME = 1e-6


@dataclass(frozen=True)
class Edge:
    """One wall of a space, seen from inside.

    Convention: the outline runs counter-clockwise, so the inside lies to the left of `direction`.
    """

    start: Point2
    end: Point2
    direction: Point2
    """Unit vector from start to end."""
    inward: Point2
    """Unit vector into the room."""
    length: float

    @property
    def turn(self) -> float:
        """Turn of a thing that stands with its back to this wall and faces the room.

        >>> back = edges(((0, 0), (4, 0), (4, 3), (0, 3)))[2]  # the wall at y = 3
        >>> round(back.turn, 3)
        0.0
        """
        return math.atan2(self.inward[0], -self.inward[1])

    def at(self, along: float, into: float = 0.0) -> Point2:
        """The point `along` metres from the start and `into` metres inside the room (negative: in the wall).

        >>> edges(((0, 0), (4, 0), (4, 3), (0, 3)))[1].at(1.0, 0.5)
        (3.5, 1.0)
        """
        return (
            self.start[0] + self.direction[0] * along + self.inward[0] * into,
            self.start[1] + self.direction[1] * along + self.inward[1] * into,
        )

    def rectangle(self, start: float, end: float, low: float, high: float) -> Rectangle:
        """The axis-aligned rectangle between two places along the wall and two depths into the room."""
        (ax, ay), (bx, by) = self.at(start, low), self.at(end, high)
        return min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)


def edges(outline: Sequence[Point2]) -> tuple[Edge, ...]:
    """The edges of an outline; edge i goes from corner i to i + 1.

    Raises:
        ValueError: an edge that is not axis-aligned or has no length.
    """
    result = []
    for i, start in enumerate(outline):
        end = outline[(i + 1) % len(outline)]
        dx, dy = end[0] - start[0], end[1] - start[1]
        length = abs(dx) + abs(dy)
        if length < _SAME or min(abs(dx), abs(dy)) > _SAME:
            raise ValueError(f"expected axis-aligned edges, got one from {start} to {end}")
        direction = (
            0.0 if abs(dx) < _SAME else math.copysign(1.0, dx),
            0.0 if abs(dy) < _SAME else math.copysign(1.0, dy),
        )
        inward = (0.0 - direction[1], 0.0 + direction[0])
        result.append(Edge((start[0], start[1]), (end[0], end[1]), direction, inward, length))
    return tuple(result)


def area(outline: Sequence[Point2]) -> float:
    """Area in m², positive for a counter-clockwise outline.

    >>> area(((0, 0), (4, 0), (4, 3), (0, 3)))
    12.0
    """
    total = 0.0
    for i, (x, y) in enumerate(outline):
        u, v = outline[(i + 1) % len(outline)]
        total += x * v - u * y
    return total / 2


def bounds(outline: Sequence[Point2]) -> Rectangle:
    """The smallest rectangle around an outline."""
    xs, ys = [x for x, _ in outline], [y for _, y in outline]
    return min(xs), min(ys), max(xs), max(ys)


def contains(outline: Sequence[Point2], point: Point2, margin: float = 0.0) -> bool:
    """Whether a point lies in the outline, at least `margin` metres from every wall.

    >>> contains(((0, 0), (4, 0), (4, 3), (0, 3)), (3.8, 1.0), margin=0.3)
    False
    """
    x, y = point
    inside = False
    for i, (ax, ay) in enumerate(outline):
        bx, by = outline[(i + 1) % len(outline)]
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
        if margin > 0:
            dx = max(min(ax, bx) - x, x - max(ax, bx), 0.0)
            dy = max(min(ay, by) - y, y - max(ay, by), 0.0)
            if math.hypot(dx, dy) < margin:
                return False
    return inside


def contains_rectangle(outline: Sequence[Point2], rectangle: Rectangle, margin: float = 0.0) -> bool:
    """Whether a rectangle lies in the outline, `margin` metres from every wall (negative: may enter them).

    >>> l_shape = ((0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4))
    >>> contains_rectangle(l_shape, (0.5, 0.5, 3.5, 1.5)), contains_rectangle(l_shape, (1.0, 1.0, 3.0, 3.0))
    (True, False)
    """
    x0, y0, x1, y1 = rectangle
    x0, y0, x1, y1 = x0 - margin, y0 - margin, x1 + margin, y1 + margin
    if x1 - x0 < 2 * _SAME or y1 - y0 < 2 * _SAME or not contains(outline, ((x0 + x1) / 2, (y0 + y1) / 2)):
        return False
    inner = (x0 + _SAME, y0 + _SAME, x1 - _SAME, y1 - _SAME)
    for i, (ax, ay) in enumerate(outline):
        bx, by = outline[(i + 1) % len(outline)]
        # No edge may pass through the rectangle's inside.
        if overlap(inner, (min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)), closed=True):
            return False
    return True


def overlap(a: Rectangle, b: Rectangle, gap: float = 0.0, *, closed: bool = False) -> bool:
    """Whether two rectangles overlap, or come nearer than `gap`; `closed`: touching counts."""
    if closed:
        return a[0] <= b[2] + gap and b[0] <= a[2] + gap and a[1] <= b[3] + gap and b[1] <= a[3] + gap
    return (
        a[0] < b[2] + gap - _SAME
        and b[0] < a[2] + gap - _SAME
        and a[1] < b[3] + gap - _SAME
        and b[1] < a[3] + gap - _SAME
    )


def cells(outline: Outline) -> list[Rectangle]:
    """An outline as rectangles that do not overlap, one for each step of its corners' y.

    >>> cells(((0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)))
    [(0, 0, 4, 2), (0, 2, 2, 4)]
    """
    ys = sorted({y for _, y in outline})
    result = []
    for low, high in pairwise(ys):
        middle = (low + high) / 2
        crossings = sorted(
            a[0]
            for a, b in zip(outline, (*outline[1:], outline[0]), strict=True)
            if min(a[1], b[1]) < middle < max(a[1], b[1])
        )
        result += [(x0, low, x1, high) for x0, x1 in zip(crossings[::2], crossings[1::2], strict=True)]
    return result


@dataclass(frozen=True)
class Hole:
    """An opening as one of its two spaces sees it."""

    index: int
    """The opening's place in the plan."""
    opening: Opening
    space: int
    edge: int
    start: float
    """Metres along this space's edge."""
    end: float
    bottom: float
    top: float
    far: bool
    """Seen from the space behind, whose plan does not write it again."""


def holes(plan: Plan, space: int) -> tuple[Hole, ...]:
    """Every opening in the walls of a space, those that another space wrote among them, by edge and place."""
    return holes_of(plan.spaces, plan.openings, space)


def holes_of(spaces: Sequence[Space], openings: Sequence[Opening], space: int) -> tuple[Hole, ...]:
    """As `holes`, while the plan is not whole yet.

    Raises:
        ValueError: an opening that leads to a space which has no wall there.
    """
    found = []
    for index, opening in enumerate(openings):
        if opening.space == space:
            found.append(
                Hole(
                    index,
                    opening,
                    space,
                    opening.edge,
                    opening.start,
                    opening.end,
                    opening.bottom,
                    opening.top,
                    False,
                )
            )
        elif opening.leads == space:
            near = edges(spaces[opening.space].outline)[opening.edge]
            a, b = near.at(opening.start, -opening.depth), near.at(opening.end, -opening.depth)
            for i, edge in enumerate(edges(spaces[space].outline)):
                if edge.direction != (-near.direction[0], -near.direction[1]):
                    continue
                along = [_along(edge, b), _along(edge, a)]
                if abs(_into(edge, a)) < 1e-3 and along[0] > -1e-3 and along[1] < edge.length + 1e-3:
                    found.append(
                        Hole(index, opening, space, i, along[0], along[1], opening.bottom, opening.top, True)
                    )
                    break
            else:
                raise ValueError(f"opening {index} leads to space {space}, which has no wall there")
    return tuple(sorted(found, key=lambda hole: (hole.edge, hole.start)))


def _along(edge: Edge, point: Point2) -> float:
    return (point[0] - edge.start[0]) * edge.direction[0] + (point[1] - edge.start[1]) * edge.direction[1]


def _into(edge: Edge, point: Point2) -> float:
    return (point[0] - edge.start[0]) * edge.inward[0] + (point[1] - edge.start[1]) * edge.inward[1]


def door_sweep(plan: Plan, hole: Hole) -> Rectangle | None:
    """The ground that has to stay free before an opening in this space: a door's swing, a passage's way.

    None for a window that nobody walks through.
    """
    opening = hole.opening
    if opening.kind == "window" and opening.bottom > 0.1:
        return None
    edge = edges(plan.spaces[hole.space].outline)[hole.edge]
    reach = 0.7
    if opening.kind == "door":
        reach = max(hole.end - hole.start, 0.7)
    return edge.rectangle(hole.start, hole.end, 0.0, reach)


def leaves(edge: Edge, hole: Hole) -> list[Leaf]:
    """The leaves of a door, one or two, as the space sees it that wrote it.

    The heading is the angle of the leaf's far end seen from its hinge, counter-clockwise from +X, radians.
    """
    details = hole.opening.details
    into = bool(details.get("into", True))
    double = details.get("leaves", 1) == 2
    a, b = hole.start + LINING, hole.end - LINING
    sides = ["start", "end"] if double else [details.get("hinge", "start")]
    width = (b - a) / len(sides)
    angle = float(details.get("angle", 0.0))
    depth = hole.opening.depth
    plane = 0.0 if into else -depth
    base = math.atan2(edge.direction[1], edge.direction[0])
    found = []
    for side in sides:
        along = a if side == "start" else b
        heading = base if side == "start" else base + math.pi
        # From the start, turning counter-clockwise swings into the room, which lies to the left.
        sense = (1.0 if side == "start" else -1.0) * (1.0 if into else -1.0)
        found.append((edge.at(along, plane), heading + sense * angle, sense, width))
    return found


def obstacles(space: Space) -> tuple[tuple[float, float, float, float, float, float], ...]:
    """Boxes (x0, y0, x1, y1, z0, z1) round what is built in: columns, beams, soffits, ducts, a fireplace."""
    names = ("columns", "beams", "obstacles")
    return tuple((a, b, c, d, e, f) for name in names for a, b, c, d, e, f in space.details.get(name, ()))
