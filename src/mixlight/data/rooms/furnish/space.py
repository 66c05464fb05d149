"""One space while it is furnished: what stands in it, and putting a thing at a place."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.furnish.chooser import Chooser
from mixlight.data.rooms.furnish.ground import Block, Ground, block_of
from mixlight.data.rooms.furnish.placed import Placed, rounded
from mixlight.data.rooms.pieces import Style
from mixlight.data.rooms.plan import Item, Plan

__all__ = ["Space"]


class Space(Chooser):
    """One space of a plan, and the items of the whole plan so far."""

    def __init__(
        self,
        plan: Plan,
        space: int,
        rng: Random,
        style: Style,
        catalogue: Catalogue | None,
        items: list[Item],
    ) -> None:
        self.plan = plan
        self.kind = plan.spaces[space].kind
        self.ground = Ground(plan, space)
        super().__init__(rng, style, catalogue, self.ground.height)
        self.items = items
        self.first = len(items)
        self.area = self.ground.area
        self.main = space == 0
        self.covered = 0.0
        """Floor under furniture, m²."""
        self.density = 1.0
        """How many small things there are, against the usual number."""
        self.on_tops: dict[int, list[Block]] = {}
        """What is taken on top of the item of that number, in its own frame."""

    def put(
        self,
        item: Item,
        position: tuple[float, float, float],
        turn: float,
        *,
        gap: float = 0.0,
        ways: bool = True,
        edge: int | None = None,
        along: float = 0.0,
        solid: bool = True,
    ) -> Placed | None:
        """Put an item there if nothing is in its way; `gap` metres stay free around it."""
        item = replace(
            item, position=rounded(position), turn=round((turn + math.pi) % (2 * math.pi) - math.pi, 4)
        )
        block = block_of(item, gap)
        if solid and item.position[2] < 0.02:  # what stands on the floor may stand on a rug
            block = replace(block, low=max(block.low, 0.021))
        if solid and not self.ground.free(block, ways=ways):
            return None
        if solid:
            self.ground.take(replace(block_of(item), low=block.low))
        self.items.append(item)
        if solid and position[2] < 0.2 and item.size[2] > 0.3:
            self.covered += item.size[0] * item.size[1]
        return Placed(len(self.items) - 1, item, edge, along)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The smallest rectangle around the space."""
        xs, ys = [x for x, _ in self.ground.outline], [y for _, y in self.ground.outline]
        return min(xs), min(ys), max(xs), max(ys)

    def full(self, share: float = 0.42) -> bool:
        """Whether that share of the floor is under furniture, so that people can still walk."""
        return self.covered > share * self.area

    def chance(self, probability: float) -> bool:
        """True that often."""
        return self.rng.random() < probability
