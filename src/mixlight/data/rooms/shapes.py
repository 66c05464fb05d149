"""Meshes of simple bodies, from which walls, furniture and lamps are put together.

Convention: metres, +Z up; faces run counter-clockwise seen from outside, quads carry four corners and
triangles end in -1. Texture coordinates are metres along the surface, so a pattern keeps its size on every
body. **Corners are shared only across edges that are meant to look round** (a box has 24 corners, the rim of
a cylinder is there twice), so `smooth` may be set on any mesh, and meshes of both kinds may be merged.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from mixlight.data.rooms.mesh import Mesh, Part

__all__ = [
    "bars",
    "box",
    "boxes",
    "cone",
    "cylinder",
    "extrude",
    "instances",
    "lathe",
    "loft",
    "merge",
    "move",
    "panel",
    "pillow",
    "placement",
    "polygon",
    "rotation",
    "rounded_box",
    "sheet",
    "sphere",
    "torus",
    "transform",
    "tube",
    "weld",
]

Vector = Sequence[float]

_BOX_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6], [1, 2, 6, 5], [3, 0, 4, 7]])
"""Corners of a box's faces (-z, +z, -y, +y, +x, -x); corner i has bits of x and y in circular order."""

_BOX_AXES = np.array([[0, 1], [0, 1], [0, 2], [0, 2], [1, 2], [1, 2]])
"""The two axes that are a face's texture coordinates."""

_BOX_CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


