"""The primitive bodies: closed, outside outwards, the right volume, textures in metres."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Mesh

BALL = np.linspace(0, 2 * math.pi, 33)[:-1]
L_SHAPE = np.array([[0.0, 0], [2, 0], [2, 1], [1, 1], [1, 3], [0, 3]])


def triangles(mesh: Mesh) -> np.ndarray:
    """Corners [T, 3, 3]: every quad is two triangles."""
    quads = mesh.faces[mesh.faces[:, 3] >= 0]
    index = np.concatenate((mesh.faces[:, :3], quads[:, [0, 2, 3]]))
    return mesh.vertices[index]


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive where the outside is outwards."""
    a, b, c = triangles(mesh).transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def area(mesh: Mesh) -> float:
    a, b, c = triangles(mesh).transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def edges_match(mesh: Mesh) -> bool:
    """Closed and oriented: every directed edge has its opposite exactly once."""
    mesh = shapes.weld(mesh)
    edges: dict[tuple[int, int], int] = {}
    for face in mesh.faces.tolist():
        ring = [i for i in face if i >= 0]
        for i, j in zip(ring, ring[1:] + ring[:1], strict=True):
            edges[i, j] = edges.get((i, j), 0) + 1
    return all(count == 1 and edges.get((j, i)) == 1 for (i, j), count in edges.items())


CLOSED = {
    "box": (shapes.box((0, 1, 2), (1, 3, 5)), 6.0),
    "cylinder": (shapes.cylinder(0.5, 2.0, segments=256), math.pi / 2),
    "cone": (shapes.cone(0.5, 0.0, 3.0, segments=256), math.pi / 4),
    "frustum": (shapes.cone(0.0, 0.5, 3.0, segments=256), math.pi / 4),
    "sphere": (shapes.sphere(0.5, segments=128, rings=64), math.pi / 6),
    "torus": (shapes.torus(1.0, 0.25, segments=256, sides=64), 2 * math.pi**2 * 0.25**2),
    "extrude": (shapes.extrude(L_SHAPE, 0.5, 1.5), 4.0),
    "rounded_box": (shapes.rounded_box((0, 0, 0), (1, 1, 1), 0.0001), 1.0),
    "ball": (shapes.rounded_box((-1, -1, -1), (1, 1, 1), 1.0, steps=12), 4 / 3 * math.pi),
    "puffed": (shapes.rounded_box((0, 0, 0), (1, 1, 0.3), 0.1, puff=0.05, middle=6), None),
    "tube": (shapes.tube(np.array([[0.0, 0, 0], [0, 0, 1], [0, 0, 2]]), 0.1, segments=128), 0.02 * math.pi),
    "bent tube": (shapes.tube(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), 0.1), None),
    "ring": (
        shapes.tube(np.stack((np.cos(BALL), np.sin(BALL), 0 * BALL), -1), 0.1, closed=True),
        None,
    ),
    "pillow": (shapes.pillow(0.5, 0.4, 0.2), None),
    "lathe": (shapes.lathe(np.array([[0.3, 0], [0.5, 0.2], [0.2, 0.7], [0.0, 0.8]])), None),
    "turned": (
        shapes.transform(shapes.box((0, 0, 0), (1, 2, 3)), shapes.placement((1, 2, 3), 0.7, (2, 1, 1))),
        12.0,
    ),
    "mirrored": (
        shapes.transform(shapes.cylinder(0.5, 2.0, segments=256), np.diag([-1.0, 1, 1, 1])),
        math.pi / 2,
    ),
}


@pytest.mark.parametrize("name", CLOSED)
def test_bodies_are_closed_with_their_outside_outwards(name: str) -> None:
    mesh, expected = CLOSED[name]
    assert edges_match(mesh)
    assert volume(mesh) > 0
    if expected is not None:
        assert volume(mesh) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("name", CLOSED)
def test_faces_and_textures_fit_the_contract(name: str) -> None:
    mesh = CLOSED[name][0]
    assert mesh.uv is not None
    assert mesh.uv.shape == (len(mesh.faces), 4, 2)
    assert mesh.faces[:, :3].min() == 0
    assert mesh.faces.max() == len(mesh.vertices) - 1
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.uv).all()


