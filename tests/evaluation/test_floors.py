"""Floors and the ceiling: constant guesses, and the truth through its own parameters."""

import math
from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, samples_of
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.floors import oracle_light, photo_mean_light, training_mean_light
from mixlight.image import exr
from mixlight.image.color import srgb_to_linear
from mixlight.light.separate import luminance
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect
from tests.synthetic import room

VIEW = CanonicalView(24, 32)


def store(folder: Path, scene: str, panorama: Tensor) -> PanoramaRecord:
    exr.write(folder / f"{scene}.exr", panorama.numpy(), {})
    return PanoramaRecord(scene, folder / f"{scene}.exr", "train", "indoor", scene)


def mean_luminance(environment: Tensor) -> float:
    return float(luminance(equirect.integrate(environment))) / (4 * math.pi)


def test_the_mean_light_is_the_mean_over_all_views_in_their_exposure(tmp_path: Path) -> None:
    records = [store(tmp_path, f"room{k}", room(32, k)) for k in range(2)]
    environments = torch.stack([s.environment for record in records for s in samples_of(record, VIEW)])
    assert len(environments) == 16
    torch.testing.assert_close(training_mean_light(records, VIEW), environments.mean(0))


def test_the_geometric_mean_has_the_typical_brightness_and_the_mean_shape(tmp_path: Path) -> None:
    records = [store(tmp_path, f"room{k}", room(32, k)) for k in range(2)]
    environments = [s.environment for record in records for s in samples_of(record, VIEW)]
    scales = torch.tensor([mean_luminance(environment) for environment in environments])
    found = training_mean_light(records, VIEW, geometric=True)
    assert mean_luminance(found) == pytest.approx(float(scales.log().mean().exp()), rel=1e-4)
    shape = torch.stack([e / scale for e, scale in zip(environments, scales, strict=True)]).mean(0)
    torch.testing.assert_close(found / mean_luminance(found), shape, rtol=1e-4, atol=1e-5)
    # One bright scene moves the plain mean, and not this one.
    assert mean_luminance(found) <= mean_luminance(training_mean_light(records, VIEW))


def test_something_to_average_is_asked_for(tmp_path: Path) -> None:
    for records in ([], [store(tmp_path, "black", torch.zeros(16, 32, 3))]):
        with pytest.raises(ValueError, match="expected training panoramas with light in them"):
            training_mean_light(records, VIEW)


def test_the_photos_mean_is_constant_light_of_its_linear_colour(tmp_path: Path) -> None:
    sample = next(samples_of(store(tmp_path, "a", room(32)), VIEW))
    found = photo_mean_light(sample)
    assert found.shape == (ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3)
    linear = torch.from_numpy(srgb_to_linear(sample.photo.numpy())).mean((1, 2))
    torch.testing.assert_close(found, linear.expand_as(found))


@pytest.mark.parametrize("separation", ["top_fraction", "max_fraction"])
def test_the_oracle_keeps_the_light_of_a_scene_it_can_hold(tmp_path: Path, separation: str) -> None:
    """Energy within what clamped ambient lobes add, and in the photo's exposure."""
    sample = next(samples_of(store(tmp_path, "a", room(64)), VIEW))
    found = oracle_light(sample, separation)
    assert found.shape == sample.environment.shape
    assert mean_luminance(found) == pytest.approx(mean_luminance(sample.environment), rel=0.03)
    even = store(tmp_path, "even", torch.full((32, 64, 3), 0.7))
    sample = next(samples_of(even, VIEW))
    torch.testing.assert_close(oracle_light(sample, separation), sample.environment, rtol=2e-3, atol=0)
