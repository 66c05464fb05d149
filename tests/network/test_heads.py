"""Heads: shapes, what an untrained network says, positive light, and linearity."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.network.heads import LightHeads, Prediction
from mixlight.network.sparsemax import MODES
from tests.tolerances import TOLERANCE

CHANNELS = 10


def heads(**options: object) -> LightHeads:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        made = LightHeads(CHANNELS, (3, 4), hidden=16, grid_channels=4, **options)  # type: ignore[arg-type]
    return made.eval()


@torch.no_grad()
def predict(made: LightHeads, batch: int = 2, scale: float = 1.0) -> Prediction:
    generator = torch.Generator().manual_seed(1)
    features = scale * torch.randn(batch, CHANNELS, 3, 4, generator=generator)
    return made(features, torch.rand(batch, 3, generator=generator) + 0.1)


def prediction(batch: int = 2, dtype: torch.dtype = torch.float64) -> Prediction:
    generator = torch.Generator().manual_seed(2)
    r = torch.rand(batch, 3 + 128 + 27 + 2 + 1, generator=generator, dtype=dtype) + 0.05
    share = r[:, :128] / r[:, :128].sum(1, keepdim=True)
    colour = torch.nn.functional.normalize(r[:, 128:131], dim=-1)
    return Prediction(share, share, r[:, 131] * 9, colour, r[:, 132:159].view(-1, 9, 3), r[:, 159:161])


@pytest.mark.parametrize("mode", MODES)
def test_light_is_complete_finite_and_never_negative(mode: str) -> None:
    for scale in (1.0, 1e4):
        light = predict(heads(sparse_mode=mode), batch=3, scale=scale)
        assert light.scores.shape == light.distribution.shape == (3, 128)
        assert light.ambient.shape == (3, 9, 3)
        assert light.camera.shape == (3, 2)
        assert bool(torch.isfinite(light.anchor_energy).all())
        assert float(light.anchor_energy.min()) >= 0
        assert float(light.intensity.min()) > 0
        assert float(light.ambient[:, 0].min()) > 0
        torch.testing.assert_close(light.colour.norm(dim=-1), torch.ones(3))
        if mode in ("masked", "sparsemax"):
            torch.testing.assert_close(light.distribution.sum(-1), torch.ones(3))


def test_an_untrained_network_says_what_it_starts_from() -> None:
    made = heads()
    torch.nn.init.zeros_(made.outputs.weight)
    distribution = torch.zeros(128)
    distribution[torch.tensor([3, 40])] = torch.tensor([0.75, 0.25])
    ambient = torch.linspace(0.2, 2.0, 27).view(9, 3)
    made.start_from(
        distribution, math.log(7.0), torch.tensor([0.4, 0.1, -0.2]), ambient, torch.tensor([-0.1, 0.02])
    )
    light = predict(made)
    for found, expected in (
        (light.distribution, distribution),
        (light.intensity, torch.tensor(7.0)),
        (light.ambient, ambient),
        (light.camera, torch.tensor([-0.1, 0.02])),
    ):
        torch.testing.assert_close(found, expected.expand_as(found), **TOLERANCE[torch.float32])
    ratio = light.colour[0] / light.colour[0, 1]
    torch.testing.assert_close(ratio, torch.tensor([0.4, 0.1, -0.2]).sub(0.1).exp())


@given(gains=st.lists(st.floats(1e-4, 1e4), min_size=6, max_size=6))
def test_light_times_a_gain_is_light_times_a_gain(gains: list[float]) -> None:
    light, gain = prediction(), torch.tensor(gains, dtype=torch.float64).view(2, 3)
    scaled = light.scaled(gain)
    torch.testing.assert_close(scaled.anchor_energy, light.anchor_energy * gain[:, None], rtol=1e-10, atol=0)
    assert torch.equal(scaled.ambient, light.ambient * gain[:, None])
    torch.testing.assert_close(scaled.colour.norm(dim=-1), torch.ones(2, dtype=torch.float64))
    for name in ("scores", "distribution", "camera"):
        assert torch.equal(getattr(scaled, name), getattr(light, name))


def test_gains_follow_one_another() -> None:
    light = prediction()
    one, two = torch.tensor([[0.5, 1.0, 3.0]] * 2).double(), torch.tensor([[2.0, 0.1, 1.0]] * 2).double()
    torch.testing.assert_close(
        light.scaled(one).scaled(two).anchor_energy, light.scaled(one * two).anchor_energy
    )


def test_scaling_is_differentiable() -> None:
    def energy(intensity: Tensor, gain: Tensor) -> Tensor:
        light = prediction(1)
        light = Prediction(
            light.scores, light.distribution, intensity, light.colour, light.ambient, light.camera
        )
        return light.scaled(gain).anchor_energy[:, :4]

    inputs = [torch.tensor([2.0], dtype=torch.float64), torch.tensor([[0.5, 1.0, 2.0]], dtype=torch.float64)]
    assert torch.autograd.gradcheck(energy, [value.requires_grad_() for value in inputs])


def test_a_gain_before_the_sparse_layer_keeps_fewer_anchors() -> None:
    generator = torch.Generator().manual_seed(3)
    spread = torch.rand(128, generator=generator)
    counts = []
    for gain in (1.0, 3.0):
        made = heads(sparse_gain=gain)
        torch.nn.init.zeros_(made.outputs.weight)
        made.start_from(spread / spread.sum(), 0.0, torch.zeros(3), torch.ones(9, 3), torch.zeros(2))
        light = predict(made)
        counts.append(int((light.distribution[0] > 0).sum()))
        torch.testing.assert_close(light.distribution.sum(-1), torch.ones(2))
        torch.testing.assert_close(light.scores[0], spread / spread.sum())
    assert counts[0] == 128 > counts[1]


def test_gradients_reach_every_parameter() -> None:
    made = heads(dropout=0.0)
    light = made(torch.randn(2, CHANNELS, 3, 4, generator=torch.Generator().manual_seed(1)), torch.ones(2, 3))
    parts = [light.scores, light.distribution, light.intensity, light.colour, light.ambient, light.camera]
    sum(part.square().sum() for part in parts).backward()
    assert {name for name, p in made.named_parameters() if p.grad is None or not bool(p.grad.any())} == set()


def test_moving_keeps_every_part() -> None:
    light = prediction().to("cpu")
    assert torch.equal(light.anchor_energy, prediction().anchor_energy)


def test_an_unknown_sparse_mode_is_refused() -> None:
    with pytest.raises(Exception, match="dense"):
        heads(sparse_mode="dense")