@pytest.mark.parametrize("name", ["box", "cylinder", "extrude", "rounded_box"])
def test_textures_are_in_metres(name: str) -> None:
    """The area in texture coordinates is the area in space, wherever the body unrolls without stretching."""
    mesh = CLOSED[name][0]
    assert mesh.uv is not None
    quads = mesh.faces[:, 3] >= 0
    corners = [mesh.uv[:, :3], mesh.uv[quads][:, [0, 2, 3]]]
    flat = 0.0
    for uv in corners:
        a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        flat += float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)
    assert flat == pytest.approx(area(mesh), rel=1e-3)


def test_sharp_edges_share_no_corners() -> None:
    """Otherwise a body that is shaded smoothly would lose its rims."""
    assert len(shapes.box((0, 0, 0), (1, 1, 1)).vertices) == 24
    cylinder = shapes.cylinder(1.0, 1.0, segments=8)
    lid = set(cylinder.faces[cylinder.faces[:, 3] < 0][:, :3].ravel().tolist())
    side = set(cylinder.faces[cylinder.faces[:, 3] >= 0].ravel().tolist())
    assert not lid & side


def test_a_concave_polygon_keeps_its_area() -> None:
    mesh = shapes.polygon(L_SHAPE, 1.5)
    assert area(mesh) == pytest.approx(4.0)
    assert volume(mesh) == pytest.approx(4.0 * 1.5 / 3)
    assert volume(shapes.polygon(L_SHAPE, 1.5, up=False)) == pytest.approx(-4.0 * 1.5 / 3)


@given(st.lists(st.floats(0.2, 2.0), min_size=4, max_size=24))
def test_stars_keep_their_area(radii: list[float]) -> None:
    angles = np.arange(len(radii)) * (2 * math.pi / len(radii))
    r = np.array(radii)
    outline = np.stack((r * np.cos(angles), r * np.sin(angles)), -1)
    shoelace = float((r * np.roll(r, -1)).sum() * math.sin(2 * math.pi / len(radii)) / 2)
    assert area(shapes.polygon(outline)) == pytest.approx(shoelace)


def test_a_polygon_with_a_corner_on_a_straight_edge() -> None:
    outline = np.array([[0.0, 0], [1, 0], [2, 0], [2, 2], [0, 2], [0, 1]])
    assert area(shapes.polygon(outline)) == pytest.approx(4.0)


@given(st.floats(0.1, 3), st.floats(0.1, 3), st.floats(0.1, 3), st.floats(0, 2))
def test_a_rounded_box_stays_in_its_box(x: float, y: float, z: float, radius: float) -> None:
    mesh = shapes.rounded_box((0, 0, 0), (x, y, z), radius)
    assert mesh.vertices.min(0) == pytest.approx([0, 0, 0], abs=1e-9)
    assert mesh.vertices.max(0) == pytest.approx([x, y, z])
    assert volume(mesh) <= x * y * z * (1 + 1e-9)


def test_merging_keeps_every_part() -> None:
    a, b = shapes.box((0, 0, 0), (1, 1, 1)), shapes.cylinder(0.5, 1.0, base=(3, 0, 0))
    whole = shapes.merge([a, b])
    assert volume(whole) == pytest.approx(volume(a) + volume(b))
    assert whole.smooth
    assert whole.uv is not None


def test_a_panel_looks_to_the_side_of_along_x_up() -> None:
    mesh = shapes.panel((0, 0, 0), (2, 0, 0), (0, 0, 1), unit_uv=True)
    a, b, c = mesh.vertices[mesh.faces[0, :3]]
    assert np.cross(b - a, c - a) == pytest.approx([0, -2, 0])
    assert mesh.uv is not None
    assert mesh.uv.max() == 1.0


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: shapes.box((0, 0, 0), (1, 0, 1)),
        lambda: shapes.rounded_box((0, 0, 0), (1, 1, 1), -0.1),
        lambda: shapes.polygon(L_SHAPE[::-1]),
        lambda: shapes.polygon(np.array([[0.0, 0], [1, 1], [1, 0], [0, 1]])),
        lambda: shapes.extrude(L_SHAPE, 1.0, 1.0),
        lambda: shapes.tube(np.zeros((2, 3)), 0.1),
        lambda: shapes.merge([]),
        lambda: shapes.lathe(np.array([[-0.1, 0.0], [0.1, 1.0]])),
        lambda: shapes.cone(0.1, 0.1, 0.0),
        lambda: shapes.sheet(np.zeros((1, 4, 3))),
        lambda: shapes.loft(np.zeros((1, 4, 3))),
    ],
)
def test_what_is_no_body_is_refused(wrong: object) -> None:
    assert callable(wrong)
    with pytest.raises(ValueError, match="expected"):
        wrong()
