"""sRGB on tensors against the NumPy functions that photos are read with."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.image.color import linear_to_srgb, srgb_to_linear
from mixlight.network.srgb import decode, encode
from tests.tolerances import TOLERANCE


@pytest.mark.parametrize("shape", [(), (2,), (1, 2, 3)])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_agrees_with_numpy(shape: tuple[int, ...], dtype: torch.dtype) -> None:
    values = torch.rand(shape, dtype=dtype, generator=torch.Generator().manual_seed(0))
    for ours, theirs in ((encode, linear_to_srgb), (decode, srgb_to_linear)):
        expected = torch.from_numpy(np.asarray(theirs(values.numpy())))
        torch.testing.assert_close(ours(values), expected, **TOLERANCE[dtype])


@given(st.floats(0, 1))
def test_there_and_back(value: float) -> None:
    there = encode(torch.tensor(value, dtype=torch.float64))
    assert decode(there).item() == pytest.approx(value, abs=1e-7)
    assert 0 <= there.item() <= 1


def test_gradients_are_finite_at_black() -> None:
    for function in (encode, decode):
        black = torch.zeros(2, dtype=torch.float64, requires_grad=True)
        function(black).sum().backward()
        assert bool(black.grad.isfinite().all())
        away = torch.tensor([0.2, 0.9], dtype=torch.float64, requires_grad=True)
        assert torch.autograd.gradcheck(function, (away,))
