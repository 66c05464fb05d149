"""Plans: deterministic, complete as JSON, with free cameras."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys

import pytest

from mixlight.data.rooms.cameras import clearance, place_cameras
from mixlight.data.rooms.make_plan import make_plan, stream
from mixlight.data.rooms.outline import contains
from mixlight.data.rooms.plan import Item, Opening, Plan
from mixlight.data.rooms.plan_json import (
    from_document,
    from_json,
    plain,
    read_surface,
    surface_document,
    to_document,
    to_json,
)

SEEDS = range(16)


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    return [make_plan(seed) for seed in SEEDS]


def test_the_same_seed_gives_the_same_plan(plans):
    for plan in plans[:4]:
        assert make_plan(plan.seed) == plan
    assert make_plan(1000) != dataclasses.replace(make_plan(1001), seed=1000)


def test_the_same_seed_gives_the_same_plan_in_another_process(plans):
    """Strings hash differently from process to process: no set's order may decide anything."""
    script = (
        "import hashlib, sys\n"
        "from mixlight.data.rooms.make_plan import make_plan\n"
        "from mixlight.data.rooms.plan_json import to_json\n"
        "sys.stdout.write(to_json(make_plan(3)))"
    )
    for salt in ("1",):
        run = subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": salt},
        )
        assert run.stdout == to_json(plans[3])


def test_json_gives_the_same_plan_back(plans):
    for plan in plans:
        assert from_json(to_json(plan)) == plan
        assert plain(plan) == plan


def test_cameras_are_free(plans):
    for plan in plans:
        space = plan.spaces[0]
        assert len(plan.cameras) == 3
        for camera in plan.cameras:
            assert camera.space == 0
            assert contains(space.outline, camera.position[:2], 0.07)
            assert 1.0 < camera.position[2] <= min(1.8, space.height - 0.4)
            assert clearance(plan, camera.position) > 0.1
            assert -math.pi <= camera.turn <= math.pi


def test_number_of_cameras():
    assert len(make_plan(5, cameras=7).cameras) == 7
    with pytest.raises(ValueError, match="at least 1 camera"):
        make_plan(5, cameras=0)


def test_kind_can_be_asked_for_and_is_checked():
    assert make_plan(2, kind="bathroom").spaces[0].kind == "bathroom"
    with pytest.raises(ValueError, match="expected one of living"):
        make_plan(2, kind="dungeon")


def test_clearance_is_the_distance_to_a_turned_box():
    plan = dataclasses.replace(make_plan(0), fixtures=(), spaces=(_empty_space(),), openings=())
    item = Item("box", "own:box", (2.0, 2.0, 0.0), math.pi / 2, (2.0, 1.0, 1.4))
    plan = dataclasses.replace(plan, items=(item,))
    # Turned by a right angle the box reaches from x = 1.5 to 2.5 and from y = 1 to 3.
    assert clearance(plan, (3.0, 2.0, 1.5)) == pytest.approx(0.5)
    assert clearance(plan, (2.0, 3.25, 1.5)) == pytest.approx(0.25)
    assert clearance(plan, (2.5 + 0.3, 3.0 + 0.4, 1.5)) == pytest.approx(0.5)
    assert clearance(plan, (2.0, 2.0, 1.5)) < 0
    assert clearance(plan, (2.0, 2.0, 1.8)) == math.inf
    assert clearance(plan, (2.0, 2.0, 1.8), over=False) < 0


def test_a_full_room_is_an_error():
    space = _empty_space()
    full = Item("box", "own:box", (2.0, 1.5, 0.0), 0.0, (4.0, 3.0, 2.2))
    plan = dataclasses.replace(make_plan(0), spaces=(space,), openings=(), items=(full,), fixtures=())
    with pytest.raises(ValueError, match="no place for a camera"):
        place_cameras(plan, stream(0, "cameras"), 1)


