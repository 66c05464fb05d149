"""From a photo to its light: scale, shapes of photos, and what is refused."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from mixlight.image.color import linear_to_srgb
from mixlight.network import weights
from mixlight.network.estimator import Estimate, Estimator, to_lighting
from mixlight.network.heads import Prediction
from mixlight.network.model import MixLightNet, ModelSettings
from mixlight.network.weights import WeightsError

SETTINGS = ModelSettings(height=64, width=64, hidden=32, grid_channels=8)
CARD = {"kind": "mixlight", "name": "untrained", "settings": SETTINGS.to_card()}
FOV = math.radians(60)


def network(same_for_all: bool = False) -> MixLightNet:
    """Untrained; `same_for_all` ignores what the photo shows, so that its light is the photo's mean alone."""
    with torch.random.fork_rng():
        torch.manual_seed(0)
        made = MixLightNet(SETTINGS)
    distribution = torch.zeros(128)
    distribution[torch.tensor([20, 60])] = torch.tensor([0.7, 0.3])
    ambient = torch.zeros(9, 3)
    ambient[0], ambient[1] = 1.5, 0.3
    made.heads.start_from(distribution, 0.5, torch.zeros(3), ambient, torch.tensor([-0.14, 0.02]))
    if same_for_all:
        torch.nn.init.zeros_(made.heads.outputs.weight)
    return made


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return Estimator(network(), CARD)


@pytest.fixture(scope="module")
def blind() -> Estimator:
    return Estimator(network(same_for_all=True), CARD)


def photo(height: int = 96, width: int = 128, seed: int = 0) -> Tensor:
    """Linear, from .05 to .5, soft."""
    generator = torch.Generator().manual_seed(seed)
    coarse = torch.rand(1, 3, 3, 4, generator=generator) * 0.45 + 0.05
    return torch.nn.functional.interpolate(coarse, (height, width), mode="bilinear")[0].permute(1, 2, 0)


def total(estimate: Estimate) -> Tensor:
    return estimate.lighting.total_energy()


# ------------------------------------------------------------------------------------------------------ scale


@settings(max_examples=10)
@given(gain=st.floats(0.1, 2.0))
def test_light_follows_the_photos_exposure_exactly_where_the_relative_light_is_the_same(
    blind: Estimator, gain: float
) -> None:
    """Twice as bright a photo, unclipped, has twice the light: the unit is the photo's mean linear colour."""
    one, other = blind.estimate(photo(), FOV), blind.estimate(photo() * gain, FOV)
    torch.testing.assert_close(other.lighting.energy, one.lighting.energy * gain, rtol=1e-4, atol=0)
    torch.testing.assert_close(other.lighting.ambient, one.lighting.ambient * gain, rtol=1e-4, atol=0)


def test_light_follows_the_photos_white_balance(blind: Estimator) -> None:
    gain = torch.tensor([1.5, 1.0, 0.6])
    one, other = blind.estimate(photo(), FOV), blind.estimate(photo() * gain, FOV)
    torch.testing.assert_close(total(other), total(one) * gain, rtol=1e-4, atol=0)


def test_a_network_that_looks_follows_the_exposure_about(estimator: Estimator) -> None:
    """Its relative light may move with the brightness of the picture, its unit moves exactly."""
    one, other = estimator.estimate(photo(), FOV), estimator.estimate(photo() * 2, FOV)
    ratio = total(other) / total(one)
    assert bool(((ratio > 1.5) & (ratio < 2.7)).all())


def test_a_linear_file_and_its_photo_give_one_light(estimator: Estimator) -> None:
    """What is above white is clipped before the photo is reduced, as in the photo's own file."""
    bright = photo()
    bright[10:14, 20:24] = 300.0
    linear, clipped = estimator.estimate(bright, FOV), estimator.estimate(bright.clamp(max=1), FOV)
    assert torch.equal(linear.lighting.energy, clipped.lighting.energy)
    assert torch.equal(linear.lighting.ambient, clipped.lighting.ambient)
    assert float(linear.view.max()) <= 1


