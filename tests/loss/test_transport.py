"""The Sinkhorn divergence on the sphere against POT, exact transport and finite differences."""

import math

import numpy as np
import ot
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import TypeCheckError

from mixlight.loss.transport import SphericalSinkhorn, pairwise_angle
from mixlight.sphere import points
from tests.tolerances import TOLERANCE

F64 = torch.float64
ANCHORS = points.vogel(128, dtype=F64)
FEW = points.vogel(24, dtype=F64)


def masses(seed: int, *shape: int, count: int = 128, active: int = 8) -> torch.Tensor:
    """Sparse distributions of a few lights of very different strength."""
    generator = torch.Generator().manual_seed(seed)
    mass = torch.zeros(*shape, count, dtype=F64)
    rank = torch.rand(*shape, count, dtype=F64, generator=generator).argsort(-1)[..., :active]
    strength = torch.rand(*shape, active, dtype=F64, generator=generator) ** 4 + 1e-3
    mass.scatter_(-1, rank, strength)
    return mass / mass.sum(-1, keepdim=True)


def pot_divergence(a: torch.Tensor, b: torch.Tensor, cost: torch.Tensor, epsilon: float) -> float:
    """Debiased divergence from POT's plans: <plan, cost> + epsilon KL(plan | a b^T)."""

    def value(x, y):
        used_x, used_y = x > 0, y > 0  # POT wants strictly positive masses
        x, y, c = x[used_x], y[used_y], cost.numpy()[np.ix_(used_x, used_y)]
        plan = ot.sinkhorn(x, y, c, epsilon, method="sinkhorn_log", numItermax=5_000, stopThr=1e-9)
        ratio = np.where(plan > 0, plan, 1) / np.where(plan > 0, np.outer(x, y), 1)
        return (plan * c).sum() + epsilon * (plan * np.log(ratio)).sum()

    a, b = a.numpy(), b.numpy()
    return value(a, b) - value(a, a) / 2 - value(b, b) / 2


class TestGolden:
    def test_single_lights_cost_their_angle(self):
        """To the next anchor .30, to the farthest 3.0: what the method asks for."""
        loss = SphericalSinkhorn(ANCHORS)
        light = torch.eye(128, dtype=F64)
        cost = loss.cost.clone()
        next_one, farthest = (cost[64] + 9 * light[64]).argmin(), cost[64].argmax()
        assert loss(light[64], light[next_one]).item() == pytest.approx(0.30, abs=0.005)
        assert loss(light[64], light[farthest]).item() == pytest.approx(2.96, abs=0.005)
        got = loss(light[64].expand(128, 128), light)
        torch.testing.assert_close(got, cost[64], rtol=1e-8, atol=1e-8)

    def test_reference_pair_of_the_method(self):
        """Somewhere on the spiral a move to the next anchor costs .30 and one to the antipode 3.01."""
        cost = SphericalSinkhorn(ANCHORS).cost
        nearest = (cost + 9 * torch.eye(128)).amin(1)
        farthest = cost.amax(1)
        assert nearest.min() > math.radians(15.7)
        assert nearest.max() < math.radians(17.4)
        assert ((nearest - 0.30).abs() + (farthest - 3.01).abs()).min() < 0.02

    def test_squared_cost(self):
        loss = SphericalSinkhorn(ANCHORS, cost="geodesic2")
        light = torch.eye(128, dtype=F64)
        got = loss(light[3], light[90]).item()
        assert got == pytest.approx(pairwise_angle(ANCHORS)[3, 90].item() ** 2, rel=1e-8)

    def test_pairwise_angle_is_accurate_at_both_ends(self):
        tiny = 1e-9
        x = torch.tensor([[1.0, 0, 0], [math.cos(tiny), math.sin(tiny), 0], [-1, 0, 0]], dtype=F64)
        angle = pairwise_angle(x)
        assert angle[0, 1].item() == pytest.approx(tiny, rel=1e-6)
        assert angle[0, 2].item() == pytest.approx(math.pi, abs=1e-12)
        assert (angle.diagonal() == 0).all()


