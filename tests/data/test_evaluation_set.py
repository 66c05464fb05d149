"""Samples of protocol M: fixed, exposed at the median, and faced as the photo is."""

from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data import display
from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, collect, samples_of
from mixlight.data.panoramas import PanoramaRecord
from mixlight.image import exr
from mixlight.image.color import srgb_to_linear
from mixlight.light.separate import luminance
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import camera, equirect
from tests.synthetic import room

VIEW = CanonicalView(48, 64)


def store(folder: Path, scene: str, panorama: Tensor) -> PanoramaRecord:
    exr.write(folder / f"{scene}.exr", panorama.numpy(), {})
    return PanoramaRecord(scene, folder / f"{scene}.exr", "test", "indoor", scene)


def decoded(photo: Tensor) -> Tensor:
    return torch.from_numpy(srgb_to_linear(photo.permute(1, 2, 0).numpy()))


def test_a_panorama_gives_eight_photos_at_middle_gray(tmp_path: Path) -> None:
    samples = list(samples_of(store(tmp_path, "a", room(128)), VIEW))
    assert [sample.azimuth_deg for sample in samples] == [0, 45, 90, 135, 180, 225, 270, 315]
    for sample in samples:
        assert sample.photo.shape == (3, 48, 64)
        assert sample.environment.shape == (ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3)
        assert float(luminance(decoded(sample.photo)).median()) == pytest.approx(0.18, rel=0.01)
        torch.testing.assert_close(sample.photo * 255, (sample.photo * 255).round(), rtol=0, atol=1e-4)


def test_samples_are_the_same_every_time_and_whatever_the_files_scale(tmp_path: Path) -> None:
    panorama = room(128)
    first = list(samples_of(store(tmp_path, "a", panorama), VIEW, 2))
    again = list(samples_of(store(tmp_path, "a", panorama), VIEW, 2))
    darker = list(samples_of(store(tmp_path, "b", panorama / 64), VIEW, 2))
    for a, b, c in zip(first, again, darker, strict=True):
        assert torch.equal(a.photo, b.photo)
        assert torch.equal(a.environment, b.environment)
        assert c.gain == pytest.approx(64 * a.gain, rel=1e-3)
        torch.testing.assert_close(c.environment, a.environment, rtol=5e-3, atol=1e-4)
        assert float((c.photo - a.photo).abs().max()) < 2 / 255


def test_the_environment_is_ahead_where_the_photo_looks(tmp_path: Path) -> None:
    x, y, z = equirect.pixel_directions(128).unbind(-1)
    panorama = torch.stack([1 + 0.4 * x, 1 + 0.4 * y, 1 + 0.4 * z], -1)
    for sample in samples_of(store(tmp_path, "a", panorama), VIEW):
        rays = camera.ray_directions(VIEW.height, VIEW.width, VIEW.fov, 0.0, sample.pitch)
        expected = equirect.sample(sample.environment, rays).clamp(max=1)
        torch.testing.assert_close(decoded(sample.photo), expected, rtol=0.02, atol=2e-3)


@pytest.mark.parametrize("fov_deg", [40.0, 90.0])
def test_a_network_with_another_view_sees_the_same_photo(tmp_path: Path, fov_deg: float) -> None:
    """At 90 degrees the photo of 60 is an island in its mean colour; at 40 only its centre is seen."""
    record = store(tmp_path, "a", room(128))
    (usual,) = samples_of(record, CanonicalView(96, 128), 1)
    half = torch.tensor(fov_deg).deg2rad()
    canonical = CanonicalView(96, 128, float(half))
    (other,) = samples_of(record, canonical, 1)
    torch.testing.assert_close(usual.environment / usual.gain, other.environment / other.gain)
    if fov_deg > 60:
        corner = other.photo[:, :10, :10]
        torch.testing.assert_close(corner, corner[:, :1, :1].expand_as(corner))
        assert other.gain == pytest.approx(usual.gain, rel=0.05)
    else:
        assert float(other.photo.std()) > 0


def test_black_views_are_left_out_and_scenes_stay_in_order(tmp_path: Path) -> None:
    half = torch.zeros(128, 256, 3)
    half[:, 128:160] = 1.0  # straight ahead and a little to the right
    black = store(tmp_path, "black", torch.zeros(64, 128, 3))
    samples = collect([black, store(tmp_path, "half", half), store(tmp_path, "a", room(64))], VIEW, 4)
    assert [sample.scene for sample in samples] == ["half", "a", "a", "a", "a"]
    assert samples[0].azimuth_deg == 0


def test_a_photo_exposed_for_the_panorama_is_a_part_of_the_encoded_map(tmp_path: Path) -> None:
    """Protocol S: the whole view is shown, at the scale on which the panorama's median is .5, level."""
    x, y, z = equirect.pixel_directions(128).unbind(-1)
    panorama = torch.stack([1 + 0.4 * x, 1 + 0.4 * y, 1 + 0.4 * z], -1)
    wide = CanonicalView(48, 64, 1.3)
    (sample,) = samples_of(store(tmp_path, "a", panorama), wide, 1, pitch=0.0, fov=1.3, exposure="panorama")
    assert sample.fov == 1.3
    rays = camera.ray_directions(48, 64, 1.3)
    encoded = display.encode(panorama)
    expected = equirect.sample(encoded, rays).clamp(max=1)
    torch.testing.assert_close(sample.photo.permute(1, 2, 0), expected, rtol=0, atol=5e-3)
    torch.testing.assert_close(sample.environment ** (1 / 2.4), encoded, rtol=2e-3, atol=0)


def test_samples_have_names_of_their_own(tmp_path: Path) -> None:
    samples = list(samples_of(store(tmp_path, "a", room(64)), VIEW))
    assert [sample.name for sample in samples[:3]] == ["a_az000", "a_az045", "a_az090"]


def test_an_unknown_exposure_is_refused(tmp_path: Path, unchecked: None) -> None:
    with pytest.raises(ValueError, match="expected an exposure out of view, panorama, got 'sun'"):
        next(samples_of(store(tmp_path, "a", room(64)), VIEW, exposure="sun"))  # type: ignore[arg-type]
