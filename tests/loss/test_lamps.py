"""The objective of free lamps: matching against scipy's, stages, and absent lamps."""

import dataclasses

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from mixlight.light.lamps import Lamps, environment
from mixlight.loss.common import LossWeights
from mixlight.loss.lamps import LampLoss, LampWeights, _pairs, matched_terms

WEIGHTS = LampWeights()
QUIET = LossWeights(spheres=(0.0, 0.0, 0.0), spheres_si=(0.0, 0.0, 0.0))


def some(batch: int = 3, seed: int = 0) -> Lamps:
    generator = torch.Generator().manual_seed(seed)
    return Lamps(
        torch.nn.functional.normalize(torch.randn(batch, 3, 3, generator=generator), dim=-1),
        0.01 + 0.2 * torch.rand(batch, 3, generator=generator),
        torch.rand(batch, 3, 3, generator=generator) + 0.1,
        torch.rand(batch, 3, generator=generator) + 0.1,
    )


@given(seed=st.integers(0, 200))
def test_the_assignment_is_hungarian_matchings(seed: int) -> None:
    predicted, true = some(seed=seed), some(seed=seed + 1000)
    terms = matched_terms(predicted, true, WEIGHTS)
    found = sum(getattr(WEIGHTS, name.removeprefix("lamp_")) * term for name, term in terms.items())
    cost = sum(getattr(WEIGHTS, name) * pair for name, pair in _pairs(predicted, true).items())
    for k in range(3):
        rows, columns = linear_sum_assignment(cost[k].numpy())
        assert float(found[k]) == pytest.approx(float(cost[k].numpy()[rows, columns].mean()), rel=1e-5)


def test_the_order_of_lamps_does_not_matter() -> None:
    predicted, true = some(seed=1), some(seed=2)
    order = [2, 0, 1]
    mixed = Lamps(
        predicted.direction[:, order],
        predicted.sharpness[:, order],
        predicted.energy[:, order],
        predicted.ambient,
    )
    for name, term in matched_terms(predicted, true, WEIGHTS).items():
        torch.testing.assert_close(matched_terms(mixed, true, WEIGHTS)[name], term)


def test_an_absent_lamp_has_no_place() -> None:
    true = some(1)
    true.energy[:, 1] = 0
    elsewhere = true._replace(direction=true.direction.clone())
    elsewhere.direction[:, 1] *= -1
    terms = matched_terms(elsewhere, true, WEIGHTS)
    assert sum(float(term.sum()) for term in terms.values()) == pytest.approx(0, abs=1e-6)


def test_the_true_lamps_cost_nothing_and_others_do() -> None:
    loss = LampLoss(QUIET, WEIGHTS, map_height=16)
    true = some()
    picture, camera = environment(true, 16), torch.zeros(3, 2)
    best, terms = loss(true, camera, true, picture, camera)
    assert float(best) == pytest.approx(0, abs=1e-5)
    assert {
        "lamp_environment",
        "lamp_direction",
        "lamp_size",
        "lamp_intensity",
        "lamp_colour",
    } <= terms.keys()
    worse, _ = loss(some(seed=5), camera, true, picture, camera)
    assert float(worse) > 0.1


def test_the_first_stage_matches_nothing_and_no_scale_matters() -> None:
    loss = LampLoss(QUIET, WEIGHTS, map_height=16)
    true, predicted, camera = some(), some(seed=5), torch.zeros(3, 2)
    picture = environment(true, 16)
    _, terms = loss(predicted, camera, true, picture, camera, progress=0.1)
    assert not {"lamp_direction", "lamp_size"} & terms.keys()
    plain, _ = loss(predicted, camera, true, picture, camera)

    def bright(light: Lamps) -> Lamps:
        return light._replace(energy=8 * light.energy, ambient=8 * light.ambient)

    scaled, _ = loss(bright(predicted), camera, bright(true), 8 * picture, camera)
    torch.testing.assert_close(scaled, plain, rtol=1e-4, atol=0)


def test_gradients_reach_every_part() -> None:
    loss = LampLoss(LossWeights(), WEIGHTS, map_height=16)
    true = some()
    parts = [part.clone().requires_grad_() for part in some(seed=5)]
    loss(Lamps(*parts), torch.zeros(3, 2), true, environment(true, 16), torch.zeros(3, 2))[0].backward()
    for part in parts:
        assert part.grad is not None
        assert bool(part.grad.isfinite().all())
        assert float(part.grad.abs().max()) > 0


@pytest.mark.parametrize(("field", "value"), [("first_stage", 1.5), ("direction", -1.0)])
def test_weights_out_of_range_are_refused(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"expected {field}"):
        dataclasses.replace(WEIGHTS, **{field: value})
