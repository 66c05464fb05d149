"""A plan becomes meshes, lights and portals, each in its place."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mixlight.data.rooms import scene
from mixlight.data.rooms.make_plan import make_plan
from mixlight.data.rooms.mesh import Emission
from mixlight.data.rooms.plan import Item, Opening, Plan
from mixlight.data.rooms.store import group_names
from tests.data.rooms.boxes import plain_plan

SUN = (0.0, 0.6, 0.8)


def with_sun(plan: Plan, **changes: object) -> Plan:
    sky = replace(plan.sky, sun_direction=SUN, sun_illuminance=6830.0, sun_temperature=6504.0)
    return replace(plan, sky=replace(sky, **changes))  # type: ignore[arg-type]


def test_a_plain_room() -> None:
    built = scene.build(plain_plan(3, 2), sky_height=16)
    assert built.name == "room-00003"
    assert built.groups == ("ceiling", "off", "sky")
    assert built.sky.shape == (16, 32, 3)
    assert built.sun is None
    assert len(built.cameras) == 2
    lit = {part.material.group for part in built.parts if isinstance(part.material, Emission)}
    assert lit == {"ceiling", "off"}  # what is off is rendered, too: a remix may switch it on


def test_the_sun_in_units_of_683_lux() -> None:
    sun = scene.build(with_sun(plain_plan()), sky_height=16).sun
    assert sun is not None
    assert sun.direction == SUN
    assert np.dot(sun.irradiance, (0.2126, 0.7152, 0.0722)) == pytest.approx(10.0, rel=1e-3)
    assert sun.irradiance[0] / sun.irradiance[2] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("changes", [{"sun_illuminance": 0.0}, {"sun_direction": None}])
def test_no_sun(changes: dict[str, object]) -> None:
    built = scene.build(with_sun(plain_plan(), **changes), sky_height=16)
    assert built.sun is None
    assert "sun" not in built.groups


@pytest.mark.parametrize("edge", range(4))
def test_portals_stand_in_the_outer_wall_and_look_in(edge: int) -> None:
    plan = plain_plan()
    window = Opening("window", 0, edge, 1.0, 2.2, 0.9, 2.1, depth=0.3)
    inner = Opening("window", 0, (edge + 1) % 4, 1.0, 2.2, 0.9, 2.1, leads=1)
    (portal,) = scene.portals_of(replace(plan, openings=(window, inner)))
    assert (portal.width, portal.height) == pytest.approx((1.2, 1.2))
    axes, middle = portal.matrix[:3, :3], portal.matrix[:3, 3]
    assert np.linalg.det(axes) == pytest.approx(1.0)
    # Towards the middle of the room lies its -z.
    assert -axes[:, 2] @ (np.array([2.0, 2.5, 1.5]) - middle) > 0
    assert middle[2] == pytest.approx(1.5)
    outside = max(-middle[0], middle[0] - 4, -middle[1], middle[1] - 5)
    assert outside == pytest.approx(0.3)


def test_a_library_that_is_not_there() -> None:
    chair = Item("chair", "library:x", (1.0, 1.0, 0.0), 0.0, (1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="expected a library of furniture with 'library:x', received none"):
        scene.build(replace(plain_plan(), items=(chair,)), sky_height=16)


def test_a_piece_that_nobody_makes() -> None:
    chair = Item("chair", "own:x", (1.0, 1.0, 0.0), 0.0, (1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="own:x"):
        scene.build(replace(plain_plan(), items=(chair,)), sky_height=16)


@pytest.mark.parametrize("seed", range(0, 60, 7))
def test_real_plans(seed: int) -> None:
    plan = make_plan(seed, cameras=2)
    built = scene.build(plan, sky_height=16)
    assert built.groups == tuple(group_names(plan))
    faces = 0
    for part in built.parts:
        mesh = part.mesh
        faces += len(mesh.faces)
        assert np.isfinite(mesh.vertices).all(), part.name
        assert mesh.faces.shape[1:] == (4,)
        if len(mesh.faces):
            assert mesh.faces[:, :3].min() >= 0, part.name
            assert mesh.faces.max() < len(mesh.vertices), part.name
        if isinstance(part.material, Emission):
            assert all(math.isfinite(c) and c >= 0 for c in part.material.radiance)
    assert 100 < faces < 2_000_000
