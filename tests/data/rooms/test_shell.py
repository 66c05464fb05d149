"""Walls, windows and doors as meshes: closed skins, sane faces, everything inside the wall or before it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from mixlight.data.rooms import dressings, shell, windows
from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.layout import draw_building
from mixlight.data.rooms.make_plan import stream
from mixlight.data.rooms.mesh import Mesh, Part
from mixlight.data.rooms.outline import cells, edges
from mixlight.data.rooms.plan import Opening, Plan, Sky, Surface
from mixlight.data.rooms.plan_json import plain, surface_document

SEEDS = range(30)


def building_plan(seed: int, kind: str | None = None) -> Plan:
    building = draw_building(stream(seed, "layout"), kind)
    sky = Sky("day", None, 0.0, 10_000.0, (1.0, 1.0, 1.0), None)
    return plain(Plan(seed, tuple(building.spaces), tuple(building.openings), (), (), sky, ()))


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    return [building_plan(seed) for seed in SEEDS]


def solid_angle(mesh: Mesh, point: np.ndarray) -> float:
    """Signed solid angle of all faces from a point, positive for faces that look away from it.

    Van Oosterom and Strackee 1983: tan(omega/2) = a.(b x c) / (abc + (a.b)c + (b.c)a + (c.a)b).
    """
    faces = mesh.faces
    quads = faces[faces[:, 3] >= 0]
    triangles = np.concatenate((faces[faces[:, 3] < 0][:, :3], quads[:, :3], quads[:, [0, 2, 3]]))
    a, b, c = (mesh.vertices[triangles[:, i]] - point for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    top = (a * np.cross(b, c)).sum(1)
    bottom = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(2 * np.arctan2(top, bottom).sum())


def skin_with_caps(plan: Plan) -> list[Part]:
    """The inner skin, its windows closed at their outer ends."""
    builder = Builder("skin")
    shell.add_skin(builder, plan)
    for opening in plan.openings:
        if opening.kind == "window" and opening.leads is None:
            edge = edges(plan.spaces[opening.space].outline)[opening.edge]
            span, heights = (opening.start, opening.end), (opening.bottom, opening.top)
            builder.wall_quad(Surface("paint"), edge, span, -opening.depth, heights)
    return builder.parts()


def test_inner_skin_is_closed(plans):
    """From inside, a closed surface that looks inwards covers the sphere once: -4 pi."""
    for plan in plans:
        parts = skin_with_caps(plan)
        for space in plan.spaces:
            x0, y0, x1, y1 = cells(space.outline)[0]
            point = np.array([x0 + 0.41 * (x1 - x0), y0 + 0.37 * (y1 - y0), 0.53 * space.height])
            total = sum(solid_angle(part.mesh, point) for part in parts)
            assert total == pytest.approx(-4 * math.pi, abs=1e-6)
        outside = np.array([-30.0, -20.0, 1.0])
        assert sum(solid_angle(part.mesh, outside) for part in parts) == pytest.approx(0, abs=1e-6)


def test_facade_is_closed_and_its_holes_are_the_windows(plans):
    for plan in plans:
        builder = Builder("facade")
        shell.add_facade(builder, plan)
        thickness = max(
            (o.depth for o in plan.openings if o.kind == "window" and o.leads is None), default=0.3
        )
        for opening in plan.openings:
            if opening.kind == "window" and opening.leads is None:
                edge = edges(plan.spaces[opening.space].outline)[opening.edge]
                span, heights = (opening.start, opening.end), (opening.bottom, opening.top)
                builder.wall_quad(Surface("paint"), edge, span, -thickness, heights, outside=True)
        parts = builder.parts()
        bottom = min(float(part.mesh.vertices[:, 2].min()) for part in parts)
        x0, y0, x1, y1 = cells(plan.spaces[0].outline)[0]
        point = np.array([x0 + 0.41 * (x1 - x0), y0 + 0.37 * (y1 - y0), 1.3])
        seen = sum(solid_angle(part.mesh, point) for part in parts)
        # Open below: what is missing is the ground's solid angle, which the roof's faces lowered to it have.
        roof = next(part for part in parts if part.material.kind == "concrete")
        floor = dataclasses.replace(
            roof.mesh,
            vertices=np.column_stack((roof.mesh.vertices[:, :2], np.full(len(roof.mesh.vertices), bottom))),
        )
        assert seen - solid_angle(floor, point) == pytest.approx(4 * math.pi, abs=1e-6)


def test_parts_are_sane(plans):
    for plan in plans:
        count = 0
        for part in [*shell.parts(plan), *windows.parts(plan), *dressings.parts(plan)]:
            mesh = part.mesh
            count += len(mesh.faces)
            assert np.isfinite(mesh.vertices).all()
            assert mesh.faces[:, :3].min() >= 0
            assert mesh.faces.max() < len(mesh.vertices)
            assert mesh.uv is not None
            assert mesh.uv.shape == (len(mesh.faces), 4, 2)
            corners = mesh.vertices[mesh.faces[:, :3]]
            areas = np.linalg.norm(
                np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
            )
            assert (areas > 1e-9).mean() > 0.99
        assert 50 < count < 200_000


def one_window(**details: object) -> Plan:
    plan = building_plan(0)
    space = plan.spaces[0]
    outline = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    space = dataclasses.replace(space, outline=outline, walls=space.walls[:1] * 4, height=2.5, details={})
    frame = surface_document(Surface("wood", (0.2, 0.1, 0.05)))
    values = {"frame": frame, "metal": frame, "fabric": frame, "mullions": [2, 2], "inset": 0.5, **details}
    opening = Opening("window", 0, 2, 1.0, 3.0, 0.9, 2.1, None, 0.3, values)
    return dataclasses.replace(plan, spaces=(space,), openings=(opening,))


def test_a_window_lies_in_its_hole():
    parts = windows.parts(one_window(style="casement", sill=False))
    corners = np.concatenate([part.mesh.vertices for part in parts])
    # The wall at y = 3 runs from (4, 3) to (0, 3): 1 to 3 m along it is x from 3 to 1.
    assert corners[:, 0].min() == pytest.approx(1.0)
    assert corners[:, 0].max() == pytest.approx(3.0)
    assert corners[:, 1].min() > 3.0
    assert corners[:, 1].max() < 3.3
    assert corners[:, 2].min() == pytest.approx(0.9)
    assert corners[:, 2].max() == pytest.approx(2.1)


def test_panes_fill_most_of_a_window():
    parts = windows.parts(one_window(style="picture"))
    glass = [part.mesh for part in parts if part.material.kind == "glass"]
    a, b, _, d = (np.concatenate([mesh.vertices[mesh.faces[:, i]] for mesh in glass]) for i in range(4))
    area = np.linalg.norm(np.cross(b - a, d - a), axis=1).sum()
    assert 0.8 < area / (2.0 * 1.2) < 0.95


@pytest.mark.parametrize("dressing", ["curtain", "sheer", "venetian", "roller", "roman", "vertical"])
def test_a_drawn_dressing_covers_the_window(dressing):
    """Straight rays through a grid of points of the window meet cloth or slats nearly everywhere."""
    for drawn, low, high in ((1.0, 0.85, 1.0), (0.3, 0.1, 0.75)):
        plan = one_window(dressing=dressing, drawn=drawn, tilt=1.2 if dressing == "venetian" else 0.2)
        parts = dressings.parts(plan)
        covered = np.zeros((24, 40), dtype=bool)
        x, z = np.meshgrid(np.linspace(1.05, 2.95, 40), np.linspace(0.97, 2.03, 24))
        for part in parts:
            mesh = part.mesh
            assert mesh.vertices[:, 1].max() < 3.3
            assert mesh.vertices[:, 1].min() > 2.75
            faces = mesh.faces
            quads = faces[faces[:, 3] >= 0]
            for t in np.concatenate((faces[faces[:, 3] < 0][:, :3], quads[:, :3], quads[:, [0, 2, 3]])):
                covered |= inside(mesh.vertices[t][:, [0, 2]], x, z)
        assert low <= covered.mean() <= high, dressing


def inside(triangle: np.ndarray, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    (ax, az), (bx, bz), (cx, cz) = triangle
    sides = [
        (bx - ax) * (z - az) - (bz - az) * (x - ax),
        (cx - bx) * (z - bz) - (cz - bz) * (x - bx),
        (ax - cx) * (z - cz) - (az - cz) * (x - cx),
    ]
    return np.logical_or(
        np.logical_and.reduce([s >= 0 for s in sides]), np.logical_and.reduce([s <= 0 for s in sides])
    ) & (abs((bx - ax) * (cz - az) - (bz - az) * (cx - ax)) > 1e-12)
