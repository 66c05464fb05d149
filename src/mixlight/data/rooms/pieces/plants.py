"""Plants in pots, flowers in vases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.pieces.contents import vessel
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import Style, tone
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]

_SOIL = Surface("carpet", (0.025, 0.016, 0.011), roughness=1.0)


class _Leaves:
    """Leaves of one plant: they share a shape and differ in place, direction and size."""

    def __init__(self, rng: Random, bend: float) -> None:
        self._rng, self._bend = rng, bend
        self._rows: list[tuple[float, ...]] = []

    def add(self, at: Sequence[float], heading: float, rise: float, length: float, width: float) -> None:
        """One that grows from a point towards `heading` (from +X, radians), up by `rise`."""
        roll = self._rng.uniform(-0.3, 0.3)
        self._rows.append((at[0], at[1], at[2], heading - math.pi / 2, rise, roll, length, width))

    def mesh(self, reach: float, height: float) -> Mesh:
        """All of them, none farther than `reach` from the stem or higher than `height`."""
        rows = np.array(self._rows)
        angle, rise, roll, length, width = rows[:, 3:].T
        scale = np.zeros((len(rows), 4, 4))
        scale[:, 0, 0], scale[:, 1, 1], scale[:, 2, 2], scale[:, 3, 3] = width, length, length, 1.0
        matrices = _turns(2, angle) @ _turns(0, rise) @ _turns(1, roll) @ scale
        matrices[:, :3, 3] = rows[:, :3]
        mesh = shapes.instances(leaf(self._bend), matrices)
        return replace(mesh, vertices=np.clip(mesh.vertices, (-reach, -reach, 0.01), (reach, reach, height)))


def _turns(axis: int, angles: np.ndarray) -> np.ndarray:
    """Rotation matrices about one axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found = np.tile(np.eye(4), (len(angles), 1, 1))
    found[:, i, i] = found[:, j, j] = np.cos(angles)
    found[:, j, i], found[:, i, j] = np.sin(angles), -np.sin(angles)
    return found


def leaf(bend: float) -> Mesh:
    """A leaf 1 long and 1 wide that grows along +Y from the origin, its upper side up; its tip hangs down by
    `bend`.
    """
    t = np.linspace(0, 1, 6)
    half = 0.5 * np.sin(np.pi * np.clip(t * 0.92 + 0.06, 0, 1)) ** 0.8
    points = np.empty((3, 6, 3))
    for row, side in enumerate((-1.0, 0.0, 1.0)):
        points[row, :, 0] = side * half
        points[row, :, 1] = t * (1 - 0.25 * bend * t)
        points[row, :, 2] = 0.25 * t - bend * t**2 + 0.06 * abs(side) * half
    return shapes.sheet(points)


def _draw(rng: Random, style: Style, *, small: bool) -> Item:
    height = rng.uniform(0.14, 0.38) if small else rng.uniform(0.6, 1.9)
    what = rng.choice(["rosette", "bush", "stems"] if small else ["rosette", "tree", "bush", "palm", "tree"])
    wide = (
        height
        * {
            "rosette": rng.uniform(0.7, 1.1),
            "bush": rng.uniform(0.6, 0.9),
            "stems": 0.7,
            "tree": rng.uniform(0.4, 0.6),
            "palm": rng.uniform(0.6, 0.9),
        }[what]
    )
    wide = min(max(wide, 0.12), 1.1)
    pot = rng.choice(
        [
            style.ceramic,
            Surface("concrete", (0.3, 0.29, 0.27), roughness=0.8),
            Surface("plaster", tone(rng, (1, 0.42, 0.24), 0.1, 0.2), roughness=0.85),
            *style.accents[:3],
        ]
    )
    green = replace(
        style.leaf, colour=tone(rng, style.leaf.colour, 0.03, 0.13, spread=0.2), seed=rng.randrange(50)
    )
    stem = Surface("wood", (0.09, 0.06, 0.035), roughness=0.8)
    return draft((wide, wide, height), (pot, green, _SOIL, stem), what=what, seed=rng.randrange(1 << 20))


