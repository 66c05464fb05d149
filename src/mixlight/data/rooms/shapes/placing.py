"""Meshes moved, copied, merged and welded."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms.mesh import Mesh, Part

__all__ = ["Vector", "instances", "merge", "move", "placement", "rotation", "transform", "weld"]

Vector = Sequence[float]


def placement(
    position: Vector = (0.0, 0.0, 0.0), turn: float = 0.0, scale: Vector = (1.0, 1.0, 1.0)
) -> Float[np.ndarray, "4 4"]:
    """The matrix that scales, then turns about +Z (radians, counter-clockwise from above), then moves.

    >>> (placement((1, 0, 0), math.pi / 2) @ [2, 0, 0, 1]).round(6)
    array([1., 2., 0., 1.])
    """
    cosine, sine = math.cos(turn), math.sin(turn)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]) * np.asarray(
        scale
    )
    matrix[:3, 3] = position
    return matrix


def rotation(axis: Literal["x", "y", "z"], angle: float) -> Float[np.ndarray, "4 4"]:
    """The matrix that turns about an axis, counter-clockwise seen from its tip, in radians.

    >>> (rotation("x", math.pi / 2) @ [0, 1, 0, 1]).round(6)
    array([0., 0., 1., 1.])
    """
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    matrix = np.eye(4)
    matrix[i, i] = matrix[j, j] = math.cos(angle)
    matrix[j, i] = math.sin(angle)
    matrix[i, j] = -matrix[j, i]
    return matrix


def transform(mesh: Mesh, matrix: Float[np.ndarray, "4 4"]) -> Mesh:
    """The mesh with its corners moved by an affine matrix; a mirror keeps the outside outside.

    Texture coordinates stay as they are.

    >>> from mixlight.data.rooms.shapes import box
    >>> float(transform(box((0, 0, 0), (1, 1, 1)), placement((5, 0, 0))).vertices[:, 0].min())
    5.0
    """
    vertices = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    faces, uv = mesh.faces, mesh.uv
    if np.linalg.det(matrix[:3, :3]) < 0:
        triangles = faces[:, 3] < 0
        order = np.where(triangles[:, None], [2, 1, 0, 3], [3, 2, 1, 0])
        faces = np.take_along_axis(faces, order, 1)
        uv = None if uv is None else np.take_along_axis(uv, order[..., None], 1)
    return Mesh(vertices, faces, uv, mesh.smooth)


def move(part: Part, matrix: Float[np.ndarray, "4 4"]) -> Part:
    """The part with its mesh moved by an affine matrix."""
    return replace(part, mesh=transform(part.mesh, matrix))


def merge(meshes: Iterable[Mesh]) -> Mesh:
    """All meshes as one; it is smooth if any of them is, and has no texture coordinates if one has none.

    Raises:
        ValueError: no mesh.

    >>> from mixlight.data.rooms.shapes import box
    >>> merge([box((0, 0, 0), (1, 1, 1)), box((2, 0, 0), (3, 1, 1))]).faces.shape
    (12, 4)
    """
    meshes = list(meshes)
    if not meshes:
        raise ValueError("expected at least one mesh, received none")
    if len(meshes) == 1:
        return meshes[0]
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [
        np.where(m.faces < 0, m.faces, m.faces + offset) for m, offset in zip(meshes, offsets, strict=True)
    ]
    uv = [mesh.uv for mesh in meshes if mesh.uv is not None]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(faces),
        np.concatenate(uv) if len(uv) == len(meshes) else None,
        any(mesh.smooth for mesh in meshes),
    )


def instances(mesh: Mesh, matrices: Float[np.ndarray, "copies 4 4"]) -> Mesh:
    """Many copies of a mesh, each moved by its own affine matrix (no mirrors), as one mesh.

    >>> from mixlight.data.rooms.shapes import box
    >>> instances(box((0, 0, 0), (1, 1, 1)), np.stack([np.eye(4)] * 3)).faces.shape
    (18, 4)
    """
    count, corners = len(matrices), len(mesh.vertices)
    vertices = np.einsum("nij,vj->nvi", matrices[:, :3, :3], mesh.vertices) + matrices[:, None, :3, 3]
    faces = np.broadcast_to(mesh.faces, (count, *mesh.faces.shape))
    faces = np.where(faces < 0, faces, faces + (np.arange(count) * corners)[:, None, None])
    uv = None if mesh.uv is None else np.tile(mesh.uv, (count, 1, 1))
    return Mesh(vertices.reshape(-1, 3), faces.reshape(-1, 4), uv, mesh.smooth)


def weld(mesh: Mesh, tolerance: float = 1e-5) -> Mesh:
    """The mesh with corners at one place made one, and faces that thereby lose their area taken out.

    >>> from mixlight.data.rooms.shapes import box
    >>> len(weld(box((0, 0, 0), (1, 1, 1))).vertices)
    8
    """
    keys = np.round((mesh.vertices - mesh.vertices.min(0)) / tolerance).astype(np.int64)
    spans = keys.max(0) + 1
    if float(spans[0]) * float(spans[1]) * float(spans[2]) >= 2.0**63:
        raise ValueError(f"expected a coarser tolerance for a mesh of this size, received {tolerance}")
    keys = (keys[:, 0] * spans[1] + keys[:, 1]) * spans[2] + keys[:, 2]  # one number sorts faster than three
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    faces = np.where(mesh.faces < 0, -1, inverse.reshape(-1)[mesh.faces])
    uv = np.zeros((*faces.shape, 2)) if mesh.uv is None else mesh.uv.copy()
    for i in range(4):  # a quad that has lost one edge is a triangle: its last corner moves to the gap
        j = (i + 1) % 4
        gap = (faces[:, 3] >= 0) & (faces[:, i] == faces[:, j])
        if not gap.any():
            continue
        keep = [k for k in range(4) if k != j]
        faces[gap] = np.concatenate((faces[gap][:, keep], np.full((gap.sum(), 1), -1)), 1)
        uv[gap] = np.concatenate((uv[gap][:, keep], np.zeros((gap.sum(), 1, 2))), 1)
    a, b, c = faces[:, 0], faces[:, 1], faces[:, 2]
    good = (a != b) & (b != c) & (c != a)
    return Mesh(mesh.vertices[first], faces[good], None if mesh.uv is None else uv[good], mesh.smooth)
