"""The network: settings that come back from a card, and light relative to the photo's mean colour."""

import dataclasses

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.image.color import srgb_to_linear
from mixlight.network import backbones
from mixlight.network.model import MixLightNet, ModelSettings, mean_linear_colour

SETTINGS = ModelSettings(height=64, width=64, hidden=32, grid_channels=8)


@pytest.fixture(scope="module")
def network() -> MixLightNet:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        return MixLightNet(SETTINGS).eval()


def photos(batch: int = 2, seed: int = 0) -> Tensor:
    return torch.rand(batch, 3, 64, 64, generator=torch.Generator().manual_seed(seed))


def test_light_is_the_relative_light_times_the_photos_mean_colour(network: MixLightNet) -> None:
    photo = photos()
    with torch.no_grad():
        relative, mean = network.relative(photo)
        light = network(photo)
    torch.testing.assert_close(light.anchor_energy, relative.anchor_energy * mean[:, None])
    torch.testing.assert_close(light.ambient, relative.ambient * mean[:, None])


def test_a_photo_alone_gives_what_it_gives_in_a_batch(network: MixLightNet) -> None:
    photo = photos(3)
    with torch.no_grad():
        batch = network(photo)
        for k in range(3):
            alone = network(photo[k : k + 1])
            torch.testing.assert_close(alone.ambient[0], batch.ambient[k], rtol=1e-3, atol=1e-4)


@given(st.lists(st.floats(0, 1), min_size=3, max_size=3))
def test_the_mean_colour_is_that_of_linear_light(colour: list[float]) -> None:
    values = np.stack([np.full((5, 7), c, np.float32) for c in colour])
    values[:, 1] = 0.2
    found = mean_linear_colour(torch.from_numpy(values)[None])[0]
    mean = srgb_to_linear(values.astype(np.float64)).mean((1, 2))
    expected = np.maximum(mean, max(0.05 * mean.max(), 1e-3))
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-4)


def test_the_mean_colour_can_always_be_a_unit() -> None:
    assert mean_linear_colour(torch.zeros(1, 3, 4, 4)).tolist() == [[pytest.approx(1e-3)] * 3]
    red = torch.zeros(1, 3, 4, 4)
    red[:, 0] = 1
    assert mean_linear_colour(red)[0].tolist() == pytest.approx([1.0, 0.05, 0.05])


def test_the_mean_colour_is_differentiable() -> None:
    photo = (torch.rand(1, 3, 2, 2, generator=torch.Generator().manual_seed(0)) * 0.8 + 0.1).requires_grad_()
    mean_linear_colour(photo).sum().backward()
    assert photo.grad is not None
    assert bool((photo.grad > 0).all())
    black = torch.zeros(1, 3, 2, 2, requires_grad=True)
    mean_linear_colour(black).sum().backward()
    assert black.grad is not None
    assert bool(black.grad.isfinite().all())


def test_settings_come_back_from_their_card() -> None:
    changed = ModelSettings(height=192, sparse_mode="literal", dropout=0, fov_deg=65)
    assert ModelSettings.from_card(changed.to_card()) == changed
    canonical = changed.canonical
    assert (canonical.height, canonical.width, round(canonical.fov, 3)) == (192, 128, 1.134)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"colour": "red"}, "expected the settings backbone, .*colour$"),
        ({"height": "96"}, "expected int for height, got '96'"),
        ({"height": True}, "expected int for height, got True"),
        ({"height": 96.5}, "expected int for height"),
        ({"height": 0}, "height of at least 1, got 0"),
        ({"fov_deg": 180.0}, r"fov_deg in \(0, 180\), got 180"),
        ({"dropout": 1.0}, "dropout in"),
        ({"sharpness": 0.0}, "sharpness above 0"),
        ({"backbone": "resnet"}, "expected a backbone out of"),
        ({"sparse_mode": "dense"}, "expected a value of sparse_mode out of"),
        ({"sparse_gain": 0}, "sparse_gain above 0"),
    ],
)
@pytest.mark.usefixtures("unchecked")
def test_cards_that_do_not_fit_are_refused(changes: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        ModelSettings.from_card(SETTINGS.to_card() | changes)


def test_a_card_without_a_setting_is_refused() -> None:
    card = SETTINGS.to_card()
    del card["anchors"]
    with pytest.raises(ValueError, match="anchors"):
        ModelSettings.from_card(card)


def test_the_seed_decides_the_untrained_weights() -> None:
    def made() -> MixLightNet:
        with torch.random.fork_rng():
            torch.manual_seed(5)
            return MixLightNet(SETTINGS)

    one, two = made().state_dict(), made().state_dict()
    assert all(torch.equal(one[key], two[key]) for key in one)


def test_pretrained_weights_are_those_of_the_backbone() -> None:
    network = MixLightNet(SETTINGS, pretrained=True)
    expected = backbones.create("efficientnet_lite0").state_dict()
    found = network.backbone.state_dict()
    assert all(torch.equal(found[key], expected[key]) for key in expected)
    with pytest.raises(ValueError, match="densenet121"):
        MixLightNet(dataclasses.replace(SETTINGS, backbone="densenet121"), pretrained=True)
