"""Doors: linings, architraves, leaves that stand open or shut, handles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.mesh import Mesh
from mixlight.data.rooms.outline import LINING, Edge, Hole, edges, holes, leaves
from mixlight.data.rooms.plan import Plan, Surface
from mixlight.data.rooms.plan_json import read_surface
from mixlight.data.rooms.shapes import boxes, cylinder, placement, rotation, transform

__all__ = ["add_doors"]

_LEAF = 0.042
"""Thickness of a leaf."""
_GLASS = Surface("glass", (0.9, 0.92, 0.9), roughness=0.02, transmission=0.92)


def add_doors(builder: Builder, plan: Plan) -> None:
    """Adds every door of the plan, and the linings of passages that have one."""
    for index in range(len(plan.spaces)):
        for hole in holes(plan, index):
            if hole.opening.kind == "window":
                continue
            edge = edges(plan.spaces[index].outline)[hole.edge]
            details = hole.opening.details
            if "frame" in details and (hole.opening.kind == "door" or details.get("lining")):
                frame = read_surface(details["frame"])
                _architrave(builder, frame, edge, hole, plan.spaces[index].height)
                if not hole.far:
                    _lining(builder, frame, edge, hole)
            if not hole.far and hole.opening.kind == "door" and "leaf" in details:
                _add_leaves(builder, edge, hole)


def _architrave(builder: Builder, frame: Surface, edge: Edge, hole: Hole, height: float) -> None:
    wide, thick = 0.068, 0.016
    a, b, top = hole.start, hole.end, hole.top
    left, right = max(a - wide, 0.0), min(b + wide, edge.length)
    high = min(top + wide, height)
    builder.wall_box(frame, edge, (left, a), (0.0, thick), (0.0, high))
    builder.wall_box(frame, edge, (b, right), (0.0, thick), (0.0, high))
    builder.wall_box(frame, edge, (a, b), (0.0, thick), (top, high))


def _lining(builder: Builder, frame: Surface, edge: Edge, hole: Hole) -> None:
    a, b, top, depth = hole.start, hole.end, hole.top, hole.opening.depth
    builder.wall_box(frame, edge, (a, a + LINING), (-depth, 0.001), (0.0, top))
    builder.wall_box(frame, edge, (b - LINING, b), (-depth, 0.001), (0.0, top))
    builder.wall_box(frame, edge, (a + LINING, b - LINING), (-depth, 0.001), (top - LINING, top))


def _add_leaves(builder: Builder, edge: Edge, hole: Hole) -> None:
    details = hole.opening.details
    leaf, metal = read_surface(details["leaf"]), read_surface(details["metal"])
    height = hole.top - LINING - 0.006
    for hinge, heading, sense, width in leaves(edge, hole):
        matrix = placement((*hinge, 0.006), heading)
        for surface, mesh in _leaf(leaf, metal, details, width - 0.003, height - 0.003, sense):
            builder.mesh(surface, transform(mesh, matrix))


def _leaf(
    leaf: Surface, metal: Surface, details: dict[str, Any], width: float, height: float, sense: float
) -> list[tuple[Surface, Mesh]]:
    """A leaf in its own frame: hinge at the origin, +X to the lock, its thickness away from the swing."""
    y0, y1 = (-_LEAF, 0.0) if sense > 0 else (0.0, _LEAF)
    style = details.get("style", "flush")
    found: list[tuple[Surface, Mesh]] = []
    stile, rail, middle = 0.11, 0.13, 0.95
    if style == "flush" or width < 0.45:
        found.append((leaf, _box((0.002, y0, 0.0), (width, y1, height))))
    else:
        bars = [
            ((0.002, y0, 0.0), (stile, y1, height)),
            ((width - stile, y0, 0.0), (width, y1, height)),
            ((stile, y0, 0.0), (width - stile, y1, rail * 1.5)),
            ((stile, y0, height - rail), (width - stile, y1, height)),
        ]
        if style == "panel":
            bars.append(((stile, y0, middle - rail / 2), (width - stile, y1, middle + rail / 2)))
            thin = 0.012
            bars.append(((stile, y0 + thin, rail), (width - stile, y1 - thin, height - rail)))
        else:
            y = (y0 + y1) / 2
            pane = np.array(
                [
                    (stile, y, rail),
                    (width - stile, y, rail),
                    (width - stile, y, height - rail),
                    (stile, y, height - rail),
                ]
            )
            found.append((_GLASS, Mesh(pane, np.array([[0, 1, 2, 3]]), pane[None][..., [0, 2]])))
        found.append((leaf, boxes(np.array([a for a, _ in bars]), np.array([b for _, b in bars]))))
    for face in (y0, y1):
        out = math.copysign(1.0, face - (y0 + y1) / 2)
        found += [(metal, mesh) for mesh in _handle(width - 0.06, face, out)]
    return found


def _handle(x: float, face: float, out: float) -> list[Mesh]:
    """A lever with its plate, 1.03 m above the ground."""
    z = 1.03
    plate = sorted((face, face + out * 0.008))
    lever = sorted((face + out * 0.045, face + out * 0.06))
    neck = transform(cylinder(0.009, 0.05, segments=10), rotation("x", -out * math.pi / 2))
    return [
        _box((x - 0.022, plate[0], z - 0.09), (x + 0.022, plate[1], z + 0.07)),
        transform(neck, placement((x, face, z + 0.03))),
        _box((x - 0.115, lever[0], z + 0.021), (x + 0.01, lever[1], z + 0.039)),
    ]


def _box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    return boxes(np.array([low]), np.array([high]))
