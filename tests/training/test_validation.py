"""Validation: fixed views, errors of the spheres as protocol M defines them, and the score made of them."""

import math
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.data.panoramas import PanoramaRecord
from mixlight.image import exr
from mixlight.light.lighting import Lighting
from mixlight.network.heads import Prediction
from mixlight.network.model import MixLightNet, ModelSettings
from mixlight.render.spheres import SphereRenderer
from mixlight.training.validation import SPHERES, ValidationSet, predicted_environments, score_spheres
from tests.synthetic import room

SETTINGS = ModelSettings(height=64, width=64, hidden=16, grid_channels=4)


def store(folder: Path, scene: str, panorama: Tensor, category: str = "indoor") -> PanoramaRecord:
    exr.write(folder / f"{scene}.exr", panorama.numpy(), {})
    return PanoramaRecord(scene, folder / f"{scene}.exr", "val", category, scene)


@pytest.fixture(scope="module")
def network() -> MixLightNet:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        made = MixLightNet(SETTINGS)
    ambient = torch.zeros(9, 3)
    ambient[0] = 2.0
    made.heads.start_from(torch.full((128,), 1 / 128), 0.5, torch.zeros(3), ambient, torch.zeros(2))
    return made


# ------------------------------------------------------------------------------------------------- the errors


def test_even_light_a_tenth_too_dark_costs_a_tenth_of_each_sphere(renderer: SphereRenderer) -> None:
    true = torch.ones(1, 32, 64, 3)
    rmse, si_rmse = score_spheres(renderer, 0.9 * true, true)[0]
    shown = renderer.render(true[0])[:, renderer.mask]
    torch.testing.assert_close(rmse, 0.1 * shown.square().mean((1, 2)).sqrt(), rtol=1e-4, atol=0)
    torch.testing.assert_close(si_rmse, torch.zeros(3), rtol=0, atol=1e-4)


def test_errors_are_those_of_the_pictures(renderer: SphereRenderer) -> None:
    """Against NumPy: over the sphere's pixels and channels, with and without the best single scale."""
    predicted, true = room(32, 1), room(32, 2)
    found = score_spheres(renderer, predicted[None], true[None])[0].numpy()
    mask = renderer.mask.numpy()
    for i in range(len(SPHERES)):
        p, g = (renderer.render(x)[i].numpy()[mask].astype(np.float64).ravel() for x in (predicted, true))
        scale = np.linalg.lstsq(p[:, None], g, rcond=None)[0][0]
        expected = [np.sqrt(np.mean((p - g) ** 2)), np.sqrt(np.mean((scale * p - g) ** 2))]
        np.testing.assert_allclose(found[:, i], expected, rtol=1e-4)


def test_a_prediction_becomes_the_environment_of_its_lighting() -> None:
    generator = torch.Generator().manual_seed(0)
    share = torch.zeros(2, 128)
    share[:, 7] = 1.0
    ambient = torch.randn(2, 9, 3, generator=generator)
    colour = torch.full((2, 3), 3**-0.5)
    light = Prediction(share, share, torch.tensor([1.0, 5.0]), colour, ambient, torch.zeros(2, 2))
    maps = predicted_environments(light, 0.0025, 16)
    for k in range(2):
        expected = Lighting(ambient=ambient[k], energy=light.anchor_energy[k]).environment(16)
        torch.testing.assert_close(maps[k], expected)
    assert float(maps.min()) >= 0


# ---------------------------------------------------------------------------------------------------- the set


def test_real_panoramas_have_eight_views_and_rooms_a_few(tmp_path: Path, renderer: SphereRenderer) -> None:
    records = [store(tmp_path, "a", room(32)), store(tmp_path, "r", room(32, 1), "room")]
    validation = ValidationSet(records, SETTINGS.canonical, 2, renderer)
    assert {kind: len(samples) for kind, samples in validation.samples.items()} == {"real": 8, "rooms": 2}
    assert set(ValidationSet(records, SETTINGS.canonical, 0, renderer).samples) == {"real"}


def test_something_to_validate_on_is_asked_for(tmp_path: Path, renderer: SphereRenderer) -> None:
    for records in ([], [store(tmp_path, "black", torch.zeros(16, 32, 3))]):
        with pytest.raises(ValueError, match="split val and light in it"):
            ValidationSet(records, SETTINGS.canonical, 2, renderer)


def test_metrics_are_medians_and_the_score_a_geometric_mean(
    tmp_path: Path, renderer: SphereRenderer, network: MixLightNet
) -> None:
    records = [store(tmp_path, "a", room(32)), store(tmp_path, "r", room(32, 1), "room")]
    validation = ValidationSet(records, SETTINGS.canonical, 3, renderer)
    before = {key: value.clone() for key, value in network.state_dict().items()}
    found = validation.evaluate(network)
    assert found == validation.evaluate(network)
    assert not network.training
    assert all(torch.equal(before[key], value) for key, value in network.state_dict().items())

    logs = {}
    for kind, samples in validation.samples.items():
        with torch.no_grad():
            light = network(torch.stack([sample.photo for sample in samples]))
        maps = predicted_environments(light, SETTINGS.sharpness)
        cells = score_spheres(renderer, maps, torch.stack([sample.environment for sample in samples])).numpy()
        for i, sphere in enumerate(SPHERES):
            for k, error in enumerate(("rmse", "si_rmse")):
                median = float(torch.from_numpy(cells)[:, k, i].median())
                assert found[f"{kind}/{sphere}/{error}"] == pytest.approx(median, rel=1e-5)
        per_sphere = np.log(cells).mean((0, 1))
        logs[kind] = (per_sphere[0] + per_sphere[1] / 4) / 1.25
        assert found[f"{kind}/score"] == pytest.approx(math.exp(logs[kind]), rel=1e-4)
    # Real panoramas count twice.
    assert found["score"] == pytest.approx(math.exp((2 * logs["real"] + logs["rooms"]) / 3), rel=1e-4)


def test_a_better_light_has_a_lower_score(
    tmp_path: Path, renderer: SphereRenderer, network: MixLightNet
) -> None:
    """Even light: the network that predicts just that is far ahead of the one with stray lamps."""
    validation = ValidationSet(
        [store(tmp_path, "even", torch.full((32, 64, 3), 0.5))], SETTINGS.canonical, 2, renderer
    )
    stray = validation.evaluate(network)["score"]
    with torch.random.fork_rng():
        torch.manual_seed(0)
        good = MixLightNet(SETTINGS)
    torch.nn.init.zeros_(good.heads.outputs.weight)
    ambient = torch.zeros(9, 3)
    ambient[0] = math.sqrt(4 * math.pi)  # radiance 1 in units of the photo's mean
    good.heads.start_from(torch.full((128,), 1 / 128), -8.0, torch.zeros(3), ambient, torch.zeros(2))
    assert validation.evaluate(good)["score"] < stray / 10
