"""Plants in pots, flowers in vases."""

from __future__ import annotations

import math
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


def leaf(length: float, width: float, bend: float) -> Mesh:
    """A leaf that grows along +Y from the origin, its upper side up, hanging down by `bend` at its tip."""
    t = np.linspace(0, 1, 6)
    half = width / 2 * np.sin(np.pi * np.clip(t * 0.92 + 0.06, 0, 1)) ** 0.8
    points = np.empty((3, 6, 3))
    for row, side in enumerate((-1.0, 0.0, 1.0)):
        points[row, :, 0] = side * half
        points[row, :, 1] = length * t * (1 - 0.25 * bend * t)
        points[row, :, 2] = length * (0.25 * t - bend * t**2) + 0.18 * abs(side) * half
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
    if what in ("rosette", "stems"):
        for i in range(rng.randint(10, 22)):
            angle, rise = i * 2.4 + rng.uniform(-0.3, 0.3), rng.uniform(0.15, 1.25)
            length = min(reach * rng.uniform(0.75, 1.0) / max(math.cos(rise * 0.8), 0.3), room * 1.05)
            _leaf(
                bodies,
                rng,
                (0, 0, base),
                angle,
                rise,
                length,
                length * rng.uniform(0.12, 0.3),
                rng.uniform(0.1, 0.5),
                reach,
                height,
            )
    elif what == "palm":
        stems = rng.randint(5, 10)
        for i in range(stems):
            angle, lean = i * 2.4, rng.uniform(0.15, 0.5)
            top = np.array(
                [
                    math.cos(angle) * lean * reach,
                    math.sin(angle) * lean * reach,
                    base + room * rng.uniform(0.45, 0.75),
                ]
            )
            path = np.array(
                [
                    (0.3 * r * math.cos(angle), 0.3 * r * math.sin(angle), base),
                    top * [0.5, 0.5, 1] + [0, 0, -0.3 * (top[2] - base)],
                    top,
                ]
            )
            bodies.add(1, shapes.tube(path, 0.006, segments=5, caps=False))
            for j in range(9):
                _leaf(
                    bodies,
                    rng,
                    top,
                    angle + (j - 4) * 0.33,
                    rng.uniform(0.2, 0.7),
                    reach * rng.uniform(0.4, 0.62),
                    0.035,
                    0.5,
                    reach,
                    height,
                )
    else:
        trunk = what == "tree"
        crown = base + room * (0.45 if trunk else 0.05)
        count = rng.randint(1, 3)
        for _ in range(count):
            x, y = rng.uniform(-0.3, 0.3) * r, rng.uniform(-0.3, 0.3) * r
            path = np.array(
                [
                    (x, y, base - 0.01),
                    (x * 1.5, y * 1.5, (base + crown) / 2 + 0.01),
                    (x * 0.5, y * 0.5, height - room * 0.12),
                ]
            )
            bodies.add(3, shapes.tube(path, 0.008 + 0.01 * room * trunk, segments=6, caps=False))
        leaves = int(min(60 + 160 * width, 170))
        for _ in range(leaves):
            u, v = rng.uniform(0, 2 * math.pi), rng.uniform(-1, 1)
            radius = rng.uniform(0.25, 0.8) ** 0.5
            at = (math.cos(u) * math.sqrt(1 - v * v) * radius * reach * 0.8, math.sin(u) * math.sqrt(1 - v * v) * radius * reach * 0.8,
                  (crown + height) / 2 + v * radius * (height - crown) / 2 * 0.85)  # fmt: skip
            size = rng.uniform(0.16, 0.3) * min(width, 0.6)
            _leaf(
                bodies,
                rng,
                at,
                u + rng.uniform(-0.8, 0.8),
                rng.uniform(-0.4, 0.8),
                size,
                size * rng.uniform(0.35, 0.6),
                rng.uniform(0.1, 0.6),
                reach,
                height,
            )
    return bodies.parts()


def _leaf(
    bodies: Bodies,
    rng: Random,
    at: tuple[float, float, float] | np.ndarray,
    angle: float,
    rise: float,
    length: float,
    width: float,
    bend: float,
    reach: float,
    height: float,
) -> None:
    """A leaf from a point, towards `angle` and up by `rise`; kept within the plant's box."""
    mesh = leaf(length, width, bend)
    matrix = (
        shapes.placement((float(at[0]), float(at[1]), float(at[2])), angle)
        @ shapes.rotation("x", rise)
        @ shapes.rotation("y", rng.uniform(-0.3, 0.3))
    )
    mesh = shapes.transform(mesh, matrix)
    vertices = np.clip(mesh.vertices, (-reach, -reach, 0.01), (reach, reach, height))
    bodies.add(1, replace(mesh, vertices=vertices))


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
    for i in range(rng.randint(5, 12)):
        angle, lean = i * 2.4, rng.uniform(0.2, 0.85)
        top = np.array(
            [
                math.cos(angle) * lean * (width / 2 - 0.04),
                math.sin(angle) * lean * (width / 2 - 0.04),
                height - 0.03 - 0.2 * lean * (height - tall),
            ]
        )
        bodies.add(
            1,
            shapes.tube(
                np.array([(0, 0, tall * 0.8), top * [0.35, 0.35, 0.85], top]), 0.003, segments=4, caps=False
            ),
        )
        size = rng.uniform(0.02, 0.035)
        head = shapes.lathe(
            np.array(
                [
                    (0.0, -size * 0.6),
                    (size * 0.7, -size * 0.3),
                    (size, size * 0.4),
                    (size * 0.5, size * 0.2),
                    (0.0, size * 0.3),
                ]
            ),
            segments=9,
            crease=3.0,
        )
        bodies.put(2, head, shapes.placement(top) @ shapes.rotation("y", lean * 0.6))
        _leaf(bodies, rng, top * [0.5, 0.5, 0.8], angle, 0.6, width * 0.3, 0.03, 0.4, width / 2, height)
    return bodies.parts()


PIECES = (
    Piece("plant", "plant", lambda rng, style: _draw(rng, style, small=False), _plant),
    Piece("small_plant", "small_plant", lambda rng, style: _draw(rng, style, small=True), _plant),
    Piece("flowers", "flowers", _draw_flowers, _flowers),
)
