"""Beds with their bedclothes, and soft things that lie about: rugs, cushions, blankets, clothes, towels."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.pieces.piece import Bodies, Piece, draft
from mixlight.data.rooms.pieces.seating import legs
from mixlight.data.rooms.pieces.style import Style, tone
from mixlight.data.rooms.plan import Item, Surface

__all__ = ["PIECES", "crumpled"]


def _draw_bed(rng: Random, style: Style, *, single: bool = False) -> Item:
    width = rng.choice([0.9, 0.9, 1.0, 1.2]) if single else rng.choice([1.4, 1.6, 1.6, 1.8])
    frame = rng.choice([style.wood, style.wood, style.upholstery, style.dark_metal])
    head = rng.choice([0.0, rng.uniform(0.75, 1.25)])
    margin = 0.05
    top = rng.uniform(0.48, 0.62)
    cover = rng.choice(
        [
            style.linen,
            style.upholstery_2,
            Surface("fabric", tone(rng, (1, 0.95, 0.9), 0.05, 0.6), roughness=0.95),
        ]
    )
    x, y = width / 2, 1.0
    return draft(
        (width + 2 * margin, 2.12, max(head, top + 0.34)),
        (frame, style.linen, cover, rng.choice([style.linen, cover, style.upholstery_2])),
        head=round(head, 3),
        top=round(top, 3),
        margin=margin,
        made=rng.random() < 0.6,
        pillows=1 if width < 1.3 else rng.choice([2, 2, 3, 4]),
        foot=round(rng.choice([0.0, 0.12, 0.2]), 3),
        seed=rng.randrange(1 << 20),
        tops=[[-x + 0.1, -y + 0.1, x - 0.1, y - 0.6, round(top + 0.075, 3), 1.0]],
    )


def _bed(item: Item) -> list[Part]:
    width, depth, _ = item.size
    p, bodies, rng = item.parameters, Bodies(item), Random(item.parameters["seed"])
    margin, top, foot = p["margin"], p["top"], p["foot"]
    x, y = width / 2, depth / 2
    low = top - 0.22
    if foot > 0:
        legs(bodies, 0, width, depth, foot, 0.06, inset=0.02)
    bodies.box(0, (-x, -y, foot), (x, y - 0.06, max(low, foot + 0.06)))
    if p["head"] > 0:
        soft = item.surfaces[0].kind in ("fabric", "leather")
        board = (-x, y - 0.07, foot * 0.2), (x, y, p["head"])
        bodies.add(0, shapes.rounded_box(*board, 0.03 if soft else 0.008))
    else:
        bodies.box(0, (-x, y - 0.06, foot), (x, y, low + 0.05))
    half = x - margin
    bodies.add(1, shapes.rounded_box((-half, -y + 0.04, low), (half, y - 0.08, top), 0.06))
    bodies.add(2, duvet(rng, half, y, top, made=p["made"]))
    count = min(p["pillows"], 2 if half < 0.95 else 3)
    wide = min(0.72, 2 * half / count)
    for layer in range(2 if p["pillows"] > count else 1):
        for i in range(count):
            mesh = shapes.pillow(wide * 0.92, 0.46, 0.15)
            at = -half + (i + 0.5) * 2 * half / count
            lean = shapes.rotation("x", rng.uniform(0.25, 0.5) if layer == 0 else rng.uniform(0.7, 0.9))
            spin = shapes.rotation("z", rng.uniform(-0.12, 0.12))
            place = shapes.placement((at, y - 0.36 + (-0.1 if layer else 0.0), top + 0.06 + 0.07 * layer))
            bodies.put(1 if layer == 0 else 3, mesh, place @ spin @ lean @ shapes.placement((0, 0, -0.05)))
    return bodies.parts()


def duvet(rng: Random, half: float, y: float, top: float, *, made: bool) -> Mesh:
    """A duvet over a mattress: it hangs down on three sides in soft folds; turned back if not made."""
    across, along = 33, 41
    u, v = np.linspace(-1, 1, across), np.linspace(0, 1, along)
    end = y - 0.62 if made else y - rng.uniform(0.75, 1.3)
    reach = half + 0.012
    s = u * (half + 0.3)  # measured over the cloth
    xs = np.sign(s) * np.minimum(np.abs(s), reach)
    drop = np.maximum(np.abs(s) - reach, 0.0)
    length = (end + y - 0.02) + 0.22
    t = v * length
    ys = end - np.minimum(t, end + y - 0.02)
    drop_end = np.maximum(t - (end + y - 0.02), 0.0)
    points = np.empty((across, along, 3))
    points[..., 0] = xs[:, None]
    points[..., 1] = ys[None, :]
    phases = [rng.uniform(0, 6.3) for _ in range(6)]
    soft = np.zeros((across, along))
    for i, (kx, ky) in enumerate(((3, 5), (7, 2), (5, 9), (11, 6), (2, 13), (9, 14))):
        soft += np.sin(kx * u[:, None] * 2 + ky * v[None, :] * 2 + phases[i]) / (1.5 + i)
    rough = 0.006 if made else 0.022
    rise = np.zeros(along) if made else 0.05 * np.clip(1 - v * 3, 0, 1)
    lift = (0.05 + rise)[None, :]
    flat = (drop[:, None] == 0) & (drop_end[None, :] == 0)
    points[..., 2] = top + lift + rough * soft - drop[:, None] - drop_end[None, :]
    # Where the cloth hangs, the folds go sideways instead of up.
    sway = 0.012 * np.sin(26 * v * length / 2 + phases[0])[None, :] * np.clip(drop / 0.2, 0, 1)[:, None]
    points[..., 0] += np.sign(u)[:, None] * np.abs(sway + 0.012 * (drop[:, None] > 0))
    points[..., 1] -= (
        0.012 * np.abs(np.sin(9 * u + phases[1]))[:, None] * np.clip(drop_end / 0.2, 0, 1)[None, :]
    )
    points[..., 2] = np.where(flat, np.maximum(points[..., 2], top + 0.012), points[..., 2])
    return shapes.sheet(points[:, ::-1])


def crumpled(rng: Random, width: float, depth: float, height: float, *, steps: int = 18) -> Mesh:
    """A heap of cloth that fills a box: clothes, a towel, a blanket thrown down."""
    u = np.linspace(-1, 1, steps)
    x, y = np.meshgrid(u, u, indexing="ij")
    angle = np.arctan2(y, x)
    radius = np.maximum(np.abs(x), np.abs(y))
    edge = 0.86 + 0.1 * np.sin(angle * rng.choice([3, 4, 5]) + rng.uniform(0, 6)) + 0.04 * np.sin(angle * 9)
    body = np.clip(1 - radius**2, 0, 1) ** 0.6
    noise = np.zeros_like(x)
    for i in range(6):
        kx, ky = rng.uniform(-5, 5), rng.uniform(-5, 5)
        noise += np.sin(kx * x * (1 + i * 0.5) + ky * y * (1 + i * 0.5) + rng.uniform(0, 6)) / (1 + i * 0.6)
    z = body * (0.7 + 0.12 * noise)
    z = np.tanh(1.6 * z / max(float(z.max()), 1e-6)) / math.tanh(1.6)  # heaps are flat on top
    z = np.clip(z, 0.0, 1.0)
    squash = np.where(radius > 0, np.maximum(np.abs(x), np.abs(y)) / np.maximum(np.hypot(x, y), 1e-9), 1.0)
    points = np.stack(
        (x * edge * squash * width / 2, y * edge * squash * depth / 2, 0.004 + z * (height - 0.004)), -1
    )
    return shapes.sheet(points)


def _draw_rug(rng: Random, style: Style) -> Item:
    small = rng.random() < 0.3
    size = (
        (rng.uniform(0.5, 0.9), rng.uniform(0.45, 0.6), 0.014)
        if small
        else (rng.uniform(1.4, 3.0), rng.uniform(1.0, 2.0), 0.014)
    )
    return draft(size, (style.rug,), round=not small and rng.random() < 0.15)


def _rug(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    if item.parameters["round"]:
        body = shapes.cylinder(0.5, height, segments=48)
        bodies.put(0, body, shapes.placement(scale=(width, depth, 1)))
        return bodies.parts()
    bodies.box(0, (-width / 2, -depth / 2, 0.0), (width / 2, depth / 2, height))
    return bodies.parts()


def _cloth(rng: Random, style: Style) -> Surface:
    return rng.choice(
        [
            style.linen,
            style.upholstery_2,
            style.upholstery,
            *(Surface("fabric", s.colour, roughness=0.95) for s in style.books[:5]),
        ]
    )


def _draw_cushion(rng: Random, style: Style) -> Item:
    side = rng.uniform(0.35, 0.5)
    return draft((side, side * rng.uniform(0.75, 1.0), rng.uniform(0.1, 0.15)), (_cloth(rng, style),))


def _cushion(item: Item) -> list[Part]:
    bodies = Bodies(item)
    bodies.add(0, shapes.pillow(*item.size))
    return bodies.parts()


def _draw_heap(low: float, high: float, tall: tuple[float, float]) -> object:
    def draw(rng: Random, style: Style) -> Item:
        wide = rng.uniform(low, high)
        return draft(
            (wide, wide * rng.uniform(0.6, 1.0), rng.uniform(*tall)),
            (_cloth(rng, style),),
            seed=rng.randrange(1 << 20),
        )

    return draw


def _heap(item: Item) -> list[Part]:
    bodies = Bodies(item)
    bodies.add(0, crumpled(Random(item.parameters["seed"]), *item.size))
    return bodies.parts()


def _draw_laundry(rng: Random, style: Style) -> Item:
    wide = rng.uniform(0.4, 0.8)
    cloths = [_cloth(rng, style) for _ in range(4)]
    return draft(
        (wide, wide * rng.uniform(0.7, 1.0), rng.uniform(0.1, 0.2)), cloths, seed=rng.randrange(1 << 20)
    )


def _laundry(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    for i in range(4):
        w, d, h = (
            width * rng.uniform(0.5, 0.72),
            depth * rng.uniform(0.5, 0.72),
            height * (1.0 if i == 0 else rng.uniform(0.4, 0.9)),
        )
        x, y = rng.uniform(-1, 1) * (width - w) / 2, rng.uniform(-1, 1) * (depth - d) / 2
        bodies.put(i, crumpled(rng, w, d, h, steps=14), shapes.placement((x, y, 0.0)))
    return bodies.parts()


def _draw_towel(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.25, 0.4), rng.uniform(0.2, 0.3), rng.uniform(0.05, 0.2)),
        (style.linen, _cloth(rng, style)),
        seed=rng.randrange(1 << 20),
    )


def _folded(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies, rng = Bodies(item), Random(item.parameters["seed"])
    count = max(1, int(height / 0.05))
    for i in range(count):
        a, b = i * height / count, (i + 1) * height / count
        x, y = width / 2 - rng.uniform(0, 0.012), depth / 2 - rng.uniform(0, 0.012)
        bodies.add(rng.randrange(2), shapes.rounded_box((-x, -y, a), (x, y, b), (b - a) * 0.45))
    return bodies.parts()


def _draw_towel_rail(rng: Random, style: Style) -> Item:
    return draft(
        (rng.uniform(0.4, 0.65), 0.09, rng.uniform(0.4, 0.75)),
        (style.metal, rng.choice([style.linen, _cloth(rng, style)])),
        towel=rng.random() < 0.85,
        share=round(rng.uniform(0.5, 0.9), 2),
    )


def _towel_rail(item: Item) -> list[Part]:
    width, depth, height = item.size
    bodies = Bodies(item)
    x, y, z = width / 2, depth / 2, height - 0.02
    bodies.bars(0, [((-x + 0.01, -0.01, z), (x - 0.01, -0.01, z))], 0.009)
    for side in (-1, 1):
        bodies.bars(0, [((side * (x - 0.012), -0.01, z), (side * (x - 0.012), y, z))], 0.009)
    if item.parameters["towel"]:
        half = x * item.parameters["share"]
        turn = np.linspace(0, math.pi, 7)
        line = [(-0.01 + 0.014, 0.2 * height)]
        line += [(-0.01 + 0.014 * math.cos(t), z + 0.014 * math.sin(t)) for t in turn]
        line += [(-0.01 - 0.016, z - 0.5 * height), (-0.01 - 0.018, 0.03)]
        columns = np.linspace(-half, half, 13)
        points = np.empty((13, len(line), 3))
        points[..., 0] = columns[:, None]
        for j, (at, high) in enumerate(line):
            points[:, j, 1] = at + 0.006 * math.sin(j) * np.sin(columns * 40) * (high < z - 0.05)
            points[:, j, 2] = high
        bodies.add(1, shapes.sheet(points[::-1]))
    return bodies.parts()


PIECES = (
    Piece("bed", "bed", _draw_bed, _bed),
    Piece("single_bed", "child_bed", lambda rng, style: _draw_bed(rng, style, single=True), _bed),
    Piece("rug", "rug", _draw_rug, _rug),
    Piece("cushion", "cushion", _draw_cushion, _cushion),
    Piece("clothes", "clothes", _draw_heap(0.3, 0.6, (0.05, 0.14)), _heap),  # type: ignore[arg-type]
    Piece("blanket", "blanket", _draw_heap(0.5, 1.0, (0.06, 0.16)), _heap),  # type: ignore[arg-type]
    Piece("laundry", "laundry", _draw_laundry, _laundry),
    Piece("towel", "towel", _draw_towel, _folded),
    Piece("folded_clothes", "clothes", _draw_towel, _folded, 0.6),
    Piece("towel_rail", "towel_rail", _draw_towel_rail, _towel_rail),
)
