"""The training objective: each term 0 where it should be, no scale, and only what has a weight."""

import dataclasses
import math
from typing import Any

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light.lighting import Lighting
from mixlight.light.separate import luminance
from mixlight.loss.total import LossWeights, TotalLoss
from mixlight.sphere import equirect

HEIGHT = 8
SHARPNESS = 0.0025
SETTINGS = ("sphere_offset", "transport_form")
OFF = {field.name: 0.0 for field in dataclasses.fields(LossWeights) if field.name not in SETTINGS}
OFF |= {"spheres": (0.0, 0.0, 0.0), "spheres_si": (0.0, 0.0, 0.0)}  # type: ignore[dict-item]
TERMS = set(OFF)


@pytest.fixture(scope="module")
def loss() -> TotalLoss:
    return TotalLoss(LossWeights(), 128, SHARPNESS, HEIGHT)


def truth(batch: int = 2, gain: float = 1.0) -> dict[str, Tensor]:
    """A light that the representation holds, with the map made of it."""
    generator = torch.Generator().manual_seed(0)
    energy = torch.zeros(batch, 128, 3)
    for row in energy:
        chosen = torch.randint(128, (3,), generator=generator)
        shares = torch.rand(3, 1, generator=generator) + 0.2
        row[chosen] = shares * torch.tensor([1.2, 1.0, 0.8])
    ambient = 0.1 * torch.randn(batch, 9, 3, generator=generator)
    ambient[:, 0] = 2.0
    maps = Lighting(ambient=ambient, energy=energy, sharpness=SHARPNESS).environment(HEIGHT)
    camera = torch.tensor([[-0.14, 0.02]]).expand(batch, -1)
    light = {"true_energy": energy * gain, "true_ambient": ambient * gain, "true_map": maps * gain}
    return light | {"true_camera": camera}


def prediction_of(true: dict[str, Tensor]) -> dict[str, Tensor]:
    """The very light as the network would have to say it."""
    total = true["true_energy"].sum(1)
    share = luminance(true["true_energy"])
    share = share / share.sum(-1, keepdim=True).clamp(min=1e-9)
    intensity = total.norm(dim=-1)
    return {
        "scores": share,
        "distribution": share,
        "intensity": intensity.clamp(min=1e-3),
        "colour": total / intensity.clamp(min=1e-9)[:, None],
        "ambient": true["true_ambient"].clone(),
        "camera": true["true_camera"].clone(),
    }


def wrong(predicted: dict[str, Tensor], seed: int = 1) -> dict[str, Tensor]:
    generator = torch.Generator().manual_seed(seed)
    share = torch.rand(predicted["distribution"].shape, generator=generator)
    share = share / share.sum(-1, keepdim=True)
    return predicted | {
        "scores": share,
        "distribution": share,
        "intensity": predicted["intensity"] * 3,
        "colour": predicted["colour"].roll(1, -1),
        "ambient": predicted["ambient"] * 1.5,
        "camera": predicted["camera"] + 0.2,
    }


def test_every_term_is_least_for_the_true_light(loss: TotalLoss) -> None:
    true = truth()
    best, best_terms = loss(**prediction_of(true), **true)
    worse, worse_terms = loss(**wrong(prediction_of(true)), **true)
    assert set(best_terms) == set(worse_terms) == TERMS
    assert float(best) < 0.05 < float(worse)
    for name in TERMS:
        # The spheres' share: a lobe on 8 rows is narrower than a texel, rounding in the transport.
        assert float(best_terms[name]) == pytest.approx(0, abs=2e-2), name
        assert float(worse_terms[name]) > float(best_terms[name]) + 1e-3, name


def test_the_loss_is_the_weighted_sum_of_its_terms(loss: TotalLoss) -> None:
    true = truth()
    value, terms = loss(**wrong(prediction_of(true)), **true)
    expected = sum(
        (1.0 if name.startswith("spheres") else getattr(loss.weights, name)) * float(term)
        for name, term in terms.items()
    )
    assert float(value) == pytest.approx(expected, rel=1e-5)
    assert not any(term.requires_grad for term in terms.values())


