"""Collects rectangles and boxes by what they are made of, and turns them into parts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.outline import Edge
from mixlight.data.rooms.plan import Point3, Surface
from mixlight.data.rooms.shapes import boxes, merge

__all__ = ["Builder"]

Quad = tuple[Sequence[Point3], Sequence[tuple[float, float]]]


class Builder:
    """Rectangles, boxes and other meshes of a wall or a whole room, one part for each surface.

    Convention: places on a wall are (along, into, z): metres from the edge's first corner, metres into the
    room from the wall's inner face (negative: in the wall) and metres above the floor.
    """

    def __init__(self, name: str) -> None:
        """`name` is the parts' name."""
        self._name = name
        self._quads: dict[Surface, list[Quad]] = {}
        self._boxes: dict[Surface, list[tuple[Point3, Point3]]] = {}
        self._meshes: dict[Surface, list[Mesh]] = {}

    def quad(self, surface: Surface, corners: Sequence[Point3], uv: Sequence[tuple[float, float]]) -> None:
        """One rectangle, corners counter-clockwise seen from its outside."""
        self._quads.setdefault(surface, []).append((corners, uv))

    def box(self, surface: Surface, low: Point3, high: Point3) -> None:
        """One box between its lowest and highest corner; nothing where it has no thickness."""
        if all(b - a > 1e-6 for a, b in zip(low, high, strict=True)):
            self._boxes.setdefault(surface, []).append((low, high))

    def mesh(self, surface: Surface, mesh: Mesh) -> None:
        """Any mesh in the room frame."""
        self._meshes.setdefault(surface, []).append(mesh)

    def wall_box(
        self,
        surface: Surface,
        edge: Edge,
        along: tuple[float, float],
        into: tuple[float, float],
        z: tuple[float, float],
    ) -> None:
        """A box on a wall, between two places along it, two depths into the room and two heights."""
        x0, y0, x1, y1 = edge.rectangle(along[0], along[1], into[0], into[1])
        self.box(surface, (x0, y0, z[0]), (x1, y1, z[1]))

    def wall_quad(
        self,
        surface: Surface,
        edge: Edge,
        along: tuple[float, float],
        into: float,
        z: tuple[float, float],
        *,
        outside: bool = False,
    ) -> None:
        """A rectangle in a plane along the wall that looks into the room (`outside`: out of it)."""
        (ax, ay), (bx, by) = edge.at(along[0], into), edge.at(along[1], into)
        corners = [(ax, ay, z[0]), (bx, by, z[0]), (bx, by, z[1]), (ax, ay, z[1])]
        uv = [(along[0], z[0]), (along[1], z[0]), (along[1], z[1]), (along[0], z[1])]
        # Seen from inside, the edge runs from right to left, so this order looks outwards.
        if not outside:
            corners.reverse()
            uv.reverse()
        self.quad(surface, corners, uv)

    def parts(self) -> list[Part]:
        """One part for each surface, in the order of their first use."""
        surfaces = list(dict.fromkeys([*self._quads, *self._boxes, *self._meshes]))
        found = []
        for surface in surfaces:
            meshes = []
            if quads := self._quads.get(surface):
                vertices = np.array([c for corners, _ in quads for c in corners], dtype=np.float64)
                uv = np.array([uv for _, uv in quads], dtype=np.float64)
                meshes.append(Mesh(vertices, np.arange(len(vertices)).reshape(-1, 4), uv))
            if bodies := self._boxes.get(surface):
                meshes.append(boxes(np.array([a for a, _ in bodies]), np.array([b for _, b in bodies])))
            meshes += self._meshes.get(surface, [])
            found.append(Part(merge(meshes), surface, self._name))
        return found
