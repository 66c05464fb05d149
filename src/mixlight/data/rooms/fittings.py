"""What is built into a room beside walls and openings, drawn as plain values for `Space.details`.

Keys, each optional; boxes are [x0, y0, x1, y1, z0, z1] in the room frame, surfaces are documents:
`beams`, `columns` (boxes) with `beams_surface`, `columns_surface`, `columns_round`; `soffits` (boxes of the
ceiling's surface); `ducts` ([x0, y0, z0, x1, y1, z1, radius]) with `ducts_surface`; `cornice` (size,
surface); `rails` (z, height, depth, surface); `panels` (bottom, top, width, style, surface, edges);
`fireplace` (edge, centre, width, height, depth, surface); `skirting` ([height, depth]); `plates` (places of
switches and sockets: [edge, along, z, width]); `obstacles` (boxes round what other things must not enter).
"""

from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Any

from mixlight.data.rooms.building import Building
from mixlight.data.rooms.footprints import millimetres
from mixlight.data.rooms.outline import (
    Edge,
    Hole,
    Outline,
    Rectangle,
    area,
    bounds,
    contains_rectangle,
    edges,
    holes_of,
)
from mixlight.data.rooms.palette import UPRIGHT, choose, paint_colour, wood_colour
from mixlight.data.rooms.plan import Surface
from mixlight.data.rooms.plan_json import surface_document

__all__ = ["draw_fittings", "free_runs", "strips"]

_HOMES = ("living", "bedroom", "kitchen", "corridor", "empty")
_LARGE = ("hall", "shop", "workshop", "office")


def draw_fittings(rng: Random, building: Building, space: int) -> None:
    """Adds what is built into a space of the building, once its openings are known."""
    here = building.spaces[space]
    found = holes_of(building.spaces, building.openings, space)
    details: dict[str, Any] = dict(here.details)
    walls = edges(here.outline)
    head = max((hole.top for hole in found), default=2.0)
    room = here.height - head
    details["skirting"] = [millimetres(rng.uniform(0.055, 0.15)), millimetres(rng.uniform(0.01, 0.02))]
    if (
        here.kind in (*_HOMES, "hall")
        and here.height > 2.5
        and rng.random() < 0.3 + 0.3 * (here.height > 2.8)
    ):
        details["cornice"] = {
            "size": millimetres(rng.uniform(0.05, 0.14)),
            "surface": surface_document(
                here.ceiling if here.ceiling.kind == "paint" else building.palette.trim
            ),
        }
    if rng.random() < {"workshop": 0.45, "living": 0.12, "hall": 0.2, "shop": 0.2}.get(here.kind, 0.05):
        _beams(rng, here.outline, here.height, room, details)
    if here.kind in _LARGE and area(here.outline) > 55 and rng.random() < 0.65:
        _columns(rng, building, here.outline, here.height, found, details)
    if here.kind in ("workshop", "shop", "office", "hall") and room > 0.25 and rng.random() < 0.4:
        _ducts(rng, here.outline, here.height, room, details)
    if here.kind in (*_HOMES, "bathroom", "office") and room > 0.3 and rng.random() < 0.1:
        _soffit(rng, walls, here.height, details)
    if here.kind in ("living", "bedroom", "hall", "corridor", "office") and rng.random() < 0.22:
        _panels(rng, building, here.kind, here.height, len(walls), details)
    if here.kind in ("living", "hall") and rng.random() < 0.25:
        _fireplace(rng, walls, found, details)
    details["plates"] = _plates(rng, walls, found)
    building.spaces[space] = replace(here, details=details)


def strips(outline: Outline, at: float, *, across_x: bool) -> list[tuple[float, float]]:
    """The pieces of a line at y = `at` (or x, for `across_x` False) that lie in an outline.

    >>> strips(((0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)), 3.0, across_x=True)
    [(0, 2)]
    """
    k = 0 if across_x else 1
    crossings = sorted(
        a[k]
        for a, b in zip(outline, (*outline[1:], outline[0]), strict=True)
        if min(a[1 - k], b[1 - k]) < at < max(a[1 - k], b[1 - k])
    )
    return list(zip(crossings[::2], crossings[1::2], strict=True))


def free_runs(
    length: float, found: list[Hole], z: tuple[float, float], margin: float = 0.08
) -> list[tuple[float, float]]:
    """The pieces of a wall that no opening interrupts between two heights."""
    at, runs = 0.0, []
    for hole in sorted(found, key=lambda hole: hole.start):
        if hole.bottom >= z[1] + margin or hole.top <= z[0] - margin:
            continue
        if hole.start - margin > at:
            runs.append((at, hole.start - margin))
        at = max(at, hole.end + margin)
    if length > at:
        runs.append((at, length))
    return [(a, b) for a, b in runs if b - a > 0.02]


