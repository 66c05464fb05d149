"""The losses on P, E and R."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import TypeCheckError

from mixlight.loss import sources
from tests.tolerances import TOLERANCE

F64 = torch.float64
EXACT = TOLERANCE[F64]
VECTOR_LOSSES = [sources.distribution_loss, sources.masked_l1, sources.colour_loss]


def distributions(seed: int, *shape: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    a, b = torch.rand(2, *shape, 3, dtype=F64, generator=generator)
    b = torch.where(b < 0.4, 0.0, b)
    return a, b


class TestGolden:
    def test_distribution(self):
        eye = torch.eye(4)
        assert sources.distribution_loss(eye[0], eye[3]).item() == 2
        assert sources.distribution_loss(eye[0], torch.full((4,), 0.25)).item() == pytest.approx(0.75)

    def test_masked_l1(self):
        true = torch.tensor([0.0, 1.0, 0.0])
        assert sources.masked_l1(torch.tensor([0.1, 0.5, 0.4]), true).item() == pytest.approx(0.5)
        assert sources.masked_l1(torch.tensor([-0.1, 0.5, 0.4]), true).item() == pytest.approx(0.5)

    def test_masked_l1_threshold(self):
        predicted, true = torch.tensor([0.5, 0.5]), torch.tensor([1e-5, 1.0])
        assert sources.masked_l1(predicted, true).item() == 0
        assert sources.masked_l1(predicted, true, threshold=1e-4).item() == 0.5

    def test_intensity_is_a_ratio(self):
        ten, one = torch.tensor(10.0, dtype=F64), torch.tensor(1.0, dtype=F64)
        assert sources.intensity_loss(ten, one).item() == pytest.approx(math.log(10) ** 2)
        assert sources.intensity_loss(one, ten).item() == pytest.approx(math.log(10) ** 2)
        assert sources.intensity_loss(100 * ten, 100 * one).item() == pytest.approx(math.log(10) ** 2)

    def test_intensity_of_no_light_is_finite(self):
        predicted = torch.tensor([0.0, 1.0, 0.0], requires_grad=True)
        loss = sources.intensity_loss(predicted, torch.tensor([0.0, 0.0, 1.0]))
        loss.sum().backward()
        assert loss[0] == 0
        assert torch.isfinite(loss).all()
        assert torch.isfinite(predicted.grad).all()

    def test_colour_is_the_chord(self):
        angle = 0.3
        a = torch.tensor([1.0, 0, 0], dtype=F64)
        b = torch.tensor([math.cos(angle), math.sin(angle), 0], dtype=F64)
        assert sources.colour_loss(a, b).item() == pytest.approx(4 * math.sin(angle / 2) ** 2)


class TestProperties:
    @given(st.integers(0, 10_000))
    def test_zero_only_where_right(self, seed):
        a, b = distributions(seed)
        for loss in VECTOR_LOSSES:
            assert loss(b, b).item() == 0
            assert loss(a, b).item() >= 0

    @given(st.integers(0, 10_000))
    def test_masked_l1_ignores_right_anchors(self, seed):
        a, b = distributions(seed)
        changed = torch.where(b > 0, a + 1, a)
        torch.testing.assert_close(sources.masked_l1(changed, b), sources.masked_l1(a, b), **EXACT)

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, shape):
        a, b = distributions(2, *shape)
        for loss in VECTOR_LOSSES:
            assert loss(a, b).shape == shape
        assert sources.intensity_loss(a[..., 0] + 1, b[..., 0] + 1).shape == shape

    def test_gradcheck(self):
        a, b = distributions(3, 4)
        for loss in VECTOR_LOSSES:
            assert torch.autograd.gradcheck(lambda x, f=loss: f(x, b), (a.requires_grad_(),))
        e = torch.tensor([0.5, 2.0, 300.0], dtype=F64, requires_grad=True)
        assert torch.autograd.gradcheck(lambda x: sources.intensity_loss(x, torch.ones_like(x)), (e,))

    def test_bad_shapes(self):
        with pytest.raises(ValueError, match=r"one shape, got \(3,\) and \(4,\)"):
            sources._same(torch.zeros(3), torch.zeros(4))
        for loss in (sources.distribution_loss, sources.masked_l1, sources.colour_loss):
            with pytest.raises((ValueError, TypeCheckError)):
                loss(torch.zeros(2, 3), torch.zeros(4, 3))


@given(st.integers(1, 20), st.integers(1, 20))
def test_concentration_counts_equal_sources(predicted_count: int, true_count: int) -> None:
    predicted, true = torch.zeros(2, 64)
    predicted[:predicted_count] = 1 / predicted_count
    true[10 : 10 + true_count] = 1 / true_count
    expected = max(0.0, math.log(predicted_count / true_count))
    assert sources.concentration_loss(predicted, true).item() == pytest.approx(expected, abs=1e-5)


def test_concentration_is_differentiable_and_finite_at_zero() -> None:
    predicted = torch.softmax(torch.randn(2, 12, dtype=torch.float64), -1).requires_grad_()
    true = torch.zeros(2, 12, dtype=torch.float64)
    true[:, 0] = 1
    assert torch.autograd.gradcheck(sources.concentration_loss, (predicted, true))
    assert torch.isfinite(sources.concentration_loss(torch.zeros(12), true[0].float()))