# ------------------------------------------------------------------------------------------- shapes of photos


@pytest.mark.parametrize(
    ("height", "width", "fov_deg"),
    [(96, 128, 60), (300, 200, 45), (90, 400, 100), (64, 64, 20), (120, 160, 120)],
)
def test_any_photo_gives_light_in_the_same_frame(
    estimator: Estimator, height: int, width: int, fov_deg: float
) -> None:
    found = estimator.estimate(photo(height, width), math.radians(fov_deg))
    assert found.view.shape == (64, 64, 3)
    assert found.lighting.ambient.shape == (9, 3)
    assert found.lighting.energy.shape == (128, 3)
    assert (found.lighting.frame, found.lighting.sharpness) == ("mixlight", SETTINGS.sharpness)
    assert found.lighting.environment(16).shape == (16, 32, 3)
    assert (found.pitch, found.roll) == (pytest.approx(-0.14, abs=0.2), pytest.approx(0.02, abs=0.2))


@pytest.mark.parametrize(("height", "width", "fov_deg"), [(216, 384, 90), (384, 216, 60), (300, 300, 75)])
def test_the_light_does_not_depend_on_what_the_view_does_not_show(
    estimator: Estimator, height: int, width: int, fov_deg: float
) -> None:
    """A photo wider than the view and the same photo cut to it."""
    whole = photo(height, width)
    half = round(width * math.tan(FOV / 2) / math.tan(math.radians(fov_deg) / 2) / 2) + 8
    cut = whole[:, max(0, width // 2 - half) : width // 2 + half]
    fov = 2 * math.atan(math.tan(math.radians(fov_deg) / 2) * cut.shape[1] / width)
    one, other = estimator.estimate(whole, math.radians(fov_deg)), estimator.estimate(cut, fov)
    torch.testing.assert_close(one.view, other.view, rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(total(one), total(other), rtol=1e-3, atol=0)


def test_a_batch_of_views_gives_each_its_own_light(estimator: Estimator) -> None:
    views = torch.stack([estimator.view(photo(seed=seed), FOV) for seed in range(3)])
    for k, found in enumerate(estimator.estimate_views(views)):
        alone = estimator.estimate(photo(seed=k), FOV)
        torch.testing.assert_close(total(found), total(alone), rtol=1e-3, atol=0)
        assert torch.equal(found.view, views[k])


def test_the_network_sees_the_view_srgb_encoded(blind: Estimator, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Tensor] = []
    relative = blind.model.relative
    monkeypatch.setattr(blind.model, "relative", lambda picture: seen.append(picture) or relative(picture))
    found = blind.estimate(photo(), FOV)
    expected = torch.from_numpy(linear_to_srgb(found.view.numpy())).permute(2, 0, 1)
    torch.testing.assert_close(seen[0][0], expected)


# -------------------------------------------------------------------------------------------------- bad input


def test_a_black_view_is_refused(estimator: Estimator) -> None:
    with pytest.raises(ValueError, match=r"all-black view"):
        estimator.estimate(torch.zeros(64, 64, 3), FOV)
    views = torch.stack([estimator.view(photo(), FOV), torch.zeros(64, 64, 3)])
    with pytest.raises(ValueError, match=r"all-black view \(number 1\)"):
        estimator.estimate_views(views)
    rim = torch.zeros(120, 160, 3)
    rim[:, :8] = 1.0  # light only where the view does not reach
    with pytest.raises(ValueError, match="all-black"):
        estimator.estimate(rim, math.radians(120))


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.1])
def test_values_that_are_no_light_are_refused(estimator: Estimator, value: float) -> None:
    bad = photo()
    bad[3, 4, 1] = value
    with pytest.raises(ValueError, match="finite values of at least 0"):
        estimator.estimate(bad, FOV)
    if value > 0 or value != value:
        with pytest.raises(ValueError, match="finite values"):
            estimator.estimate_views(bad[None, :64, :64])


@pytest.mark.parametrize("fov", [0.0, math.pi, -1.0, math.nan])
def test_impossible_fields_of_view_are_refused(estimator: Estimator, fov: float) -> None:
    with pytest.raises(ValueError, match="field of view"):
        estimator.estimate(photo(), fov)


def test_views_of_another_size_are_refused(estimator: Estimator) -> None:
    with pytest.raises(ValueError, match=r"expected views of 64 x 64, got \(32, 64\)"):
        estimator.estimate_views(torch.ones(1, 32, 64, 3))


# ---------------------------------------------------------------------------------------------------- loading


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("weights") / "model.safetensors"
    weights.save(path, network().state_dict(), CARD)
    return path


def test_stored_weights_give_the_same_light(estimator: Estimator, stored: Path) -> None:
    loaded = Estimator.load(stored)
    assert loaded.card["name"] == "untrained"
    assert not loaded.model.training
    one, other = loaded.estimate(photo(), FOV), estimator.estimate(photo(), FOV)
    # Loading folds the normalisation into the kernels, which rounds differently.
    torch.testing.assert_close(one.lighting.ambient, other.lighting.ambient, rtol=1e-4, atol=1e-5)
    torch.testing.assert_close(one.lighting.energy, other.lighting.energy, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"kind": "backbone"},
            "expected weights of a MixLight model with its settings on the card, got kind 'back",
        ),
        ({"settings": None}, "expected weights of a MixLight model"),
        ({"settings": SETTINGS.to_card() | {"colour": 1}}, "settings on the card: .*colour"),
        (
            {"settings": SETTINGS.to_card() | {"height": "tall"}},
            "settings on the card: expected int for height",
        ),
        (
            {"settings": SETTINGS.to_card() | {"hidden": 16}},
            "expected the weights of MixLightNet|should be|but is",
        ),
    ],
)
def test_foreign_weights_are_refused_by_name(
    stored: Path, tmp_path: Path, changes: dict[str, Any], says: str
) -> None:
    path = tmp_path / "foreign.safetensors"
    weights.save(path, weights.load(stored)[0], CARD | changes)
    with pytest.raises(WeightsError, match=says) as caught:
        Estimator.load(path)
    assert "foreign.safetensors" in str(caught.value)