def _beams(rng: Random, outline: Outline, height: float, room: float, details: dict[str, Any]) -> None:
    deep = min(rng.uniform(0.1, 0.32), room - 0.02)
    if deep < 0.07:
        return
    x0, y0, x1, y1 = bounds(outline)
    across_x = x1 - x0 < y1 - y0
    if rng.random() < 0.15:
        across_x = not across_x
    low, high = (y0, y1) if across_x else (x0, x1)
    wide, pitch = rng.uniform(0.07, 0.28), rng.uniform(0.6, 2.6)
    count = max(1, int((high - low) / pitch))
    found: list[list[float]] = []
    for i in range(count):
        at = low + (high - low) * (i + 0.5) / count
        for a, b in strips(outline, at, across_x=across_x):
            box = (a, at - wide / 2, b, at + wide / 2) if across_x else (at - wide / 2, a, at + wide / 2, b)
            if contains_rectangle(outline, box, -1e-3):
                found.append([*(millimetres(v) for v in box), millimetres(height - deep), height])
    if found:
        details["beams"] = found
        colour = wood_colour(rng) if rng.random() < 0.75 else paint_colour(rng)
        details["beams_surface"] = surface_document(
            Surface("wood", colour, roughness=0.7, bump=0.2, seed=rng.randrange(10_000))
        )


def _columns(
    rng: Random,
    building: Building,
    outline: Outline,
    height: float,
    found: tuple[Hole, ...],
    details: dict[str, Any],
) -> None:
    x0, y0, x1, y1 = bounds(outline)
    nx, ny = (max(1, round((b - a) / rng.uniform(4.5, 7.5))) for a, b in ((x0, x1), (y0, y1)))
    size = rng.uniform(0.24, 0.55)
    walls = edges(outline)
    ways = [walls[hole.edge].rectangle(hole.start, hole.end, 0.0, 1.2) for hole in found]
    boxes: list[list[float]] = []
    for i in range(1, nx + 1):
        for j in range(1, ny + 1):
            x, y = x0 + (x1 - x0) * i / (nx + 1), y0 + (y1 - y0) * j / (ny + 1)
            box: Rectangle = (x - size / 2, y - size / 2, x + size / 2, y + size / 2)
            if contains_rectangle(outline, box, 0.9) and not any(_near(box, way) for way in ways):
                boxes.append([*(millimetres(v) for v in box), 0.0, height])
    if boxes:
        details["columns"] = boxes
        details["columns_round"] = rng.random() < 0.35
        surface = choose(
            rng,
            [
                (replace(building.palette.wall, seed=rng.randrange(10_000)), 3.0),
                (Surface("concrete", (0.3, 0.295, 0.285), None, 0.85, bump=0.2), 1.0),
                (Surface("paint", paint_colour(rng), None, 0.6), 1.0),
            ],
        )
        details["columns_surface"] = surface_document(surface)


