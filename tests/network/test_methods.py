"""Networks of every method: what they start from, light that scales, and maps against plain sums."""

import math

import pytest
import torch
from jaxtyping import TypeCheckError
from torch import Tensor

from mixlight.light import functions, gaussians, lamps
from mixlight.light.lighting import Lighting
from mixlight.network.expanded_heads import ExpandedHeads, ExpandedLight
from mixlight.network.expansion import expansion_bias, read_expansion
from mixlight.network.heads import LightHeads, Prediction
from mixlight.network.lamp_heads import LampHeads, LampLight
from mixlight.network.methods import create, environments
from mixlight.network.model import MixLightNet
from mixlight.network.settings import Ambient, ModelSettings, Sources
from mixlight.sphere import equirect, points

PAIRS: tuple[tuple[Ambient, Sources], ...] = (
    ("sh2", "anchors"),
    ("sh2", "colours"),
    ("constant", "anchors"),
    ("sg9", "anchors"),
    ("sh2", "sh6"),
    ("sg9", "sh6"),
    ("constant", "lamps"),
)
CHANNELS, GRID = 5, (3, 4)


def settings(ambient: Ambient, sources: Sources) -> ModelSettings:
    return ModelSettings(height=32, width=32, hidden=8, grid_channels=2, ambient=ambient, sources=sources)


def light_of(ambient: Ambient, sources: Sources, batch: int = 2) -> Prediction | ExpandedLight | LampLight:
    """What untrained heads say, with outputs of some size."""
    with torch.random.fork_rng():
        torch.manual_seed(0)
        network = create(settings(ambient, sources)).eval()
        torch.nn.init.normal_(network.heads.outputs.weight, std=0.3)
        features, mean = torch.rand(batch, network.backbone.channels, 3, 4), torch.rand(batch, 3) + 0.1
    with torch.no_grad():
        found: Prediction | ExpandedLight | LampLight = network.heads(features, mean)
    return found