def test_unknown_and_missing_weights_are_refused(tmp_path: Path) -> None:
    with pytest.raises(WeightsError, match="unknown model 'nobody'"):
        Estimator.load("nobody")
    with pytest.raises(WeightsError, match=r"gone\.safetensors"):
        Estimator.load(tmp_path / "gone.safetensors")


# -------------------------------------------------------------------------------------------------- lightings


def test_anchors_with_next_to_no_light_are_switched_off() -> None:
    share = torch.zeros(1, 128)
    share[0, :3] = torch.tensor([0.9, 0.09995, 0.00005])
    light = Prediction(
        share,
        share,
        torch.tensor([2.0]),
        torch.tensor([[0.6, 0.64, 0.48]]),
        torch.ones(1, 9, 3),
        torch.zeros(1, 2),
    )
    (lighting,) = to_lighting(light, 0.01)
    assert lighting.sharpness == 0.01
    assert lighting.energy.any(-1).nonzero().flatten().tolist() == [0, 1]
    torch.testing.assert_close(lighting.energy[0], torch.tensor([1.08, 1.152, 0.864]))
    assert torch.equal(lighting.ambient, torch.ones(9, 3))


def test_a_network_without_a_sparse_layer_gives_light_too() -> None:
    made = MixLightNet(dataclasses.replace(SETTINGS, sparse_mode="none"))
    found = Estimator(made, CARD).estimate(photo(), FOV)
    assert float(found.lighting.energy.min()) >= 0
