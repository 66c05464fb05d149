"""The display encoding of protocol S."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.data import display


def panorama(seed: int, height: int = 8) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    values = torch.rand(height, 2 * height, 3, generator=generator, dtype=torch.float64) ** 4 * 50
    return torch.where(torch.rand(values.shape, generator=generator) < 0.2, 0.0, values)


def published(hdr: np.ndarray) -> np.ndarray:
    """The formula in the words of the published evaluation: percentile 50 of the encoded values above 0."""
    encoded = hdr ** (1 / 2.4)
    return encoded * (0.5 / np.percentile(encoded[encoded > 0], 50))


def test_golden() -> None:
    """Values 1 and 32 in equal number: encoded 1 and 32^(1/2.4) = 4.2379, their mean is the median."""
    values = torch.ones(2, 4, 3)
    values[1] = 32.0
    encoded = display.encode(values)
    assert encoded[0, 0, 0].item() == pytest.approx(0.5 / ((1 + 4.2379) / 2), abs=1e-4)
    assert encoded[1, 0, 0].item() == pytest.approx(0.5 * 4.2379 / ((1 + 4.2379) / 2), abs=1e-4)


@given(st.integers(0, 10_000))
def test_it_is_the_published_formula(seed: int) -> None:
    values = panorama(seed)
    np.testing.assert_allclose(display.encode(values).numpy(), published(values.numpy()), rtol=1e-9)


@given(st.integers(0, 10_000), st.floats(1e-4, 1e4))
def test_brightness_is_divided_out(seed: int, gain: float) -> None:
    values = panorama(seed)
    torch.testing.assert_close(display.encode(gain * values), display.encode(values), rtol=1e-9, atol=0)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_the_median_is_exact_for_few_values(count: int) -> None:
    values = torch.zeros(2, 4, 3, dtype=torch.float64)
    values.view(-1)[:count] = torch.tensor([3.0, 1.0, 7.0, 2.0], dtype=torch.float64)[:count]
    encoded = display.encode(values).flatten()
    assert float(np.median(encoded[encoded > 0])) == pytest.approx(0.5)


def test_black_stays_black_and_negative_values_are_refused() -> None:
    assert display.gain(torch.zeros(2, 4, 3)) == 1.0
    assert float(display.encode(torch.zeros(2, 4, 3)).sum()) == 0
    with pytest.raises(ValueError, match="at least 0"):
        display.encode(torch.full((2, 4, 3), -1.0))


def test_a_photo_has_eight_bits_and_clips() -> None:
    view = torch.tensor([[[0.0, 0.5**2.4, 4.0]]])
    assert (display.photo(view, 1.0) * 255).tolist() == [[[0.0, 128.0, 255.0]]]
    assert math.isclose(float(display.photo(view, 2.0)[0, 0, 1] * 255), round(255 * 0.5 * 2 ** (1 / 2.4)))
