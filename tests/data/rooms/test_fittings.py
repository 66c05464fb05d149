"""What is built into rooms lies in them, and not before windows or in doorways."""

from __future__ import annotations

import dataclasses

import pytest

from mixlight.data.rooms.builder import Builder
from mixlight.data.rooms.building import Building
from mixlight.data.rooms.built_in import add_built_in
from mixlight.data.rooms.fittings import free_runs, strips
from mixlight.data.rooms.layout import draw_building
from mixlight.data.rooms.make_plan import stream
from mixlight.data.rooms.outline import (
    Rectangle,
    contains_rectangle,
    door_sweep,
    edges,
    holes,
    holes_of,
    obstacles,
    overlap,
)
from mixlight.data.rooms.plan import Plan, Sky

SEEDS = range(200)


@pytest.fixture(scope="module")
def buildings() -> list[Building]:
    return [draw_building(stream(seed, "layout")) for seed in SEEDS]


def _boxes(building: Building, space: int) -> list[tuple[Rectangle, float, float]]:
    return [((a, b, c, d), low, high) for a, b, c, d, low, high in obstacles(building.spaces[space])]


def test_every_fitting_occurs(buildings):
    found = {key for b in buildings for space in b.spaces for key in space.details}
    assert found >= {
        "bands", "beams", "columns", "cornice", "ducts", "fireplace", "obstacles", "panels", "plates",
        "rails", "skirting", "soffits",
    }  # fmt: skip
    styles = {s.details["panels"]["style"] for b in buildings for s in b.spaces if "panels" in s.details}
    assert styles == {"frames", "boards", "slats"}


def test_fittings_lie_inside_their_space(buildings):
    for building in buildings:
        for index, space in enumerate(building.spaces):
            for rectangle, low, high in _boxes(building, index):
                assert contains_rectangle(space.outline, rectangle, -0.01), (space.details.keys(), rectangle)
                assert -1e-9 <= low < high <= space.height + 1e-6


def test_nothing_is_built_before_a_window_or_in_a_doorway(buildings):
    """Whatever stands in the room keeps from each opening's way; what hangs, from its top."""
    for building in buildings:
        for index, space in enumerate(building.spaces):
            walls = edges(space.outline)
            for hole in holes_of(building.spaces, building.openings, index):
                before = walls[hole.edge].rectangle(hole.start, hole.end, 0.0, 0.3)
                for rectangle, low, high in _boxes(building, index):
                    crosses = overlap(rectangle, before) and low < hole.top - 0.001 and high > hole.bottom
                    assert not crosses, (space.kind, hole.opening.kind, rectangle, low, hole.top)


def test_switches_and_sockets_are_on_walls(buildings):
    for building in buildings:
        for index, space in enumerate(building.spaces):
            walls = edges(space.outline)
            found = holes_of(building.spaces, building.openings, index)
            for edge, along, z, wide in space.details["plates"]:
                assert 0 < along - wide / 2 < along + wide / 2 < walls[edge].length
                for hole in found:
                    clear = along + wide / 2 < hole.start or along - wide / 2 > hole.end
                    assert hole.edge != edge or clear or z - 0.04 > hole.top or z + 0.04 < hole.bottom


def test_skirting_stops_at_doors():
    building = draw_building(stream(4, "layout"), "bedroom")
    sky = Sky("day", None, 0.0, 1.0, (1.0, 1.0, 1.0), None)
    plan = Plan(4, tuple(building.spaces), tuple(building.openings), (), (), sky, ())
    skirting = dataclasses.replace(building.palette.trim, seed=77)
    details = {"skirting": [0.1, 0.02]}
    spaces = tuple(dataclasses.replace(s, skirting=skirting, details=details) for s in plan.spaces)
    plan = dataclasses.replace(plan, spaces=spaces)
    builder = Builder("x")
    add_built_in(builder, plan)
    (part,) = [p for p in builder.parts() if p.material == skirting]
    boxes = part.mesh.vertices.reshape(-1, 24, 3)
    doors = 0
    for index in range(len(plan.spaces)):
        for hole in holes(plan, index):
            if hole.bottom > 0.1:
                continue
            doors += 1
            way = edges(plan.spaces[index].outline)[hole.edge].rectangle(hole.start, hole.end, 0.0, 0.05)
            assert not any(overlap((*b.min(0)[:2].tolist(), *b.max(0)[:2].tolist()), way) for b in boxes)
    assert doors > 0
    assert float(part.mesh.vertices[:, 2].max()) == pytest.approx(0.1)


def test_free_runs_around_a_window():
    building = next(b for b in (draw_building(stream(s, "layout")) for s in range(50)) if b.openings)
    hole = holes_of(building.spaces, building.openings, building.openings[0].space)[0]
    hole = dataclasses.replace(hole, start=1.0, end=2.0, bottom=0.9, top=2.1)
    assert free_runs(4.0, [hole], (1.0, 1.5), 0.1) == [(0.0, 0.9), (2.1, 4.0)]
    assert free_runs(4.0, [hole], (0.0, 0.7), 0.1) == [(0.0, 4.0)]
    assert free_runs(4.0, [hole], (2.3, 2.5), 0.1) == [(0.0, 4.0)]
    assert free_runs(1.5, [hole], (0.0, 2.5), 0.1) == [(0.0, 0.9)]


def test_strips_of_an_l_shape():
    l_shape = ((0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0))
    assert strips(l_shape, 1.0, across_x=True) == [(0.0, 4.0)]
    assert strips(l_shape, 3.0, across_x=False) == [(0.0, 2.0)]
    assert strips(l_shape, 5.0, across_x=True) == []


def test_ways_of_doors_are_free_of_columns(buildings):
    for building in buildings:
        sky = Sky("day", None, 0.0, 1.0, (1.0, 1.0, 1.0), None)
        plan = Plan(0, tuple(building.spaces), tuple(building.openings), (), (), sky, ())
        for index, space in enumerate(plan.spaces):
            sweeps = [sweep for hole in holes(plan, index) if (sweep := door_sweep(plan, hole))]
            for a, b, c, d, _, _ in space.details.get("columns", ()):
                assert not any(overlap((a, b, c, d), sweep) for sweep in sweeps)