@pytest.mark.parametrize("pair", PAIRS)
def test_maps_are_finite_light_and_linear_in_a_gain(pair: tuple[Ambient, Sources]) -> None:
    light, known = light_of(*pair), settings(*pair)
    plain = environments(light, known, 16)
    assert plain.shape == (2, 16, 32, 3)
    assert float(plain.min()) >= 0
    gain = torch.tensor([[2.0, 0.5, 1.0], [1.0, 3.0, 0.1]])
    bright = environments(light.scaled(gain), known, 16)
    torch.testing.assert_close(bright, plain * gain[:, None, None], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("pair", PAIRS)
def test_parts_add_up_where_nothing_is_clamped(pair: tuple[Ambient, Sources]) -> None:
    light, known = light_of(*pair), settings(*pair)
    whole, ambient, sources = (
        environments(light, known, 16, part) for part in ("whole", "ambient", "sources")
    )
    if pair[1] == "sh6":  # the sum is clamped, not its parts
        assert bool((whole <= ambient + sources + 1e-4).all())
    else:
        torch.testing.assert_close(whole, ambient + sources, rtol=1e-4, atol=1e-5)


def test_maps_of_smooth_gaussians_are_plain_sums() -> None:
    light = light_of("sg9", "anchors")
    assert isinstance(light, Prediction)
    found = environments(light, settings("sg9", "anchors"), 16)
    for k in range(2):
        even = gaussians.evaluate_map(points.vogel(9), light.ambient[k], functions.SMOOTH, 16).clamp(min=0)
        lobes = Lighting(torch.zeros(1, 3), light.anchor_energy[k]).environment(16)
        torch.testing.assert_close(found[k], even + lobes, rtol=1e-4, atol=1e-5)


def test_colours_of_anchors_survive_a_gain() -> None:
    light = light_of("sh2", "colours")
    assert isinstance(light, Prediction)
    assert light.colour.shape == (2, 128, 3)
    gain = torch.tensor([[2.0, 0.5, 1.0], [1.0, 3.0, 0.1]])
    brighter = light.scaled(gain)
    torch.testing.assert_close(
        brighter.anchor_energy, light.anchor_energy * gain[:, None], rtol=1e-4, atol=1e-6
    )
    torch.testing.assert_close(brighter.distribution.sum(-1), torch.ones(2))
    torch.testing.assert_close(brighter.colour.norm(dim=-1), torch.ones(2, 128))


def test_softmax_is_a_distribution_without_a_zero() -> None:
    heads = LightHeads(CHANNELS, GRID, hidden=8, grid_channels=2, sparse_mode="softmax").eval()
    share = torch.rand(128)
    heads.start_from(share / share.sum(), 0.0, torch.zeros(3), torch.ones(9, 3), torch.zeros(2))
    torch.nn.init.zeros_(heads.outputs.weight)
    with torch.no_grad():
        light = heads(torch.rand(1, CHANNELS, 3, 4), torch.ones(1, 3))
    torch.testing.assert_close(light.distribution[0], share / share.sum(), rtol=2e-2, atol=1e-4)
    assert float(light.distribution.detach().min()) > 0


def test_untrained_heads_say_what_they_start_from() -> None:
    features, mean = torch.rand(1, CHANNELS, 3, 4), torch.ones(1, 3)
    expanded = ExpandedHeads(CHANNELS, GRID, hidden=8, grid_channels=2, ambient="sg9").eval()
    torch.nn.init.zeros_(expanded.outputs.weight)
    sources, ambient = torch.rand(49, 3) + 0.1, torch.rand(9, 3) + 0.1
    expanded.start_from(sources, ambient, torch.tensor([0.1, -0.2]))
    said = expanded(features, mean)
    torch.testing.assert_close(said.sources[0], sources)
    torch.testing.assert_close(said.ambient[0], ambient)
    torch.testing.assert_close(said.camera[0], torch.tensor([0.1, -0.2]))

    free = LampHeads(CHANNELS, GRID, hidden=8, grid_channels=2).eval()
    torch.nn.init.zeros_(free.outputs.weight)
    direction = torch.nn.functional.normalize(torch.randn(3, 3), dim=-1)
    size, energy, even = torch.tensor([0.01, 0.1, 0.4]), torch.rand(3, 3) + 0.1, torch.rand(3) + 0.1
    free.start_from(direction, size, energy, even, torch.zeros(2))
    shown = free(features, mean)
    for got, expected in zip(
        (shown.direction, shown.sharpness, shown.energy, shown.ambient),
        (direction, size, energy, even),
        strict=True,
    ):
        torch.testing.assert_close(got[0], expected)


@pytest.mark.parametrize("name", ["constant", "sh2", "sh6", "sg9"])
def test_outputs_and_coefficients_are_each_others_inverse(name: functions.Functions) -> None:
    coefficients = torch.randn(functions.count(name), 3, generator=torch.Generator().manual_seed(0))
    coefficients[0] = 3.0
    read = read_expansion(expansion_bias(coefficients, name)[None], name)[0]
    torch.testing.assert_close(read, coefficients, rtol=1e-5, atol=1e-5)


def test_settings_that_fit_no_method_are_refused() -> None:
    with pytest.raises(ValueError, match="expected constant ambient light around lamps, got 'sh2'"):
        ModelSettings(sources="lamps")
    with pytest.raises(ValueError, match="sources on anchors for a glow_gain"):
        ModelSettings(sources="sh6", glow_gain=20.0)
    with pytest.raises(ValueError, match="expected sources anchors or colours, got 'sh6'"):
        MixLightNet(ModelSettings(sources="sh6"))
    with pytest.raises((ValueError, TypeCheckError), match="part"):
        environments(light_of("sh2", "anchors"), settings("sh2", "anchors"), 8, "half")  # type: ignore[arg-type]


def test_lamps_keep_their_energy_in_the_map() -> None:
    light = light_of("constant", "lamps")
    assert isinstance(light, LampLight)
    total: Tensor = equirect.integrate(lamps.environment(light.lamps(), 32))
    torch.testing.assert_close(total, light.energy.sum(1) + 4 * math.pi * light.ambient, rtol=1e-3, atol=1e-4)