@settings(max_examples=8)
@given(exponent=st.integers(-6, 12))
def test_the_loss_knows_no_scale(loss: TotalLoss, exponent: int) -> None:
    """Photo, prediction and truth twice as bright: the same loss, so that bright scenes do not rule."""
    gain = 2.0**exponent
    plain, bright = truth(), truth(gain=gain)
    predicted = wrong(prediction_of(plain))
    scaled = predicted | {"intensity": predicted["intensity"] * gain, "ambient": predicted["ambient"] * gain}
    one, terms = loss(**predicted, **plain)
    other, scaled_terms = loss(**scaled, **bright)
    assert float(other) == pytest.approx(float(one), rel=1e-4)
    for name in TERMS:
        assert float(scaled_terms[name]) == pytest.approx(float(terms[name]), rel=1e-3, abs=1e-5), name


def test_the_unit_may_be_the_photos(loss: TotalLoss) -> None:
    """By default it is the true mean luminance; in a unit of the caller's, the loss knows no scale either."""
    true = truth()
    predicted = wrong(prediction_of(true))
    mean = luminance(equirect.integrate(true["true_map"])) / (4 * math.pi)
    torch.testing.assert_close(loss(**predicted, **true, unit=mean)[0], loss(**predicted, **true)[0])
    scaled = predicted | {"intensity": predicted["intensity"] * 8, "ambient": predicted["ambient"] * 8}
    one, other = (
        loss(**predicted, **true, unit=mean / 3)[0],
        loss(**scaled, **truth(gain=8), unit=mean * 8 / 3)[0],
    )
    torch.testing.assert_close(one, other, rtol=1e-4, atol=0)


def test_a_scene_far_off_does_not_rule_a_batch(loss: TotalLoss) -> None:
    """An intensity a thousand times too high costs some, not a thousand times, more."""
    true = truth()
    predicted = prediction_of(true)
    off = predicted | {"intensity": predicted["intensity"] * torch.tensor([1.0, 1000.0])}
    assert float(loss(**off, **true)[0]) < 100


def test_the_small_map_is_that_of_the_light(loss: TotalLoss) -> None:
    true = truth()
    torch.testing.assert_close(
        loss.environment(true["true_ambient"], true["true_energy"]), true["true_map"], rtol=1e-4, atol=1e-5
    )


@pytest.mark.parametrize("name", sorted(TERMS))
def test_a_term_without_weight_is_left_out(name: str) -> None:
    value: Any = (1.0, 1.0, 1.0) if name.startswith("spheres") else 1.0
    only = TotalLoss(LossWeights(**(OFF | {name: value})), 128, SHARPNESS, HEIGHT)  # type: ignore[arg-type]
    true = truth()
    terms = only(**wrong(prediction_of(true)), **true)[1]
    kept = {"spheres", "spheres_si"} if name.startswith("spheres") else {name}
    assert set(terms) == kept
    assert (only.sphere_loss is None) == (not name.startswith("spheres"))


@pytest.mark.parametrize("black", [False, True])
def test_gradients_are_finite(loss: TotalLoss, black: bool) -> None:
    """Also where the truth has no source at all."""
    true = truth()
    if black:
        true["true_energy"] = torch.zeros_like(true["true_energy"])
    for predicted in (wrong(prediction_of(truth())), prediction_of(truth())):
        inputs = {name: value.clone().requires_grad_() for name, value in predicted.items()}
        value, _ = loss(**inputs, **true)
        value.backward()
        assert math.isfinite(float(value.detach()))
        for name, tensor in inputs.items():
            assert tensor.grad is not None, name
            assert bool(tensor.grad.isfinite().all()), name


def test_a_map_of_another_size_is_refused(loss: TotalLoss, unchecked: None) -> None:
    true = truth()
    true["true_map"] = torch.ones(2, 16, 32, 3)
    with pytest.raises(ValueError, match="expected an environment of shape"):
        loss(**prediction_of(true), **true)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"camera": -1.0}, "expected camera of at least 0, got -1"),
        ({"spheres": (1.0, -1.0, 0.0)}, "expected spheres of at least 0"),
        ({"transport": math.nan}, "expected transport"),
        ({"sphere_offset": 0.0}, "sphere_offset above 0"),
        (OFF, "at least one weight above 0"),
    ],
)
def test_weights_that_cannot_be_are_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        LossWeights(**changes)
