"""RMSE and scale-invariant RMSE."""

import math

import numpy as np
import pytest
import scipy.optimize
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light.compare import rmse_and_si_rmse
from tests.tolerances import TOLERANCE

F64 = torch.float64
EXACT = TOLERANCE[F64]


def pictures(seed: int, *shape: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    p, g = torch.rand(2, *shape, 7, 3, dtype=F64, generator=generator)
    return p, g


def test_golden():
    p = torch.tensor([[1.0, 0, 0], [1, 0, 0]], dtype=F64)
    g = torch.tensor([[1.0, 0, 0], [3, 0, 0]], dtype=F64)
    rmse, si_rmse = rmse_and_si_rmse(p, g)
    assert rmse.item() == pytest.approx(math.sqrt(4 / 6))
    assert si_rmse.item() == pytest.approx(math.sqrt(2 / 6))


def test_count():
    p, g = pictures(1)
    by_default, by_pixels = rmse_and_si_rmse(p, g)[0], rmse_and_si_rmse(p, g, count=7)[0]
    torch.testing.assert_close(by_pixels, math.sqrt(3) * by_default, **EXACT)


@given(st.integers(0, 10_000))
def test_scale_is_the_best_one(seed):
    """SciPy's minimiser finds no better scale."""
    p, g = pictures(seed)
    best = scipy.optimize.minimize_scalar(lambda s: ((s * p - g) ** 2).mean().item(), tol=1e-12)
    assert rmse_and_si_rmse(p, g)[1].item() == pytest.approx(math.sqrt(best.fun), rel=1e-6)


@given(st.integers(0, 10_000))
def test_against_numpy(seed):
    p, g = pictures(seed)
    assert rmse_and_si_rmse(p, g)[0].item() == pytest.approx(
        np.sqrt(np.mean((p.numpy() - g.numpy()) ** 2)), rel=1e-12
    )


@given(st.integers(0, 10_000), st.floats(1e-3, 1e3))
def test_scale_invariance(seed, scale):
    p, g = pictures(seed)
    si_rmse = rmse_and_si_rmse(p, g)[1]
    torch.testing.assert_close(rmse_and_si_rmse(scale * p, g)[1], si_rmse, **EXACT)
    torch.testing.assert_close(rmse_and_si_rmse(p, scale * g)[1], scale * si_rmse, **EXACT)


@pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
def test_leading_shapes(shape):
    p, g = pictures(2, *shape)
    for got in rmse_and_si_rmse(p, g):
        assert got.shape == shape


def test_black_predictions():
    g = torch.ones(4, 3, dtype=F64)
    p = torch.zeros(4, 3, dtype=F64, requires_grad=True)
    rmse, si_rmse = rmse_and_si_rmse(p, g)
    assert rmse.item() == si_rmse.item() == 1
    (rmse + si_rmse).backward()
    assert torch.isfinite(p.grad).all()


def test_gradient_at_the_truth_is_zero():
    g = torch.rand(4, 3)
    p = g.clone().requires_grad_()
    rmse_and_si_rmse(p, g)[0].backward()
    assert (p.grad == 0).all()


def test_good_fits_keep_their_digits():
    """A relative error of 1e-4 in float32, where <g, g> - <p, g>²/<p, p> has no digit left."""
    g = torch.linspace(1, 2, 3000).reshape(1000, 3)
    error = 1e-4 * torch.tensor([1.0, -1.0]).repeat(1500).reshape(1000, 3)
    assert rmse_and_si_rmse(g + error, g)[1].item() == pytest.approx(1e-4, rel=0.01)


def test_gradcheck():
    p, g = pictures(3, 2)
    assert torch.autograd.gradcheck(rmse_and_si_rmse, (p.requires_grad_(), g.requires_grad_()))


def test_bad_shapes():
    with pytest.raises(ValueError, match="at least one pixel"):
        rmse_and_si_rmse(torch.zeros(0, 3), torch.zeros(0, 3))
