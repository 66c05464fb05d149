import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.render.scene_camera import DEFAULT_SHARE, SceneCamera, default_point, place
from mixlight.sphere.camera import ray_directions

ANGLE = st.floats(-0.6, 0.6)
BOX = np.array([-0.3, 0.0, -0.2]), np.array([0.3, 0.5, 0.2])


def test_golden_ground_point_and_horizon() -> None:
    camera = SceneCamera(640, 480, math.radians(60), math.radians(-8))
    # The horizon lies tan(8 deg) focal lengths above the centre; 45 degrees down is one height away.
    assert camera.horizon(0.3) == pytest.approx(0.5 - math.tan(math.radians(8)) * camera.focal / 480)
    v = 0.5 + math.tan(math.radians(37)) * camera.focal / 480
    point = SceneCamera(640, 960, math.radians(60), math.radians(-8)).ground_point(0.5, 0.25 + v / 2)
    np.testing.assert_allclose(point, [0, -1, -1], atol=1e-12)


@given(pitch=ANGLE, roll=ANGLE, fov=st.floats(0.3, 2.0))
def test_rays_are_those_of_the_sphere_module(pitch: float, roll: float, fov: float) -> None:
    camera = SceneCamera(7, 5, fov, pitch, roll)
    centres = np.stack(np.meshgrid(np.arange(7) + 0.5, np.arange(5) + 0.5), -1)
    expected = ray_directions(5, 7, fov, 0.0, pitch, roll).double().numpy()
    np.testing.assert_allclose(camera.directions(centres), expected, atol=1e-6)


@given(pitch=ANGLE, roll=ANGLE, u=st.floats(0, 1), v=st.floats(0, 1))
def test_ground_points_appear_where_they_were_clicked(pitch: float, roll: float, u: float, v: float) -> None:
    camera = SceneCamera(640, 480, 1.1, pitch, roll)
    if v > camera.horizon(u) + 0.1 and math.cos(roll) > 0:
        point = camera.ground_point(u, v)
        assert point[1] == pytest.approx(-1.0)
        where, depth = camera.project(point)
        assert depth > 0
        np.testing.assert_allclose(where, [u * 640, v * 480], atol=1e-6)


@given(pitch=ANGLE, roll=ANGLE, u=st.floats(0, 1))
def test_the_horizon_is_level(pitch: float, roll: float, u: float) -> None:
    camera = SceneCamera(640, 480, 1.1, pitch, roll)
    ray = camera.directions(np.array([u * 640, camera.horizon(u) * 480]))
    assert ray[1] == pytest.approx(0.0, abs=1e-9)


def test_a_camera_that_leans_right_sees_the_horizon_fall_to_the_left() -> None:
    camera = SceneCamera(640, 480, 1.0, 0.0, math.radians(10))
    # Turned clockwise, the content turns counter-clockwise: down on the left side, up on the right.
    assert camera.horizon(0.0) > 0.5 > camera.horizon(1.0)


@pytest.mark.parametrize(
    ("u", "v", "says"),
    [
        (0.5, 0.2, "below the horizon .* above it"),
        (0.5, 0.505, r"0\.\d\d° below it"),
        (1.2, 0.8, "inside the photo"),
        (0.5, -0.1, "inside the photo"),
        (math.nan, 0.8, "inside the photo"),
    ],
)
def test_points_that_are_no_ground(u: float, v: float, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        SceneCamera(640, 480, 1.0).ground_point(u, v)


@pytest.mark.parametrize(
    "arguments",
    [
        (0, 4, 1.0),
        (4, 4, 0.0),
        (4, 4, math.pi),
        (4, 4, 1.0, 2.0),
        (4, 4, 1.0, math.nan),
        (4, 4, 1.0, 0.0, 4.0),
    ],
)
def test_impossible_cameras(arguments: Any) -> None:
    with pytest.raises(ValueError, match="expected"):
        SceneCamera(*arguments)


def test_default_point_is_below_the_horizon_or_refused() -> None:
    assert default_point(SceneCamera(640, 480, 1.0, -0.5)) == (0.5, pytest.approx(2 / 3))
    with pytest.raises(ValueError, match="shows ground below its horizon"):
        default_point(SceneCamera(640, 480, 1.0, 0.6))


@given(u=st.floats(0.2, 0.8), v=st.floats(0.62, 0.8), turn=st.floats(-3, 3), size=st.floats(0.01, 100))
def test_without_a_size_an_object_spans_its_share_of_the_photo(
    u: float, v: float, turn: float, size: float
) -> None:
    camera = SceneCamera(640, 480, 1.0, -0.1, 0.05)
    lower, upper = BOX[0] * size, BOX[1] * size
    placement = place(camera, lower, upper, u, v, turn=turn)
    corners = np.array(np.meshgrid(*zip(lower, upper, strict=True))).reshape(3, -1).T
    world = placement.apply(corners)
    assert world[:, 1].min() == pytest.approx(-1.0)  # it stands on the ground
    where, _ = camera.project(world)
    assert np.ptp(where, axis=0).max() / 480 == pytest.approx(DEFAULT_SHARE, rel=1e-6)
    foot, _ = camera.project(placement.apply(np.array([0.0, lower[1], 0.0])))
    np.testing.assert_allclose(foot, [u * 640, v * 480], atol=1e-6)


def test_with_the_cameras_height_a_model_has_its_own_size() -> None:
    placement = place(SceneCamera(640, 480, 1.0), *BOX, 0.5, 0.7, camera_height=1.6)
    # Half a metre is 0.5 / 1.6 camera heights.
    top = placement.apply(np.array([0.0, 0.5, 0.0]))[1]
    assert top == pytest.approx(-1 + 0.5 / 1.6)
    assert place(SceneCamera(640, 480, 1.0), *BOX, 0.5, 0.7, camera_height=1.6, scale=2.0).scale == 2 / 1.6


def test_a_turn_is_counter_clockwise_from_above() -> None:
    placement = place(SceneCamera(640, 480, 1.0), *BOX, 0.5, 0.7, camera_height=1.0, turn=math.pi / 2)
    front = placement.apply(np.array([0.0, 0.0, 0.2])) - placement.point
    np.testing.assert_allclose(front, [0.2, 0, 0], atol=1e-12)  # from the camera, it now looks to the right


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"scale": -1.0}, "scale: expected a number above 0"),
        ({"scale": math.nan}, "scale"),
        ({"camera_height": 0.0}, "camera height"),
        ({"camera_height": 0.05}, "wholly in front of the camera"),
        ({"scale": 1e4}, "wholly in front of the camera"),
    ],
)
def test_sizes_that_cannot_be(options: dict[str, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        place(SceneCamera(640, 480, 1.0), *BOX, 0.5, 0.9, **options)


def test_a_model_without_extent_is_refused() -> None:
    with pytest.raises(ValueError, match="some extent"):
        place(SceneCamera(640, 480, 1.0), np.zeros(3), np.zeros(3), 0.5, 0.9)
