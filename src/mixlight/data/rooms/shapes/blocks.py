"""Boxes, sharp and soft."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms.mesh import Mesh
from mixlight.data.rooms.shapes.flat import sheet
from mixlight.data.rooms.shapes.placing import Vector, merge, weld

__all__ = ["box", "boxes", "rounded_box"]

_BOX_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [1, 2, 6, 5], [3, 0, 4, 7]])
"""Corners of a box's faces (-z, +z, -y, +y, +x, -x); corner i has bits of x and y in circular order."""

_BOX_AXES = np.array([[0, 1], [0, 1], [0, 2], [0, 2], [1, 2], [1, 2]])
"""The two axes that are a face's texture coordinates."""

_BOX_CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


def boxes(low: Float[np.ndarray, "boxes 3"], high: Float[np.ndarray, "boxes 3"]) -> Mesh:
    """Boxes along the axes, given by their lowest and highest corners, as one mesh.

    Raises:
        ValueError: a box whose lowest corner is not below its highest.

    >>> boxes(np.zeros((3, 3)), np.ones((3, 3))).vertices.shape
    (72, 3)
    """
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    if not (low < high).all():
        wrong = int(np.argmin((low < high).all(1)))
        raise ValueError(f"expected low < high, received {low[wrong].tolist()} and {high[wrong].tolist()}")
    corners = np.where(_BOX_CORNERS[None, :, :] == 0, low[:, None, :], high[:, None, :])
    vertices = corners[:, _BOX_FACES]  # boxes, faces, corners, axes
    uv = np.take_along_axis(vertices, np.broadcast_to(_BOX_AXES[None, :, None, :], (len(low), 6, 4, 2)), -1)
    count = vertices[..., 0].size
    return Mesh(vertices.reshape(-1, 3), np.arange(count).reshape(-1, 4), uv.reshape(-1, 4, 2))


def box(low: Vector, high: Vector) -> Mesh:
    """One box along the axes, from its lowest to its highest corner.

    Texture coordinates are the two coordinates along each face, in metres.

    Raises:
        ValueError: the lowest corner is not below the highest.

    >>> float(box((0, 0, 0), (2, 1, 1)).uv.max())
    2.0
    """
    return boxes(np.asarray([low], dtype=np.float64), np.asarray([high], dtype=np.float64))


def rounded_box(
    low: Vector, high: Vector, radius: float, *, steps: int = 2, puff: float = 0.0, middle: int = 1
) -> Mesh:
    """A box whose edges and corners are round, smooth, for what is soft.

    Args:
        low: Lowest corner.
        high: Highest corner.
        radius: Of the edges in metres; it is taken down to half of the shortest side.
        steps: Faces across half a rounded edge (an eighth of a turn).
        puff: Metres by which the middle of each side stands out, as a stuffed cushion's does, the
            smaller sides less.
        middle: Faces across the flat part of each side; at least 4 if `puff` is to look round.

    Raises:
        ValueError: the lowest corner is not below the highest, or a negative radius.

    >>> float(rounded_box((0, 0, 0), (1, 1, 1), 0.1).vertices.max())
    1.0
    """
    a, b = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    if not (a < b).all() or radius < 0:
        raise ValueError(
            f"expected low < high and radius >= 0, received {a.tolist()}, {b.tolist()}, {radius}"
        )
    size = b - a
    radius = min(radius, 0.4999 * float(size.min()))
    arc = radius * (1 - np.tan(np.linspace(math.pi / 4, 0.0, steps + 1)))
    lines = [
        np.concatenate(
            (a[k] + arc, np.linspace(a[k] + radius, b[k] - radius, middle + 1)[1:-1], b[k] - arc[::-1])
        )
        for k in range(3)
    ]
    sides = []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        flat = np.stack(np.meshgrid(lines[i], lines[j], indexing="ij"), -1)
        bulge = np.ones(flat.shape[:2])
        for k, across in ((i, flat[..., 0]), (j, flat[..., 1])):
            bulge = bulge * np.clip(1 - ((across - (a[k] + b[k]) / 2) / (size[k] / 2)) ** 2, 0, 1)
        share = size[i] * size[j] / max(size[0] * size[1], size[1] * size[2], size[2] * size[0])
        for end in (0, 1):
            points = np.empty((*flat.shape[:2], 3))
            points[..., i], points[..., j] = flat[..., 0], flat[..., 1]
            points[..., axis] = b[axis] if end else a[axis]
            inner = np.clip(points, a + radius, b - radius)
            away = points - inner
            length = np.linalg.norm(away, axis=-1, keepdims=True)
            points = inner + away * (radius / np.maximum(length, 1e-12)) if radius > 0 else points
            points[..., axis] += (1 if end else -1) * puff * share * bulge
            sides.append(sheet(points if end else points.transpose(1, 0, 2)))
    return replace(weld(merge(sides)), smooth=True)
