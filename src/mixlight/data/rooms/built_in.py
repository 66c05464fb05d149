"""What is built into a room: skirting, cornices, rails, beams, columns, wall panels, ducts."""

from __future__ import annotations

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.outline import edges, holes
from mixlight.data.rooms.plan import Plan, Space
from mixlight.data.rooms.plan_json import read_surface

__all__ = ["add_built_in"]


def add_built_in(builder: Builder, plan: Plan) -> None:
    """Adds the skirting of every space and what its details ask for."""
    for index, space in enumerate(plan.spaces):
        _skirting(builder, plan, index)
        _beams(builder, space)


def _skirting(builder: Builder, plan: Plan, index: int) -> None:
    space = plan.spaces[index]
    if space.skirting is None:
        return
    high, thick = space.details.get("skirting", (0.09, 0.014))
    found = holes(plan, index)
    for i, edge in enumerate(edges(space.outline)):
        low = [hole for hole in found if hole.edge == i and hole.bottom < high]
        at = 0.0
        for hole in sorted(low, key=lambda hole: hole.start):
            builder.wall_box(space.skirting, edge, (at, hole.start), (0.0, thick), (0.0, high))
            at = hole.end
        builder.wall_box(space.skirting, edge, (at, edge.length), (0.0, thick), (0.0, high))


def _beams(builder: Builder, space: Space) -> None:
    for name in ("beams", "columns"):
        if name in space.details:
            surface = read_surface(space.details[f"{name}_surface"])
            for x0, y0, x1, y1, z0, z1 in space.details[name]:
                builder.box(surface, (x0, y0, z0), (x1, y1, z1))
