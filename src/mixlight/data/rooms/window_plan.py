"""Which windows a room has; `windows` makes their meshes."""

from __future__ import annotations

from random import Random
from typing import Any

from mixlight.data.rooms.building import Building
from mixlight.data.rooms.dressing_plan import draw_dressing, varied
from mixlight.data.rooms.footprints import millimetres
from mixlight.data.rooms.outline import Edge, edges
from mixlight.data.rooms.palette import choose
from mixlight.data.rooms.plan import Opening
from mixlight.data.rooms.plan_json import surface_document

__all__ = ["add_partition", "draw_windows"]

_WALLS_WITH_WINDOWS: dict[str, tuple[float, ...]] = {
    "living": (0.02, 0.58, 0.36, 0.04),
    "bedroom": (0.04, 0.72, 0.24),
    "office": (0.12, 0.6, 0.26, 0.02),
    "kitchen": (0.1, 0.68, 0.22),
    "bathroom": (0.45, 0.52, 0.03),
    "hall": (0.25, 0.4, 0.25, 0.1),
    "corridor": (0.55, 0.4, 0.05),
    "shop": (0.2, 0.65, 0.15),
    "workshop": (0.2, 0.5, 0.25, 0.05),
    "empty": (0.08, 0.55, 0.32, 0.05),
}
"""Probabilities of windows in 0, 1, 2 ... walls."""

_STYLES: dict[str, tuple[tuple[str, float], ...]] = {
    "living": (("casement", 5.0), ("picture", 2.0), ("french", 2.5), ("sliding", 1.5), ("tall", 1.0)),
    "bedroom": (("casement", 6.0), ("picture", 1.0), ("french", 1.5), ("tall", 0.8)),
    "office": (("ribbon", 3.5), ("casement", 3.0), ("curtain_wall", 1.5), ("picture", 1.0)),
    "kitchen": (("counter", 5.0), ("casement", 2.5), ("french", 1.2), ("sliding", 0.8)),
    "bathroom": (("small", 6.0), ("casement", 1.0)),
    "hall": (("tall", 3.0), ("clerestory", 2.0), ("curtain_wall", 1.5), ("casement", 1.5)),
    "corridor": (("casement", 3.0), ("small", 1.0), ("ribbon", 0.7), ("tall", 0.7)),
    "shop": (("shopfront", 5.0), ("clerestory", 1.0), ("casement", 0.8)),
    "workshop": (("industrial", 4.0), ("clerestory", 2.0), ("casement", 1.0)),
    "empty": (("casement", 4.0), ("french", 1.0), ("picture", 1.5), ("industrial", 0.7), ("tall", 1.0)),
}


def draw_windows(rng: Random, building: Building, space: int) -> None:
    """Adds a space's windows to the building."""
    here = building.spaces[space]
    count = choose(rng, list(enumerate(_WALLS_WITH_WINDOWS[here.kind])))
    walls = edges(here.outline)
    order = sorted(range(len(walls)), key=lambda i: -walls[i].length * rng.uniform(0.4, 1.0))
    style = choose(rng, _STYLES[here.kind])
    reveal = building.palette.trim if rng.random() < 0.5 else None
    common: dict[str, Any] = {
        "style": style,
        "frame": surface_document(building.palette.frame),
        "metal": surface_document(building.palette.metal),
        "frosted": here.kind == "bathroom" and rng.random() < 0.7,
        "inset": round(rng.uniform(0.15, 0.75), 3),
        "sill": rng.random() < 0.8,
    }
    if reveal is not None and reveal.kind == "paint":
        common["reveal"] = surface_document(reveal)
    dressing = draw_dressing(rng, here.kind, style)
    bay = _bay(walls)
    if count > 0 and bay is not None and here.kind in ("living", "bedroom", "empty", "kitchen"):
        bottom = rng.choice([0.4, 0.6, 0.85])
        rows = rng.choice([1, 1, 2])
        placed = []
        for edge in bay:
            # The sides of a bay begin behind the thickness of the wall that they come out of.
            thick = building.outer + 0.06
            start, end = (thick if edge == bay[0] else 0.1), (thick if edge == bay[2] else 0.1)
            span = (start, walls[edge].length - end)
            if span[1] - span[0] > 0.35:
                columns = max(1, round((span[1] - span[0]) / 0.8))
                details = {**common, "style": "bay", "mullions": [columns, rows]}
                heights = (bottom, building.head)
                placed.append(_place(rng, building, (space, edge), span, heights, details, dressing))
        count -= any(placed)
    for edge_index in order:
        if count <= 0:
            return
        spans_here, bottom, top, details = _spans(
            rng, style, walls[edge_index].length, building.head, here.height
        )
        placed = [
            _place(rng, building, (space, edge_index), span, (bottom, top), {**common, **details}, dressing)
            for span in spans_here
        ]
        count -= any(placed)


