"""Where panoramas are taken: at eye height, in free places, apart from each other."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

from mixlight.data.rooms.footprints import millimetres
from mixlight.data.rooms.outline import Edge, Hole, Leaf, bounds, contains, edges, holes, leaves, obstacles
from mixlight.data.rooms.plan import Camera, Item, Plan, Point3

__all__ = ["clearance", "place_cameras"]

EYE_HEIGHT = (1.1, 1.8)
"""Metres over the floor: sitting to standing."""

_TRIES = 240
_LEVELS = ((0.45, 0.4, False), (0.3, 0.3, False), (0.3, 0.3, True), (0.18, 0.2, True), (0.08, 0.12, True))
"""Distance to walls, to things, and whether a thing well below the camera may stand under it."""


def place_cameras(plan: Plan, rng: Random, count: int = 3) -> Plan:
    """The plan with `count` cameras in its main space.

    A camera keeps .45 m from walls and .4 m from furniture where the room has such places, less where it has
    none; it stands over free floor if there is any, else over low things. The second and further cameras
    are taken far from the others, so that the light differs.

    Raises:
        ValueError: a count below 1, or a room so full that no camera fits.
    """
    if count < 1:
        raise ValueError(f"expected at least 1 camera, got {count}")
    space = plan.spaces[0]
    x0, y0, x1, y1 = bounds(space.outline)
    places: list[Point3] = []
    for wall, thing, over in _LEVELS:
        places = []
        for _ in range(_TRIES):
            x, y = rng.uniform(x0, x1), rng.uniform(y0, y1)
            z = min(rng.triangular(*EYE_HEIGHT, 1.5), space.height - 0.4)
            if contains(space.outline, (x, y), wall) and clearance(plan, (x, y, z), over=over) >= thing:
                places.append((millimetres(x), millimetres(y), millimetres(z)))
        if len(places) >= 4 * count:
            break
        if places and (wall, thing, over) == _LEVELS[-1]:
            break
    if not places:
        raise ValueError(
            f"no place for a camera in room {plan.seed}: {len(plan.items)} things in {space.kind}"
        )
    # Photographers stand rather in the open: of two places the one with more room around.
    chosen = [max(rng.sample(places, min(2, len(places))), key=lambda p: _room_around(plan, p))]
    while len(chosen) < count:
        # Of a few places the farthest, so that not every second camera stands in a corner.
        some = rng.sample(places, min(6, len(places)))
        chosen.append(max(some, key=lambda p: min(math.dist(p, q) for q in chosen)))
    cameras = tuple(Camera(0, p, round(rng.uniform(-math.pi, math.pi), 4)) for p in chosen)
    return replace(plan, cameras=cameras)


def _room_around(plan: Plan, place: Point3) -> float:
    """Distance to the nearest wall or thing."""
    x, y, _ = place
    walls = min(
        math.hypot(
            max(min(a[0], b[0]) - x, x - max(a[0], b[0]), 0), max(min(a[1], b[1]) - y, y - max(a[1], b[1]), 0)
        )
        for a, b in ((edge.start, edge.end) for edge in edges(plan.spaces[0].outline))
    )
    return min(walls, clearance(plan, place))


def clearance(plan: Plan, point: Point3, *, over: bool = True) -> float:
    """Distance in metres from a point to the nearest thing of the plan; negative inside one.

    Things are the boxes around items and fixtures, what is built into the main space, and its doors'
    leaves. `over`: a thing that ends .35 m or more under the point is not in the way; else whatever is
    higher than .12 m is.
    """
    x, y, z = point
    nearest = math.inf
    for item in plan.items:
        low, high = item.position[2], item.position[2] + item.size[2]
        if low > z + 0.35 or high < (z - 0.35 if over else 0.12):
            continue
        nearest = min(nearest, _to_footprint(item, x, y))
    for fixture in plan.fixtures:
        # A shade right overhead would fill half of the panorama.
        if fixture.position[2] - fixture.size[2] / 2 < z + 0.3 + min(fixture.size[:2]):
            reach = max(fixture.size[0], fixture.size[1]) / 2 + 0.1
            nearest = min(nearest, math.hypot(fixture.position[0] - x, fixture.position[1] - y) - reach)
    for a, b, c, d, low, high in obstacles(plan.spaces[0]):
        if low - 0.3 < z < high + 0.3:
            nearest = min(nearest, _outside(max(a - x, x - c), max(b - y, y - d)))
    for edge, hole in ((edges(plan.spaces[0].outline)[h.edge], h) for h in holes(plan, 0)):
        if hole.opening.kind == "door" and hole.opening.leads is not None:
            nearest = min(nearest, *(_to_leaf(leaf, x, y) for leaf in _leaves_here(plan, edge, hole)))
    return nearest


def _leaves_here(plan: Plan, edge: Edge, hole: Hole) -> list[Leaf]:
    """The leaves of a door, which the space that wrote it knows."""
    if hole.far:
        near = plan.spaces[hole.opening.space]
        edge = edges(near.outline)[hole.opening.edge]
        hole = next(h for h in holes(plan, hole.opening.space) if h.index == hole.index and not h.far)
    return leaves(edge, hole)


def _to_leaf(leaf: Leaf, x: float, y: float) -> float:
    """Distance to a leaf seen from above, a line as long as the leaf is wide."""
    (u, v), heading, _, width = leaf
    along = (x - u) * math.cos(heading) + (y - v) * math.sin(heading)
    across = (y - v) * math.cos(heading) - (x - u) * math.sin(heading)
    return math.hypot(across, along - min(max(along, 0.0), width)) - 0.05


def _to_footprint(item: Item, x: float, y: float) -> float:
    dx, dy = x - item.position[0], y - item.position[1]
    c, s = math.cos(item.turn), math.sin(item.turn)
    u, v = c * dx + s * dy, -s * dx + c * dy
    return _outside(abs(u) - item.size[0] / 2, abs(v) - item.size[1] / 2)


def _outside(dx: float, dy: float) -> float:
    """Distance to a rectangle from the distances beyond its sides; negative inside."""
    if dx <= 0 and dy <= 0:
        return max(dx, dy)
    return math.hypot(max(dx, 0.0), max(dy, 0.0))