# --- putting together ---------------------------------------------------------------------------------------


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
    """The matrix that turns about an axis through the origin, counter-clockwise seen from its tip, in radians.

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


# --- boxes --------------------------------------------------------------------------------------------------


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


# --- round bodies -------------------------------------------------------------------------------------------


def loft(
    rings: Float[np.ndarray, "rings points 3"],
    *,
    closed: bool = True,
    caps: bool = False,
    smooth: bool = True,
) -> Mesh:
    """The skin between curves of equally many points.

    Args:
        rings: [R, N, 3] the curves one after the other; the outside is on the right hand of someone who walks
            along a ring with the next ring above: rings that go up are counter-clockwise seen from above.
        closed: Each ring's last point is joined to its first.
        caps: The first and the last ring are filled (they must be convex).
        smooth: Shaded as a round body.

    Raises:
        ValueError: fewer than two rings, or caps on open rings.

    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> loft(np.stack((square, square + [0, 0, 2]))).faces.shape
    (4, 4)
    """
    rings = np.asarray(rings, dtype=np.float64)
    count, points = rings.shape[:2]
    if count < 2 or (caps and not closed):
        raise ValueError(f"expected two rings or more, closed if capped, received {count}, closed = {closed}")
    around = np.arange(points if closed else points - 1)
    following = (around + 1) % points
    base = np.arange(count - 1)[:, None] * points
    faces = np.stack(
        (base + around, base + following, base + points + following, base + points + around), -1
    ).reshape(-1, 4)
    edges = np.linalg.norm(np.diff(np.concatenate((rings, rings[:, :1]), 1), axis=1), axis=-1)
    along = np.concatenate(([0.0], np.cumsum(edges[int(np.argmax(edges.sum(1)))])))
    rise = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(rings, axis=0), axis=-1).mean(1))))
    u = np.broadcast_to(
        np.stack((along[around], along[around + 1], along[around + 1], along[around]), -1),
        (count - 1, len(around), 4),
    )
    v = np.broadcast_to(np.stack((rise[:-1], rise[:-1], rise[1:], rise[1:]), -1)[:, None], u.shape)
    skin = Mesh(rings.reshape(-1, 3), faces, np.stack((u, v), -1).reshape(-1, 4, 2), smooth)
    if not caps:
        return skin
    lids = [_lid(rings[0][::-1]), _lid(rings[-1])]
    return replace(merge([skin, *lids]), smooth=smooth)


def _lid(ring: Float[np.ndarray, "points 3"]) -> Mesh:
    """A convex ring filled with a fan around its middle."""
    count = len(ring)
    vertices = np.concatenate((ring.mean(0, keepdims=True), ring))
    i = np.arange(count)
    faces = np.stack((np.zeros(count, dtype=np.int64), 1 + i, 1 + (i + 1) % count, np.full(count, -1)), -1)
    axis = int(np.argmin(np.ptp(ring, axis=0)))
    flat = np.delete(vertices, axis, 1)
    return Mesh(vertices, faces, _corners(flat, faces))


def lathe(
    profile: Float[np.ndarray, "points 2"], *, segments: int = 24, caps: bool = True, crease: float = 0.6
) -> Mesh:
    """A body of revolution about +Z.

    Args:
        profile: [P, 2] radius and height, from below to above on the outside (a bowl goes on inside, down).
        segments: Faces around.
        caps: Ends whose radius is not 0 are filled.
        crease: Radians; where the profile turns by more than that, the edge is sharp.

    Raises:
        ValueError: fewer than two points, or a negative radius.

    >>> float(lathe(np.array([[0.1, 0.0], [0.1, 0.5]]), segments=8).vertices.max())
    0.5
    """
    profile = np.asarray(profile, dtype=np.float64)
    if len(profile) < 2 or (profile[:, 0] < 0).any():
        raise ValueError(f"expected two points or more with radii >= 0, received {profile.tolist()}")
    angles = np.arange(segments) * (2 * math.pi / segments)
    circle = np.stack((np.cos(angles), np.sin(angles)), -1)
    rings = np.empty((len(profile), segments, 3))
    rings[..., :2] = profile[:, None, :1] * circle
    rings[..., 2] = profile[:, None, 1]
    steps = np.diff(profile, axis=0)
    heading = np.arctan2(steps[:, 1], steps[:, 0])
    bend = np.abs((np.diff(heading) + math.pi) % (2 * math.pi) - math.pi)
    cuts = [0, *(np.nonzero(bend > crease)[0] + 1).tolist(), len(profile) - 1]
    bands = [loft(rings[start : end + 1]) for start, end in itertools.pairwise(cuts)]
    if caps and profile[0, 0] > 0:
        bands.append(_lid(rings[0][::-1]))
    if caps and profile[-1, 0] > 0:
        bands.append(_lid(rings[-1]))
    whole = merge(bands)
    if (profile[:, 0] == 0).any():  # at a pole the quads are triangles
        whole = _without_poles(whole)
    return replace(whole, smooth=True)


def _without_poles(mesh: Mesh) -> Mesh:
    """Quads with two corners at one place become triangles; no corner is shared that was not before."""
    faces, uv = mesh.faces.copy(), None if mesh.uv is None else mesh.uv.copy()
    quads = faces[:, 3] >= 0
    place = mesh.vertices[faces]
    for i in range(4):
        j = (i + 1) % 4
        gap = quads & (np.abs(place[:, i] - place[:, j]).max(-1) < 1e-12)
        keep = [k for k in range(4) if k != j]
        faces[gap] = np.concatenate((mesh.faces[gap][:, keep], np.full((int(gap.sum()), 1), -1)), 1)
        if uv is not None and mesh.uv is not None:
            uv[gap] = np.concatenate((mesh.uv[gap][:, keep], np.zeros((int(gap.sum()), 1, 2))), 1)
        quads = quads & ~gap
    return replace(mesh, faces=faces, uv=uv)


def cone(
    bottom: float,
    top: float,
    height: float,
    *,
    base: Vector = (0.0, 0.0, 0.0),
    segments: int = 24,
    caps: bool = True,
) -> Mesh:
    """A frustum that stands on `base`: radius `bottom` below and `top` above (0 makes a point).

    Raises:
        ValueError: a negative radius or no height.

    >>> float(cone(0.2, 0.0, 1.0).vertices[:, 2].max())
    1.0
    """
    if bottom < 0 or top < 0 or height <= 0:
        raise ValueError(f"expected radii >= 0 and a height > 0, received {bottom}, {top} and {height}")
    mesh = lathe(np.array([[bottom, 0.0], [top, height]]), segments=segments, caps=caps)
    return replace(mesh, vertices=mesh.vertices + np.asarray(base, dtype=np.float64))


def cylinder(
    radius: float, height: float, *, base: Vector = (0.0, 0.0, 0.0), segments: int = 24, caps: bool = True
) -> Mesh:
    """An upright cylinder that stands on `base`.

    Raises:
        ValueError: a negative radius or no height.

    >>> float(cylinder(0.5, 2.0, base=(0, 0, 1)).vertices[:, 2].max())
    3.0
    """
    return cone(radius, radius, height, base=base, segments=segments, caps=caps)


def sphere(radius: float, *, centre: Vector = (0.0, 0.0, 0.0), segments: int = 24, rings: int = 12) -> Mesh:
    """A sphere.

    >>> float(sphere(0.5, centre=(0, 0, 1)).vertices[:, 2].max())
    1.5
    """
    angles = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    profile = np.stack((radius * np.cos(angles), radius * np.sin(angles)), -1)
    profile[[0, -1], 0] = 0.0
    mesh = lathe(profile, segments=segments, crease=math.pi)
    return replace(mesh, vertices=mesh.vertices + np.asarray(centre, dtype=np.float64))


def torus(
    radius: float, thickness: float, *, centre: Vector = (0.0, 0.0, 0.0), segments: int = 24, sides: int = 10
) -> Mesh:
    """A ring that lies flat: `radius` to the middle of its tube, whose own radius is `thickness`.

    >>> float(torus(0.4, 0.1).vertices.max().round(6))
    0.5
    """
    angles = np.linspace(0.0, 2 * math.pi, sides + 1)  # counter-clockwise: up on the outer side
    profile = np.stack((radius + thickness * np.cos(angles), thickness * np.sin(angles)), -1)
    mesh = lathe(profile, segments=segments, caps=False, crease=math.pi)
    return weld(replace(mesh, vertices=mesh.vertices + np.asarray(centre, dtype=np.float64)))


def tube(
    path: Float[np.ndarray, "points 3"],
    radius: float,
    *,
    segments: int = 8,
    closed: bool = False,
    caps: bool = True,
) -> Mesh:
    """A round bar along a path: legs, handles, cables, stems.

    Args:
        path: [P, 3] its middle line, P >= 2, no two neighbours at one place.
        radius: Of the bar in metres.
        segments: Faces around.
        closed: The last point is joined to the first.
        caps: Open ends are filled.

    Raises:
        ValueError: fewer than two points, or two neighbours at one place.

    >>> float(tube(np.array([[0.0, 0, 0], [0, 0, 1]]), 0.01).vertices[:, 2].max())
    1.0
    """
    path = np.asarray(path, dtype=np.float64)
    line = np.concatenate((path, path[:1])) if closed else path
    steps = np.diff(line, axis=0)
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    if len(path) < 2 or (lengths == 0).any():
        raise ValueError(f"expected two different points or more, received {path.tolist()}")
    steps = steps / lengths
    if closed:
        tangents = steps + np.roll(steps, 1, 0)
    else:
        tangents = np.concatenate((steps[:1], steps[1:] + steps[:-1], steps[-1:]))
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-12)
    side = np.cross(tangents[0], [0.0, 0.0, 1.0] if abs(tangents[0, 2]) < 0.9 else [1.0, 0.0, 0.0])
    angles = np.arange(segments) * (2 * math.pi / segments)
    rings = np.empty((len(path), segments, 3))
    for i, tangent in enumerate(tangents):  # the frame is carried along, so the bar does not twist
        side = side - (side @ tangent) * tangent
        side /= np.linalg.norm(side)
        other = np.cross(tangent, side)
        rings[i] = path[i] + radius * (np.cos(angles)[:, None] * side + np.sin(angles)[:, None] * other)
    if not closed:
        return loft(rings, caps=caps)
    return weld(loft(np.concatenate((rings, rings[:1]))))


def bars(
    starts: Float[np.ndarray, "bars 3"],
    ends: Float[np.ndarray, "bars 3"],
    radius: float,
    *,
    segments: int = 8,
) -> Mesh:
    """Straight round bars with flat ends, all as one mesh: legs, rails, spokes.

    Raises:
        ValueError: a bar without length.

    >>> bars(np.zeros((5, 3)), np.eye(5, 3) + [0, 0, 1], 0.01, segments=6).faces.shape
    (90, 4)
    """
    starts, ends = np.asarray(starts, dtype=np.float64), np.asarray(ends, dtype=np.float64)
    along = ends - starts
    lengths = np.linalg.norm(along, axis=1)
    if (lengths == 0).any():
        raise ValueError(f"expected bars with a length, received one from {starts[lengths == 0][0].tolist()}")
    axis = along / lengths[:, None]
    helper = np.where(np.abs(axis[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    side = np.cross(helper, axis)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    matrices = np.zeros((len(starts), 4, 4))
    matrices[:, :3, 0] = side * radius
    matrices[:, :3, 1] = np.cross(axis, side) * radius
    matrices[:, :3, 2] = along
    matrices[:, :3, 3] = starts
    matrices[:, 3, 3] = 1.0
    unit = _unit_cylinder(segments)
    mesh = instances(unit, matrices)
    if mesh.uv is not None:  # metres: around and along
        scale = np.repeat(np.stack((np.full(len(lengths), radius), lengths), -1), len(unit.faces), 0)
        mesh = replace(mesh, uv=mesh.uv * scale[:, None, :])
    return mesh


@lru_cache(maxsize=16)
def _unit_cylinder(segments: int) -> Mesh:
    return cylinder(1.0, 1.0, segments=segments)


# --- flat things and cloth ----------------------------------------------------------------------------------


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
    return Mesh(vertices, faces, _corners(outline, faces))


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


def _corners(
    flat: Float[np.ndarray, "vertices 2"], faces: Int[np.ndarray, "faces 4"]
) -> Float[np.ndarray, "faces 4 2"]:
    """Texture coordinates of the faces' corners from those of the vertices (0 for a triangle's fourth)."""
    return np.where((faces < 0)[..., None], 0.0, flat[np.maximum(faces, 0)])