def _plant(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies, rng, what = Bodies(item), Random(item.parameters["seed"]), item.parameters["what"]
    reach = width / 2
    tall = min(max(0.22 * height, 0.06), 0.38) if what != "stems" else 0.4 * height
    r = min(tall * rng.uniform(0.42, 0.6), reach * 0.95)
    bodies.add(0, vessel("pot", r, tall, segments=20))
    bodies.add(2, shapes.cylinder(r * 0.88, 0.006, base=(0, 0, tall * 0.88), segments=16))
    base = tall * 0.88
    room = height - base
    leaves = _Leaves(rng, rng.uniform(0.1, 0.5))
    if what in ("rosette", "stems"):
        slim = rng.uniform(0.12, 0.3)
        for i in range(rng.randint(10, 22)):
            heading, rise = i * 2.4 + rng.uniform(-0.3, 0.3), rng.uniform(0.15, 1.25)
            length = min(reach * rng.uniform(0.75, 1.0) / max(math.cos(rise * 0.8), 0.3), room * 1.05)
            leaves.add((0, 0, base), heading, rise, length, length * slim)
    elif what == "palm":
        for i in range(rng.randint(5, 10)):
            heading, lean = i * 2.4, rng.uniform(0.15, 0.5)
            c, s, z = math.cos(heading), math.sin(heading), base + room * rng.uniform(0.45, 0.75)
            top = (c * lean * reach, s * lean * reach, z)
            bow = (top[0] * 0.5, top[1] * 0.5, z - 0.3 * (z - base))
            path = np.array([(0.3 * r * c, 0.3 * r * s, base), bow, top])
            bodies.add(1, shapes.tube(path, 0.006, segments=5, caps=False))
            for j in range(9):
                length = reach * rng.uniform(0.4, 0.62)
                leaves.add(top, heading + (j - 4) * 0.33, rng.uniform(0.2, 0.7), length, 0.035)
    else:
        crown = base + room * (0.45 if what == "tree" else 0.05)
        for _ in range(rng.randint(1, 3)):
            x, y = rng.uniform(-0.3, 0.3) * r, rng.uniform(-0.3, 0.3) * r
            knee = (x * 1.5, y * 1.5, (base + crown) / 2 + 0.01)
            path = np.array([(x, y, base - 0.01), knee, (x * 0.5, y * 0.5, height - room * 0.12)])
            bodies.add(3, shapes.tube(path, 0.008 + 0.01 * room * (what == "tree"), segments=6, caps=False))
        slim = rng.uniform(0.35, 0.6)
        for _ in range(int(min(60 + 160 * width, 170))):
            u, v = rng.uniform(0, 2 * math.pi), rng.uniform(-1, 1)
            radius = rng.uniform(0.25, 0.8) ** 0.5
            across = math.sqrt(1 - v * v) * radius * reach * 0.8
            z = (crown + height) / 2 + v * radius * (height - crown) * 0.425
            length = rng.uniform(0.16, 0.3) * min(width, 0.6)
            at = (math.cos(u) * across, math.sin(u) * across, z)
            leaves.add(at, u + rng.uniform(-0.8, 0.8), rng.uniform(-0.4, 0.8), length, length * slim)
    bodies.add(1, leaves.mesh(reach, height))
    return bodies.parts()


def _draw_flowers(rng: Random, style: Style) -> Item:
    height = rng.uniform(0.28, 0.5)
    petals = Surface(
        "plant",
        tone(
            rng,
            rng.choice([(1, 0.1, 0.1), (1, 0.75, 0.1), (1, 0.95, 0.9), (0.9, 0.3, 0.7), (1, 0.5, 0.3)]),
            0.12,
            0.6,
        ),
        roughness=0.6,
    )
    return draft(
        (height * 0.7, height * 0.7, height),
        (rng.choice([style.glass, style.ceramic, *style.accents[:2]]), style.leaf, petals),
        seed=rng.randrange(1 << 20),
    )


def _flowers(item: Item) -> list[Part]:
    width, _, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    tall = height * 0.48
    bodies.add(0, vessel("vase", tall * 0.32, tall, segments=18))
    leaves = _Leaves(rng, 0.4)
    head = np.array([(0.0, -0.6), (0.7, -0.3), (1.0, 0.4), (0.5, 0.2), (0.0, 0.3)])
    flower = shapes.lathe(head, segments=9, crease=3.0)
    for i in range(rng.randint(5, 12)):
        heading, lean = i * 2.4, rng.uniform(0.2, 0.85)
        x, y = (f(heading) * lean * (width / 2 - 0.04) for f in (math.cos, math.sin))
        z = height - 0.03 - 0.2 * lean * (height - tall)
        path = np.array([(0, 0, tall * 0.8), (x * 0.35, y * 0.35, z * 0.85), (x, y, z)])
        bodies.add(1, shapes.tube(path, 0.003, segments=4, caps=False))
        size = rng.uniform(0.02, 0.035)
        place = shapes.placement((x, y, z), 0.0, (size, size, size)) @ shapes.rotation("y", lean * 0.6)
        bodies.put(2, flower, place)
        leaves.add((x * 0.5, y * 0.5, z * 0.8), heading, 0.6, width * 0.3, 0.03)
    bodies.add(1, leaves.mesh(width / 2, height))
    return bodies.parts()


PIECES = (
    Piece("plant", "plant", lambda rng, style: _draw(rng, style, small=False), _plant),
    Piece("small_plant", "small_plant", lambda rng, style: _draw(rng, style, small=True), _plant),
    Piece("flowers", "flowers", _draw_flowers, _flowers),
)
