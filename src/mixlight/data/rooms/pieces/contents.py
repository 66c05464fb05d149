"""What fills shelves and racks: books, boxes, jars, folded clothes; built into the piece that holds them."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import numpy as np

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh
from mixlight.data.rooms.pieces.piece import Bodies

__all__ = ["books", "boxes", "clothes_on_hangers", "fill", "folded", "jars"]


def books(
    bodies: Bodies,
    rng: Random,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z: float,
    clear: float,
    surfaces: Sequence[int],
) -> None:
    """Books side by side from x0 on, their backs towards -Y, a few lying, now and then a gap at the end."""
    x, end = x0, x1 if rng.random() < 0.45 else x0 + (x1 - x0) * rng.uniform(0.35, 0.95)
    tallest = min(clear - 0.02, 0.34)
    if tallest < 0.1 or y1 - y0 < 0.08:
        return
    usual = rng.uniform(0.55, 0.95) * tallest
    series, left = 0, 0
    height, colour, deep = usual, surfaces[0], 0.16
    while x < end:
        if left == 0:  # a new book, or a row of volumes that look alike
            left = rng.choice([1, 1, 1, 1, 2, 4, 7])
            series = rng.choice(list(surfaces))
            height = min(usual * rng.uniform(0.8, 1.25), tallest)
            deep = min(rng.uniform(0.11, 0.22), y1 - y0 - 0.01)
            colour = series
        thick = rng.uniform(0.012, 0.045)
        if x + thick > x1:
            return
        front = y0 + rng.uniform(0.004, 0.03) + max(0.0, (y1 - y0 - 0.25) * 0.5)
        bodies.box(colour, (x, front, z), (x + thick - 0.001, min(front + deep, y1), z + height))
        x += thick
        left -= 1
        if rng.random() < 0.03 and x + 0.24 < end:
            stack(
                bodies,
                rng,
                x + 0.12,
                (y0 + y1) / 2,
                z,
                min(0.2, clear * 0.8),
                surfaces,
                wide=0.22,
                deep=y1 - y0 - 0.02,
            )
            x += 0.26


def stack(
    bodies: Bodies,
    rng: Random,
    x: float,
    y: float,
    z: float,
    height: float,
    surfaces: Sequence[int],
    *,
    wide: float = 0.24,
    deep: float = 0.3,
    top: int | None = None,
) -> None:
    """Lying books or boxes, one on the other, no larger than `wide` x `deep`."""
    at = z
    while True:
        thick = rng.uniform(0.012, 0.045)
        if at + thick > z + height:
            return
        w, d = wide * rng.uniform(0.7, 1.0) / 2, deep * rng.uniform(0.6, 1.0) / 2
        body = shapes.box((-w, -d, 0), (w, d, thick - 0.001))
        spin = rng.uniform(-0.12, 0.12) * (1 - max(w / wide, d / deep) * 1.6)
        bodies.put(rng.choice(list(surfaces)), body, shapes.placement((x, y, at), spin))
        at += thick


def boxes(
    bodies: Bodies,
    rng: Random,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z: float,
    clear: float,
    surfaces: Sequence[int],
) -> None:
    """Boxes, binders or cartons of a few sizes side by side, some two high."""
    x = x0 + rng.uniform(0, 0.04)
    kind = rng.choice(["files", "cartons", "cartons", "packets"])
    while True:
        if kind == "files":
            w, h, d = rng.uniform(0.05, 0.085), min(0.32, clear - 0.02), 0.28
        elif kind == "packets":
            w, h, d = (
                rng.uniform(0.06, 0.16),
                rng.uniform(0.4, 0.9) * min(clear, 0.32),
                rng.uniform(0.04, 0.12),
            )
        else:
            w, h, d = rng.uniform(0.16, 0.4), rng.uniform(0.4, 0.92) * min(clear, 0.4), rng.uniform(0.2, 0.4)
        d = min(d, y1 - y0 - 0.01)
        if x + w > x1 or h < 0.04:
            return
        colour, front = rng.choice(list(surfaces)), y0 + rng.uniform(0.0, min(0.05, y1 - y0 - d))
        row = front
        while row + d <= y1 and (row == front or kind == "packets"):
            bodies.box(colour, (x, row, z), (x + w - 0.002, row + d - 0.002, z + h))
            if 2 * h < clear - 0.02 and rng.random() < 0.5:
                bodies.box(
                    colour, (x + 0.003, row + 0.003, z + h), (x + w - 0.006, row + d - 0.006, z + 2 * h)
                )
            row += d
        x += w + (rng.uniform(0.0, 0.01) if rng.random() < 0.85 else rng.uniform(0.05, 0.2))


def jars(
    bodies: Bodies,
    rng: Random,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z: float,
    clear: float,
    surfaces: Sequence[int],
) -> None:
    """Bottles, jars, cans, cups and bowls in loose order."""
    x = x0
    while x < x1:
        what = rng.choice(["can", "bottle", "jar", "bowl", "cup"])
        r = {"can": 0.035, "bottle": 0.036, "jar": 0.045, "bowl": 0.075, "cup": 0.042}[what] * rng.uniform(
            0.85, 1.2
        )
        h = {"can": 0.11, "bottle": 0.27, "jar": 0.15, "bowl": 0.07, "cup": 0.095}[what] * rng.uniform(
            0.85, 1.15
        )
        r, h = min(r, (y1 - y0) / 2 - 0.005), min(h, clear - 0.02)
        if x + 2 * r > x1 or h < 0.04 or r < 0.02:
            return
        colour = rng.choice(list(surfaces))
        for _ in range(rng.choice([1, 1, 1, 3, 4])):
            if x + 2 * r > x1:
                return
            y = rng.uniform(y0 + r, max(y0 + r, min(y1 - r, y0 + r + 0.08)))
            bodies.put(colour, vessel(what, r, h), shapes.placement((x + r, y, z)))
            x += 2 * r + rng.uniform(0.002, 0.02)
        x += rng.uniform(0.0, 0.08)


def vessel(what: str, radius: float, height: float, *, segments: int = 14) -> Mesh:
    """A turned thing that stands at the origin: can, bottle, jar, bowl, cup, vase or pot."""
    r, h = radius, height
    profiles = {
        "can": [(r, 0), (r, h), (0, h)],
        "jar": [
            (r * 0.95, 0),
            (r, 0.02 * h),
            (r, 0.78 * h),
            (r * 0.7, 0.85 * h),
            (r * 0.75, 0.86 * h),
            (r * 0.75, h),
            (0, h),
        ],
        "bottle": [(r, 0), (r, 0.58 * h), (r * 0.85, 0.68 * h), (r * 0.38, 0.8 * h), (r * 0.36, h), (0, h)],
        "bowl": [
            (r * 0.45, 0),
            (r * 0.5, 0.05 * h),
            (r * 0.85, 0.5 * h),
            (r, h),
            (r * 0.94, h),
            (r * 0.78, 0.5 * h),
            (0, 0.14 * h),
        ],
        "cup": [
            (r * 0.75, 0),
            (r * 0.95, 0.25 * h),
            (r, h),
            (r * 0.9, h),
            (r * 0.84, 0.25 * h),
            (0, 0.12 * h),
        ],
        "vase": [
            (r * 0.5, 0),
            (r * 0.85, 0.2 * h),
            (r, 0.42 * h),
            (r * 0.75, 0.68 * h),
            (r * 0.4, 0.85 * h),
            (r * 0.52, h),
            (r * 0.44, h),
            (r * 0.3, 0.84 * h),
            (0, 0.8 * h),
        ],
        "pot": [(r * 0.72, 0), (r, 0.9 * h), (r * 1.0, h), (r * 0.9, h), (r * 0.88, 0.88 * h), (0, 0.88 * h)],
    }
    return shapes.lathe(np.array(profiles[what], dtype=np.float64), segments=segments, crease=0.5)


def folded(
    bodies: Bodies,
    rng: Random,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z: float,
    clear: float,
    surfaces: Sequence[int],
) -> None:
    """Piles of folded clothes or towels."""
    x = x0 + rng.uniform(0, 0.05)
    while True:
        w, d = rng.uniform(0.22, 0.32), min(rng.uniform(0.25, 0.36), y1 - y0)
        if x + w > x1 or clear < 0.08:
            return
        at, top = z, z + rng.uniform(0.2, 0.9) * min(clear - 0.02, 0.35)
        while True:
            thick = rng.uniform(0.02, 0.05)
            if at + thick > top:
                break
            body = shapes.rounded_box(
                (x + rng.uniform(0, 0.012), y0, at),
                (x + w - rng.uniform(0, 0.012), y0 + d, at + thick),
                thick * 0.45,
            )
            bodies.add(rng.choice(list(surfaces)), body)
            at += thick
        x += w + rng.uniform(0.01, 0.12)


def clothes_on_hangers(
    bodies: Bodies,
    rng: Random,
    x0: float,
    x1: float,
    y: float,
    z: float,
    length: float,
    surfaces: Sequence[int],
    *,
    deep: float = 0.5,
) -> None:
    """Clothes side by side under a rail along x at height z, hanging down by up to `length`."""
    x = x0
    colour = rng.choice(list(surfaces))
    drop = length
    while x < x1:
        if rng.random() < 0.4:
            colour, drop = rng.choice(list(surfaces)), length * rng.uniform(0.6, 1.0)
        half, thick = deep / 2 * rng.uniform(0.8, 1.0), rng.uniform(0.015, 0.045)
        if x + thick > x1:
            return
        wave = [rng.uniform(-0.01, 0.01) for _ in range(4)]
        ys = np.array([-1.0, -0.85, -0.3, 0.0, 0.3, 0.85, 1.0]) * half
        tops = np.array([0.13, 0.09, 0.03, 0.0, 0.03, 0.09, 0.13])
        rows = []
        for i, share in enumerate((0.0, 0.35, 0.7, 1.0)):
            zs = z - 0.05 - tops * (1 - share) - (drop - 0.05) * share
            bulge = thick / 2 * (0.5 + 0.5 * share) + np.zeros(7)
            front = np.stack((x + thick / 2 + bulge + wave[i], y + ys, zs), -1)
            back = np.stack((x + thick / 2 - bulge + wave[i], y + ys, zs), -1)[::-1]
            rows.append(np.concatenate((front, back)))
        bodies.add(colour, shapes.loft(np.stack(rows[::-1]), caps=True))
        x += thick + rng.uniform(0.0, 0.03)


def fill(
    bodies: Bodies,
    rng: Random,
    what: str,
    x0: float,
    x1: float,
    y0: float,
    y1: float,
    z: float,
    clear: float,
    surfaces: Sequence[int],
) -> None:
    """Fill one board of a shelf with books, boxes, jars or folded clothes; "mixed": by chance."""
    if what == "mixed":
        what = rng.choice(["books", "books", "boxes", "jars"])
    {"books": books, "boxes": boxes, "jars": jars, "folded": folded}[what](
        bodies, rng, x0, x1, y0, y1, z, clear, surfaces
    )
