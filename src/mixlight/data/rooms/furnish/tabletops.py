"""Putting things on top of other things."""

from __future__ import annotations

import math
from dataclasses import replace

from mixlight.data.rooms.furnish.ground import Block, block_of, corners_of, overlaps
from mixlight.data.rooms.furnish.placed import Placed, in_room, rounded
from mixlight.data.rooms.furnish.space import Space
from mixlight.data.rooms.furnish.tops import tops_of
from mixlight.data.rooms.plan import Item

__all__ = ["Tabletops"]


class Tabletops(Space):
    """A space in which things stand on things."""

    def on(
        self,
        thing: str | Item | None,
        base: Placed | int,
        *,
        tries: int = 6,
        x: float | None = None,
        y: float | None = None,
        turn: float | None = None,
        spread: float = math.pi,
        top: int | None = None,
        back: bool = False,
    ) -> Placed | None:
        """On top of an item: anywhere on it, or at `x`, `y` (-1 to 1 of what is free there), turned by `turn`
        against it, give or take `spread`; `back`: along its rear edge.
        """
        rng = self.rng
        index = base if isinstance(base, int) else base.index
        tops = tops_of(self.items[index])
        if not tops:
            return None
        item = self.chosen(thing)
        if item is None:
            return None
        below = self.items[index]
        taken = self.on_tops.setdefault(index, [])
        for _ in range(tries):
            place = tops[top] if top is not None else rng.choices(tops, [t.area for t in tops])[0]
            if item.size[2] > place.clear:
                continue
            angle = (turn or 0.0) + rng.uniform(-spread, spread)
            reach_x = (abs(math.cos(angle)) * item.size[0] + abs(math.sin(angle)) * item.size[1]) / 2
            reach_y = (abs(math.sin(angle)) * item.size[0] + abs(math.cos(angle)) * item.size[1]) / 2
            half_x, half_y = place.width / 2 - reach_x - 0.005, place.depth / 2 - reach_y - 0.005
            if half_x < 0 or half_y < 0:
                continue
            u = x if x is not None else rng.uniform(-1, 1)
            v = y if y is not None else (rng.uniform(0.7, 1.0) if back else rng.uniform(-1, 1))
            local = (place.x + u * half_x, place.y + v * half_y)
            block = Block.of(
                corners_of(local, angle, item.size[0], item.size[1], 0.004),
                place.height,
                place.height + item.size[2],
            )
            if any(overlaps(block, other) for other in taken):
                continue
            at = in_room(below, *local)
            placed = replace(
                item,
                position=rounded((*at, below.position[2] + place.height)),
                turn=round(below.turn + angle, 4),
                supported_by=index,
            )
            # Something on the wall behind (a shelf, a picture) may hang into what is free above.
            solid = block_of(placed)
            near = replace(solid, low=solid.low + 0.01)
            if any(
                overlaps(near, other) for other in self.ground.blocks if other.low > below.position[2] + 0.3
            ):
                continue
            taken.append(block)
            self.items.append(placed)
            return Placed(len(self.items) - 1, placed)
        return None
