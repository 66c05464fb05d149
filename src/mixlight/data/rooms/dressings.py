"""What hangs before windows: curtains, sheers, and venetian, roller, roman and vertical blinds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.outline import Edge, edges
from mixlight.data.rooms.plan import Opening, Plan, Surface
from mixlight.data.rooms.plan_json import read_surface
from mixlight.data.rooms.shapes import sheet, tube
from mixlight.data.rooms.windows import frame_plane

__all__ = ["parts"]


def parts(plan: Plan) -> list[Part]:
    """The dressings of all windows."""
    builder = Builder("dressing")
    for index, opening in enumerate(plan.openings):
        details = opening.details
        if opening.kind != "window" or details.get("dressing", "none") == "none":
            continue
        space = plan.spaces[opening.space]
        edge = edges(space.outline)[opening.edge]
        cloth = read_surface(details["fabric"])
        drawn = float(details["drawn"])
        if details["dressing"] in ("curtain", "sheer"):
            _curtains(builder, edge, opening, space.height, cloth, drawn, phase=float(index))
        else:
            _BLINDS[details["dressing"]](builder, edge, opening, cloth, drawn)
    return builder.parts()


def _curtains(
    builder: Builder, edge: Edge, opening: Opening, height: float, cloth: Surface, drawn: float, phase: float
) -> None:
    left, right = max(opening.start - 0.22, 0.03), min(opening.end + 0.22, edge.length - 0.03)
    rod = min(opening.top + 0.12, height - 0.04)
    bottom = 0.02 if opening.details.get("to_floor") or opening.bottom < 0.3 else opening.bottom - 0.12
    into = 0.085
    metal = read_surface(opening.details["metal"])
    if opening.details.get("pelmet"):
        # A box of the cloth hides rod and heading.
        builder.wall_box(cloth, edge, (left - 0.03, right + 0.03), (0.0, 0.17), (rod - 0.16, rod + 0.03))
    else:
        path = np.array([(*edge.at(s, into), rod) for s in (left - 0.02, right + 0.02)])
        builder.mesh(metal, tube(path, 0.011, segments=8))
    width = (right - left) / 2 * max(drawn, 0.12)
    for start, end in ((left, left + width), (right - width, right)):
        builder.mesh(cloth, _folds(edge, start, end, into, bottom, rod - 0.01, drawn, phase))
    if opening.details.get("sheer"):
        veil = Surface("translucent", (0.75, 0.74, 0.7), roughness=1.0, transmission=0.65)
        builder.mesh(veil, _folds(edge, left, right, into - 0.05, bottom, rod - 0.02, 1.0, phase + 2))


def _folds(
    edge: Edge, start: float, end: float, into: float, bottom: float, top: float, drawn: float, phase: float
) -> Mesh:
    """A hanging cloth; the less it is drawn, the deeper and closer its folds."""
    pitch = 0.09 + 0.09 * drawn
    depth = 0.045 - 0.025 * drawn
    count = max(12, int((end - start) / pitch * 8))
    s = np.linspace(start, end, count)
    angle = 2 * math.pi * (s - start) / pitch + phase
    wobble = 0.3 * np.sin(angle * 0.37 + 1.7 * phase)
    levels = np.array([0.0, 0.12, 0.55, 1.0])
    points = np.empty((len(levels), count, 3))
    for k, level in enumerate(levels):
        into_here = into + depth * (0.55 + 0.45 * level) * np.sin(angle + wobble * (0.4 + level))
        points[k, :, 0] = edge.start[0] + edge.direction[0] * s + edge.inward[0] * into_here
        points[k, :, 1] = edge.start[1] + edge.direction[1] * s + edge.inward[1] * into_here
        points[k, :, 2] = top + (bottom - top) * level
    return sheet(points)


def _venetian(builder: Builder, edge: Edge, opening: Opening, slats: Surface, drawn: float) -> None:
    a, b, into = opening.start + 0.01, opening.end - 0.01, _blind_plane(opening)
    top = opening.top - 0.005
    builder.wall_box(slats, edge, (a, b), (into, into + 0.045), (top - 0.045, top))
    bottom = top - 0.05 - (opening.top - opening.bottom - 0.07) * drawn
    deep, pitch = 0.05, 0.042
    tilt = float(opening.details.get("tilt", 0.3))
    x, z = deep / 2 * math.cos(tilt), deep / 2 * math.sin(tilt)
    middle = into + 0.0225
    for level in np.arange(top - 0.07, bottom, -pitch).tolist():
        corners = [
            (*edge.at(a, middle - x), level + z),
            (*edge.at(a, middle + x), level - z),
            (*edge.at(b, middle + x), level - z),
            (*edge.at(b, middle - x), level + z),
        ]
        builder.quad(slats, corners, [(a, 0.0), (a, deep), (b, deep), (b, 0.0)])
    builder.wall_box(slats, edge, (a, b), (middle - 0.012, middle + 0.012), (bottom - 0.02, bottom))
    count = max(2, round((b - a) / 0.6) + 1)
    for i in range(count):
        s = a + 0.08 + (b - a - 0.16) * i / (count - 1)
        builder.wall_box(
            slats, edge, (s - 0.001, s + 0.001), (middle + x, middle + x + 0.0015), (bottom, top - 0.04)
        )


def _roller(builder: Builder, edge: Edge, opening: Opening, cloth: Surface, drawn: float) -> None:
    a, b, into = opening.start + 0.012, opening.end - 0.012, _blind_plane(opening) + 0.02
    top = opening.top - 0.03
    bottom = top - (opening.top - opening.bottom - 0.06) * drawn
    builder.mesh(cloth, tube(np.array([(*edge.at(s, into + 0.02), top) for s in (a, b)]), 0.022, segments=12))
    builder.wall_quad(cloth, edge, (a, b), into, (bottom, top))
    builder.wall_box(cloth, edge, (a, b), (into - 0.006, into + 0.006), (bottom - 0.02, bottom))


def _roman(builder: Builder, edge: Edge, opening: Opening, cloth: Surface, drawn: float) -> None:
    """A cloth drawn up in folds: flat below, bellies above."""
    a, b, into = opening.start + 0.01, opening.end - 0.01, _blind_plane(opening) + 0.01
    full = opening.top - opening.bottom - 0.04
    top, hanging = opening.top - 0.01, max(full * drawn, 0.12)
    folds = max(2, round((full - hanging) / 0.16)) + 1
    # Profile from the top down: straight cloth, then the gathered folds at the lower end.
    profile = [(0.0, top), (0.0, top - max(hanging - 0.05 * folds, 0.04))]
    for _ in range(folds):
        z = profile[-1][1]
        profile += [(0.035, z - 0.03), (0.03, z - 0.05), (0.0, z - 0.04)]
    points = np.array(
        [[(*edge.at(s, into + depth), max(z, opening.bottom + 0.01)) for s in (a, b)] for depth, z in profile]
    )
    builder.mesh(cloth, sheet(points))


def _vertical(builder: Builder, edge: Edge, opening: Opening, cloth: Surface, drawn: float) -> None:
    """Hanging strips, turned about their upright middle; the others are stacked at one side."""
    a, b, into = opening.start + 0.01, opening.end - 0.01, _blind_plane(opening) + 0.06
    top, bottom, wide = opening.top - 0.04, opening.bottom + 0.02, 0.127
    builder.wall_box(cloth, edge, (a, b), (into - 0.02, into + 0.02), (top, top + 0.035))
    tilt = float(opening.details.get("tilt", 0.3))
    count = max(2, round((b - a) / 0.11))
    stacked = round(count * (1 - drawn))
    for i in range(count):
        if i < stacked:
            along, angle = a + 0.03 + 0.012 * i, 1.45
        else:
            along, angle = a + (b - a) * (i + 0.5) / count, tilt
        s, d = wide / 2 * math.cos(angle), min(wide / 2 * math.sin(angle), 0.058)
        low, high = edge.at(along - s, into - d), edge.at(along + s, into + d)
        corners = [(*high, bottom), (*low, bottom), (*low, top), (*high, top)]
        builder.quad(cloth, corners, [(0.0, bottom), (wide, bottom), (wide, top), (0.0, top)])


def _blind_plane(opening: Opening) -> float:
    """Blinds hang in the reveal where it is deep enough, else before the wall."""
    plane = frame_plane(opening)
    return -plane + 0.01 if plane > 0.06 else 0.005


_BLINDS: dict[str, Callable[[Builder, Edge, Opening, Surface, float], None]] = {
    "venetian": _venetian,
    "roller": _roller,
    "roman": _roman,
    "vertical": _vertical,
}
