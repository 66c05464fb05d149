"""Round bodies: skins between curves, bodies of revolution, bars along paths."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from mixlight.data.rooms.mesh import Mesh
from mixlight.data.rooms.shapes.flat import corner_uv
from mixlight.data.rooms.shapes.placing import Vector, instances, merge, weld

__all__ = ["bars", "cone", "cylinder", "lathe", "loft", "sphere", "torus", "tube"]


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
    return Mesh(vertices, faces, corner_uv(flat, faces))


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
