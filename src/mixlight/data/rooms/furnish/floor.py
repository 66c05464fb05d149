"""Putting things on the floor of a space, free or by other things, and under its ceiling."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from mixlight.data.rooms.furnish.ground import block_of
from mixlight.data.rooms.furnish.placed import Placed, in_room, rounded
from mixlight.data.rooms.furnish.space import Space
from mixlight.data.rooms.plan import Item, Point2

__all__ = ["Floor"]


class Floor(Space):
    """A space whose floor is furnished."""

    def free(
        self,
        thing: str | Item | None,
        *,
        tries: int = 14,
        margin: float = 0.3,
        turn: float | None = None,
        loose: float = 0.06,
        ways: bool = True,
        **limits: Any,
    ) -> Placed | None:
        """Somewhere on the floor, along the walls' directions give or take `loose` radians."""
        rng = self.rng
        item = self.chosen(thing, **limits)
        if item is None:
            return None
        x0, y0, x1, y1 = self.bounds
        for _ in range(tries):
            angle = rng.choice([0.0, math.pi / 2, math.pi, -math.pi / 2]) if turn is None else turn
            at = (rng.uniform(x0, x1), rng.uniform(y0, y1), 0.0)
            placed = self.put(item, at, angle + rng.uniform(-loose, loose), gap=margin, ways=ways)
            if placed is not None:
                return placed
        return None

    def beside(
        self,
        thing: str | Item | None,
        anchor: Placed,
        side: int,
        *,
        gap: float = 0.04,
        level: bool = True,
        **limits: Any,
    ) -> Placed | None:
        """Next to a thing, on its +x side (side 1) or its -x side (side -1), their backs in line."""
        item = self.chosen(thing, **limits)
        if item is None:
            return None
        base = anchor.item
        x = side * (base.size[0] / 2 + gap + item.size[0] / 2)
        y = base.size[1] / 2 - item.size[1] / 2 if level else 0.0
        return self.put(item, (*in_room(base, x, y), 0.0), base.turn, edge=anchor.edge)

    def before(
        self,
        thing: str | Item | None,
        anchor: Placed,
        distance: float,
        *,
        shift: float = 0.0,
        facing: bool = True,
        loose: float = 0.04,
        ways: bool = True,
        **limits: Any,
    ) -> Placed | None:
        """In front of a thing, `distance` metres between them, facing it or facing as it does."""
        item = self.chosen(thing, **limits)
        if item is None:
            return None
        base = anchor.item
        y = -(base.size[1] / 2 + distance + item.size[1] / 2)
        turn = base.turn + (math.pi if facing else 0.0) + self.rng.uniform(-loose, loose)
        return self.put(item, (*in_room(base, shift, y), 0.0), turn, ways=ways)

    def around(
        self, table: Placed, kind: str, *, share: float = 0.9, ends: bool = True, tuck: float = 0.12
    ) -> list[Placed]:
        """Chairs of one kind around a table, their fronts to it, pushed in more or less."""
        rng = self.rng
        chair = self.again(kind)
        if chair is None:
            return []
        width, depth, _ = table.item.size
        pitch = chair.size[0] + 0.1
        places: list[tuple[float, float, float]] = []
        for side, along, across in ((0, width, depth), (1, depth, width)):
            if side == 1 and not ends:
                continue
            count = int((along - 0.06) / pitch)
            if side == 1 and along < 0.65:
                count = 0
            for i in range(count):
                offset = (i - (count - 1) / 2) * (along / max(count, 1))
                reach = across / 2 + chair.size[1] / 2 - tuck * rng.uniform(-0.6, 1.0) * 2
                for sign in (-1, 1):
                    local = (offset, sign * reach) if side == 0 else (sign * reach, offset)
                    # A chair that is not turned faces -Y: it has to stand at +Y of the table.
                    turn = {(0, 1): 0.0, (0, -1): math.pi, (1, 1): -math.pi / 2, (1, -1): math.pi / 2}[
                        side, sign
                    ]
                    places.append((*local, turn))
        found = []
        for x, y, turn in places:
            if rng.random() > share:
                continue
            at = in_room(table.item, x, y)
            angle = (
                table.item.turn
                + turn
                + (rng.gauss(0.0, 0.1) if rng.random() < 0.8 else rng.uniform(-0.7, 0.7))
            )
            placed = self._tucked(chair, at, angle, table)
            if placed is not None:
                found.append(placed)
        return found

    def _tucked(self, chair: Item, at: Point2, turn: float, table: Placed) -> Placed | None:
        """A chair may stand under the edge of its table, but under nothing else."""
        item = replace(chair, position=rounded((*at, 0.0)), turn=round(turn, 4))
        block = replace(block_of(item), low=0.021)
        own = [other for other in self.ground.blocks if other.bounds == block_of(table.item).bounds]
        if not self.ground.free(block, ignore=own):
            return None
        self.ground.take(block)
        self.items.append(item)
        self.covered += item.size[0] * item.size[1] * 0.7
        return Placed(len(self.items) - 1, item)

    def ceiling(self, thing: str | Item | None, **limits: Any) -> Placed | None:
        """Under the ceiling, along the walls."""
        rng = self.rng
        item = self.chosen(thing, **limits)
        if item is None:
            return None
        x0, y0, x1, y1 = self.bounds
        for _ in range(8):
            at = (rng.uniform(x0, x1), rng.uniform(y0, y1), self.height - item.size[2])
            turn = rng.choice([0.0, math.pi / 2])
            candidate = replace(item, position=rounded(at), turn=round(turn, 4))
            block = replace(block_of(candidate, 0.05), high=self.height - 0.02)
            if self.ground.free(block, ways=False):
                self.ground.take(block)
                self.items.append(candidate)
                return Placed(len(self.items) - 1, candidate)
        return None