def _place(
    rng: Random,
    building: Building,
    wall: tuple[int, int],
    span: tuple[float, float],
    heights: tuple[float, float],
    details: dict[str, Any],
    dressing: dict[str, Any],
) -> bool:
    """Adds one window where the wall is free and the open air is behind it."""
    start, end = millimetres(span[0]), millimetres(span[1])
    if not building.free(*wall, start, end, 0.05) or not building.outdoors(*wall, start, end):
        return False
    bottom, top = (millimetres(z) for z in heights)
    values = {**details, **varied(rng, dressing)}
    building.openings.append(Opening("window", *wall, start, end, bottom, top, None, building.outer, values))
    return True


def _bay(walls: tuple[Edge, ...]) -> tuple[int, int, int] | None:
    """The three walls of a bay: a front of 1.5 m or more with short sides that lead inwards."""
    count = len(walls)
    for i, front in enumerate(walls):
        side, other = walls[i - 1], walls[(i + 1) % count]
        before, after = walls[i - 2], walls[(i + 2) % count]
        short = 0.4 < side.length < 1.0 and 0.4 < other.length < 1.0 and front.length > 1.5
        if short and before.direction == front.direction == after.direction:
            # An alcove goes outwards where the outline turns right into it.
            turn = before.direction[0] * side.direction[1] - before.direction[1] * side.direction[0]
            if turn < 0:
                return (i - 1) % count, i, (i + 1) % count
    return None


def add_partition(rng: Random, building: Building, near: int, far: int, depth: float) -> None:
    """A glass partition between two neighbours, as offices have, on the wall that they share."""
    here, there = edges(building.spaces[near].outline), building.spaces[far].outline
    opening = next(o for o in building.openings if o.space == near and o.leads == far)
    edge = here[opening.edge]
    shared = [
        (p[0] - edge.start[0]) * edge.direction[0] + (p[1] - edge.start[1]) * edge.direction[1] for p in there
    ]
    low, high = max(min(shared), 0.0) + 0.15, min(max(shared), edge.length) - 0.15
    for start, end in ((low, opening.start - 0.15), (opening.end + 0.15, high)):
        start, end = millimetres(start), millimetres(end)
        if end - start < 0.6 or not building.free(near, opening.edge, start, end, 0.1):
            continue
        bottom = rng.choice([0.06, 0.06, 0.9])
        top = max(min(building.spaces[s].height for s in (near, far)) - rng.choice([0.2, 0.6]), opening.top)
        details: dict[str, Any] = {
            "style": "partition",
            "frame": surface_document(building.palette.frame),
            "metal": surface_document(building.palette.metal),
            "frosted": rng.random() < 0.12,
            "inset": 0.3,
            "sill": False,
            "mullions": [max(1, round((end - start) / rng.uniform(0.9, 1.5))), 1],
            **draw_dressing(rng, "partition", "partition"),
        }
        building.openings.append(
            Opening("window", near, opening.edge, start, end, bottom, millimetres(top), far, depth, details)
        )


