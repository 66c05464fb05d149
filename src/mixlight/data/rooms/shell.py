"""Walls, floors and ceilings with their openings, and the building's outside."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.built_in import add_built_in
from mixlight.data.rooms.doors import add_doors
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.outline import Edge, Hole, cells, edges, holes
from mixlight.data.rooms.plan import Plan, Space, Surface
from mixlight.data.rooms.plan_json import read_surface

__all__ = ["add_facade", "add_skin", "parts"]

_OUTER = 0.3
_BELOW = 4.0
_SLAB = 0.3


def parts(plan: Plan) -> list[Part]:
    """Every part of the building but its windows: walls, floors, ceilings, reveals, doors, what is built in.

    The inner faces of a space and the reveals of its openings form a closed skin, and a second skin outside
    closes the building, so that light comes in through windows alone.
    """
    builder = Builder("shell")
    add_skin(builder, plan)
    add_facade(builder, plan)
    add_doors(builder, plan)
    add_built_in(builder, plan)
    return builder.parts()


def add_skin(builder: Builder, plan: Plan) -> None:
    """Adds the inner faces of all spaces and the reveals: closed but for the windows' outer ends."""
    for index, space in enumerate(plan.spaces):
        found = holes(plan, index)
        for i, edge in enumerate(edges(space.outline)):
            _wall(builder, space, i, edge, [hole for hole in found if hole.edge == i])
        _level(builder, space, 0.0, space.floor, up=True)
        _level(builder, space, space.height, space.ceiling, up=False)
    for opening_holes in (holes(plan, index) for index in range(len(plan.spaces))):
        for hole in opening_holes:
            if not hole.far:
                _reveal(builder, plan, hole)


def _wall(builder: Builder, space: Space, index: int, edge: Edge, found: list[Hole]) -> None:
    bands = [band for band in space.details.get("bands", ()) if band["edge"] == index]
    along = sorted({0.0, edge.length, *(v for hole in found for v in (hole.start, hole.end))})
    heights = {0.0, space.height, *(min(b[k], space.height) for b in bands for k in ("bottom", "top"))}
    for start, end in pairwise(along):
        middle = (start + end) / 2
        here = [hole for hole in found if hole.start < middle < hole.end]
        levels = sorted({*heights, *(v for hole in here for v in (hole.bottom, hole.top))})
        for low, high in pairwise(levels):
            centre = (low + high) / 2
            if any(hole.bottom < centre < hole.top for hole in here) or high - low < 1e-6:
                continue
            builder.wall_quad(_material(space, index, bands, centre), edge, (start, end), 0.0, (low, high))


def _material(space: Space, index: int, bands: list[dict[str, Any]], z: float) -> Surface:
    for band in bands:
        if band["bottom"] < z < band["top"]:
            return read_surface(band["surface"])
    return space.walls[index]


def _level(builder: Builder, space: Space, z: float, surface: Surface, *, up: bool) -> None:
    for x0, y0, x1, y1 in cells(space.outline):
        corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        if not up:
            corners.reverse()
        builder.quad(surface, [(x, y, z) for x, y in corners], corners)


def _reveal(builder: Builder, plan: Plan, hole: Hole) -> None:
    """The four sides of an opening, from the wall's inner face to the other end."""
    space, opening = plan.spaces[hole.space], hole.opening
    edge = edges(space.outline)[hole.edge]
    wall = space.walls[hole.edge]
    if "reveal" in opening.details:
        wall = read_surface(opening.details["reveal"])
    a, b, low, high, depth = hole.start, hole.end, hole.bottom, hole.top, opening.depth

    def side(
        surface: Surface, places: list[tuple[float, float, float]], uv: list[tuple[float, float]]
    ) -> None:
        builder.quad(surface, [(*edge.at(along, -into), z) for along, into, z in places], uv)

    up = [(0.0, low), (depth, low), (depth, high), (0.0, high)]
    side(wall, [(b, d, z) for d, z in up], up)
    back = up[::-1]
    side(wall, [(a, d, z) for d, z in back], back)
    across = [(a, 0.0), (b, 0.0), (b, depth), (a, depth)]
    side(wall, [(s, d, high) for s, d in across], across)
    ground = space.floor if low < 0.02 else wall
    back = across[::-1]
    side(ground, [(s, d, low) for s, d in back], [edge.at(s, -d) for s, d in back])
    if opening.kind == "door" and opening.leads is None:
        # What stands behind a shut door's gaps.
        builder.wall_quad(wall, edge, (a, b), -depth, (low, high))


