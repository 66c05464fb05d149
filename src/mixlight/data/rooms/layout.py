"""The building of a plan: the main space, its neighbours behind doors and passages, and every opening."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from random import Random
from typing import Literal

from mixlight.data.rooms.fittings import draw_fittings
from mixlight.data.rooms.footprints import DIMENSIONS, Outline, draw_height, draw_outline, millimetres
from mixlight.data.rooms.outline import Edge, Rectangle, bounds, edges, holes_of, overlap
from mixlight.data.rooms.palette import Palette, choose, draw_palette, floor, paint_colour, tiles
from mixlight.data.rooms.plan import Opening, Space, Surface
from mixlight.data.rooms.plan_json import surface_document
from mixlight.data.rooms.window_plan import add_partition, draw_windows

__all__ = ["KIND_SHARES", "Building", "draw_building"]

KIND_SHARES: tuple[tuple[str, float], ...] = (
    ("living", 0.24),
    ("bedroom", 0.15),
    ("office", 0.15),
    ("kitchen", 0.12),
    ("bathroom", 0.07),
    ("hall", 0.07),
    ("corridor", 0.05),
    ("shop", 0.06),
    ("workshop", 0.06),
    ("empty", 0.03),
)
"""How often each kind is the main space."""

_NEIGHBOURS: dict[str, tuple[tuple[str, float], ...]] = {
    "living": (("kitchen", 4.0), ("corridor", 3.0), ("bedroom", 2.0), ("living", 1.5), ("office", 1.0)),
    "bedroom": (("corridor", 4.0), ("bathroom", 3.0), ("living", 1.0)),
    "office": (("office", 3.0), ("corridor", 4.0), ("empty", 0.5)),
    "kitchen": (("living", 4.0), ("corridor", 3.0)),
    "bathroom": (("corridor", 3.0), ("bedroom", 3.0)),
    "hall": (("corridor", 3.0), ("hall", 1.0), ("office", 1.0), ("living", 1.5)),
    "corridor": (("living", 2.0), ("bedroom", 2.0), ("office", 2.0), ("kitchen", 1.0), ("bathroom", 1.0)),
    "shop": (("shop", 1.0), ("corridor", 2.0), ("office", 1.0)),
    "workshop": (("workshop", 1.0), ("office", 1.0), ("corridor", 1.5)),
    "empty": (("corridor", 3.0), ("empty", 2.0), ("kitchen", 1.0)),
}

_NEIGHBOUR_COUNT: dict[str, tuple[float, ...]] = {
    "living": (0.25, 0.45, 0.25, 0.05),
    "corridor": (0.1, 0.3, 0.4, 0.2),
    "bathroom": (0.6, 0.4),
    "shop": (0.6, 0.35, 0.05),
    "workshop": (0.6, 0.35, 0.05),
}
"""Probabilities of 0, 1, 2 ... neighbours."""

_COMMON_COUNT = (0.4, 0.42, 0.18)

_OPEN_PLAN: dict[frozenset[str], float] = {
    frozenset({"living", "kitchen"}): 0.7,
    frozenset({"living"}): 0.9,
    frozenset({"hall"}): 0.9,
    frozenset({"shop"}): 0.8,
    frozenset({"hall", "living"}): 0.7,
    frozenset({"living", "corridor"}): 0.3,
    frozenset({"hall", "corridor"}): 0.5,
    frozenset({"office"}): 0.35,
    frozenset({"workshop"}): 0.6,
}
"""Probability that two kinds are joined by a passage without a door."""


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


def draw_building(rng: Random, kind: str | None = None) -> Building:
    """Spaces and openings of a plan; the main space is of `kind`, or of any.

    The main space's outline begins at the origin or near it, its floor is at z = 0 like all floors.
    """
    kind = kind or choose(rng, KIND_SHARES)
    height = draw_height(rng, kind)
    head = min(max(rng.gauss(2.15, 0.12), 1.98) + 0.55 * max(height - 2.6, 0.0), height - 0.12)
    building = Building(draw_palette(rng, kind), millimetres(rng.uniform(0.18, 0.48)), millimetres(head))
    outline = draw_outline(rng, kind)
    building.spaces.append(_space(rng, building, kind, outline, height, main=True))
    counts = _NEIGHBOUR_COUNT.get(kind, _COMMON_COUNT)
    for _ in range(choose(rng, list(enumerate(counts)))):
        _add_neighbour(rng, building, 0)
    for space in range(1, len(building.spaces)):
        if rng.random() < 0.2:
            _add_neighbour(rng, building, space)
    for space in range(len(building.spaces)):
        draw_windows(rng, building, space)
    for space in range(len(building.spaces)):
        _shut_doors(rng, building, space)
    for space in range(len(building.spaces)):
        draw_fittings(rng, building, space)
    return building


def _space(
    rng: Random, building: Building, kind: str, outline: Outline, height: float, *, main: bool
) -> Space:
    palette = building.palette
    wall = palette.wall
    if not main and rng.random() < 0.5:
        wall = replace(wall, kind="paint", colour=paint_colour(rng), second=None, bump=0.05)
    walls = [wall] * len(outline)
    if main and palette.accent is not None:
        lengths = [edge.length if edge.length > 1.5 else 0.0 for edge in edges(outline)]
        walls[rng.choices(range(len(walls)), lengths)[0]] = palette.accent
    ground = palette.floor if main else floor(rng, kind)
    if not main and kind not in ("bathroom", "kitchen") and rng.random() < 0.6:
        ground = palette.floor
    details = _details(rng, kind, walls)
    return Space(kind, outline, height, tuple(walls), ground, palette.ceiling, palette.skirting, details)


def _details(rng: Random, kind: str, walls: list[Surface]) -> dict[str, object]:
    """Bands of tiles round a bathroom; `fittings` adds more."""
    if kind == "bathroom" and rng.random() < 0.85:
        surface = tiles(rng, wall=True)
        if rng.random() < 0.5:
            walls[:] = [surface] * len(walls)
            return {}
        top = millimetres(rng.uniform(1.1, 2.05))
        return {
            "bands": [
                {"edge": i, "bottom": 0.0, "top": top, "surface": surface_document(surface)}
                for i in range(len(walls))
            ]
        }
    return {}


def _add_neighbour(rng: Random, building: Building, space: int) -> None:
    """Puts a room behind one of the walls, with a door or a passage to it, where there is place."""
    here = building.spaces[space]
    kind = choose(rng, _NEIGHBOURS[here.kind])
    order = list(range(len(here.outline)))
    rng.shuffle(order)
    opening = draw_doorway(rng, building, here.kind, kind)
    for edge_index in order:
        edge = edges(here.outline)[edge_index]
        width = min(opening[0], edge.length - 0.3)
        if width < 0.65:
            continue
        for _ in range(4):
            start = millimetres(rng.uniform(0.12, edge.length - width - 0.12))
            end = millimetres(start + width)
            if not building.free(space, edge_index, start, end):
                continue
            outline = _behind(rng, building, edge, start, end, kind, opening[2])
            if outline is None:
                continue
            low, high = DIMENSIONS[kind].height
            height = millimetres(min(max(here.height, low), max(high, min(here.height, 3.2))))
            top = millimetres(min(opening[1], here.height - 0.15, height - 0.15))
            building.spaces.append(_space(rng, building, kind, outline, height, main=False))
            building.openings.append(
                Opening(
                    opening[4],
                    space,
                    edge_index,
                    start,
                    end,
                    0.0,
                    top,
                    len(building.spaces) - 1,
                    opening[2],
                    opening[3],
                )
            )
            pair = {here.kind, kind}
            glass = 0.45 if "office" in pair and pair <= {"office", "corridor", "hall"} else 0.04
            if rng.random() < glass:
                add_partition(rng, building, space, len(building.spaces) - 1, opening[2])
            return


def _behind(
    rng: Random, building: Building, edge: Edge, start: float, end: float, kind: str, gap: float
) -> Outline | None:
    """A free rectangle behind a piece of a wall, `gap` metres away."""
    corners = draw_outline(rng, kind, plain=True, scale=0.8)
    _, _, width, depth = bounds(corners)
    width = max(width, end - start + 0.3)
    for shrink in (1.0, 0.75, 0.55):
        span, reach = max(width * shrink, end - start + 0.25), max(depth * shrink, 1.1)
        for _ in range(3):
            low = rng.uniform(end + 0.12 - span, start - 0.12)
            if rng.random() < 0.3:
                low = -rng.choice([0.0, span - edge.length])
                if low > start - 0.12 or low + span < end + 0.12:
                    continue
            low, high = millimetres(low), millimetres(low + span)
            rectangle = edge.rectangle(low, high, -gap - reach, -gap)
            x0, y0, x1, y1 = (millimetres(v) for v in rectangle)
            if building.clear((x0, y0, x1, y1), gap=gap - 0.002):
                return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    return None


def draw_doorway(
    rng: Random, building: Building, here: str, there: str
) -> tuple[float, float, float, dict[str, object], Literal["door", "passage"]]:
    """Width, top, depth, details and kind of the opening between two spaces."""
    depth = millimetres(rng.uniform(0.09, 0.24))
    if rng.random() < _OPEN_PLAN.get(frozenset({here, there}), 0.08):
        width = rng.uniform(0.95, 1.6) if rng.random() < 0.5 else rng.uniform(1.6, 4.2)
        top = rng.choice([2.05, 2.15, 2.3, 2.5, 9.0])  # the last: up to a lintel under the ceiling
        return width, top, depth, {"lining": rng.random() < 0.3, **_lining(building)}, "passage"
    width, details = door_details(rng, building, here)
    details["angle"] = round(choose(rng, [(rng.uniform(1.2, 1.57), 3.0), (rng.uniform(0.15, 1.2), 2.0)]), 3)
    return width, rng.choice([1.98, 2.01, 2.05, 2.1]), depth, details, "door"


def _lining(building: Building) -> dict[str, object]:
    return {"frame": surface_document(building.palette.trim)}


def door_details(rng: Random, building: Building, here: str) -> tuple[float, dict[str, object]]:
    """Width and details of a door."""
    wide = here in ("hall", "shop", "workshop", "office") and rng.random() < 0.3
    width = millimetres(rng.uniform(1.3, 1.9) if wide else rng.uniform(0.68, 0.95))
    style = choose(rng, [("panel", 4.0), ("flush", 3.5), ("glazed", 1.5 if here != "bathroom" else 0.1)])
    details: dict[str, object] = {
        "frame": surface_document(building.palette.trim),
        "leaf": surface_document(building.palette.door),
        "metal": surface_document(building.palette.metal),
        "style": style,
        "leaves": 2 if wide else 1,
        "hinge": rng.choice(["start", "end"]),
        "into": rng.random() < 0.5,
        "angle": 0.0,
    }
    return width, details


def _shut_doors(rng: Random, building: Building, space: int) -> None:
    """Every room can be entered: a shut door where there is no other way, sometimes one more."""
    here = building.spaces[space]
    ways = [h for h in holes_of(building.spaces, building.openings, space) if h.opening.kind != "window"]
    wanted = (0 if ways else 1) + choose(rng, [(0, 7.5), (1, 2.0), (2, 0.5)])
    if here.kind == "corridor":
        wanted += rng.randint(0, 3)
    order = [i for i in range(len(here.outline)) for _ in range(3)]
    rng.shuffle(order)
    for edge_index in order:
        if wanted <= 0:
            return
        width, details = door_details(rng, building, here.kind)
        length = edges(here.outline)[edge_index].length
        if length < width + 0.3:
            continue
        start = rng.choice([0.15, length - width - 0.15, rng.uniform(0.15, length - width - 0.15)])
        start, end = millimetres(start), millimetres(start + width)
        # A shut door needs its wall's thickness: no other room may begin right behind it.
        e = edges(here.outline)[edge_index]
        if building.free(space, edge_index, start, end, 0.12) and building.clear(
            e.rectangle(start, end, -0.1, -0.02)
        ):
            top = min(rng.choice([1.98, 2.01, 2.05, 2.1]), here.height - 0.15)
            building.openings.append(
                Opening("door", space, edge_index, start, end, 0.0, millimetres(top), None, 0.06, details)
            )
            wanted -= 1
