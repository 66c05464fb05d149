"""Frames and rotations: against the table of conventions.md and SciPy's rotations."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mixlight.sphere import equirect, frames
from mixlight.sphere.frames import FRAMES, convert_directions, convert_panorama, rotation
from tests.tolerances import TOLERANCE

ANGLE = st.floats(-math.pi, math.pi)
NAMES = st.sampled_from(sorted(FRAMES))
SIGNED_AXES = torch.cat((torch.eye(3), -torch.eye(3)))


def test_the_frames_are_these() -> None:
    assert list(FRAMES) == ["mixlight", "three", "blender", "unity", "mitsuba", "usd", "filament", "unreal"]
    assert {name for name, frame in FRAMES.items() if not frame.right_handed} == {"unity", "unreal"}
    assert {name: frame.units_per_metre for name, frame in FRAMES.items() if frame.units_per_metre != 1} == {
        "unreal": 100.0
    }


@pytest.mark.parametrize(
    ("name", "right", "up", "forward"),
    [
        ("mixlight", (1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ("three", (1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ("mitsuba", (1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ("usd", (1, 0, 0), (0, 1, 0), (0, 0, -1)),
        ("blender", (1, 0, 0), (0, 0, 1), (0, 1, 0)),
        ("unity", (1, 0, 0), (0, 1, 0), (0, 0, 1)),
        ("unreal", (0, 1, 0), (0, 0, 1), (1, 0, 0)),
    ],
)
def test_right_up_and_forward_in_each_frame(
    name: str, right: tuple[int, ...], up: tuple[int, ...], forward: tuple[int, ...]
) -> None:
    ours = torch.tensor([[1.0, 0, 0], [0, 1, 0], [0, 0, -1]])
    theirs = convert_directions(ours, "mixlight", name)
    assert theirs.tolist() == [list(map(float, axis)) for axis in (right, up, forward)]
    assert torch.equal(theirs, ours @ FRAMES[name].matrix().T)


@given(NAMES, NAMES, NAMES)
def test_conversions_of_directions_compose_and_invert(a: str, b: str, c: str) -> None:
    directions = torch.tensor([[0.1, -0.7, 0.3], [2.0, 5.0, -1.0]])
    there = convert_directions(directions, a, b)
    assert torch.equal(convert_directions(there, b, a), directions)
    assert torch.equal(convert_directions(there, b, c), convert_directions(directions, a, c))


@given(NAMES, NAMES, NAMES)
def test_conversions_of_panoramas_compose_and_invert(a: str, b: str, c: str) -> None:
    panorama = torch.arange(8.0).view(1, 8, 1)
    there = convert_panorama(panorama, a, b)
    assert torch.equal(convert_panorama(there, b, a), panorama)
    assert torch.equal(convert_panorama(there, b, c), convert_panorama(panorama, a, c))


@pytest.mark.parametrize("batch", [(), (2,), (1, 2)])
def test_convert_panorama_takes_any_batch(batch: tuple[int, ...]) -> None:
    panorama = torch.rand(*batch, 2, 4, 3)
    rolled = convert_panorama(panorama, "mixlight", "unreal")
    assert torch.equal(rolled, panorama.roll(1, -2))


def test_a_width_that_has_no_quarter_is_refused() -> None:
    with pytest.raises(ValueError, match=r"divisible by 4.*received 6"):
        convert_panorama(torch.zeros(3, 6, 3), "mixlight", "three")


@pytest.mark.parametrize("names", [("mixlight", "maya"), ("maya", "mixlight")])
def test_an_unknown_frame_is_refused_by_name(names: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match=r"expected a frame out of mixlight.*received 'maya'"):
        convert_directions(SIGNED_AXES, *names)
    with pytest.raises(ValueError, match="maya"):
        convert_panorama(torch.zeros(2, 4, 3), *names)


def test_the_table_of_frames_is_read_only() -> None:
    with pytest.raises(TypeError):
        frames.FRAMES["maya"] = frames.FRAMES["usd"]  # type: ignore[index]


@given(ANGLE, ANGLE, ANGLE)
def test_rotation_equals_scipy(yaw: float, pitch: float, roll: float) -> None:
    # Capital letters: about the turned axes, i.e. R_y R_x R_z.
    expected = torch.from_numpy(Rotation.from_euler("YXZ", [-yaw, pitch, -roll]).as_matrix())
    torch.testing.assert_close(
        rotation(yaw, pitch, roll, dtype=torch.float64), expected, **TOLERANCE[torch.float64]
    )


def test_signs_of_yaw_pitch_and_roll() -> None:
    right, up, forward = torch.tensor([1.0, 0, 0]), torch.tensor([0, 1.0, 0]), torch.tensor([0, 0, -1.0])
    quarter = math.pi / 2
    torch.testing.assert_close(rotation(quarter) @ forward, right, **TOLERANCE[torch.float32])
    torch.testing.assert_close(rotation(0.0, quarter) @ forward, up, **TOLERANCE[torch.float32])
    # A camera rolled clockwise has its top at the right, and sees what is above at its left.
    torch.testing.assert_close(rotation(0.0, 0.0, quarter) @ up, right, **TOLERANCE[torch.float32])
    torch.testing.assert_close(rotation(0.0, 0.0, quarter).T @ up, -right, **TOLERANCE[torch.float32])


def test_yaw_does_not_tilt_a_pitched_camera() -> None:
    forward = rotation(1.2, -0.4, dtype=torch.float64) @ torch.tensor([0.0, 0, -1], dtype=torch.float64)
    assert forward[1].item() == pytest.approx(math.sin(-0.4))
    u = equirect.directions_to_uv(forward)[0].item()
    assert u == pytest.approx(0.5 + 1.2 / (2 * math.pi))


def test_rotation_of_tensors_is_batched_differentiable_and_follows_their_dtype() -> None:
    yaw = torch.tensor([[0.1], [2.0]], dtype=torch.float64, requires_grad=True)
    pitch = torch.tensor([0.2, -0.3, 0.5], dtype=torch.float64, requires_grad=True)
    both = rotation(yaw, pitch, 0.7)
    assert both.shape == (2, 3, 3, 3)
    assert both.dtype == torch.float64
    torch.testing.assert_close(both[1, 2], rotation(2.0, 0.5, 0.7, dtype=torch.float64))
    assert torch.autograd.gradcheck(lambda y, p: rotation(y, p, 0.7), (yaw, pitch))
    assert rotation(torch.tensor(0.5, dtype=torch.float16)).dtype == torch.float16
    assert rotation(0.5).dtype == torch.float32
