"""What the random camera does to light: linear gains that the labels share, and each part of it alone."""

import dataclasses

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.data.camera_model import (
    PLAIN,
    CameraSettings,
    Exposed,
    exposure_gain,
    fill_outside,
    plain_photo,
    random_photo,
    usable_gain,
)
from mixlight.image.color import linear_to_srgb, srgb_to_linear
from mixlight.light.separate import luminance

ALL = torch.ones(24, 32, dtype=torch.bool)
EIGHT_BITS = 0.5 / 255


def scene(seed: int = 0, contrast: float = 1.0) -> Tensor:
    """[24, 32, 3] radiance around 1 with soft structure and a few highlights."""
    generator = torch.Generator().manual_seed(seed)
    coarse = torch.randn(1, 3, 4, 5, generator=generator) * contrast
    smooth = torch.nn.functional.interpolate(coarse, (24, 32), mode="bilinear")[0].permute(1, 2, 0).exp()
    return smooth + 20 * (torch.rand(24, 32, 1, generator=generator) > 0.99)


def shoot(view: Tensor, seed: int = 0, inside: Tensor = ALL, **parts: float) -> Exposed:
    """A random photo in which only the named parts of the camera vary."""
    exposed = random_photo(view, inside, dataclasses.replace(PLAIN, **parts), np.random.default_rng(seed))
    assert exposed is not None
    return exposed


def decoded(photo: Tensor) -> Tensor:
    return torch.from_numpy(srgb_to_linear(photo.numpy()))


# --------------------------------------------------------------------------------------------------- exposure


@given(seed=st.integers(0, 100), gain=st.floats(1e-4, 1e4))
def test_the_exposure_puts_the_median_at_middle_gray_whatever_the_scale(seed: int, gain: float) -> None:
    view = scene(seed) * gain
    found = exposure_gain(view, ALL)
    assert float(luminance(view * found).median()) == pytest.approx(0.18, rel=1e-5)
    assert found * gain == pytest.approx(exposure_gain(scene(seed), ALL), rel=1e-5)


def test_the_exposure_looks_at_the_frame_alone() -> None:
    view, inside = scene(), ALL.clone()
    inside[:, 20:] = False
    dark = torch.where(inside[..., None], view, 1e-6)
    assert exposure_gain(dark, inside) == exposure_gain(view, inside) != exposure_gain(view, ALL)
    with pytest.raises(ValueError, match="pixel inside"):
        exposure_gain(view, torch.zeros_like(ALL))


def test_a_view_that_is_black_by_more_than_half_has_gain_one() -> None:
    view = torch.zeros(24, 32, 3)
    assert exposure_gain(view, ALL) == 1.0
    view[:11] = 5.0
    assert exposure_gain(view, ALL) == 1.0


@pytest.mark.parametrize(("gain", "usable"), [(0.0201, True), (49.9, True), (0.0199, False), (50.1, False)])
def test_gains_beyond_fifty_are_not_usable(gain: float, usable: bool) -> None:
    assert usable_gain(gain) is usable
    view = torch.full((24, 32, 3), 0.18 / gain)
    assert (random_photo(view, ALL, PLAIN, np.random.default_rng(0)) is not None) is usable


# ------------------------------------------------------------------------------------------------ plain photo


def test_a_plain_photo_is_gain_times_radiance_in_eight_bits_clipped_at_white() -> None:
    view = scene()
    gain = exposure_gain(view, ALL)
    photo, gains = plain_photo(view, ALL, gain).photo, plain_photo(view, ALL, gain).gain
    expected = torch.from_numpy(linear_to_srgb((view * gain).clamp(max=1).numpy()))
    torch.testing.assert_close(photo, expected, rtol=0, atol=EIGHT_BITS + 1e-6)
    torch.testing.assert_close(photo * 255, (photo * 255).round(), rtol=0, atol=1e-4)
    assert gains.tolist() == pytest.approx([gain] * 3)
    assert float(photo.max()) == 1.0


@given(seed=st.integers(0, 1000))
def test_without_variation_the_random_camera_is_the_plain_one(seed: int) -> None:
    view = scene(seed)
    random, plain = shoot(view, seed), plain_photo(view, ALL, exposure_gain(view, ALL))
    torch.testing.assert_close(random.photo, plain.photo, rtol=0, atol=1e-6)
    torch.testing.assert_close(random.gain, plain.gain)


def test_outside_the_frame_lies_the_mean_colour_in_linear_light() -> None:
    inside = ALL.clone()
    inside[:6] = False
    photo = torch.rand(24, 32, 3, generator=torch.Generator().manual_seed(0))
    filled = fill_outside(photo, inside)
    assert torch.equal(filled[6:], photo[6:])
    expected = decoded(photo[6:]).mean((0, 1))
    torch.testing.assert_close(decoded(filled[:6]), expected.expand(6, 32, 3), rtol=1e-5, atol=1e-6)
    assert fill_outside(photo, ALL) is photo
    with pytest.raises(ValueError, match="pixel inside"):
        fill_outside(photo, torch.zeros_like(ALL))


# ---------------------------------------------------------------------------------------------- random camera


