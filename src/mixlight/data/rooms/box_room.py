"""TEMPORARY thin slice: a box with a window and a lamp."""

from __future__ import annotations

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Emission, Part
from mixlight.data.rooms.plan import Camera, Opening, Plan, Sky, Space, Surface


def box_plan(seed: int) -> Plan:
    """A plan."""
    wall = Surface("paint", (0.7, 0.68, 0.64))
    return Plan(
        seed=seed,
        spaces=(
            Space("living", ((0, 0), (4, 0), (4, 5), (0, 5)), 2.6, (wall,) * 4,
                  Surface("planks", (0.35, 0.2, 0.1)),
                  Surface("paint", (0.8, 0.8, 0.8))),
        ),
        openings=(Opening("window", 0, 2, 1.2, 2.8, 0.9, 2.2),),
        items=(), fixtures=(),
        sky=Sky("day", None, 0.0, 12000.0, (0.7, 0.95, 1.4), (0.3, 0.7, 0.648), 60000.0),
        cameras=(Camera(0, (2.0, 2.0, 1.5), 0.0),),
    )  # fmt: skip


def box_parts(plan: Plan) -> list[Part]:
    """Its parts."""
    s = plan.spaces[0]
    t, h = 0.15, 2.6
    walls = [
        ((-t, -t, -t), (4 + t, 0, h)), ((-t, -t, -t), (0, 5 + t, h)), ((4, -t, -t), (4 + t, 5 + t, h)),
        ((0, 5, -t), (1.2, 5 + t, h)), ((2.8, 5, -t), (4, 5 + t, h)),
        ((1.2, 5, -t), (2.8, 5 + t, 0.9)), ((1.2, 5, 2.2), (2.8, 5 + t, h)),
    ]  # fmt: skip
    return [
        Part(shapes.merge([shapes.box(a, b) for a, b in walls]), s.walls[0], "walls"),
        Part(shapes.box((-t, -t, -t), (4 + t, 5 + t, 0)), s.floor, "floor"),
        Part(shapes.box((-t, -t, h), (4 + t, 5 + t, h + t)), s.ceiling, "ceiling"),
        Part(shapes.box((0.3, 3.0, 0), (1.2, 4.8, 0.7)), Surface("fabric", (0.1, 0.15, 0.3)), "box"),
        Part(
            shapes.box((1.85, 1.35, 2.5), (2.15, 1.65, 2.52)),
            Emission("ceiling", (8.0, 5.5, 3.0), True),
            "lamp",
        ),
    ]