class TestReference:
    @pytest.mark.parametrize("cost", ["geodesic", "geodesic2"])
    def test_against_pot(self, cost):
        epsilon = 0.3
        loss = SphericalSinkhorn(FEW, cost, epsilon, iterations=100)
        a, b = (0.7 * masses(seed, 2, count=24) + 0.3 / 24 for seed in (1, 2))
        expected = [pot_divergence(x, y, loss.cost, epsilon) for x, y in zip(a, b, strict=True)]
        torch.testing.assert_close(loss(a, b), torch.tensor(expected, dtype=F64), rtol=1e-6, atol=1e-8)

    def test_default_is_converged(self):
        a, b = masses(3, 32), masses(4, 32)
        default, long = SphericalSinkhorn(ANCHORS), SphericalSinkhorn(ANCHORS, iterations=400)
        torch.testing.assert_close(default(a, b), long(a, b), rtol=1e-6, atol=1e-8)

    @pytest.mark.parametrize("epsilon", [0.3, 0.1, 0.07, 0.05, 0.03])
    @pytest.mark.parametrize("active", [2, 5, 24])
    def test_over_relaxation_never_runs_off(self, epsilon, active):
        """Without the guard some of these diverge, which more iterations turn into NaN."""
        a, b = masses(5, 32, count=24, active=active), masses(6, 32, count=24, active=5)
        values = [SphericalSinkhorn(FEW, epsilon=epsilon, iterations=n)(a, b) for n in (32, 300)]
        assert (values[0] - values[1]).abs().max() < 0.02

    def test_small_epsilon_is_plain_transport(self):
        a, b = masses(5, count=24, active=5), masses(6, count=24, active=5)
        exact = ot.emd2(a.numpy(), b.numpy(), pairwise_angle(FEW).numpy())
        errors = [
            exact - SphericalSinkhorn(FEW, epsilon=epsilon, iterations=300)(a, b).item()
            for epsilon in (0.04, 0.02, 0.01)
        ]
        assert errors[0] > errors[1] > errors[2] > 0
        assert errors[2] < 0.01 * exact

    def test_log_domain_path_agrees_with_the_matrix_path(self, monkeypatch):
        a, b = masses(7, 4), masses(8, 4)
        loss = SphericalSinkhorn(ANCHORS)
        fast = loss(a, b)
        monkeypatch.setattr("mixlight.loss.transport._KERNEL_LIMIT", 0.0)
        torch.testing.assert_close(loss(a, b), fast, rtol=1e-9, atol=1e-11)

    def test_tiny_epsilon_stays_finite(self):
        loss = SphericalSinkhorn(FEW, epsilon=1e-3, iterations=20)
        value = loss(masses(9, count=24, active=3), masses(10, count=24, active=3))
        assert torch.isfinite(value)
        assert value > 0


class TestProperties:
    loss = SphericalSinkhorn(ANCHORS)

    @given(st.integers(0, 10_000), st.integers(1, 20), st.integers(1, 20))
    def test_a_divergence(self, seed, active_a, active_b):
        a, b = masses(seed, active=active_a), masses(seed + 1, active=active_b)
        value = self.loss(a, b).item()
        assert value >= -1e-4
        assert value <= math.pi
        assert value == pytest.approx(self.loss(b, a).item(), abs=1e-3)
        assert self.loss(a, a).item() == pytest.approx(0, abs=1e-4)

    @given(st.integers(0, 10_000), st.floats(0.01, 100))
    def test_only_shares_count(self, seed, scale):
        a, b = masses(seed), masses(seed + 1)
        torch.testing.assert_close(self.loss(scale * a, b), self.loss(a, b), rtol=1e-7, atol=1e-9)

    def test_farther_costs_more(self):
        light = torch.eye(128, dtype=F64)
        lamp = masses(11)
        order = self.loss.cost[20].argsort()
        mixed = 0.5 * light + 0.5 * lamp
        values = self.loss(mixed[20].expand(4, 128), mixed[order[[1, 20, 60, 127]]])
        assert (values.diff() > 0).all()

    def test_masses_below_zero_and_none_at_all(self):
        light = torch.eye(128, dtype=F64)
        scores = light[5] - 0.5 * light[9]
        assert self.loss(scores, light[5]).item() == pytest.approx(0, abs=1e-8)
        even = torch.full((128,), 1 / 128, dtype=F64)
        zero = torch.zeros(128, dtype=F64, requires_grad=True)
        value = self.loss(zero, light[5])
        torch.testing.assert_close(value, self.loss(even, light[5]), rtol=1e-8, atol=1e-10)
        value.backward()
        assert torch.isfinite(zero.grad).all()

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, shape):
        a, b = masses(12, *shape), masses(13, *shape)
        got = self.loss(a, b)
        assert got.shape == shape
        last = self.loss(a.reshape(-1, 128)[-1], b.reshape(-1, 128)[-1])
        torch.testing.assert_close(got.flatten()[-1], last, rtol=1e-9, atol=1e-11)

    def test_float32_and_autocast(self):
        a, b = masses(14, 4), masses(15, 4)
        exact = self.loss(a, b)
        single = self.loss(a.float(), b.float())
        assert single.dtype == torch.float32
        torch.testing.assert_close(single.double(), exact, **TOLERANCE[torch.float32])
        with torch.autocast("cpu", torch.bfloat16):
            torch.testing.assert_close(self.loss(a.float(), b.float()), single)

    def test_module_state_is_no_weight(self):
        assert not self.loss.state_dict()
        assert not list(self.loss.parameters())


