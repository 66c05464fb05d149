"""What every building must be, over many seeds."""

from __future__ import annotations

from itertools import combinations

import pytest

from mixlight.data.rooms.building import Building
from mixlight.data.rooms.footprints import DIMENSIONS
from mixlight.data.rooms.layout import KIND_SHARES, draw_building
from mixlight.data.rooms.make_plan import stream
from mixlight.data.rooms.outline import area, bounds, cells, contains, edges, holes_of, overlap
from mixlight.data.rooms.palette import choose
from mixlight.data.rooms.plan import KINDS, SURFACES, Surface
from mixlight.data.rooms.plan_json import read_surface

SEEDS = range(70)


@pytest.fixture(scope="module")
def buildings() -> list[Building]:
    return [draw_building(stream(seed, "layout")) for seed in SEEDS]


def test_every_kind_can_be_asked_for():
    for kind in KINDS:
        for seed in range(5):
            assert draw_building(stream(seed, "layout"), kind).spaces[0].kind == kind


def test_kinds_come_as_often_as_their_shares_say(buildings):
    assert {kind for kind, _ in KIND_SHARES} == set(KINDS)
    assert sum(share for _, share in KIND_SHARES) == pytest.approx(1)
    # The kind is the first thing that is drawn, so it can be had for many seeds.
    found = [choose(stream(seed, "layout"), KIND_SHARES) for seed in range(3000)]
    assert found[: len(buildings)] == [building.spaces[0].kind for building in buildings]
    for kind, share in KIND_SHARES:
        # Four standard deviations of the most frequent kind.
        assert found.count(kind) / len(found) == pytest.approx(share, abs=0.031)


def test_outlines_are_simple_and_counter_clockwise(buildings):
    for building in buildings:
        for space in building.spaces:
            walls = edges(space.outline)
            assert area(space.outline) > 0
            assert sum((c[2] - c[0]) * (c[3] - c[1]) for c in cells(space.outline)) == pytest.approx(
                area(space.outline)
            )
            # A point just inside the middle of every wall is inside; just outside it is not.
            for wall in walls:
                assert wall.length >= 0.2
                assert contains(space.outline, wall.at(wall.length / 2, 0.01))
                assert not contains(space.outline, wall.at(wall.length / 2, -0.01))


def test_main_space_has_the_size_of_its_kind(buildings):
    for building in buildings:
        space = building.spaces[0]
        d = DIMENSIONS[space.kind]
        # The missing corner of an L takes up to 2/5, a bay adds a little.
        assert 0.5 * d.area[0] <= area(space.outline) <= 1.2 * d.area[1]
        assert 2.3 <= space.height <= 6.0
        x0, y0, x1, y1 = bounds(space.outline)
        assert min(x1 - x0, y1 - y0) >= min(d.narrow, 1.1) - 1e-9


def test_spaces_keep_a_walls_thickness_apart(buildings):
    for building in buildings:
        for one, other in combinations(building.spaces, 2):
            for a in cells(one.outline):
                for b in cells(other.outline):
                    assert not overlap(a, b, 0.05)


def test_openings_lie_inside_their_edges_and_apart(buildings):
    for building in buildings:
        for index, space in enumerate(building.spaces):
            walls = edges(space.outline)
            found = holes_of(building.spaces, building.openings, index)
            for hole in found:
                assert 0 < hole.start < hole.end < walls[hole.edge].length
                assert 0 <= hole.bottom < hole.top < space.height
            for a, b in combinations(found, 2):
                assert a.edge != b.edge or a.end < b.start or b.end < a.start


def test_both_sides_of_an_opening_see_the_same_hole(buildings):
    shared = 0
    for building in buildings:
        near = {
            h.index: h
            for i in range(len(building.spaces))
            for h in holes_of(building.spaces, building.openings, i)
            if not h.far
        }
        for i in range(len(building.spaces)):
            for far in holes_of(building.spaces, building.openings, i):
                if not far.far:
                    continue
                shared += 1
                hole = near[far.index]
                assert far.space == hole.opening.leads
                here = edges(building.spaces[hole.space].outline)[hole.edge]
                there = edges(building.spaces[far.space].outline)[far.edge]
                assert there.at(far.end) == pytest.approx(here.at(hole.start, -hole.opening.depth), abs=2e-3)
                assert there.at(far.start) == pytest.approx(here.at(hole.end, -hole.opening.depth), abs=2e-3)
    assert shared > 60


def test_windows_look_into_the_open(buildings):
    count = 0
    for building in buildings:
        for opening in building.openings:
            if opening.kind != "window" or opening.leads is not None:
                continue
            count += 1
            edge = edges(building.spaces[opening.space].outline)[opening.edge]
            outside = edge.rectangle(opening.start, opening.end, -1.5, -building.outer - 0.002)
            assert building.clear(outside, gap=building.outer - 1e-6)
            assert opening.depth == building.outer
    assert count > 100


def test_every_space_can_be_entered(buildings):
    closed = []
    for building in buildings:
        for index in range(len(building.spaces)):
            ways = [
                h for h in holes_of(building.spaces, building.openings, index) if h.opening.kind != "window"
            ]
            if not ways:
                closed.append(building)
    assert not closed


def test_paint_is_mostly_calm(buildings):
    """Three quarters of the main walls are white, grey or beige: a saturation of at most .45."""
    painted = [b.spaces[0].walls for b in buildings]
    walls = [w for walls in painted for w in walls if w.kind in ("paint", "plaster")]
    calm = [w for w in walls if 1 - min(w.colour) / max(w.colour) < 0.45 and w.colour[0] > 0.9 * w.colour[2]]
    assert 0.66 < len(calm) / len(walls) < 0.92


def _surfaces(value: object) -> list[Surface]:
    if isinstance(value, Surface):
        return [value]
    if isinstance(value, dict):
        if {"kind", "roughness", "metallic"} <= set(value):
            return [read_surface(value)]
        return [s for inner in value.values() for s in _surfaces(inner)]
    if isinstance(value, list | tuple):
        return [s for inner in value for s in _surfaces(inner)]
    return []


def test_surfaces_are_physical(buildings):
    for building in buildings:
        spaces = [(s.walls, s.floor, s.ceiling, s.skirting, s.details) for s in building.spaces]
        for surface in _surfaces((spaces, [o.details for o in building.openings])):
            assert surface.kind in SURFACES
            for colour in (surface.colour, surface.second or surface.colour):
                assert all(0 <= c <= 0.95 for c in colour)
            assert 0 <= surface.roughness <= 1
            assert 0 <= surface.transmission < 1
            assert surface.scale > 0