def test_a_photo_follows_its_generator_alone() -> None:
    view = scene()
    photos = [random_photo(view, ALL, CameraSettings(), np.random.default_rng(seed)) for seed in (3, 3, 4)]
    assert all(photo is not None for photo in photos)
    first, again, other = (photo for photo in photos if photo is not None)
    assert torch.equal(first.photo, again.photo)
    assert torch.equal(first.gain, again.gain)
    assert not torch.equal(first.photo, other.photo)


@given(seed=st.integers(0, 1000))
def test_exposure_and_white_balance_are_the_gain_of_the_labels(seed: int) -> None:
    """What is not clipped in the photo is radiance times the gain that the labels get."""
    view = scene(seed, contrast=0.5)
    exposed = shoot(view, seed, exposure_ev=0.5, white_balance=0.2, highlight_rule=0.5)
    expected = (view * exposed.gain).clamp(max=1)
    steps = (exposed.photo - torch.from_numpy(linear_to_srgb(expected.numpy()))).abs()
    assert float(steps.max()) <= EIGHT_BITS + 1e-5


@given(seed=st.integers(0, 1000))
def test_white_balance_keeps_the_luminance_of_white(seed: int) -> None:
    view = scene(seed)
    balanced = shoot(view, seed, white_balance=0.2)
    assert float(luminance(balanced.gain)) == pytest.approx(exposure_gain(view, ALL), rel=1e-5)
    assert float(balanced.gain.max() / balanced.gain.min()) > 1


@given(seed=st.integers(0, 1000))
def test_another_response_curve_keeps_the_scale_at_the_median(seed: int) -> None:
    """Light times the gain is on the scale that a user reads off the photo as if it were sRGB."""
    view = scene(seed, contrast=0.7)
    exposed = shoot(view, seed, curve_share=1.0)
    read = float(luminance(decoded(exposed.photo)).median())
    assert float(luminance(view * exposed.gain).median()) == pytest.approx(read, rel=0.02)
    assert float(exposed.photo.min()) >= 0
    assert float(exposed.photo.max()) <= 1


def test_a_photo_exposed_for_its_highlights_keeps_them() -> None:
    view = scene(contrast=1.5)
    bright = float(luminance(view).quantile(0.99))
    for seed in range(5):
        gain = float(luminance(shoot(view, seed, highlight_rule=1.0).gain))
        assert 0.59 < gain * bright < 1.21


def test_vignetting_darkens_the_corners_and_not_the_centre() -> None:
    view = torch.full((24, 32, 3), 0.5)
    photo = decoded(shoot(view, 1, vignetting=0.5).photo)
    assert float(photo[12, 16, 0]) == pytest.approx(0.18, abs=0.01)
    assert float(photo[0, 0, 0]) < 0.16
    torch.testing.assert_close(photo, photo.flip(0), rtol=0, atol=1e-6)
    torch.testing.assert_close(photo, photo.flip(1), rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_blur_and_sharpening_keep_even_light(seed: int) -> None:
    even = torch.full((24, 32, 3), 0.5)
    torch.testing.assert_close(shoot(even, seed, blur=3.0).photo, shoot(even, seed).photo, rtol=0, atol=1e-6)


def test_blur_softens_and_its_negative_sharpens() -> None:
    edge = torch.full((24, 32, 3), 0.5)
    edge[:, 16:] = 1.5
    steepness = {}
    for seed in range(12):
        photo = decoded(shoot(edge, seed, blur=3.0).photo)[12, :, 0]
        steepness[seed] = float((photo[16] - photo[15]) / 0.36)
    assert min(steepness.values()) < 0.4
    assert max(steepness.values()) > 1.05


def test_noise_has_no_mean_and_grows_with_the_light() -> None:
    even = torch.full((64, 64, 3), 0.5)
    inside = torch.ones(64, 64, dtype=torch.bool)
    spread = []
    for seed in range(6):
        photo = decoded(shoot(even, seed, inside, noise=0.2).photo)
        assert float(photo.mean()) == pytest.approx(0.18, abs=0.01)
        spread.append(float(photo.std()))
    assert max(spread) > 0.01
    halves = torch.cat([torch.full((32, 64, 3), 0.1), torch.full((32, 64, 3), 0.4)])
    photo = decoded(shoot(halves, int(np.argmax(spread)), inside, noise=0.2).photo)
    assert float(photo[32:].std()) > 1.4 * float(photo[:32].std())


def test_jpeg_changes_little_and_only_when_asked() -> None:
    view = scene(contrast=0.5)
    plain, packed = shoot(view), shoot(view, jpeg_share=1.0)
    difference = (plain.photo - packed.photo).abs()
    assert 0 < float(difference.mean()) < 0.05
    assert torch.equal(plain.gain, packed.gain)


def test_the_frame_is_all_that_exposure_and_fill_know() -> None:
    inside = ALL.clone()
    inside[:, :8] = False
    view = scene()
    changed = torch.where(inside[..., None], view, 100.0)
    a, b = shoot(view, 5, inside, exposure_ev=0.5), shoot(changed, 5, inside, exposure_ev=0.5)
    assert torch.equal(a.photo, b.photo)
    assert torch.equal(a.gain, b.gain)


@pytest.mark.parametrize(
    ("name", "value"),
    [("noise", -0.1), ("exposure_ev", float("nan")), ("jpeg_share", 1.5), ("vignetting", 2.0)],
)
def test_settings_that_cannot_be_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"expected {name} of at (least 0|most 1)"):
        CameraSettings(**{name: value})
