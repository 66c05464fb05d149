"""Meshes of simple bodies, from which walls, furniture and lamps are put together.

Convention: metres, +Z up; faces run counter-clockwise seen from outside, quads carry four corners and
triangles end in -1. Texture coordinates are metres along the surface, so a pattern keeps its size on every
body. **Corners are shared only across edges that are meant to look round** (a box has 24 corners, the rim of
a cylinder is there twice), so `smooth` may be set on any mesh, and meshes of both kinds may be merged.
"""

from __future__ import annotations

from mixlight.data.rooms.shapes.blocks import box, boxes, rounded_box
from mixlight.data.rooms.shapes.flat import extrude, panel, pillow, polygon, sheet
from mixlight.data.rooms.shapes.placing import instances, merge, move, placement, rotation, transform, weld
from mixlight.data.rooms.shapes.turned import bars, cone, cylinder, lathe, loft, sphere, torus, tube

__all__ = [
    "bars",
    "box",
    "boxes",
    "cone",
    "cylinder",
    "extrude",
    "instances",
    "lathe",
    "loft",
    "merge",
    "move",
    "panel",
    "pillow",
    "placement",
    "polygon",
    "rotation",
    "rounded_box",
    "sheet",
    "sphere",
    "torus",
    "transform",
    "tube",
    "weld",
]