class TestGradient:
    def test_gradcheck(self):
        """Potentials against finite differences, also at anchors that hold no mass in the truth."""
        loss = SphericalSinkhorn(FEW, epsilon=0.3, iterations=60)
        generator = torch.Generator().manual_seed(1)
        a = (torch.rand(2, 24, dtype=F64, generator=generator) + 0.05).requires_grad_()
        b = masses(16, 2, count=24, active=6)
        assert torch.autograd.gradcheck(lambda x: loss(x, b), (a,), atol=1e-7, rtol=1e-5, fast_mode=True)
        assert torch.autograd.gradcheck(lambda x: loss(b, x), (a,), atol=1e-7, rtol=1e-5, fast_mode=True)

    def test_default_settings_against_finite_differences(self):
        loss = SphericalSinkhorn(ANCHORS)
        a, b = 0.9 * masses(17) + 0.1 / 128, masses(18)
        x = a.clone().requires_grad_()
        loss(x, b).backward()
        precise = SphericalSinkhorn(ANCHORS, iterations=400)
        step = 1e-6
        for anchor in (int(a.argmax()), int(a.argmin()), int(b.argmax())):
            nudge = torch.zeros(128, dtype=F64)
            nudge[anchor] = step
            slope = ((precise(a + nudge, b) - precise(a - nudge, b)) / (2 * step)).item()
            assert x.grad[anchor].item() == pytest.approx(slope, abs=1e-4)

    def test_points_the_light_where_it_belongs(self):
        light = torch.eye(128, dtype=F64)
        scores = (0.9 * light[30] + 0.1 / 128).requires_grad_()
        loss = SphericalSinkhorn(ANCHORS)
        loss(scores, light[70]).backward()
        assert scores.grad.argmin() == 70
        near, far = loss.cost[70].argsort()[[1, 127]]
        assert scores.grad[near] < scores.grad[far]

    def test_no_gradient_into_the_truth_is_needed(self):
        loss = SphericalSinkhorn(FEW)
        b = masses(19, count=24).requires_grad_(False)
        assert not loss(masses(20, count=24), b).requires_grad


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"points": 2 * ANCHORS}, "unit directions"),
            ({"points": ANCHORS, "epsilon": 0.0}, "epsilon > 0"),
            ({"points": ANCHORS, "epsilon": float("nan")}, "epsilon > 0"),
            ({"points": ANCHORS, "iterations": 0}, "iterations >= 1"),
            ({"points": ANCHORS, "cost": "euclidean"}, "cost"),
        ],
    )
    def test_settings(self, arguments, message):
        with pytest.raises((ValueError, TypeCheckError), match=message):
            SphericalSinkhorn(**arguments)

    def test_shapes(self):
        loss = SphericalSinkhorn(FEW)
        with pytest.raises(ValueError, match=r"shape \[..., 24\]"):
            loss(torch.ones(25), torch.ones(25))
