"""Meshes of what is built into a room: skirting, cornices, rails, beams, columns, wall panels, ducts."""

from __future__ import annotations

from typing import Any

import numpy as np

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.fittings import free_runs
from mixlight.data.rooms.outline import Edge, Hole, edges, holes
from mixlight.data.rooms.plan import Plan, Space, Surface
from mixlight.data.rooms.plan_json import read_surface
from mixlight.data.rooms.shapes import cylinder, tube

__all__ = ["add_built_in"]

_PLASTIC = Surface("plastic", (0.7, 0.7, 0.68), roughness=0.35)
_SOOT = Surface("paint", (0.015, 0.014, 0.013), roughness=0.95)


def add_built_in(builder: Builder, plan: Plan) -> None:
    """Adds the skirting of every space and what its details ask for (keys: `fittings`)."""
    for index, space in enumerate(plan.spaces):
        found = holes(plan, index)
        for i, edge in enumerate(edges(space.outline)):
            here = [hole for hole in found if hole.edge == i]
            _along_wall(builder, space, i, edge, here)
        _overhead(builder, space)
        if "fireplace" in space.details:
            _fireplace(builder, space)
        for i, along, z, wide in space.details.get("plates", ()):
            edge = edges(space.outline)[int(i)]
            builder.wall_box(
                _PLASTIC, edge, (along - wide / 2, along + wide / 2), (0.0, 0.011), (z - 0.04, z + 0.04)
            )


def _along_wall(builder: Builder, space: Space, index: int, edge: Edge, here: list[Hole]) -> None:
    if space.skirting is not None:
        high, thick = space.details.get("skirting", (0.09, 0.014))
        for a, b in free_runs(edge.length, here, (0.0, high - 0.001), 0.0):
            builder.wall_box(space.skirting, edge, (a, b), (0.0, thick), (0.0, high))
    if "cornice" in space.details:
        size, top = space.details["cornice"]["size"], space.height
        surface = read_surface(space.details["cornice"]["surface"])
        for share, drop in ((1.0, 0.3), (0.65, 0.65), (0.3, 1.0)):
            runs = free_runs(edge.length, here, (top - drop * size, top), 0.0)
            for a, b in runs:
                builder.wall_box(surface, edge, (a, b), (0.0, share * size), (top - drop * size, top))
    for rail in space.details.get("rails", ()):
        z = (rail["z"], rail["z"] + rail["height"])
        for a, b in free_runs(edge.length, here, z, 0.07):
            builder.wall_box(read_surface(rail["surface"]), edge, (a, b), (0.0, rail["depth"]), z)
    panels = space.details.get("panels")
    if panels and index in panels["edges"]:
        _panels(builder, space, index, edge, here, panels)


def _panels(
    builder: Builder, space: Space, index: int, edge: Edge, here: list[Hole], panels: dict[str, Any]
) -> None:
    surface = read_surface(panels["surface"]) if panels["surface"] else space.walls[index]
    low, high, width = panels["bottom"], min(panels["top"], space.height), panels["width"]
    levels = [(low, high)]
    if panels["style"] == "frames" and high > 1.5:
        levels = [(low, 0.85), (1.02, high)]
    for bottom, top in levels:
        for a, b in free_runs(edge.length, here, (bottom, top), 0.1):
            if panels["style"] == "frames":
                _frames(builder, surface, edge, (a, b), (bottom, top), width)
                continue
            gap = 0.004 if panels["style"] == "boards" else 0.35 * width
            thick = 0.014 if panels["style"] == "boards" else 0.03
            count = max(1, round((b - a) / width))
            step = (b - a) / count
            for i in range(count):
                run = (a + i * step + gap / 2, a + (i + 1) * step - gap / 2)
                builder.wall_box(surface, edge, run, (0.0, thick), (bottom, top))


def _frames(
    builder: Builder,
    surface: Surface,
    edge: Edge,
    run: tuple[float, float],
    z: tuple[float, float],
    width: float,
) -> None:
    """Picture-frame mouldings, evenly along a free piece of the wall."""
    margin, bar, thick = 0.11, 0.028, 0.016
    count = max(1, round((run[1] - run[0]) / (width + margin)))
    step = (run[1] - run[0]) / count
    if step < margin + 4 * bar or z[1] - z[0] < 0.25:
        return
    for i in range(count):
        a, b = run[0] + i * step + margin / 2, run[0] + (i + 1) * step - margin / 2
        builder.wall_box(surface, edge, (a, b), (0.0, thick), (z[0], z[0] + bar))
        builder.wall_box(surface, edge, (a, b), (0.0, thick), (z[1] - bar, z[1]))
        builder.wall_box(surface, edge, (a, a + bar), (0.0, thick), (z[0] + bar, z[1] - bar))
        builder.wall_box(surface, edge, (b - bar, b), (0.0, thick), (z[0] + bar, z[1] - bar))


def _overhead(builder: Builder, space: Space) -> None:
    details = space.details
    if "beams" in details:
        surface = read_surface(details["beams_surface"])
        for x0, y0, x1, y1, z0, z1 in details["beams"]:
            builder.box(surface, (x0, y0, z0), (x1, y1, z1))
    if "columns" in details:
        surface = read_surface(details["columns_surface"])
        for x0, y0, x1, y1, z0, z1 in details["columns"]:
            if details.get("columns_round"):
                base = ((x0 + x1) / 2, (y0 + y1) / 2, z0)
                builder.mesh(surface, cylinder((x1 - x0) / 2, z1 - z0, base=base, segments=32))
            else:
                builder.box(surface, (x0, y0, z0), (x1, y1, z1))
    for x0, y0, x1, y1, z0, z1 in details.get("soffits", ()):
        builder.box(space.ceiling, (x0, y0, z0), (x1, y1, z1))
    if "ducts" in details:
        surface = read_surface(details["ducts_surface"])
        for x0, y0, z0, x1, y1, z1, radius in details["ducts"]:
            path = np.array([(x0, y0, z0), (x1, y1, z1)])
            builder.mesh(surface, tube(path, radius, segments=16))


def _fireplace(builder: Builder, space: Space) -> None:
    given = space.details["fireplace"]
    edge = edges(space.outline)[given["edge"]]
    surface = read_surface(given["surface"])
    a, b = given["centre"] - given["width"] / 2, given["centre"] + given["width"] / 2
    high, deep = given["height"], given["depth"]
    jamb = 0.22 * given["width"]
    lintel = high - 0.24
    builder.wall_box(surface, edge, (a, a + jamb), (0.0, deep), (0.0, high))
    builder.wall_box(surface, edge, (b - jamb, b), (0.0, deep), (0.0, high))
    builder.wall_box(surface, edge, (a + jamb, b - jamb), (0.0, deep), (lintel, high))
    builder.wall_box(surface, edge, (a - 0.06, b + 0.06), (0.0, deep + 0.06), (high, high + 0.05))
    builder.wall_box(surface, edge, (a - 0.03, b + 0.03), (deep, deep + 0.4), (0.0, 0.025))
    # Before whatever panels cover the wall.
    builder.wall_quad(_SOOT, edge, (a + jamb, b - jamb), 0.035, (0.0, lintel))
