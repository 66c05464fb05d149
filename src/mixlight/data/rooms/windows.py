"""Windows: frames, sashes, glazing bars, panes and sills."""

from __future__ import annotations

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.outline import Edge, edges
from mixlight.data.rooms.plan import Opening, Plan, Surface
from mixlight.data.rooms.plan_json import read_surface

__all__ = ["frame_plane", "parts"]

_CLEAR = Surface("glass", (0.93, 0.95, 0.94), roughness=0.0, transmission=0.9)
_FROSTED = Surface("translucent", (0.85, 0.87, 0.87), roughness=0.5, transmission=0.75)


def parts(plan: Plan) -> list[Part]:
    """Every part of the windows but their dressings."""
    builder = Builder("window")
    for opening in plan.openings:
        if opening.kind == "window":
            _window(builder, edges(plan.spaces[opening.space].outline)[opening.edge], opening)
    return builder.parts()


def frame_plane(opening: Opening) -> float:
    """How deep in the wall the frame's inner face lies, in metres from the room."""
    return min(opening.depth * float(opening.details.get("inset", 0.45)), opening.depth - 0.08)


def _window(builder: Builder, edge: Edge, opening: Opening) -> None:
    details = opening.details
    frame = read_surface(details["frame"])
    columns, rows = details.get("mullions", (1, 1))
    a, b, low, high = opening.start, opening.end, opening.bottom, opening.top
    plane = frame_plane(opening)
    thick = 0.065
    into = (-plane - thick, -plane)
    slim = details.get("style") in ("curtain_wall", "shopfront", "industrial")
    wide = 0.04 if slim else 0.06
    builder.wall_box(frame, edge, (a, a + wide), into, (low, high))
    builder.wall_box(frame, edge, (b - wide, b), into, (low, high))
    builder.wall_box(frame, edge, (a + wide, b - wide), into, (low, low + wide))
    builder.wall_box(frame, edge, (a + wide, b - wide), into, (high - wide, high))
    left, right, bottom, top = a + wide, b - wide, low + wide, high - wide
    bar = 0.03 if slim else 0.09
    for i in range(1, columns):
        x = left + (right - left) * i / columns
        builder.wall_box(frame, edge, (x - bar / 2, x + bar / 2), into, (bottom, top))
    bar = 0.03
    for j in range(1, rows):
        z = bottom + (top - bottom) * j / rows
        inner = (into[0] + 0.012, into[1] - 0.012)
        builder.wall_box(frame, edge, (left, right), inner, (z - bar / 2, z + bar / 2))
    glass = _FROSTED if details.get("frosted") else _CLEAR
    builder.wall_quad(glass, edge, (left, right), -plane - thick / 2, (bottom, top))
    if low > 0.25 and details.get("sill", True):
        shelf = read_surface(details["sill"]) if isinstance(details.get("sill"), dict) else frame
        builder.wall_box(shelf, edge, (a - 0.04, b + 0.04), (0.0, 0.04), (low - 0.03, low))
        builder.wall_box(shelf, edge, (a, b), (-plane, 0.0), (low - 0.001, low + 0.004))
