"""Glow: few sources out of a spread distribution, and not a bit of light lost."""

import math
from dataclasses import fields, replace

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import gaussians, harmonics
from mixlight.light.lighting import Lighting
from mixlight.network.glow import Glow
from mixlight.network.heads import Prediction
from mixlight.network.model import MixLightNet, ModelSettings
from mixlight.network.sparsemax import SLSparsemax
from mixlight.sphere import equirect, points
from tests.tolerances import TOLERANCE

SHARPNESS = 0.0025


def spread(
    batch: int = 2, seed: int = 0, dtype: torch.dtype = torch.float32, power: float = 3.0
) -> Prediction:
    """A light with every anchor lit, some more than others."""
    generator = torch.Generator().manual_seed(seed)
    share = torch.rand(batch, 128, generator=generator, dtype=dtype) ** power + 1e-3
    share = share / share.sum(-1, keepdim=True)
    colour = torch.nn.functional.normalize(
        torch.rand(batch, 3, generator=generator, dtype=dtype) + 0.1, dim=-1
    )
    intensity = torch.rand(batch, generator=generator, dtype=dtype) + 0.5
    ambient = torch.randn(batch, 9, 3, generator=generator, dtype=dtype)
    return Prediction(share, share, intensity, colour, ambient, torch.zeros(batch, 2, dtype=dtype))


def all_harmonics(light: Prediction) -> Tensor:
    """Coefficients of ambient and sources together."""
    lobes = gaussians.to_harmonics(points.vogel(128), light.anchor_energy, SHARPNESS)
    return light.ambient + lobes


@given(gain=st.floats(0.5, 200), seed=st.integers(0, 99), power=st.floats(0.0, 8.0))
def test_all_light_keeps_its_harmonics(gain: float, seed: int, power: float) -> None:
    light = spread(seed=seed, power=power)
    after = Glow(128, SHARPNESS, gain)(light)
    torch.testing.assert_close(all_harmonics(after), all_harmonics(light), rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(after.distribution.sum(-1), torch.ones(2))
    assert bool((after.anchor_energy <= light.anchor_energy * (1 + 1e-5)).all())


def test_a_map_has_the_same_integral_and_irradiance() -> None:
    """The reference is the map itself, not the harmonics that the module computes with."""
    light = spread(1)
    after = Glow(128, SHARPNESS, 20.0)(light)
    maps = [Lighting(x.ambient[0], x.anchor_energy[0], SHARPNESS) for x in (light, after)]
    before_map, after_map = (harmonics.evaluate_map(x.ambient, 64) + x.sources_map(64) for x in maps)
    torch.testing.assert_close(
        equirect.integrate(after_map), equirect.integrate(before_map), rtol=2e-4, atol=1e-4
    )
    torch.testing.assert_close(
        harmonics.project(after_map, 2), harmonics.project(before_map, 2), rtol=1e-2, atol=1e-3
    )


def test_the_sparse_layer_chooses_and_a_source_keeps_its_energy() -> None:
    light = spread(3)
    counts = []
    for gain in (0.01, 3.0, 10.0, 30.0):
        after = Glow(128, SHARPNESS, gain)(light)
        chosen = SLSparsemax(128)(gain * light.scores) > 0
        assert torch.equal(after.distribution > 0, chosen)
        torch.testing.assert_close(after.anchor_energy[chosen], light.anchor_energy[chosen])
        counts.append(int(chosen.sum()))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] == 3 * 128 > counts[-1] >= 3


def test_one_sure_source_stays_as_it_is() -> None:
    one = torch.zeros(1, 128)
    one[0, 7] = 1.0
    light = Prediction(
        one, one, torch.ones(1), torch.full((1, 3), 3**-0.5), torch.zeros(1, 9, 3), torch.zeros(1, 2)
    )
    after = Glow(128, SHARPNESS, 5.0)(light)
    for name in ("distribution", "intensity", "ambient"):
        torch.testing.assert_close(getattr(after, name), getattr(light, name), rtol=0, atol=0)


def test_light_without_sources_stays_without() -> None:
    dark = torch.zeros(1, 128)
    light = Prediction(
        dark, dark, torch.ones(1), torch.full((1, 3), 3**-0.5), torch.ones(1, 9, 3), torch.zeros(1, 2)
    )
    after = Glow(128, SHARPNESS, 5.0)(light)
    assert float(after.anchor_energy.abs().sum()) == 0
    torch.testing.assert_close(after.ambient, light.ambient)


@pytest.mark.parametrize("gain", [0.0, -1.0, math.nan])
def test_a_gain_that_chooses_nothing_is_refused(gain: float) -> None:
    with pytest.raises(ValueError, match="gain above 0"):
        Glow(128, SHARPNESS, gain)
    with pytest.raises(ValueError, match="glow_gain of at least 0") if gain else pytest.MonkeyPatch.context():
        ModelSettings(glow_gain=gain)


def test_gradients_are_those_of_the_light() -> None:
    light = spread(1, dtype=torch.float64)
    glow = Glow(128, SHARPNESS, 10.0)

    def after(intensity: Tensor, ambient: Tensor) -> Tensor:
        result = glow(replace(light, intensity=intensity, ambient=ambient))
        return torch.cat([result.ambient.flatten(), result.anchor_energy.sum((0, 2))[:8]])

    inputs = [x.clone().requires_grad_() for x in (light.intensity, light.ambient)]
    assert torch.autograd.gradcheck(after, inputs)


def test_precision_follows_the_light() -> None:
    light = spread(2)
    double = Prediction(*(getattr(light, field.name).double() for field in fields(Prediction)))
    after, reference = Glow(128, SHARPNESS, 10.0)(double), Glow(128, SHARPNESS, 10.0)(light)
    assert after.ambient.dtype == torch.float64
    torch.testing.assert_close(after.ambient.float(), reference.ambient, **TOLERANCE[torch.float32])


def test_a_network_glows_in_its_result_and_not_in_training() -> None:
    photo = torch.rand(2, 3, 64, 64, generator=torch.Generator().manual_seed(4))
    settings = {"height": 64, "width": 64, "hidden": 16, "grid_channels": 4}
    networks = []
    for gain in (0.0, 30.0):
        with torch.random.fork_rng():
            torch.manual_seed(0)
            networks.append(MixLightNet(ModelSettings(**settings, glow_gain=gain)).eval())  # type: ignore[arg-type]
    plain, glowing = networks
    assert plain.state_dict().keys() == glowing.state_dict().keys()
    with torch.no_grad():
        share = torch.rand(128, generator=torch.Generator().manual_seed(5)) ** 2
        for network in networks:
            network.heads.start_from(
                share / share.sum(), 0.0, torch.zeros(3), torch.ones(9, 3), torch.zeros(2)
            )
        torch.testing.assert_close(
            plain.relative(photo)[0].distribution, glowing.relative(photo)[0].distribution
        )
        before, after = plain(photo), glowing(photo)
    assert int((after.distribution > 0).sum()) < int((before.distribution > 0).sum())
    torch.testing.assert_close(all_harmonics(after), all_harmonics(before), rtol=1e-4, atol=1e-4)


def test_older_cards_have_no_glow() -> None:
    card = ModelSettings().to_card()
    del card["glow_gain"]
    assert ModelSettings.from_card(card) == ModelSettings()