def _spans(
    rng: Random, style: str, length: float, head: float, height: float
) -> tuple[list[tuple[float, float]], float, float, dict[str, Any]]:
    """Places along a wall, sill, head and mullions (columns, rows) of a style's windows."""
    margin = rng.uniform(0.1, 0.7)
    bottom, top, columns, rows = 0.9, head, 1, 1
    if style in ("ribbon", "curtain_wall", "shopfront"):
        margin = rng.uniform(0.08, 0.5)
        spans = [(margin, length - margin)]
        if length > 7 and rng.random() < 0.5:
            middle = length / 2
            spans = [(margin, middle - 0.2), (middle + 0.2, length - margin)]
        width = spans[0][1] - spans[0][0]
        columns = max(1, round(width / rng.uniform(0.9, 1.7)))
        if style == "ribbon":
            bottom, rows = rng.uniform(0.7, 1.1), rng.choice([1, 1, 2])
        elif style == "curtain_wall":
            bottom, top, rows = rng.uniform(0.03, 0.4), height - rng.uniform(0.06, 0.3), rng.choice([1, 2, 2])
        else:
            bottom, top = rng.uniform(0.05, 0.6), min(height - 0.15, rng.uniform(2.4, 3.2))
        return _inside(spans, length), bottom, top, {"mullions": [columns, rows]}
    wanted = {
        "casement": rng.uniform(0.8, 1.9), "picture": rng.uniform(1.8, 3.2), "french": rng.uniform(0.9, 1.9),
        "sliding": rng.uniform(1.9, 4.2), "tall": rng.uniform(0.8, 1.5), "counter": rng.uniform(0.8, 1.9),
        "small": rng.uniform(0.45, 0.95), "clerestory": rng.uniform(1.0, 3.0),
        "industrial": rng.uniform(1.4, 3.6),
    }[style]  # fmt: skip
    width = min(wanted, length - 2 * margin, length - 0.3)
    if style == "casement":
        bottom, columns = rng.uniform(0.75, 1.05), 1 if width < 0.9 else rng.choice([2, 2, 3])
        rows = rng.choice([1, 1, 1, 2, 3])
    elif style == "picture":
        bottom, columns = rng.uniform(0.25, 0.7), rng.choice([1, 2, 3])
    elif style == "french":
        bottom, columns, rows = 0.03, 2 if width > 1.1 else 1, rng.choice([1, 1, 3, 4])
    elif style == "sliding":
        bottom, columns = 0.03, max(2, round(width / 1.2))
    elif style == "tall":
        bottom, columns, rows = rng.uniform(0.35, 0.8), 2, rng.choice([2, 3, 4])
        top = min(height - 0.2, head + 0.4)
    elif style == "counter":
        bottom, columns = rng.uniform(1.02, 1.2), rng.choice([1, 2])
    elif style == "small":
        bottom, top = rng.uniform(1.2, 1.5), min(head, 2.1)
    elif style == "clerestory":
        bottom = max(1.7, min(height - 1.2, height * rng.uniform(0.6, 0.75)))
        top, columns = height - rng.uniform(0.12, 0.3), max(1, round(width / rng.uniform(0.8, 1.5)))
    elif style == "industrial":
        bottom, top = rng.uniform(0.9, 1.4), min(height - 0.2, rng.uniform(2.3, 3.6))
        columns, rows = max(2, round(width / 0.45)), rng.randint(3, 5)
    if top - bottom < 0.4 or width < 0.4:
        return [], bottom, top, {}
    pier = rng.uniform(0.3, 1.6)
    many = max(1, int((length - 2 * margin + pier) / (width + pier)))
    most = {"living": 3, "small": 1, "counter": 1, "picture": 2, "sliding": 1, "french": 2}.get(style, 3)
    if style in ("clerestory", "industrial", "tall"):
        most = 8
    many = min(many, rng.randint(1, most) if most < 8 else most)
    total = many * width + (many - 1) * pier
    first = (
        (length - total) / 2
        if rng.random() < 0.6
        else rng.uniform(margin, max(margin, length - total - margin))
    )
    spans = [(first + i * (width + pier), first + i * (width + pier) + width) for i in range(many)]
    return _inside(spans, length), bottom, top, {"mullions": [columns, rows]}


def _inside(spans: list[tuple[float, float]], length: float) -> list[tuple[float, float]]:
    return [(a, b) for a, b in spans if a >= 0.06 and b <= length - 0.06 and b - a > 0.35]