def add_facade(builder: Builder, plan: Plan) -> None:
    """The outside of the building: one skin around all spaces, with the windows' holes.

    The skin lies where the windows' reveals end; it is found on the grid of all corners.
    """
    outdoors = [o for o in plan.openings if o.kind == "window" and o.leads is None]
    thickness = max((o.depth for o in outdoors), default=_OUTER)
    top = max(space.height for space in plan.spaces) + _SLAB
    surface = Surface("plaster", (0.55, 0.52, 0.47), None, 0.9)
    if "facade" in plan.spaces[0].details:
        surface = read_surface(plan.spaces[0].details["facade"])
    roof = Surface("concrete", (0.25, 0.25, 0.24), None, 0.9)
    solid = [
        (x0 - thickness, y0 - thickness, x1 + thickness, y1 + thickness)
        for space in plan.spaces
        for x0, y0, x1, y1 in cells(space.outline)
    ]
    xs = sorted({round(v, 6) for r in solid for v in (r[0], r[2])})
    ys = sorted({round(v, 6) for r in solid for v in (r[1], r[3])})
    inside = [
        [
            any(r[0] < (xa + xb) / 2 < r[2] and r[1] < (ya + yb) / 2 < r[3] for r in solid)
            for ya, yb in pairwise(ys)
        ]
        for xa, xb in pairwise(xs)
    ]

    def filled(i: int, j: int) -> bool:
        return 0 <= i < len(inside) and 0 <= j < len(inside[0]) and inside[i][j]

    faces: list[Edge] = []
    for i, (xa, xb) in enumerate(pairwise(xs)):
        for j, (ya, yb) in enumerate(pairwise(ys)):
            if not inside[i][j]:
                continue
            corners = [(xa, ya), (xb, ya), (xb, yb), (xa, yb)]
            builder.quad(roof, [(x, y, top) for x, y in corners], corners)
            around = edges(corners)
            beside = (filled(i, j - 1), filled(i + 1, j), filled(i, j + 1), filled(i - 1, j))
            faces += [edge for edge, neighbour in zip(around, beside, strict=True) if not neighbour]
    windows = []
    for opening in outdoors:
        edge = edges(plan.spaces[opening.space].outline)[opening.edge]
        windows.append(
            (edge, opening, edge.at(opening.start, -opening.depth), edge.at(opening.end, -opening.depth))
        )
    for face in faces:
        cuts = []
        for edge, opening, start, end in windows:
            if edge.direction != face.direction:
                continue
            across = (start[0] - face.start[0]) * face.inward[0] + (start[1] - face.start[1]) * face.inward[1]
            a, b = (
                (p[0] - face.start[0]) * face.direction[0] + (p[1] - face.start[1]) * face.direction[1]
                for p in (start, end)
            )
            if abs(across) < 1e-4 and b > 1e-6 and a < face.length - 1e-6:
                cuts.append((max(a, 0.0), min(b, face.length), opening.bottom, opening.top))
        _facade_face(builder, surface, face, cuts, top)


def _facade_face(
    builder: Builder, surface: Surface, face: Edge, cuts: list[tuple[float, float, float, float]], top: float
) -> None:
    along = sorted({0.0, face.length, *(v for cut in cuts for v in cut[:2])})
    for start, end in pairwise(along):
        if end - start < 1e-6:
            continue
        middle = (start + end) / 2
        here = [cut for cut in cuts if cut[0] < middle < cut[1]]
        levels = sorted({-_BELOW, top, *(v for cut in here for v in cut[2:])})
        for low, high in pairwise(levels):
            if not any(cut[2] < (low + high) / 2 < cut[3] for cut in here):
                builder.wall_quad(surface, face, (start, end), 0.0, (low, high), outside=True)
