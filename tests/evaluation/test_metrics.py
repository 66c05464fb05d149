"""RMSE and si-RMSE of pictures under a mask."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.evaluation.metrics import rmse, si_rmse
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
