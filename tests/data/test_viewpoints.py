"""Viewpoints of our making: identity, geometry of a moved camera, and what is refused."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mixlight.data.viewpoints import moved, random_move
from mixlight.sphere import equirect


def _smooth(height: int = 32) -> torch.Tensor:
    x, y, z = equirect.pixel_directions(height).unbind(-1)
    return torch.stack([1 + 0.5 * x, 1 + 0.5 * y, 1 + 0.5 * z], -1)


def test_no_move_is_the_panorama() -> None:
    panorama = _smooth()
    torch.testing.assert_close(moved(panorama, (0.0, 0.0, 0.0)), panorama, rtol=1e-4, atol=1e-4)


def test_even_stretch_without_a_move_changes_nothing() -> None:
    panorama = _smooth()
    same = moved(panorama, (0.0, 0.0, 0.0), (1.3, 1.3, 1.3))
    torch.testing.assert_close(same, panorama, rtol=1e-4, atol=1e-4)


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10_000))
def test_constant_light_stays_constant(seed: int) -> None:
    offset, stretch = random_move(np.random.default_rng(seed))
    constant = torch.full((16, 32, 3), 2.5)
    torch.testing.assert_close(moved(constant, offset, stretch), constant)


@settings(deadline=None, max_examples=15)
@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(0.7, 1.4), st.floats(0.7, 1.4))
def test_every_ray_meets_its_point(x: float, z: float, stretch_x: float, stretch_z: float) -> None:
    """The same by another way: march along a ray until it leaves the ellipsoid, here by bisection."""
    offset, stretch = (0.7 * x, 0.1, 0.7 * z), (stretch_x, 1.0, stretch_z)
    panorama = _smooth(64)
    found = moved(panorama, offset, stretch)
    scale, place = np.array(stretch), np.array(offset)
    for row, column in ((10, 5), (32, 64), (50, 100)):
        ray = equirect.pixel_directions(64)[row, column].double().numpy()
        low, high = 0.0, 10.0
        for _ in range(60):
            middle = (low + high) / 2
            inside = np.sum(((place + middle * ray) / scale) ** 2) < 1
            low, high = (middle, high) if inside else (low, middle)
        point = (place + low * ray) / scale
        expected = 1 + 0.5 * point / np.linalg.norm(point)
        np.testing.assert_allclose(found[row, column].numpy(), expected, atol=2e-3)


def test_moving_towards_a_lamp_makes_it_larger_and_brighter() -> None:
    panorama = torch.zeros(64, 128, 3)
    panorama[30:34, 62:66] = 1.0  # ahead
    plain = equirect.integrate(panorama)[0]
    near = equirect.integrate(moved(panorama, (0.0, 0.0, -0.5)))[0]
    far = equirect.integrate(moved(panorama, (0.0, 0.0, 0.5)))[0]
    # Twice as near: four times the solid angle; half as far again: 1 / 1.5^2.
    assert float(near / plain) == pytest.approx(4.0, rel=0.1)
    assert float(far / plain) == pytest.approx(1 / 2.25, rel=0.15)


def test_random_moves_stay_inside_and_repeat() -> None:
    for seed in range(50):
        offset, stretch = random_move(np.random.default_rng(seed))
        assert sum((o / s) ** 2 for o, s in zip(offset, stretch, strict=True)) < 0.7
        assert math.hypot(offset[0], offset[2]) <= 0.45
        assert (offset, stretch) == random_move(np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("offset", "stretch", "message"),
    [
        ((1.0, 0.0, 0.0), (1.0, 1.0, 1.0), "inside the ellipsoid"),
        ((0.0, 0.0, 0.8), (1.0, 1.0, 0.7), "inside the ellipsoid"),
        ((0.0, 0.0, 0.0), (1.0, 0.0, 1.0), "above 0"),
    ],
)
def test_refuses(
    offset: tuple[float, float, float], stretch: tuple[float, float, float], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        moved(_smooth(), offset, stretch)
