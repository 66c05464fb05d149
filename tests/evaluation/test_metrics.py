"""Errors of pictures under a mask."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.evaluation.metrics import normalised_rmse, rgb_angle, rmse, si_rmse
from tests.tolerances import TOLERANCE

F64 = torch.float64
EXACT = TOLERANCE[F64]
DISC = torch.hypot(*torch.meshgrid(*2 * [torch.linspace(-1, 1, 8)], indexing="ij")) < 0.9


def pictures(seed: int, *shape: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    p, g = torch.rand(2, *shape, 8, 8, 3, dtype=F64, generator=generator)
    return p, g


def test_golden():
    """One channel of three is off by 3, so the mean square over pixels and channels is 3."""
    g = torch.zeros(8, 8, 3, dtype=F64)
    p = g.clone()
    p[..., 0] = 3
    assert rmse(p, g, DISC).item() == pytest.approx(math.sqrt(3))


def test_si_golden():
    g = torch.rand(8, 8, 3, dtype=F64)
    assert si_rmse(0.25 * g, g, DISC).item() == pytest.approx(0, abs=1e-12)
    tinted = g * torch.tensor([1.0, 1.0, 0.5], dtype=F64)
    assert si_rmse(tinted, g, DISC) > 0.01  # one scale for all channels


@given(st.integers(0, 10_000))
def test_only_the_mask_counts(seed):
    p, g = pictures(seed)
    elsewhere = torch.where(DISC[..., None], p, p + 100)
    for metric in (rmse, si_rmse):
        torch.testing.assert_close(metric(elsewhere, g, DISC), metric(p, g, DISC), **EXACT)
    assert si_rmse(p, g, DISC) <= rmse(p, g, DISC)


@pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
def test_leading_shapes(shape):
    p, g = pictures(1, *shape)
    for metric in (rmse, si_rmse):
        got = metric(p, g, DISC)
        assert got.shape == shape
        one = metric(p.reshape(-1, 8, 8, 3)[-1], g.reshape(-1, 8, 8, 3)[-1], DISC)
        torch.testing.assert_close(got.flatten()[-1], one, **EXACT)


def test_bad_input():
    p, g = pictures(2)
    with pytest.raises(ValueError, match="at least one pixel"):
        rmse(p, g, torch.zeros_like(DISC))


def test_by_pixels_the_rmse_of_rgb_is_root_three_times_as_large():
    p, g = pictures(3)
    for metric in (rmse, si_rmse):
        by_pixels = metric(p, g, DISC, "pixels")
        torch.testing.assert_close(by_pixels, math.sqrt(3) * metric(p, g, DISC), **EXACT)


def test_rgb_angle_golden():
    """Red against gray: the angle whose cosine is 1 / sqrt(3); black counts as 0."""
    gray = torch.full((8, 8, 3), 0.4, dtype=F64)
    red = gray * torch.tensor([5.0, 0, 0], dtype=F64)
    expected = math.acos(1 / math.sqrt(3))
    assert rgb_angle(red, gray, DISC).item() == pytest.approx(expected)
    red[:, :4] = 0
    assert rgb_angle(red, gray, DISC).item() == pytest.approx(expected / 2)


@given(st.integers(0, 10_000), st.floats(1e-3, 1e3))
def test_rgb_angle_is_the_arc_cosine_and_blind_to_brightness(seed, gain):
    p, g = pictures(seed)
    cosine = (p * g).sum(-1) / (p.norm(dim=-1) * g.norm(dim=-1))
    expected = np.arccos(np.clip(cosine[DISC].numpy(), 0, 1)).mean()
    assert rgb_angle(gain * p, g, DISC).item() == pytest.approx(expected, abs=1e-7)
    assert rgb_angle(p, gain * p, DISC).item() == pytest.approx(0, abs=1e-7)


@given(st.integers(0, 10_000), st.integers(0, 9), st.integers(0, 9))
def test_normalised_rmse_is_that_of_the_whole_frame(seed, rows, columns):
    """Against NumPy's percentiles on the frame with its black rim."""
    p, g = pictures(seed)
    frame = (8 + rows, 8 + columns)
    scaled = []
    for picture in (p, g):
        whole = np.zeros((*frame, 3))
        whole[:8, :8] = picture.numpy()
        low, high = np.percentile(whole, [0.1, 99.9])
        scaled.append((picture.numpy() - low) / (high - low))
    error = (scaled[0] - scaled[1])[DISC.numpy()]
    expected = math.sqrt((error**2).sum() / int(DISC.sum()))
    assert normalised_rmse(p, g, DISC, frame).item() == pytest.approx(expected, rel=1e-9)


def test_normalised_rmse_is_blind_to_scale_and_survives_black():
    p, g = pictures(4, 2)
    torch.testing.assert_close(normalised_rmse(7 * p, g, DISC), normalised_rmse(p, g, DISC), **EXACT)
    assert normalised_rmse(p, g, DISC).shape == (2,)
    black = torch.zeros_like(g)
    assert bool(normalised_rmse(black, g, DISC).isfinite().all())
    with pytest.raises(ValueError, match="a frame of at least 8 x 8"):
        normalised_rmse(p, g, DISC, (8, 7))


@pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
def test_leading_shapes_of_the_others(shape):
    p, g = pictures(5, *shape)
    for metric in (rgb_angle, normalised_rmse):
        assert metric(p, g, DISC).shape == shape
