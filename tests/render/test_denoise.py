import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.render.denoise import denoise, robust_mean


def _field(rows: int = 48, columns: int = 64) -> np.ndarray:
    """A slope and a sharp shadow."""
    y, x = np.mgrid[:rows, :columns]
    return np.where((x > 20) & (y > 12), 0.2, 0.6 + 0.002 * x)[..., None].repeat(3, -1)


def _noisy(seed: int, sigma: float, runs: int = 8) -> np.ndarray:
    clean = _field()
    return clean + np.random.default_rng(seed).normal(size=(runs, *clean.shape)) * sigma


@pytest.mark.parametrize("seed", range(3))
def test_noise_falls_to_a_third_and_the_shadows_rim_stays(seed: int) -> None:
    clean = _field()
    value, variance = robust_mean(_noisy(seed, 0.1))
    smooth = denoise(value, variance, np.ones(clean.shape[:2], bool))
    before, after = (np.sqrt(((p - clean) ** 2).mean()) for p in (value, smooth))
    assert after < before / 3
    rim = smooth[20:, 19:23].mean((0, 2))
    np.testing.assert_allclose(rim, clean[30, 19:23, 0], atol=0.02)


@given(st.integers(0, 1000), st.floats(0.01, 1.0))
def test_without_noise_nothing_changes(seed: int, contrast: float) -> None:
    rng = np.random.default_rng(seed)
    field = np.kron(rng.uniform(0, contrast, (4, 5, 1)), np.ones((3, 3, 1)))
    value, variance = robust_mean(np.stack([field] * 8))
    np.testing.assert_allclose(denoise(value, variance, np.ones((12, 15), bool)), field, atol=1e-5)


def test_invalid_pixels_neither_give_nor_take() -> None:
    runs = _noisy(0, 0.05)
    valid = np.ones(runs.shape[1:3], bool)
    valid[10:30, 30:40] = False
    value, variance = robust_mean(runs)
    spoiled = np.where(valid[..., None], value, 1e6)
    first, second = denoise(value, variance, valid), denoise(spoiled, variance, valid)
    np.testing.assert_array_equal(first[valid], second[valid])
    np.testing.assert_array_equal(second[~valid], spoiled[~valid])


def test_a_firefly_leaves_no_trace() -> None:
    runs = _noisy(1, 0.02)
    runs[3, 5, 6] += 500.0
    runs[5, 40, 50] += 500.0
    value, variance = robust_mean(runs)
    smooth = denoise(value, variance, np.ones(runs.shape[1:3], bool))
    assert np.abs(smooth - _field()).max() < 0.1


def test_a_speckle_in_every_run_is_brought_down_to_its_neighbours() -> None:
    runs = _noisy(2, 0.02)
    runs[:, 5, 6] += 3.0
    value, variance = robust_mean(runs)
    assert denoise(value, variance, np.ones(runs.shape[1:3], bool))[5, 6, 0] < 0.8


@pytest.mark.parametrize("count", [5, 8, 16])
def test_the_variance_is_that_of_the_mean(count: int) -> None:
    """Reference: the spread of many such means."""
    mean, variance = robust_mean(np.random.default_rng(0).normal(size=(count, 100_000, 1)))
    assert variance.mean() == pytest.approx(mean.var(), rel=0.2)
    assert mean.var() < 1.25 / count


def test_few_runs() -> None:
    runs = np.array([[[1.0]], [[3.0]]])
    mean, variance = robust_mean(runs)
    assert (mean[0, 0], variance[0]) == (2.0, 1.0)
    assert robust_mean(runs[:1])[1][0] == 0.0
