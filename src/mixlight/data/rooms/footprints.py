"""Sizes and shapes of rooms: dimensions by kind, rectangles, L-shapes, alcoves, chimney breasts, bays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

from mixlight.data.rooms.outline import Outline, area, edges
from mixlight.data.rooms.palette import choose

__all__ = [
    "DIMENSIONS",
    "Dimensions",
    "draw_height",
    "draw_outline",
    "millimetres",
    "pushed",
    "without_corner",
]


@dataclass(frozen=True)
class Dimensions:
    """How large rooms of a kind are."""

    area: tuple[float, float]
    """m²; drawn evenly in its logarithm."""
    aspect: tuple[float, float]
    """Long side by short side."""
    height: tuple[float, float]
    narrow: float
    """The least width in metres."""
    l_shape: float = 0.0
    """Probability of a missing corner."""
    niche: float = 0.0
    """Probability of an alcove, a chimney breast or a bay."""


DIMENSIONS: dict[str, Dimensions] = {
    "living": Dimensions((13, 46), (1.0, 1.9), (2.35, 2.8), 3.0, l_shape=0.22, niche=0.35),
    "bedroom": Dimensions((8, 24), (1.0, 1.7), (2.35, 2.75), 2.5, l_shape=0.14, niche=0.3),
    "office": Dimensions((9, 110), (1.0, 2.2), (2.5, 3.2), 2.5, l_shape=0.14, niche=0.12),
    "kitchen": Dimensions((7, 24), (1.0, 2.0), (2.35, 2.75), 2.1, l_shape=0.16, niche=0.15),
    "bathroom": Dimensions((3.2, 11), (1.0, 2.1), (2.3, 2.6), 1.6, l_shape=0.12, niche=0.2),
    "hall": Dimensions((45, 240), (1.0, 2.2), (3.0, 6.0), 5.5, l_shape=0.15, niche=0.2),
    "corridor": Dimensions((5, 34), (3.0, 9.0), (2.35, 2.9), 1.1, l_shape=0.25, niche=0.2),
    "shop": Dimensions((24, 160), (1.0, 2.4), (2.7, 4.2), 4.0, l_shape=0.18, niche=0.15),
    "workshop": Dimensions((14, 150), (1.0, 2.2), (2.6, 5.5), 3.0, l_shape=0.15, niche=0.1),
    "empty": Dimensions((8, 60), (1.0, 2.2), (2.35, 3.2), 2.5, l_shape=0.2, niche=0.25),
}
"""Of every kind of space; areas and heights as dwellings, offices and shops are built."""

_OLD_HOUSE = 0.2
"""Share of homes with high ceilings."""


def millimetres(value: float) -> float:
    """Rounded to whole millimetres, so that a plan does not hang on the last bit of a sine."""
    return round(value, 3) + 0.0


def draw_height(rng: Random, kind: str) -> float:
    """A ceiling height for a room of this kind, in metres."""
    low, high = DIMENSIONS[kind].height
    if kind in ("living", "bedroom", "kitchen", "corridor", "empty") and rng.random() < _OLD_HOUSE:
        low, high = 2.8, 3.6
    return millimetres(rng.triangular(low, high, low + 0.3 * (high - low)))


def draw_outline(rng: Random, kind: str, *, scale: float = 1.0, plain: bool = False) -> Outline:
    """The outline of a room of this kind with its lower left corner at the origin.

    `scale` multiplies the area; `plain` gives a rectangle.
    """
    d = DIMENSIONS[kind]
    low, high = (math.log(a * scale) for a in d.area)
    size = math.exp(rng.uniform(low, high))
    aspect = rng.triangular(*d.aspect, d.aspect[0] + 0.35 * (d.aspect[1] - d.aspect[0]))
    narrow = max(math.sqrt(size / aspect), d.narrow)
    # A corridor is narrow however long it is.
    if kind == "corridor":
        narrow = min(narrow, rng.uniform(1.2, 2.6))
    long = max(size / narrow, narrow)
    width, depth = (narrow, long) if rng.random() < 0.5 else (long, narrow)
    width, depth = millimetres(width), millimetres(depth)
    outline: Outline = ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
    if plain:
        return outline
    if rng.random() < d.l_shape:
        outline = _l_shape(rng, kind, width, depth)
    if rng.random() < d.niche:
        outline = _niche(rng, outline)
    return outline


def _l_shape(rng: Random, kind: str, width: float, depth: float) -> Outline:
    rectangle: Outline = ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
    if kind == "corridor":
        # Two arms of one width instead of a corner cut out of a strip.
        arm, long = min(width, depth), max(width, depth)
        across = millimetres(rng.uniform(0.35, 0.8) * long)
        rectangle = ((0.0, 0.0), (across, 0.0), (across, long), (0.0, long))
        cut_x, cut_y = across - arm, long - arm
        if cut_x < 0.8:
            return ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))
        return without_corner(rectangle, rng.randrange(4), millimetres(cut_x), millimetres(cut_y))
    narrow = max(0.55 * DIMENSIONS[kind].narrow, 1.0)
    cut_x = min(rng.uniform(0.25, 0.62) * width, width - narrow)
    cut_y = min(rng.uniform(0.25, 0.62) * depth, depth - narrow)
    if min(cut_x, cut_y) < 0.5:
        return rectangle
    return without_corner(rectangle, rng.randrange(4), millimetres(cut_x), millimetres(cut_y))


def without_corner(rectangle: Outline, corner: int, cut_x: float, cut_y: float) -> Outline:
    """A rectangle (counter-clockwise from its lower left corner) with one corner cut out.

    >>> without_corner(((0, 0), (4, 0), (4, 3), (0, 3)), 2, 1.5, 1.0)
    ((0, 0), (4, 0), (4, 2.0), (2.5, 2.0), (2.5, 3), (0, 3))
    """
    x, y = rectangle[corner]
    centre_x = (rectangle[0][0] + rectangle[2][0]) / 2
    centre_y = (rectangle[0][1] + rectangle[2][1]) / 2
    u = millimetres(x + math.copysign(cut_x, centre_x - x))
    v = millimetres(y + math.copysign(cut_y, centre_y - y))
    # Corners 0 and 2 are reached along x, that is after a vertical edge and before a horizontal one.
    notch = ((x, v), (u, v), (u, y)) if corner in (0, 2) else ((u, y), (u, v), (x, v))
    return (*rectangle[:corner], *notch, *rectangle[corner + 1 :])


def pushed(outline: Outline, edge: int, start: float, end: float, depth: float) -> Outline:
    """The outline with a piece of one wall moved outward (an alcove, a bay) or inward (a chimney breast).

    `start` and `end` are metres along the edge; a positive `depth` enlarges the room. The piece is edge + 2.

    >>> room = ((0, 0), (4, 0), (4, 3), (0, 3))
    >>> area(pushed(room, 2, 1.0, 3.0, 0.5))
    13.0

    Raises:
        ValueError: a piece that does not lie inside the edge.
    """
    e = edges(outline)[edge]
    if not 0 < start < end < e.length:
        raise ValueError(f"expected 0 < start < end < {e.length}, got {start}, {end}")
    piece = [e.at(start), e.at(start, -depth), e.at(end, -depth), e.at(end)]
    corners = [(millimetres(x), millimetres(y)) for x, y in piece]
    return (*outline[: edge + 1], *corners, *outline[edge + 1 :])


def _niche(rng: Random, outline: Outline) -> Outline:
    """An alcove or a chimney breast in the middle part of a long wall."""
    candidates = [i for i, e in enumerate(edges(outline)) if e.length > 2.6]
    if not candidates:
        return outline
    index = rng.choice(candidates)
    e = edges(outline)[index]
    kind = choose(rng, [("alcove", 3.0), ("chimney", 2.0), ("bay", 1.5)])
    if kind == "chimney":
        width, depth = rng.uniform(0.9, 1.7), -rng.uniform(0.25, 0.5)
    elif kind == "alcove":
        width, depth = rng.uniform(0.9, 2.2), rng.uniform(0.25, 0.8)
    else:
        width, depth = rng.uniform(1.6, 2.8), rng.uniform(0.5, 0.9)
    width = min(width, e.length - 1.2)
    start = rng.uniform(0.5, e.length - width - 0.5)
    if rng.random() < 0.4:
        start = (e.length - width) / 2
    result = pushed(outline, index, millimetres(start), millimetres(start + width), millimetres(depth))
    # A chimney breast may not stand in the way of another wall (an L's inner corner).
    return result if _simple(result) and area(result) > 0.8 * area(outline) else outline


def _simple(outline: Outline) -> bool:
    """Whether walls that are no neighbours keep .6 m from each other."""
    spans = [
        (
            min(e.start[0], e.end[0]),
            min(e.start[1], e.end[1]),
            max(e.start[0], e.end[0]),
            max(e.start[1], e.end[1]),
        )
        for e in edges(outline)
    ]
    n = len(spans)
    for i, a in enumerate(spans):
        for j in range(i + 1, n):
            if (j - i) in (1, n - 1) or (j - i) in (2, n - 2):
                continue
            b = spans[j]
            if a[0] < b[2] + 0.6 and b[0] < a[2] + 0.6 and a[1] < b[3] + 0.6 and b[1] < a[3] + 0.6:
                return False
    return True
