"""What workshops work with: tools, boards and cabinets for them, machines."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.style import RAW_WOOD, Style, tone
from mixlight.data.rooms.pieces.tables import drawers
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES"]


def _tool(
    bodies: Bodies, rng: Random, what: str, x: float, z: float, y: float, wood: int, metal: int
) -> None:
    """One tool that hangs from (x, z) before a board at y."""
    if what == "hammer":
        bodies.bars(wood, [((x, y, z - 0.3), (x, y, z))], 0.013)
        bodies.box(metal, (x - 0.06, y - 0.015, z - 0.02), (x + 0.05, y + 0.014, z + 0.015))
    elif what == "saw":
        blade = np.array([(x, z), (x - 0.05, z), (x - 0.1, z - 0.45), (x, z - 0.45)])
        body = (
            shapes.extrude(blade[:, :], 0.0, 0.002)
            if _turns_left(blade)
            else shapes.extrude(blade[::-1], 0.0, 0.002)
        )
        bodies.put(metal, body, np.array([[1, 0, 0, 0], [0, 0, 1, y - 0.002], [0, 1, 0, 0], [0, 0, 0, 1.0]]))
        bodies.box(wood, (x - 0.06, y - 0.012, z - 0.01), (x + 0.01, y + 0.01, z + 0.07))
    elif what == "wrench":
        bodies.box(metal, (x - 0.01, y - 0.004, z - 0.22), (x + 0.01, y + 0.004, z))
        ring = shapes.rotation("x", math.pi / 2)
        bodies.put(
            metal, shapes.torus(0.017, 0.007, segments=12, sides=6), shapes.placement((x, y, z - 0.22)) @ ring
        )
    elif what == "driver":
        bodies.bars(metal, [((x, y, z - 0.22), (x, y, z - 0.1))], 0.004)
        bodies.bars(wood, [((x, y, z - 0.1), (x, y, z))], 0.014)
    else:  # pliers
        for side in (-1, 1):
            bodies.bars(wood, [((x + side * 0.03, y, z - 0.18), (x + side * 0.004, y, z - 0.06))], 0.008)
            bodies.bars(metal, [((x - side * 0.004, y, z - 0.06), (x - side * 0.01, y, z))], 0.007)


def _turns_left(outline: np.ndarray) -> bool:
    x, y = outline[:, 0], outline[:, 1]
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) > 0


def _draw_tool_board(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.8, 1.6), 0.07, rng.uniform(0.6, 1.0))
    return draft(
        size,
        (rng.choice([RAW_WOOD, style.metal, style.ceramic]), style.metal, style.wood_2, *style.accents[:2]),
        seed=rng.randrange(1 << 20),
    )


def _tool_board(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    x, y = width / 2, depth / 2
    bodies.box(0, (-x, y - 0.02, 0.0), (x, y, height))
    z = height - 0.09
    while z > 0.48 or z == height - 0.09:
        at = -x + 0.1
        while at < x - 0.06:
            what = rng.choice(["hammer", "saw", "wrench", "wrench", "driver", "driver", "pliers"])
            if rng.random() < 0.85 and not (what == "saw" and z < 0.47):
                _tool(bodies, rng, what, at, z, y - 0.035, rng.choice([2, 2, 3, 4]), 1)
            at += {"hammer": 0.14, "saw": 0.16, "wrench": 0.06, "driver": 0.05, "pliers": 0.09}[what]
        z -= 0.45
    return bodies.parts()


def _draw_tool(rng: Random, style: Style) -> Item:
    what = rng.choice(["hammer", "saw", "wrench", "driver", "pliers", "drill", "case"])
    size = {
        "hammer": (0.12, 0.34, 0.03),
        "saw": (0.12, 0.54, 0.03),
        "wrench": (0.05, 0.26, 0.015),
        "driver": (0.03, 0.24, 0.03),
        "pliers": (0.08, 0.2, 0.018),
        "drill": (0.08, 0.26, 0.24),
        "case": (0.42, 0.22, 0.2),
    }[what]
    return draft(
        size,
        (rng.choice([style.metal, style.dark_metal]), rng.choice([style.wood_2, *style.accents[:3]])),
        what=what,
        seed=rng.randrange(1 << 20),
    )


def _lying_tool(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, what = Bodies(item), item.parameters["what"]
    x, y = width / 2, depth / 2
    if what == "drill":
        bodies.add(
            1,
            shapes.tube(
                np.array([(0, y - 0.02, height - 0.05), (0, -y + 0.1, height - 0.05)]), 0.038, segments=14
            ),
        )
        bodies.add(
            0,
            shapes.tube(
                np.array([(0, -y + 0.1, height - 0.05), (0, -y + 0.06, height - 0.05)]), 0.022, segments=12
            ),
        )
        bodies.bars(0, [((0, -y + 0.06, height - 0.05), (0, -y, height - 0.05))], 0.004)
        bodies.box(1, (-0.02, 0.02, 0.05), (0.02, 0.08, height - 0.06))
        bodies.box(1, (-x, -0.03, 0.0), (x, 0.11, 0.06))
    elif what == "case":
        bodies.add(1, shapes.rounded_box((-x, -y, 0.0), (x, y, height - 0.05), 0.015, steps=1))
        bodies.add(
            0,
            shapes.tube(
                np.array(
                    [
                        (-0.08, 0, height - 0.06),
                        (-0.08, 0, height - 0.012),
                        (0.08, 0, height - 0.012),
                        (0.08, 0, height - 0.06),
                    ]
                ),
                0.01,
            ),
        )
    else:  # the tool that hangs, laid on its side
        _tool(bodies, Random(0), what, 0.0, 0.0, 0.0, 1, 0)
        flat = shapes.rotation("x", -math.pi / 2)
        return _lifted([shapes.move(part, flat) for part in bodies.parts()])
    return bodies.parts()


def _lifted(parts: list[Part]) -> list[Part]:
    """Parts moved together so that their middle is the origin and the lowest point is on the ground."""
    points = np.concatenate([part.mesh.vertices for part in parts])
    low, high = points.min(0), points.max(0)
    matrix = shapes.placement((-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]))
    return [shapes.move(part, matrix) for part in parts]


def _draw_machine(rng: Random, style: Style) -> Item:
    size = (rng.uniform(0.6, 1.3), rng.uniform(0.5, 0.9), rng.uniform(1.0, 1.7))
    paint = Surface(
        "paint",
        tone(rng, rng.choice([(0.5, 0.9, 0.7), (0.8, 0.85, 0.9), (0.3, 0.5, 1.0), (1, 0.7, 0.2)]), 0.1, 0.4),
        roughness=0.35,
    )
    return draft(
        size,
        (paint, style.metal, style.dark_metal, style.accents[0]),
        kind_of=rng.choice(["drill", "saw", "lathe"]),
    )


def _machine(item: Item) -> list[Part]:
    """A drill press, a table saw or a lathe, roughly."""
    width, depth, height = item.size
    bodies, what = Bodies(item), item.parameters["kind_of"]
    x, y = width / 2, depth / 2
    if what == "drill":
        bodies.box(1, (-x * 0.7, -y, 0.0), (x * 0.7, y, 0.06))
        bodies.add(1, shapes.cylinder(0.05, height - 0.06, base=(0, y * 0.6, 0.06), segments=20))
        bodies.add(0, shapes.rounded_box((-x * 0.45, -y * 0.8, height - 0.4), (x * 0.45, y, height), 0.05))
        bodies.add(1, shapes.cylinder(0.035, 0.25, base=(0, -y * 0.45, height - 0.62), segments=16))
        bodies.box(1, (-x, -y, height * 0.48), (x, y * 0.4, height * 0.48 + 0.05))
        bodies.bars(2, [((x * 0.45, -y * 0.3, height - 0.25), (x * 0.95, -y * 0.9, height - 0.35))], 0.012)
        bodies.box(3, (-0.04, -y * 0.8 - 0.01, height - 0.15), (0.04, -y * 0.8, height - 0.08))
    else:
        table = min(0.88, height * 0.7)
        bodies.box(0, (-x * 0.8, -y * 0.8, 0.03), (x * 0.8, y * 0.8, table - 0.05))
        bodies.box(2, (-x * 0.75, -y * 0.75, 0.0), (x * 0.75, y * 0.75, 0.03))
        bodies.box(1, (-x, -y, table - 0.05), (x, y, table))
        if what == "saw":
            blade = shapes.transform(
                shapes.cylinder(0.15, 0.004, segments=32), shapes.rotation("y", math.pi / 2)
            )
            bodies.put(1, blade, shapes.placement((0, 0, table)))
            bodies.box(1, (x * 0.4, -y, table), (x * 0.4 + 0.04, y, table + 0.07))
            bodies.box(0, (-0.02, y - 0.1, table), (0.02, y - 0.05, height))
        else:
            bodies.add(0, shapes.rounded_box((-x, -y * 0.5, table), (-x * 0.4, y * 0.7, height), 0.04))
            chuck = shapes.transform(
                shapes.cylinder(0.09, 0.1, segments=20), shapes.rotation("y", math.pi / 2)
            )
            bodies.put(1, chuck, shapes.placement((-x * 0.4, 0, table + 0.22)))
            bodies.box(0, (x * 0.6, -y * 0.3, table), (x * 0.95, y * 0.3, table + 0.28))
            bodies.bars(1, [((-x * 0.3, 0, table + 0.22), (x * 0.6, 0, table + 0.22))], 0.03)
        bodies.box(3, (-x * 0.8, -y * 0.8 - 0.02, table - 0.25), (-x * 0.5, -y * 0.8, table - 0.12))
    return bodies.parts()


def _draw_tool_cabinet(rng: Random, style: Style) -> Item:
    paint = Surface(
        "paint",
        tone(rng, rng.choice([(1, 0.05, 0.03), (0.05, 0.2, 1), (0.9, 0.95, 1), (0.9, 0.95, 1)]), 0.05, 0.25),
        roughness=0.25,
    )
    return draft(
        (rng.uniform(0.6, 0.75), 0.46, rng.uniform(0.75, 1.0)),
        (paint, style.metal, style.dark_metal),
        rows=rng.choice([4, 5, 6, 7]),
    )


def _tool_cabinet(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y = width / 2, depth / 2
    drawers(bodies, 0, 1, -x, x, -y + 0.024, y, 0.1, height - 0.02, item.parameters["rows"])
    bodies.box(2, (-x, -y, height - 0.02), (x, y, height))
    for sx in (-1, 1):
        for sy in (-1, 1):
            wheel = shapes.transform(
                shapes.cylinder(0.045, 0.03, segments=14), shapes.rotation("y", math.pi / 2)
            )
            bodies.put(2, wheel, shapes.placement((sx * (x - 0.08) - 0.015, sy * (y - 0.08), 0.045)))
            bodies.box(
                2,
                (sx * (x - 0.08) - 0.02, sy * (y - 0.08) - 0.02, 0.05),
                (sx * (x - 0.08) + 0.02, sy * (y - 0.08) + 0.02, 0.1),
            )
    return bodies.parts()


PIECES = (
    Piece("tool_board", "tool_board", _draw_tool_board, _tool_board),
    Piece("tool", "tool", _draw_tool, _lying_tool),
    Piece("machine", "machine", _draw_machine, _machine),
    Piece("tool_cabinet", "tool_cabinet", _draw_tool_cabinet, _tool_cabinet),
)
