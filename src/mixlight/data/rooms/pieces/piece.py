"""What one of our own parametric pieces is: how it is drawn by chance, and how it is built."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import Any

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.pieces.style import Style
from mixlight.data.rooms.plan import Item, Point3, Surface

__all__ = ["Bodies", "Piece", "draft", "draw_seed"]


@dataclass(frozen=True)
class Piece:
    """A parametric piece of furniture.

    Convention: it is built in its own frame: the middle of its footprint is the origin, its underside z = 0,
    it faces -Y (what hangs on a wall has the wall at +Y), and it fills the item's size.
    """

    name: str
    kind: str
    """Of the catalogue."""
    draw: Callable[[Random, Style], Item]
    """Its size, surfaces and parameters by chance; `make` names it."""
    build: Callable[[Item], list[Part]]
    """Its parts, in its own frame."""
    weight: float = 1.0
    """How common it is among the pieces of its kind."""

    def make(self, rng: Random, style: Style) -> Item:
        """One by chance, in the room's materials, standing at the origin."""
        return replace(self.draw(rng, style), kind=self.kind, piece=f"own:{self.name}")


def draft(size: Point3, surfaces: Sequence[Surface], **parameters: Any) -> Item:
    """An item that stands nowhere yet, its measures rounded to millimetres; `Piece.make` names it.

    A parameter `tops` lists where things stand on it: [x0, y0, x1, y1, height, clear height above], metres in
    the piece's frame.
    """
    width, depth, height = (round(extent, 3) for extent in size)
    return Item("", "", (0.0, 0.0, 0.0), 0.0, (width, depth, height), tuple(surfaces), dict(parameters))


def draw_seed(rng: Random) -> int:
    """A seed for what a piece draws while it is built."""
    return rng.randrange(1 << 20)


class Bodies:
    """Collects bodies by material, so that a piece has one part for each of its surfaces."""

    def __init__(self, item: Item) -> None:
        self._item = item
        self._meshes: dict[int, list[Mesh]] = {}
        self._low: dict[int, list[Sequence[float]]] = {}
        self._high: dict[int, list[Sequence[float]]] = {}
        self._bars: dict[tuple[int, float], list[tuple[Sequence[float], Sequence[float]]]] = {}

    def add(self, surface: int, *meshes: Mesh) -> None:
        """Bodies of the item's surface number `surface` (the last one it has, if there are not so many)."""
        self._meshes.setdefault(self._index(surface), []).extend(meshes)

    def box(self, surface: int, low: Sequence[float], high: Sequence[float]) -> None:
        """A box; boxes are gathered and made at once."""
        index = self._index(surface)
        self._low.setdefault(index, []).append(low)
        self._high.setdefault(index, []).append(high)

    def bars(
        self, surface: int, lines: Iterable[tuple[Sequence[float], Sequence[float]]], radius: float
    ) -> None:
        """Round bars between pairs of points; bars are gathered and made at once."""
        self._bars.setdefault((self._index(surface), round(radius, 5)), []).extend(lines)

    def put(self, surface: int, mesh: Mesh, matrix: Float[np.ndarray, "4 4"]) -> None:
        """A body moved by a matrix."""
        self.add(surface, shapes.transform(mesh, matrix))

    def parts(self) -> list[Part]:
        """Everything, one part a surface."""
        found = []
        for index in sorted({*self._meshes, *self._low, *(index for index, _ in self._bars)}):
            meshes = list(self._meshes.get(index, []))
            for (surface, radius), lines in self._bars.items():
                if surface == index:
                    ends = np.array(lines, dtype=np.float64)
                    meshes.append(shapes.bars(ends[:, 0], ends[:, 1], radius))
            if index in self._low:
                meshes.append(shapes.boxes(np.array(self._low[index]), np.array(self._high[index])))
            found.append(Part(shapes.merge(meshes), self._item.surfaces[index], self._item.kind))
        return found

    def _index(self, surface: int) -> int:
        return min(surface, len(self._item.surfaces) - 1)
