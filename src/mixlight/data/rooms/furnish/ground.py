"""Where things have a place in one space: nothing overlaps, doors open, windows and ways stay free."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from mixlight.data.rooms.outline import Rectangle, area, contains, door_sweep, edges, holes, obstacles
from mixlight.data.rooms.plan import Item, Plan, Point2

__all__ = ["Block", "Ground", "block_of", "corners_of", "overlaps"]

_TOUCH = 0.004
"""Metres by which neighbours may enter each other: rounding, and cushions that bulge."""


@dataclass(frozen=True)
class Block:
    """A turned rectangle on the ground with a range of heights: what nothing else may enter."""

    corners: tuple[Point2, Point2, Point2, Point2]
    """Counter-clockwise."""
    low: float
    high: float
    bounds: Rectangle

    @staticmethod
    def of(corners: tuple[Point2, Point2, Point2, Point2], low: float, high: float) -> Block:
        """The block over four corners."""
        xs, ys = [x for x, _ in corners], [y for _, y in corners]
        return Block(corners, low, high, (min(xs), min(ys), max(xs), max(ys)))

    @staticmethod
    def over(rectangle: Rectangle, low: float, high: float) -> Block:
        """The block over a rectangle along the axes."""
        x0, y0, x1, y1 = rectangle
        return Block(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), low, high, rectangle)


def corners_of(
    position: Point2, turn: float, width: float, depth: float, gap: float = 0.0
) -> tuple[Point2, Point2, Point2, Point2]:
    """The corners of a turned footprint, widened by `gap` on every side.

    >>> [(round(x, 6), round(y, 6)) for x, y in corners_of((0.0, 0.0), math.pi / 2, 2.0, 1.0)]
    [(0.5, -1.0), (0.5, 1.0), (-0.5, 1.0), (-0.5, -1.0)]
    """
    c, s = math.cos(turn), math.sin(turn)
    x, y = width / 2 + gap, depth / 2 + gap
    a, b, d, e = (
        (c * u - s * v + position[0], s * u + c * v + position[1])
        for u, v in ((-x, -y), (x, -y), (x, y), (-x, y))
    )
    return a, b, d, e


def block_of(item: Item, gap: float = 0.0) -> Block:
    """What an item takes up."""
    x, y, z = item.position
    return Block.of(corners_of((x, y), item.turn, item.size[0], item.size[1], gap), z, z + item.size[2])


def overlaps(a: Block, b: Block) -> bool:
    """Whether two blocks enter each other by more than rounding (separating axes).

    >>> overlaps(Block.over((0, 0, 1, 1), 0, 1), Block.over((0.9, 0, 2, 1), 0, 1))
    True
    """
    if a.low >= b.high - 1e-6 or b.low >= a.high - 1e-6:
        return False
    p, q = a.bounds, b.bounds
    if p[0] >= q[2] - _TOUCH or q[0] >= p[2] - _TOUCH or p[1] >= q[3] - _TOUCH or q[1] >= p[3] - _TOUCH:
        return False
    for corners in (a.corners, b.corners):
        for i in (0, 1):
            nx, ny = corners[i + 1][0] - corners[i][0], corners[i + 1][1] - corners[i][1]
            length = math.hypot(nx, ny)
            nx, ny = nx / length, ny / length
            u = [nx * x + ny * y for x, y in a.corners]
            v = [nx * x + ny * y for x, y in b.corners]
            if min(u) >= max(v) - _TOUCH or min(v) >= max(u) - _TOUCH:
                return False
    return True


class Ground:
    """What is taken in one space of a plan, and what is free."""

    def __init__(self, plan: Plan, space: int) -> None:
        here = plan.spaces[space]
        self.index = space
        self.outline = here.outline
        self.height = here.height
        self.area = area(here.outline)
        self.edges = edges(here.outline)
        self.holes = holes(plan, space)
        self.blocks: list[Block] = []
        """Walls' openings, columns, and every thing placed so far."""
        self.ways: list[Block] = []
        """What stays free for people: only things that lie flat may be there."""
        for hole in self.holes:
            sweep = door_sweep(plan, hole)
            if sweep is not None:
                self.ways.append(Block.over(sweep, 0.03, hole.top))
            edge, opening = self.edges[hole.edge], hole.opening
            reach, low = 0.1, hole.bottom - 0.04
            a, b, top = hole.start - 0.03, hole.end + 0.03, hole.top + 0.03
            if (
                opening.kind == "window"
                and not hole.far
                and opening.details.get("dressing", "none") != "none"
            ):
                reach, top = 0.13, hole.top + 0.16
                if opening.details["dressing"] in ("curtain", "sheer"):
                    reach, a, b = 0.19, hole.start - 0.26, hole.end + 0.26
                    low = 0.03 if opening.details.get("to_floor") or hole.bottom < 0.3 else hole.bottom - 0.14
            a, b = max(a, 0.0), min(b, edge.length)
            self.blocks.append(Block.over(edge.rectangle(a, b, 0.0, reach), max(low, 0.03), top))
        for x0, y0, x1, y1, low, high in obstacles(here):
            self.blocks.append(Block.over((x0, y0, x1, y1), max(low, 0.03), high))

    def inside(self, corners: Iterable[Point2]) -> bool:
        """Whether a footprint lies in the space, walls may be touched."""
        corners = list(corners)
        middle = (sum(x for x, _ in corners) / 4, sum(y for _, y in corners) / 4)
        # A hair towards the middle, so that what touches a wall is inside.
        near = [(x + (middle[0] - x) * 1e-3, y + (middle[1] - y) * 1e-3) for x, y in corners]
        if not all(contains(self.outline, point) for point in near):
            return False
        box = Block.of((near[0], near[1], near[2], near[3]), 0.0, 1.0)
        for x, y in self.outline:  # an inner corner of the walls may stand in the footprint
            if overlaps(box, Block.over((x - 0.005, y - 0.005, x + 0.005, y + 0.005), 0.0, 1.0)):
                return False
        return True

    def free(self, block: Block, *, ways: bool = True, ignore: Iterable[Block] = ()) -> bool:
        """Whether nothing is there yet; `ways`: nor is it a place to walk."""
        if block.high > self.height - 0.01 or not self.inside(block.corners):
            return False
        skip = {id(other) for other in ignore}
        if any(overlaps(block, other) for other in self.blocks if id(other) not in skip):
            return False
        return not ways or not any(overlaps(block, way) for way in self.ways)

    def take(self, block: Block) -> None:
        """Mark a place as taken."""
        self.blocks.append(block)