def _empty_space():
    space = make_plan(0).spaces[0]
    outline = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    return dataclasses.replace(space, outline=outline, walls=space.walls[:1] * 4, height=2.5, details={})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(format="other"), "expected a document of format"),
        (lambda d: d.update(version=99), "expected version 1"),
        (lambda d: d.pop("sky"), "missing .'sky'"),
        (lambda d: d.update(extra=1), "unknown .'extra'"),
        (
            lambda d: d["spaces"][0].update(height="high"),
            r"plan.spaces\[0\].height: expected float, got 'high'",
        ),
        (lambda d: d["spaces"][0]["outline"][0].append(1.0), "expected 2 values, got 3"),
        (lambda d: d["openings"][0].update(kind="hatch"), "expected one of"),
        (lambda d: d["openings"][0].update(details=[]), "expected an object"),
        (lambda d: d.update(spaces={}), "expected a list"),
    ],
)
def test_a_document_with_a_fault_is_refused(plans, change, message):
    document = json.loads(to_json(plans[1]))
    change(document)
    with pytest.raises(ValueError, match=message):
        from_document(document)


def test_values_that_json_cannot_hold_are_refused(plans):
    opening = Opening("door", 0, 0, 0.1, 1.0, 0.0, 2.0, details={"odd": {1, 2}})
    plan = dataclasses.replace(plans[0], openings=(opening,))
    with pytest.raises(ValueError, match=r"plan.openings\[0\].details.odd: expected a plain value"):
        to_document(plan)
    opening = dataclasses.replace(opening, details={"odd": math.nan})
    with pytest.raises(ValueError):
        to_json(dataclasses.replace(plan, openings=(opening,)))
    opening = dataclasses.replace(opening, details={"odd": {1: "a"}})
    with pytest.raises(ValueError, match="keys that are strings"):
        to_document(dataclasses.replace(plan, openings=(opening,)))


def test_no_json_is_refused():
    with pytest.raises(ValueError):
        from_json("{")
    with pytest.raises(ValueError, match="got 'list'"):
        from_json("[]")


def test_surfaces_as_documents(plans):
    for surface in plans[0].spaces[0].walls:
        assert read_surface(surface_document(surface)) == surface
    with pytest.raises(ValueError, match=r"missing .'colour'"):
        read_surface({key: value for key, value in surface_document(surface).items() if key != "colour"})


def test_clearance_is_the_distance_to_an_open_leaf():
    """A door in the wall at y = 0, hinged at its start, opened by a right angle into the room."""
    door = Opening(
        "door", 0, 0, 1.0, 2.0, 0.0, 2.0, 1, 0.15, {"hinge": "start", "into": True, "angle": math.pi / 2}
    )
    there = dataclasses.replace(
        _empty_space(), outline=((0.0, -3.0), (4.0, -3.0), (4.0, -0.15), (0.0, -0.15))
    )
    plan = dataclasses.replace(
        make_plan(0), spaces=(_empty_space(), there), openings=(door,), items=(), fixtures=()
    )
    # The leaf runs from (1.022, 0) to (1.022, .956); .05 is its thickness and a hair.
    assert clearance(plan, (1.522, 0.5, 1.5)) == pytest.approx(0.45)
    assert clearance(plan, (1.022, 1.456, 1.5)) == pytest.approx(0.45)
    assert clearance(plan, (1.022, 0.4, 1.5)) < 0
    shut = dataclasses.replace(door, details={**door.details, "angle": 0.0})
    assert clearance(dataclasses.replace(plan, openings=(shut,)), (1.5, 0.5, 1.5)) == pytest.approx(0.45)
    # The other space sees the same leaf when the door opens into it.
    away = dataclasses.replace(door, details={**door.details, "into": False})
    other = dataclasses.replace(
        plan, spaces=(there, _empty_space()), openings=(dataclasses.replace(away, space=1, leads=0),)
    )
    assert clearance(other, (1.022, -0.6, 1.5)) < 0


def test_a_column_is_in_the_way():
    space = dataclasses.replace(_empty_space(), details={"columns": [[1.0, 1.0, 1.4, 1.4, 0.0, 2.5]]})
    plan = dataclasses.replace(make_plan(0), spaces=(space,), openings=(), items=(), fixtures=())
    assert clearance(plan, (1.9, 1.2, 1.5)) == pytest.approx(0.5)
    assert clearance(plan, (1.2, 1.2, 1.5)) < 0
