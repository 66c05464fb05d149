"""Floors: constant guesses, and the photo carried on."""

import math
from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, EvaluationSample, samples_of
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.floors import photo_extended_light, photo_mean_light, training_mean_light
from mixlight.image import exr
from mixlight.image.color import srgb_to_linear
from mixlight.light.separate import luminance
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import camera, equirect
from tests.synthetic import room

VIEW = CanonicalView(24, 32)


def store(folder: Path, scene: str, panorama: Tensor) -> PanoramaRecord:
    exr.write(folder / f"{scene}.exr", panorama.numpy(), {})
    return PanoramaRecord(scene, folder / f"{scene}.exr", "train", "indoor", scene)


def mean_luminance(environment: Tensor) -> float:
    return float(luminance(equirect.integrate(environment))) / (4 * math.pi)


def test_the_mean_light_is_the_mean_over_all_views_in_their_exposure(tmp_path: Path) -> None:
    records = [store(tmp_path, f"room{k}", room(32, k)) for k in range(2)]
    samples = [s for record in records for s in samples_of(record, VIEW)]
    environments = torch.stack([s.environment for s in samples])
    assert len(environments) == 16
    torch.testing.assert_close(training_mean_light(iter(samples)), environments.mean(0))


def test_the_geometric_mean_has_the_typical_brightness_and_the_mean_shape(tmp_path: Path) -> None:
    records = [store(tmp_path, f"room{k}", room(32, k)) for k in range(2)]
    samples = [s for record in records for s in samples_of(record, VIEW)]
    environments = [s.environment for s in samples]
    scales = torch.tensor([mean_luminance(environment) for environment in environments])
    found = training_mean_light(samples, geometric=True)
    assert mean_luminance(found) == pytest.approx(float(scales.log().mean().exp()), rel=1e-4)
    shape = torch.stack([e / scale for e, scale in zip(environments, scales, strict=True)]).mean(0)
    torch.testing.assert_close(found / mean_luminance(found), shape, rtol=1e-4, atol=1e-5)
    # One bright scene moves the plain mean, and not this one.
    assert mean_luminance(found) <= mean_luminance(training_mean_light(samples))


def test_something_to_average_is_asked_for(tmp_path: Path) -> None:
    black = store(tmp_path, "black", torch.zeros(16, 32, 3))
    for samples in ([], samples_of(black, VIEW)):
        with pytest.raises(ValueError, match="expected training panoramas with light in them"):
            training_mean_light(samples)


def test_the_photos_mean_is_constant_light_of_its_linear_colour(tmp_path: Path) -> None:
    sample = next(samples_of(store(tmp_path, "a", room(32)), VIEW))
    found = photo_mean_light(sample)
    assert found.shape == (ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3)
    linear = torch.from_numpy(srgb_to_linear(sample.photo.numpy())).mean((1, 2))
    torch.testing.assert_close(found, linear.expand_as(found))


def test_an_extended_photo_shows_its_pixels_where_it_looks(tmp_path: Path) -> None:
    """Compared with the truth itself: the photo of a scene without highlights is its radiance."""
    x, y, z = equirect.pixel_directions(128).unbind(-1)
    gradient = torch.stack([1 + 0.4 * x, 1 + 0.3 * y, 1 + 0.4 * z], -1)
    sample = next(samples_of(store(tmp_path, "a", gradient), CanonicalView(96, 128)))
    found = photo_extended_light(sample)
    inside = camera.ray_directions(5, 5, 0.8, 0.0, sample.pitch).reshape(-1, 3)
    at = [equirect.sample(light, inside) for light in (found, sample.environment)]
    torch.testing.assert_close(at[0], at[1], rtol=0.02, atol=2e-3)
    # Beyond the right edge it goes on as it is there, not as at the left.
    red = found[64, :, 0]
    assert red[180] > red[128] > red[76]
    low, high = srgb_of(sample).flatten(0, 1).aminmax(dim=0)
    assert bool(((found >= low - 1e-5) & (found <= high + 1e-5)).all())


def test_far_reach_is_the_mean_of_the_photo_and_short_reach_its_rim(tmp_path: Path) -> None:
    sample = next(samples_of(store(tmp_path, "a", room(64)), VIEW))
    behind = photo_extended_light(sample, 1e3)[64, 0]
    mean = srgb_of(sample).mean((0, 1))
    torch.testing.assert_close(behind, mean, rtol=0.15, atol=0.02)  # solid angles differ over the photo
    with pytest.raises(ValueError, match="reach: expected"):
        photo_extended_light(sample, 0.0)


def srgb_of(sample: EvaluationSample) -> Tensor:
    return torch.from_numpy(srgb_to_linear(sample.photo.permute(1, 2, 0).numpy()))
