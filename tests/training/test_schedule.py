"""Rates, groups, and what is not trained."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import nn

from mixlight.network.model import MixLightNet, ModelSettings
from mixlight.training.config import OptimiserSettings
from mixlight.training.schedule import freeze, make_optimiser, rate_share, set_rate, set_training_mode


@given(
    steps=st.integers(1, 500),
    warmup=st.integers(0, 100),
    final=st.floats(0, 1),
    data=st.data(),
)
def test_the_rate_rises_to_its_peak_and_falls_to_its_end(
    steps: int, warmup: int, final: float, data: st.DataObject
) -> None:
    settings = OptimiserSettings(warmup_steps=warmup, final_share=final)
    shares = [rate_share(step, steps, settings) for step in range(steps)]
    assert all(0 <= share <= 1 for share in shares)
    rising, falling = shares[:warmup], shares[warmup:]
    assert rising == sorted(rising)
    assert falling == sorted(falling, reverse=True)
    if falling:
        assert falling[0] == 1
        step = data.draw(st.integers(warmup, steps - 1))
        turn = math.pi * (step - warmup) / (steps - warmup)
        assert shares[step] == pytest.approx(final + (1 - final) * (1 + math.cos(turn)) / 2)
    assert rate_share(steps, steps, settings) == pytest.approx(final) or warmup >= steps


@pytest.fixture
def model() -> MixLightNet:
    return MixLightNet(ModelSettings(height=64, width=64, hidden=16, grid_channels=4))


def test_groups_are_backbone_and_heads_with_and_without_decay(model: MixLightNet) -> None:
    settings = OptimiserSettings(learning_rate=0.1, backbone_rate=0.01, weight_decay=0.2)
    optimiser = make_optimiser(model, settings)
    assert isinstance(optimiser, torch.optim.AdamW)
    assert isinstance(make_optimiser(model, OptimiserSettings(name="adam")), torch.optim.Adam)
    found = [
        (g["peak"], g["weight_decay"], {p.ndim > 1 for p in g["params"]}) for g in optimiser.param_groups
    ]
    assert found == [(0.01, 0.2, {True}), (0.01, 0.0, {False}), (0.1, 0.2, {True}), (0.1, 0.0, {False})]
    held = [id(p) for g in optimiser.param_groups for p in g["params"]]
    assert sorted(held) == sorted(id(p) for p in model.parameters())
    set_rate(optimiser, 0.5)
    assert [g["lr"] for g in optimiser.param_groups] == [0.005, 0.005, 0.05, 0.05]


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_frozen_layers_are_the_first_ones_and_not_in_the_optimiser(model: MixLightNet, share: float) -> None:
    settings = OptimiserSettings(frozen_share=share)
    freeze(model, settings)
    trained = [p.requires_grad for p in model.backbone.parameters()]
    assert trained == sorted(trained)
    assert trained.count(False) == round(share * len(trained))
    held = {id(p) for g in make_optimiser(model, settings).param_groups for p in g["params"]}
    assert held == {id(p) for p in model.parameters() if p.requires_grad}


@pytest.mark.parametrize("frozen", [True, False])
def test_training_mode_keeps_the_statistics_where_it_should(model: MixLightNet, frozen: bool) -> None:
    model.eval()
    set_training_mode(model, OptimiserSettings(freeze_norms=frozen))
    norms = [m for m in model.backbone.modules() if isinstance(m, nn.BatchNorm2d)]
    assert norms
    assert {m.training for m in norms} == {not frozen}
    assert model.heads.training
    before = norms[0].running_mean.clone()
    model(torch.rand(2, 3, 64, 64, generator=torch.Generator().manual_seed(0)))
    assert torch.equal(norms[0].running_mean, before) is frozen
