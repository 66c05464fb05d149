"""Flat bodies and cloth: polygons, prisms over them, panels, sheets, cushions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from mixlight.data.rooms.mesh import Mesh
from mixlight.data.rooms.shapes.placing import Vector, merge, weld

__all__ = ["corner_uv", "extrude", "panel", "pillow", "polygon", "sheet"]


def polygon(outline: Float[np.ndarray, "points 2"], height: float = 0.0, *, up: bool = True) -> Mesh:
    """A simple polygon, convex or not, lying at a height and looking up (or down).

    Args:
        outline: [P, 2] corners, counter-clockwise seen from above.
        height: z in metres.
        up: Its outside is above; else below.

    Raises:
        ValueError: fewer than three corners, clockwise, or the outline crosses itself.

    >>> polygon(np.array([[0.0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])).faces.shape
    (4, 4)
    """
    outline = np.asarray(outline, dtype=np.float64)
    triangles = _ears(outline)
    if not up:
        triangles = triangles[:, ::-1]
    faces = np.concatenate((triangles, np.full((len(triangles), 1), -1)), 1)
    vertices = np.concatenate((outline, np.full((len(outline), 1), height)), 1)
    return Mesh(vertices, faces, corner_uv(outline, faces))


def _ears(outline: Float[np.ndarray, "points 2"]) -> Int[np.ndarray, "triangles 3"]:
    """The triangles of a simple polygon, by cutting off ears."""

    def area(p: Vector, q: Vector, r: Vector) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    points = [(float(x), float(y)) for x, y in outline]
    rest = list(range(len(points)))
    tolerance = 1e-12 * max(1.0, float(np.ptp(outline)) ** 2) if len(points) else 0.0
    triangles = []
    while len(rest) > 3:
        for k in range(len(rest)):
            i, j, m = rest[k - 1], rest[k], rest[(k + 1) % len(rest)]
            p, q, r = points[i], points[j], points[m]
            if area(p, q, r) <= tolerance:
                continue
            others = (points[n] for n in rest if n not in (i, j, m))
            if any(
                area(p, q, o) >= -tolerance and area(q, r, o) >= -tolerance and area(r, p, o) >= -tolerance
                for o in others
                if o not in (p, q, r)
            ):
                continue
            triangles.append((i, j, m))
            del rest[k]
            break
        else:
            flat = [
                k
                for k in range(len(rest))
                if abs(area(points[rest[k - 1]], points[rest[k]], points[rest[(k + 1) % len(rest)]]))
                <= tolerance
            ]
            if not flat:
                raise ValueError(f"expected a simple counter-clockwise polygon, received {points}")
            del rest[flat[0]]  # three corners in a line: the middle one bounds no area
    if len(rest) < 3 or area(*(points[k] for k in rest)) <= tolerance:
        raise ValueError(f"expected a simple counter-clockwise polygon, received {points}")
    triangles.append((rest[0], rest[1], rest[2]))
    return np.array(triangles, dtype=np.int64)


def extrude(outline: Float[np.ndarray, "points 2"], bottom: float, top: float) -> Mesh:
    """An upright prism over a simple polygon (counter-clockwise seen from above), with both ends.

    Raises:
        ValueError: the polygon is none, or `bottom` is not below `top`.

    >>> extrude(np.array([[0.0, 0], [1, 0], [0, 1]]), 0.0, 0.5).faces.shape
    (5, 4)
    """
    if not bottom < top:
        raise ValueError(f"expected bottom < top, received {bottom} and {top}")
    outline = np.asarray(outline, dtype=np.float64)
    count = len(outline)
    ends = np.stack((outline, np.roll(outline, -1, 0)), 1)  # sides, ends, 2
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))))
    vertices = np.empty((count, 4, 3))
    vertices[:, [0, 3], :2] = ends[:, :1]
    vertices[:, [1, 2], :2] = ends[:, 1:]
    vertices[:, :2, 2], vertices[:, 2:, 2] = bottom, top
    uv = np.empty((count, 4, 2))
    uv[:, [0, 3], 0], uv[:, [1, 2], 0] = along[:-1, None], along[1:, None]
    uv[..., 1] = vertices[..., 2]
    sides = Mesh(vertices.reshape(-1, 3), np.arange(4 * count).reshape(-1, 4), uv)
    return merge([sides, polygon(outline, bottom, up=False), polygon(outline, top)])


def panel(corner: Vector, along: Vector, up: Vector, *, unit_uv: bool = False) -> Mesh:
    """One rectangle, from a corner along two edges; its outside is the side of along x up.

    Args:
        corner: The first corner.
        along: The first edge; texture u goes along it.
        up: The second edge; texture v goes along it.
        unit_uv: Texture coordinates from 0 to 1 over the whole (pictures, screens) instead of metres.

    >>> float(panel((0, 0, 0), (2, 0, 0), (0, 0, 1)).uv.max())
    2.0
    """
    o, a, b = (np.asarray(v, dtype=np.float64) for v in (corner, along, up))
    u, v = (1.0, 1.0) if unit_uv else (float(np.linalg.norm(a)), float(np.linalg.norm(b)))
    uv = np.array([[[0.0, 0.0], [u, 0.0], [u, v], [0.0, v]]])
    return Mesh(np.stack((o, o + a, o + a + b, o + b)), np.array([[0, 1, 2, 3]]), uv)


def sheet(points: Float[np.ndarray, "rows columns 3"], *, smooth: bool = True) -> Mesh:
    """A cloth through a grid of points; its outside is the side of (next row) x (next column).

    Texture coordinates are metres along the cloth, u with the rows and v with the columns.

    Raises:
        ValueError: fewer than two rows or columns.

    >>> sheet(np.stack(np.meshgrid([0.0, 1, 2], [0.0, 1], [0.0], indexing="ij"), -1)[:, :, 0]).faces.shape
    (2, 4)
    """
    points = np.asarray(points, dtype=np.float64)
    rows, columns = points.shape[:2]
    if rows < 2 or columns < 2:
        raise ValueError(f"expected two rows and two columns or more, received {rows} and {columns}")
    i, j = (np.arange(rows - 1)[:, None] * columns, np.arange(columns - 1)[None, :])
    faces = np.stack((i + j, i + columns + j, i + columns + j + 1, i + j + 1), -1).reshape(-1, 4)
    u = np.zeros((rows, columns))
    v = np.zeros((rows, columns))
    u[1:] = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=-1).mean(1))[:, None]
    v[:, 1:] = np.cumsum(np.linalg.norm(np.diff(points, axis=1), axis=-1).mean(0))[None, :]
    flat = np.stack((u, v), -1).reshape(-1, 2)
    return Mesh(points.reshape(-1, 3), faces, flat[faces], smooth)


def pillow(width: float, depth: float, height: float, *, steps: int = 10) -> Mesh:
    """A stuffed cushion that lies flat with its underside's lowest point at z = 0: two sheets with a seam.

    >>> float(pillow(0.5, 0.5, 0.15).vertices[:, 2].max().round(6))
    0.15
    """
    t = np.linspace(-1, 1, steps + 1)
    t = np.sign(t) * (1 - (1 - np.abs(t)) ** 1.5)  # denser at the seam, where it is round
    x, y = np.meshgrid(t, t, indexing="ij")
    fill = np.clip((1 - x**2) * (1 - y**2), 0, None) ** 0.45
    waist = 1 - 0.08 * (1 - np.abs(x) ** 2) * np.abs(y) ** 8  # the seams draw in between the corners
    waist_x = 1 - 0.08 * (1 - np.abs(y) ** 2) * np.abs(x) ** 8
    points = np.stack((x * waist_x * width / 2, y * waist * depth / 2, height / 2 * (1 + fill)), -1)
    below = points.copy()
    below[..., 2] = height / 2 * (1 - fill)
    return replace(weld(merge([sheet(points), sheet(below.transpose(1, 0, 2))])), smooth=True)


def corner_uv(
    flat: Float[np.ndarray, "vertices 2"], faces: Int[np.ndarray, "faces 4"]
) -> Float[np.ndarray, "faces 4 2"]:
    """Texture coordinates of the faces' corners from those of the vertices (0 for a triangle's fourth)."""
    return np.where((faces < 0)[..., None], 0.0, flat[np.maximum(faces, 0)])
