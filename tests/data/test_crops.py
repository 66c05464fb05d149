"""Views see what they should: the calibration card, the mirror, and the frame of a photo."""

import dataclasses
import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.data.crops import (
    ASPECTS,
    Crop,
    CropSettings,
    evaluation_crops,
    frame_mask,
    random_crop,
    take_view,
)
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect
from mixlight.sphere.calibration import CARD_COLOURS, CARD_RADIANCE, calibration_card
from tests.synthetic import room

VIEW = CanonicalView(24, 32)


@pytest.fixture(scope="module")
def card() -> Tensor:
    return calibration_card(64)


def centre(view: Tensor) -> Tensor:
    height, width = view.shape[:2]
    return view[height // 2 - 1 : height // 2 + 1, width // 2 - 1 : width // 2 + 1].mean((0, 1))


@pytest.mark.parametrize(
    ("azimuth", "pitch_deg", "axis"),
    [(0, 0, "-Z"), (1, 0, "+X"), (2, 0, "+Z"), (3, 0, "-X"), (1, 89, "+Y"), (2, -89, "-Y")],
)
def test_a_crop_sees_the_axis_it_looks_along(card: Tensor, azimuth: int, pitch_deg: float, axis: str) -> None:
    view = take_view(card, Crop(azimuth, 4, pitch=math.radians(pitch_deg)), VIEW)
    expected = torch.tensor(CARD_COLOURS[axis]) * CARD_RADIANCE
    torch.testing.assert_close(centre(view), expected, rtol=0, atol=0.4)


def spot(azimuth_deg: float, elevation_deg: float) -> Tensor:
    """A dark panorama with one light, degrees to the right of the centre and above the horizon."""
    panorama = torch.zeros(180, 360, 3)
    panorama[round(90 - elevation_deg), round(180 + azimuth_deg)] = 1.0
    return panorama


@pytest.mark.parametrize(
    ("changes", "row", "column"),
    [
        ({}, 0.5, 0.82),
        ({"mirrored": True}, 0.5, 0.18),
        ({"roll": math.pi / 2}, 0.07, 0.5),  # the camera turns clockwise, its picture's content the other way
        ({"roll": math.pi / 2, "mirrored": True}, 0.07, 0.5),
        ({"pitch": math.radians(10)}, 0.73, 0.82),
        ({"azimuth": 1}, 0.5, 0.5),
    ],
)
def test_where_a_light_to_the_right_is_seen(changes: dict[str, float], row: float, column: float) -> None:
    """20 degrees to the right: at tan(20) / tan(30) = .63 of the half width."""
    crop = dataclasses.replace(Crop(0, 18, pitch=0.0), **changes)
    view = take_view(spot(20.5, 0.5), crop, CanonicalView(96, 128)).sum(-1)
    weight = view / view.sum()
    y = float((weight.sum(1) * (torch.arange(96) + 0.5)).sum() / 96)
    x = float((weight.sum(0) * (torch.arange(128) + 0.5)).sum() / 128)
    assert (y, x) == (pytest.approx(row, abs=0.03), pytest.approx(column, abs=0.02))


@given(
    azimuth=st.integers(0, 31),
    pitch=st.floats(-0.7, 0.3),
    roll=st.floats(-0.2, 0.2),
    fov=st.floats(0.8, 1.3),
)
def test_a_mirrored_crop_is_the_view_of_the_mirrored_panorama(
    azimuth: int, pitch: float, roll: float, fov: float
) -> None:
    panorama = room(32)
    mirrored = take_view(panorama, Crop(azimuth, 32, pitch, roll, fov, mirrored=True), VIEW)
    other = take_view(equirect.mirror(panorama), Crop(-azimuth % 32, 32, pitch, -roll, fov), VIEW)
    torch.testing.assert_close(mirrored, other, rtol=1e-3, atol=1e-2)  # of radiance up to 200


def test_turning_the_panorama_is_turning_the_camera() -> None:
    panorama = room(32)
    turned = equirect.rotate_azimuth(panorama, 2 * math.pi * 5 / 32)
    view, other = take_view(panorama, Crop(5, 32), VIEW), take_view(turned, Crop(0, 32), VIEW)
    torch.testing.assert_close(view, other, rtol=1e-3, atol=1e-2)


def test_evaluation_crops_are_eight_level_photos_of_sixty_degrees() -> None:
    crops = evaluation_crops()
    assert [round(math.degrees(crop.yaw)) for crop in crops] == list(range(0, 360, 45))
    assert {
        (round(math.degrees(c.pitch)), c.roll, round(math.degrees(c.fov)), c.mirrored) for c in crops
    } == {(-8, 0.0, 60, False)}
    for canonical in (CanonicalView(), CanonicalView(192, 256)):
        assert bool(frame_mask(crops[0], canonical).all())


# ------------------------------------------------------------------------------------------------------ frame


@pytest.mark.parametrize(("height", "width"), [(90, 160), (160, 90), (80, 80), (120, 160)])
@pytest.mark.parametrize("fov_deg", [35.0, 60.0, 75.0])
def test_the_frame_is_where_a_photo_of_that_size_would_lie(height: int, width: int, fov_deg: float) -> None:
    """Against the resampling of a photo with that field of view and shape."""
    canonical = CanonicalView(96, 128)
    crop = Crop(0, 8, frame_fov=math.radians(fov_deg), aspect=width / height)
    _, inside = canonical.resample(torch.ones(height, width, 3), math.radians(fov_deg))
    assert torch.equal(frame_mask(crop, canonical), inside)


# ----------------------------------------------------------------------------------------------------- random


@given(seed=st.integers(0, 2**32), frames=st.booleans(), canonical_deg=st.floats(30, 100))
def test_random_views_stay_within_their_bounds(seed: int, frames: bool, canonical_deg: float) -> None:
    settings = CropSettings(frames=frames)
    crop = random_crop(64, settings, np.random.default_rng(seed), math.radians(canonical_deg))
    assert 0 <= crop.azimuth < 64
    assert math.radians(-43) <= crop.pitch <= math.radians(17)
    assert abs(math.log(crop.fov / math.radians(canonical_deg))) < 6 * settings.fov_error
    canonical = CanonicalView(24, 32, math.radians(canonical_deg))
    if frames:
        low, _, high = settings.frame_fov_deg
        assert crop.aspect in ASPECTS
        assert math.radians(low) * 0.7 <= crop.frame_fov <= math.radians(high)
        assert bool(frame_mask(crop, canonical).any())
    else:
        assert bool(frame_mask(crop, canonical).all())


def test_random_views_follow_the_generator_alone() -> None:
    draws = [
        [random_crop(64, CropSettings(), np.random.default_rng(seed)) for seed in (1, 2)] for _ in range(2)
    ]
    assert draws[0] == draws[1]
    assert draws[0][0] != draws[0][1]


def test_half_of_the_random_views_are_mirrored_and_all_azimuths_are_taken() -> None:
    generator = np.random.default_rng(0)
    crops = [random_crop(8, CropSettings(), generator) for _ in range(400)]
    assert 160 < sum(crop.mirrored for crop in crops) < 240
    assert {crop.azimuth for crop in crops} == set(range(8))
    assert abs(np.mean([crop.roll for crop in crops])) < math.radians(0.5)


def test_bounds_without_width_fix_a_value() -> None:
    settings = CropSettings(pitch_deg=(-8, -8, -8), frame_fov_deg=(60, 60, 60), fov_error=0, roll_deg=0)
    crop = random_crop(8, settings, np.random.default_rng(0))
    assert (crop.pitch, crop.roll, crop.fov) == (math.radians(-8), 0, math.radians(60))


@pytest.mark.parametrize(
    "changes",
    [
        {"pitch_deg": (0.0, -8.0, 17.0)},
        {"pitch_deg": (-95.0, -8.0, 17.0)},
        {"frame_fov_deg": (50.0, 60.0, 180.0)},
        {"fov_error": -0.1},
        {"roll_deg": -1.0},
    ],
)
def test_settings_that_cannot_be_are_refused(changes: dict[str, object]) -> None:
    (name,) = changes
    with pytest.raises(ValueError, match=f"expected {name}"):
        CropSettings(**changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"azimuths": 0}, "azimuths"),
        ({"fov": 4.0}, "fov"),
        ({"frame_fov": 0.0}, "frame_fov"),
        ({"aspect": 0.0}, "aspect"),
    ],
)
def test_crops_that_cannot_be_are_refused(changes: dict[str, float], says: str) -> None:
    with pytest.raises(ValueError, match=f"expected .*{says}"):
        dataclasses.replace(Crop(0, 8), **changes)
    with pytest.raises(ValueError, match="azimuths of at least 1"):
        evaluation_crops(0)
