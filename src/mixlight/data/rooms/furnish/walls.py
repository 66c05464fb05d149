"""Putting things against the walls of a space, on them and above what stands there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from mixlight.data.rooms.furnish.ground import Block, corners_of
from mixlight.data.rooms.furnish.placed import Placed
from mixlight.data.rooms.furnish.space import Space
from mixlight.data.rooms.plan import Item

__all__ = ["Walls"]


class Walls(Space):
    """A space whose walls are furnished."""

    def against(
        self,
        thing: str | Item | None,
        *,
        tries: int = 14,
        gap: float | None = None,
        corner: float = 0.25,
        edges: Sequence[int] | None = None,
        ways: bool = True,
        near: Placed | None = None,
        **limits: Any,
    ) -> Placed | None:
        """With its back to a wall, in a corner of it with probability `corner`.

        `near`: the place nearest to another thing of a few that are free.
        """
        rng, ground = self.rng, self.ground
        item = self.chosen(thing, **limits)
        if item is None:
            return None
        width, depth, height = item.size
        z = float(item.parameters.get("elevation", 0.0))  # a basin without a column hangs on its wall
        candidates = [
            i
            for i in (range(len(ground.edges)) if edges is None else edges)
            if ground.edges[i].length >= width
        ]
        if not candidates:
            return None
        weights = [ground.edges[i].length for i in candidates]
        found: list[tuple[float, int, float, float]] = []
        for attempt in range(tries):
            index = rng.choices(candidates, weights)[0]
            edge = ground.edges[index]
            space = edge.length - width
            if rng.random() < corner:
                along = width / 2 + (
                    rng.uniform(0.0, min(0.06, space))
                    if rng.random() < 0.5
                    else space - rng.uniform(0.0, min(0.06, space))
                )
            else:
                along = width / 2 + rng.uniform(0.0, space)
            away = gap if gap is not None else (rng.uniform(0.01, 0.04) if attempt < tries * 0.6 else 0.2)
            x, y = edge.at(along, depth / 2 + away)
            if near is None:
                placed = self.put(item, (x, y, z), edge.turn, ways=ways, edge=index, along=along)
                if placed is not None:
                    return placed
            else:
                block = Block.of(corners_of((x, y), edge.turn, width, depth), max(z, 0.021), z + height)
                if ground.free(block, ways=ways):
                    far = math.dist((x, y), near.item.position[:2])
                    found.append((far, index, along, away))
        if found:
            _, index, along, away = min(found)
            edge = ground.edges[index]
            x, y = edge.at(along, depth / 2 + away)
            return self.put(item, (x, y, z), edge.turn, ways=ways, edge=index, along=along)
        return None

    def hang(
        self,
        thing: str | Item | None,
        *,
        middle: tuple[float, float] | None = None,
        bottom: float | None = None,
        edges: Sequence[int] | None = None,
        along: float | None = None,
        tries: int = 10,
        **limits: Any,
    ) -> Placed | None:
        """On a wall, its middle between two heights or its underside at `bottom`."""
        rng, ground = self.rng, self.ground
        item = self.chosen(thing, **limits)
        if item is None:
            return None
        width, depth, height = item.size
        candidates = [
            i
            for i in (range(len(ground.edges)) if edges is None else edges)
            if ground.edges[i].length > width + 0.04
        ]
        if not candidates:
            return None
        weights = [ground.edges[i].length for i in candidates]
        for _ in range(tries):
            index = rng.choices(candidates, weights)[0]
            edge = ground.edges[index]
            at = along if along is not None else rng.uniform(width / 2 + 0.02, edge.length - width / 2 - 0.02)
            if bottom is not None:
                z = bottom
            else:
                low, high = middle if middle is not None else (1.4, 1.65)
                z = rng.uniform(low, high) - height / 2
            if z < 0.02 or z + height > self.height - 0.02:
                continue
            x, y = edge.at(at, depth / 2 + 0.001)
            placed = self.put(item, (x, y, z), edge.turn, ways=False, edge=index, along=at)
            if placed is not None:
                return placed
        return None

    def above(self, thing: str | Item | None, base: Placed, bottom: float, **limits: Any) -> Placed | None:
        """On the wall above a thing that stands against it."""
        if base.edge is None:
            return None
        shift = self.rng.uniform(-0.15, 0.15) * base.item.size[0]
        return self.hang(thing, bottom=bottom, edges=[base.edge], along=base.along + shift, tries=1, **limits)

    def stretches(
        self, edge: int, depth: float, height: float, *, step: float = 0.05
    ) -> list[tuple[float, float]]:
        """Free stretches along a wall, from start to end, for something of this depth and height."""
        line = self.ground.edges[edge]
        count = int(line.length / step)
        found: list[tuple[float, float]] = []
        start: float | None = None
        for i in range(count + 1):
            a = i * step
            free = i < count and self.ground.free(
                Block.over(line.rectangle(a, a + step, 0.002, depth), 0.03, height)
            )
            if free and start is None:
                start = a
            elif not free and start is not None:
                found.append((start, a))
                start = None
        return found

    def opposite(self, thing: Placed) -> list[int]:
        """The walls that a thing faces."""
        fx, fy = thing.front
        x, y = thing.item.position[:2]
        return [
            i
            for i, edge in enumerate(self.ground.edges)
            if edge.inward[0] * fx + edge.inward[1] * fy < -0.9
            and (edge.start[0] - x) * fx + (edge.start[1] - y) * fy > 0.5
        ]
