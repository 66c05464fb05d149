"""One space while it is furnished: choosing things, and putting them against walls, free, around, on top."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import Any

from mixlight.data.rooms import pieces
from mixlight.data.rooms.catalogue import KINDS, Catalogue
from mixlight.data.rooms.furnish.ground import Block, Ground, block_of, corners_of, overlaps
from mixlight.data.rooms.furnish.tops import Top, tops_of
from mixlight.data.rooms.palette import choose
from mixlight.data.rooms.pieces import Style
from mixlight.data.rooms.plan import Item, Plan, Point2, Surface

__all__ = ["Placed", "Room"]

_LIBRARY = 0.6
"""Share of things that come from the library where it has the kind."""


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


class Room:
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
        self.plan, self.rng, self.style, self.catalogue = plan, rng, style, catalogue
        self.kind = plan.spaces[space].kind
        self.ground = Ground(plan, space)
        self.items = items
        self.first = len(items)
        self.area, self.height = self.ground.area, self.ground.height
        self.main = space == 0
        self.covered = 0.0
        """Floor under furniture, m²."""
        self.density = 1.0
        """How many small things there are, against the usual number."""
        self._on_tops: dict[int, list[Block]] = {}
        self._same: dict[str, Item] = {}

    # --- choosing ---------------------------------------------------------------------------------------

    def make(
        self,
        kind: str,
        *,
        width: float = math.inf,
        depth: float = math.inf,
        height: float = math.inf,
        own: bool | None = None,
    ) -> Item | None:
        """A thing of this kind, no larger than given (its height is always less than the room's); None if
        none of a few was small enough.

        `own`: True only our own pieces, False only the library's.
        """
        rng = self.rng
        height = min(height, self.height - 0.03)
        ours = bool(pieces.pieces_of(kind))
        found = self.catalogue.of(kind) if self.catalogue is not None and own is not True else ()
        entries = [e for e in found if e.size[0] <= width and e.size[1] <= depth and e.size[2] <= height]
        for _ in range(5):
            library = bool(entries) and (not ours or own is False or rng.random() < self._share(len(entries)))
            if library:
                return self._from_library(rng.choice(entries))
            if not ours or own is False:
                return None
            item = pieces.draw(kind, rng, self.style)
            if item.size[0] <= width and item.size[1] <= depth and item.size[2] <= height:
                return item
        return None

    def again(self, kind: str, **limits: Any) -> Item | None:
        """The same thing as the last time this was asked for in this room: chairs of one table match."""
        if kind not in self._same:
            item = self.make(kind, **limits)
            if item is None:
                return None
            self._same[kind] = item
        return self._same[kind]

    def forget(self, kind: str) -> None:
        """The next `again` draws anew."""
        self._same.pop(kind, None)

    def _share(self, count: int) -> float:
        # One or two models would be seen in every room.
        return _LIBRARY * count / (count + 1.5)

    def _from_library(self, entry: Any) -> Item:
        scale = self.rng.uniform(0.94, 1.06)
        size = tuple(round(extent * scale, 3) for extent in entry.size)
        surfaces: tuple[Surface, ...] = ()
        if not entry.textured and self.rng.random() < 0.5:
            surfaces = self._recolouring(entry.kind)
        parameters: dict[str, Any] = {}
        if entry.top is not None and KINDS[entry.kind].carries:
            x, y = size[0] / 2, size[1] / 2
            parameters["tops"] = [[-x, -y, x, y, round(entry.top * scale, 3), 1.0]]
        if entry.elevation:
            parameters["elevation"] = entry.elevation
        return Item(
            entry.kind,
            f"library:{entry.name}",
            (0.0, 0.0, 0.0),
            0.0,
            (size[0], size[1], size[2]),
            surfaces,
            parameters,
        )

    def _recolouring(self, kind: str) -> tuple[Surface, ...]:
        style, rng = self.style, self.rng
        if kind in ("sofa", "armchair", "ottoman", "chair", "office_chair", "bed"):
            return (rng.choice([style.upholstery, style.upholstery_2]), rng.choice([style.wood, style.metal]))
        if kind in (
            "table",
            "desk",
            "coffee_table",
            "shelf",
            "wardrobe",
            "sideboard",
            "dresser",
            "nightstand",
            "cabinet",
        ):
            return (style.wood, rng.choice([style.front, style.metal, style.wood]))
        if KINDS[kind].place == "top":
            return tuple(rng.sample(style.accents, 2))
        return ()

    # --- placing ----------------------------------------------------------------------------------------

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
            item, position=_round(position), turn=round((turn + math.pi) % (2 * math.pi) - math.pi, 4)
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
        item = self.make(thing, **limits) if isinstance(thing, str) else thing
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
        item = self.make(thing, **limits) if isinstance(thing, str) else thing
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
        item = self.make(thing, **limits) if isinstance(thing, str) else thing
        if item is None:
            return None
        base = anchor.item
        x = side * (base.size[0] / 2 + gap + item.size[0] / 2)
        y = base.size[1] / 2 - item.size[1] / 2 if level else 0.0
        return self.put(item, (*_from(base, x, y), 0.0), base.turn, edge=anchor.edge)

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
        item = self.make(thing, **limits) if isinstance(thing, str) else thing
        if item is None:
            return None
        base = anchor.item
        y = -(base.size[1] / 2 + distance + item.size[1] / 2)
        turn = base.turn + (math.pi if facing else 0.0) + self.rng.uniform(-loose, loose)
        return self.put(item, (*_from(base, shift, y), 0.0), turn, ways=ways)

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
            at = _from(table.item, x, y)
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
        item = replace(chair, position=_round((*at, 0.0)), turn=round(turn, 4))
        block = replace(block_of(item), low=0.021)
        own = [other for other in self.ground.blocks if other.bounds == block_of(table.item).bounds]
        if not self.ground.free(block, ignore=own):
            return None
        self.ground.take(block)
        self.items.append(item)
        self.covered += item.size[0] * item.size[1] * 0.7
        return Placed(len(self.items) - 1, item)

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
        item = self.make(thing, **limits) if isinstance(thing, str) else thing
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

    def ceiling(self, thing: str | Item | None, **limits: Any) -> Placed | None:
        """Under the ceiling, along the walls."""
        rng = self.rng
        item = self.make(thing, **limits) if isinstance(thing, str) else thing
        if item is None:
            return None
        x0, y0, x1, y1 = self.bounds
        for _ in range(8):
            at = (rng.uniform(x0, x1), rng.uniform(y0, y1), self.height - item.size[2])
            turn = rng.choice([0.0, math.pi / 2])
            candidate = replace(item, position=_round(at), turn=round(turn, 4))
            block = replace(block_of(candidate, 0.05), high=self.height - 0.02)
            if self.ground.free(block, ways=False):
                self.ground.take(block)
                self.items.append(candidate)
                return Placed(len(self.items) - 1, candidate)
        return None

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

    # --- on top of things -------------------------------------------------------------------------------

    def tops(self, base: Placed | int) -> list[Top]:
        """Where things can stand on an item."""
        return tops_of(self.items[base if isinstance(base, int) else base.index])

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
        item = self.make(thing) if isinstance(thing, str) else thing
        if item is None:
            return None
        below = self.items[index]
        taken = self._on_tops.setdefault(index, [])
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
            at = _from(below, *local)
            placed = replace(
                item,
                position=_round((*at, below.position[2] + place.height)),
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

    # --- the space --------------------------------------------------------------------------------------

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The smallest rectangle around the space."""
        xs, ys = [x for x, _ in self.ground.outline], [y for _, y in self.ground.outline]
        return min(xs), min(ys), max(xs), max(ys)

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

    def full(self, share: float = 0.42) -> bool:
        """Whether that share of the floor is under furniture, so that people can still walk."""
        return self.covered > share * self.area

    def chance(self, probability: float) -> bool:
        """True that often."""
        return self.rng.random() < probability


def _from(base: Item, x: float, y: float) -> Point2:
    """A point of an item's own frame, in the room."""
    c, s = math.cos(base.turn), math.sin(base.turn)
    return base.position[0] + c * x - s * y, base.position[1] + s * x + c * y


def _round(position: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = position
    return round(x, 4), round(y, 4), round(z, 4)