def _near(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _ducts(rng: Random, outline: Outline, height: float, room: float, details: dict[str, Any]) -> None:
    x0, y0, x1, y1 = bounds(outline)
    along_x = x1 - x0 > y1 - y0
    low, high = (y0, y1) if along_x else (x0, x1)
    found: list[list[float]] = []
    for _ in range(rng.randint(1, 3)):
        radius = min(rng.choice([0.025, 0.05, 0.1, 0.16, 0.22]), room / 2 - 0.05)
        at = rng.uniform(low + 0.4, high - 0.4)
        z = height - radius - rng.uniform(0.03, max(0.04, min(room - 2 * radius, 0.4)))
        pieces = strips(outline, at, across_x=along_x)
        if radius < 0.02 or not pieces:
            continue
        a, b = max(pieces, key=lambda piece: piece[1] - piece[0])
        ends = (a, at, z, b, at, z) if along_x else (at, a, z, at, b, z)
        found.append([*(millimetres(v) for v in ends), millimetres(radius)])
    if found:
        details["ducts"] = found
        metal = Surface("metal", (0.55, 0.56, 0.57), roughness=0.4, metallic=1.0)
        details["ducts_surface"] = surface_document(
            choose(rng, [(metal, 2.0), (Surface("paint", paint_colour(rng), roughness=0.5), 1.0)])
        )
        for a, b, c, d, e, _, r in found:
            # Round the pipe, and no longer than it.
            x, y = (0.0, r) if along_x else (r, 0.0)
            box = (min(a, d) - x, min(b, e) - y, max(a, d) + x, max(b, e) + y, c - r, c + r)
            details.setdefault("obstacles", []).append([millimetres(v) for v in box])


def _soffit(rng: Random, walls: tuple[Edge, ...], height: float, details: dict[str, Any]) -> None:
    """A lowered strip of the ceiling along one wall."""
    edge = rng.choice([e for e in walls if e.length > 1.5])
    rectangle = edge.rectangle(0.0, edge.length, 0.0, rng.uniform(0.35, 0.9))
    box = [*(millimetres(v) for v in rectangle), millimetres(height - rng.uniform(0.15, 0.28)), height]
    details["soffits"] = [box]
    details.setdefault("obstacles", []).append(box)


def _panels(
    rng: Random, building: Building, kind: str, height: float, count: int, details: dict[str, Any]
) -> None:
    style = choose(rng, [("frames", 4.0 if height > 2.6 else 1.5), ("boards", 2.5), ("slats", 1.5)])
    trim = building.palette.trim
    if style == "frames":
        # The same paint as the wall behind: only the relief shows.
        bottom, top, surface, on = 0.22, rng.choice([0.95, height - 0.25]), None, list(range(count))
    elif style == "boards":
        bottom, top, on = 0.0, rng.uniform(0.85, 1.35), list(range(count))
        wood = Surface("wood", wood_colour(rng), roughness=0.5, bump=0.1, turn=UPRIGHT)
        surface = trim if rng.random() < 0.6 else wood
        details["rails"] = [
            {"z": millimetres(top), "height": 0.03, "depth": 0.035, "surface": surface_document(surface)}
        ]
    else:
        bottom, top, on = 0.0, height, [rng.randrange(count)]
        surface = Surface("wood", wood_colour(rng), roughness=0.55, bump=0.1, turn=UPRIGHT)
    details["panels"] = {
        "style": style,
        "bottom": bottom,
        "top": millimetres(top),
        "width": millimetres(rng.uniform(0.5, 1.1) if style == "frames" else rng.uniform(0.07, 0.16)),
        "surface": None if surface is None else surface_document(surface),
        "edges": on,
    }


def _fireplace(
    rng: Random, walls: tuple[Edge, ...], found: tuple[Hole, ...], details: dict[str, Any]
) -> None:
    """A fireplace where a wall has 1.6 m free; on a chimney breast if there is one."""
    wide, high, deep = rng.uniform(1.1, 1.6), rng.uniform(0.95, 1.25), rng.uniform(0.12, 0.3)
    places = []
    for i, edge in enumerate(walls):
        here = [hole for hole in found if hole.edge == i]
        for a, b in free_runs(edge.length, here, (0.0, 2.0), 0.15):
            if b - a > wide:
                # A breast's front has two short walls beside it, and is itself hardly longer than the fire.
                places.append((abs((a + b) / 2 - edge.length / 2) + (edge.length - wide), i, (a + b) / 2))
    if not places:
        return
    _, index, centre = min(places)
    stone = Surface("stone", (0.5, 0.47, 0.42), roughness=0.5, seed=rng.randrange(10_000))
    surface = choose(
        rng,
        [
            (stone, 1.5),
            (Surface("paint", (0.72, 0.71, 0.68), roughness=0.4), 2.0),
            (Surface("brick", (0.3, 0.13, 0.08), (0.34, 0.31, 0.27), 0.9, bump=0.6), 1.0),
            (Surface("stone", (0.06, 0.058, 0.055), roughness=0.3), 0.7),
        ],
    )
    details["fireplace"] = {
        "edge": index,
        "centre": millimetres(centre),
        "width": millimetres(wide),
        "height": millimetres(high),
        "depth": millimetres(deep),
        "surface": surface_document(surface),
    }
    x0, y0, x1, y1 = walls[index].rectangle(centre - wide / 2, centre + wide / 2, 0.0, deep + 0.5)
    box = [*(millimetres(v) for v in (x0, y0, x1, y1)), 0.0, millimetres(high + 0.06)]
    details.setdefault("obstacles", []).append(box)


def _plates(rng: Random, walls: tuple[Edge, ...], found: tuple[Hole, ...]) -> list[list[float]]:
    """A switch beside every door, sockets near the floor."""
    plates: list[list[float]] = []
    for hole in found:
        if hole.opening.kind == "door":
            lock_at_end = (hole.opening.details.get("hinge") == "start") != hole.far
            along = hole.end + 0.17 if lock_at_end else hole.start - 0.17
            if 0.1 < along < walls[hole.edge].length - 0.1:
                plates.append([hole.edge, millimetres(along), 1.08, rng.choice([0.08, 0.08, 0.15])])
    for i, edge in enumerate(walls):
        here = [hole for hole in found if hole.edge == i]
        for a, b in free_runs(edge.length, here, (0.2, 0.4), 0.15):
            if b - a > 1.0 and rng.random() < 0.6:
                plates.append(
                    [i, millimetres(rng.uniform(a + 0.2, b - 0.2)), 0.3, rng.choice([0.08, 0.15, 0.22])]
                )
    return [
        plate
        for plate in plates
        if all(
            not (
                h.edge == plate[0]
                and h.start - 0.1 < plate[1] < h.end + 0.1
                and h.bottom < plate[2] + 0.1
                and plate[2] - 0.1 < h.top
            )
            for h in found
        )
    ]
