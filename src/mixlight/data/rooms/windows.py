"""Windows: frames, sashes, glazing bars, panes, handles and sills."""

from __future__ import annotations

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.outline import Edge, edges
from mixlight.data.rooms.plan import Opening, Plan, Surface
from mixlight.data.rooms.plan_json import read_surface

__all__ = ["frame_plane", "parts"]

_CLEAR = Surface("glass", (0.93, 0.95, 0.94), roughness=0.0, transmission=0.9)
_FROSTED = Surface("translucent", (0.85, 0.87, 0.87), roughness=0.5, transmission=0.75)
_THICK = 0.068
"""Of a frame, from the room to the open."""
_FIXED = ("picture", "ribbon", "curtain_wall", "shopfront", "industrial", "clerestory", "partition")
_SLIM = ("curtain_wall", "shopfront", "industrial", "partition")

Span = tuple[float, float]


def parts(plan: Plan) -> list[Part]:
    """Every part of the windows but their dressings."""
    builder = Builder("window")
    for opening in plan.openings:
        if opening.kind == "window":
            _window(builder, edges(plan.spaces[opening.space].outline)[opening.edge], opening)
    return builder.parts()


def frame_plane(opening: Opening) -> float:
    """How deep in the wall the frame's inner face lies, in metres from the room.

    >>> frame_plane(Opening("window", 0, 0, 1.0, 2.0, 0.9, 2.1, depth=0.3, details={"inset": 0.5}))
    0.15
    """
    return max(min(opening.depth * float(opening.details.get("inset", 0.45)), opening.depth - 0.08), 0.0)


def _window(builder: Builder, edge: Edge, opening: Opening) -> None:
    details = opening.details
    style = details.get("style", "casement")
    frame = read_surface(details["frame"])
    columns, rows = details.get("mullions", (1, 1))
    low, high = opening.bottom, opening.top
    plane = frame_plane(opening)
    into = (-plane - _THICK, -plane)
    wide = 0.035 if style in _SLIM else 0.055
    _ring(builder, frame, edge, (opening.start, opening.end), into, (low, high), wide)
    left, right, z = opening.start + wide, opening.end - wide, (low + wide, high - wide)
    post = 0.035 if style in _SLIM else 0.05
    pitch = (right - left + post) / columns
    glass = _FROSTED if details.get("frosted") else _CLEAR
    for i in range(columns):
        span = (left + i * pitch, left + (i + 1) * pitch - post)
        if i > 0 and style != "sliding":
            builder.wall_box(frame, edge, (span[0] - post, span[0]), into, z)
        depths = into
        if style == "sliding":
            # Every second leaf runs on the inner rail.
            span = (span[0] - post, span[1]) if i > 0 else span
            shift = 0.012 if i % 2 else -0.022
            depths = (into[0] + 0.018 + shift, into[1] - 0.018 + shift)
        _sash(builder, edge, opening, frame, glass, span, depths, z, rows, style)
    if low > 0.25 and details.get("sill", True):
        builder.wall_box(
            frame, edge, (opening.start - 0.04, opening.end + 0.04), (0.0, 0.045), (low - 0.028, low)
        )
        builder.wall_box(frame, edge, (opening.start, opening.end), (-plane, 0.0), (low - 0.001, low + 0.004))


def _sash(
    builder: Builder,
    edge: Edge,
    opening: Opening,
    frame: Surface,
    glass: Surface,
    span: Span,
    into: Span,
    z: Span,
    rows: int,
    style: str,
) -> None:
    """One light of a window: its own frame where it opens, glazing bars, pane and handle."""
    middle = (into[0] + into[1]) / 2
    if style not in _FIXED:
        # A sash stands a little proud of the frame that holds it.
        ring = 0.062 if style in ("french", "sliding") else 0.05
        proud = (into[0] + 0.012, into[1] + (0.012 if style != "sliding" else 0.0))
        _ring(builder, frame, edge, span, proud, z, ring)
        if style != "sliding" and opening.top - opening.bottom > 0.5:
            metal = read_surface(opening.details["metal"])
            height = min(max(z[0] + 0.45 * (z[1] - z[0]), 0.9 if style == "french" else 0.0), z[1] - 0.2)
            along = span[1] - ring / 2 if int(10 * span[0]) % 2 else span[0] + ring / 2
            builder.wall_box(
                metal,
                edge,
                (along - 0.012, along + 0.012),
                (proud[1], proud[1] + 0.01),
                (height - 0.05, height + 0.05),
            )
            builder.wall_box(
                metal,
                edge,
                (along - 0.009, along + 0.009),
                (proud[1] + 0.01, proud[1] + 0.045),
                (height - 0.009, height + 0.009),
            )
            builder.wall_box(
                metal,
                edge,
                (along - 0.009, along + 0.009),
                (proud[1] + 0.035, proud[1] + 0.045),
                (height - 0.11, height - 0.009),
            )
        span, z = (span[0] + ring, span[1] - ring), (z[0] + ring, z[1] - ring)
    bar = 0.035 if style in _SLIM else 0.024
    for j in range(1, rows):
        at = z[0] + (z[1] - z[0]) * j / rows
        builder.wall_box(frame, edge, span, (middle - 0.016, middle + 0.016), (at - bar / 2, at + bar / 2))
    builder.wall_quad(glass, edge, span, middle, z)


def _ring(
    builder: Builder, surface: Surface, edge: Edge, along: Span, into: Span, z: Span, wide: float
) -> None:
    """Four bars round a rectangle."""
    (a, b), (low, high) = along, z
    builder.wall_box(surface, edge, (a, a + wide), into, z)
    builder.wall_box(surface, edge, (b - wide, b), into, z)
    builder.wall_box(surface, edge, (a + wide, b - wide), into, (low, low + wide))
    builder.wall_box(surface, edge, (a + wide, b - wide), into, (high - wide, high))
