"""The building of a plan: the main space, its neighbours behind doors and passages, and every opening."""

from __future__ import annotations

from dataclasses import replace
from random import Random

from mixlight.data.rooms.building import Building
from mixlight.data.rooms.doorways import add_shut_doors, draw_doorway
from mixlight.data.rooms.fittings import draw_fittings
from mixlight.data.rooms.footprints import DIMENSIONS, draw_height, draw_outline, millimetres
from mixlight.data.rooms.outline import Edge, Outline, bounds, edges
from mixlight.data.rooms.palette import choose, floor, paint_colour, tiles
from mixlight.data.rooms.plan import Opening, Space, Surface
from mixlight.data.rooms.plan_json import surface_document
from mixlight.data.rooms.scheme import draw_palette
from mixlight.data.rooms.window_plan import add_partition, draw_windows

__all__ = ["KIND_SHARES", "draw_building"]

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
        add_shut_doors(rng, building, space)
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
