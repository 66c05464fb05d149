"""Batches are a function of seed and step, and hold photos and light that belong together."""

import dataclasses
import math
from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data.camera_model import PLAIN, CameraSettings
from mixlight.data.crops import CropSettings
from mixlight.data.labels import LabelSettings
from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.training_set import Batch, SamplingSettings, TrainingSet
from mixlight.image import exr
from mixlight.image.color import srgb_to_linear
from mixlight.light import harmonics
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import camera, equirect
from tests.synthetic import room

VIEW = CanonicalView(48, 64)
LABELS = LabelSettings(height=32, map_height=16, azimuths=32)
LEVEL = CropSettings(pitch_deg=(0, 0, 0), fov_error=0, roll_deg=0, frames=False)


def store(folder: Path, panoramas: dict[str, Tensor], category: str = "indoor") -> list[PanoramaRecord]:
    records = []
    for scene, panorama in panoramas.items():
        path = folder / f"{scene}.exr"
        exr.write(path, panorama.numpy(), {})
        records.append(PanoramaRecord(scene, path, "train", category, scene))
    return records


def make(folder: Path, records: list[PanoramaRecord], **parts: object) -> TrainingSet:
    settings = {"crops": CropSettings(), "camera": CameraSettings(), "sampling": SamplingSettings()} | parts
    return TrainingSet(records, VIEW, LABELS, folder / "cache", **settings)  # type: ignore[arg-type]


def decoded(photo: Tensor) -> Tensor:
    """[batch, 3, h, w] sRGB -> [batch, h, w, 3] linear."""
    return torch.from_numpy(srgb_to_linear(photo.permute(0, 2, 3, 1).numpy()))


def assert_equal(a: Batch, b: Batch) -> None:
    for field in dataclasses.fields(Batch):
        assert torch.equal(getattr(a, field.name), getattr(b, field.name)), field.name


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> TrainingSet:
    folder = tmp_path_factory.mktemp("rooms")
    return make(folder, store(folder, {f"room{k}": room(64, k) for k in range(2)}))


def test_a_batch_is_a_function_of_seed_and_step(rooms: TrainingSet) -> None:
    first = rooms.batch(0, 7, 3)
    other = rooms.batch(0, 8, 3)
    assert_equal(rooms.batch(0, 7, 3), first)
    assert not torch.equal(first.photo, other.photo)
    assert not torch.equal(first.photo, rooms.batch(1, 7, 3).photo)
    # Each view has its own draw, so that a larger batch begins with the smaller one.
    assert torch.equal(rooms.batch(0, 7, 4).photo[:3], first.photo)
    with pytest.raises(ValueError, match="non-negative"):
        rooms.batch(0, -1, 1)


def test_another_process_or_order_would_make_the_same_batch(rooms: TrainingSet, tmp_path: Path) -> None:
    twin = make(tmp_path, rooms.records)
    rooms.batch(0, 1, 2)
    assert_equal(twin.batch(0, 5, 2), rooms.batch(0, 5, 2))


def test_a_batch_has_the_promised_shapes_and_ranges(rooms: TrainingSet) -> None:
    batch = rooms.batch(2, 0, 6)
    shapes = {f.name: tuple(getattr(batch, f.name).shape) for f in dataclasses.fields(Batch)}
    assert shapes == {
        "photo": (6, 3, 48, 64),
        "anchor_energy": (6, 128, 3),
        "ambient": (6, 9, 3),
        "small_map": (6, 16, 32, 3),
        "camera": (6, 2),
    }
    assert {getattr(batch, f.name).dtype for f in dataclasses.fields(Batch)} == {torch.float32}
    assert 0 <= float(batch.photo.min()) < float(batch.photo.max()) <= 1
    assert float(batch.anchor_energy.min()) >= 0


# ---------------------------------------------------------------------------- photo and light belong together


def smooth(height: int = 64) -> Tensor:
    """No two directions alike, within what a photo shows unclipped: radiance from .4 to 1.6."""
    x, y, z = equirect.pixel_directions(height).unbind(-1)
    return torch.stack([1 + 0.4 * x + 0.2 * y, 1 + 0.3 * z - 0.3 * y, 1 + 0.2 * y + 0.4 * x * z], -1)


@pytest.mark.parametrize("viewpoints", [0, 3])
def test_the_photo_shows_the_map_ahead_in_its_own_exposure(tmp_path: Path, viewpoints: int) -> None:
    """Azimuth, mirror, pose, exposure, white balance and viewpoint at once: each pixel against the map."""
    crops = CropSettings(fov_error=0, roll_deg=10, frames=False)
    lens = dataclasses.replace(PLAIN, exposure_ev=0.3, white_balance=0.1)
    sampling = SamplingSettings(moved_real=viewpoints)
    training = make(tmp_path, store(tmp_path, {"a": smooth()}), crops=crops, camera=lens, sampling=sampling)
    batch = training.batch(0, 0, 12)
    for photo, small, (pitch, roll) in zip(
        decoded(batch.photo), batch.small_map, batch.camera.tolist(), strict=True
    ):
        rays = camera.ray_directions(VIEW.height, VIEW.width, VIEW.fov, 0.0, pitch, roll)
        expected = equirect.sample(small, rays)
        seen = photo < 0.98
        error = (photo - expected)[seen].abs() / expected[seen]
        assert float(error.median()) < 0.02
        assert float(error.max()) < 0.12  # texels of 11 degrees


def test_ambient_and_sources_are_those_of_the_map(rooms: TrainingSet) -> None:
    batch = rooms.batch(0, 3, 6)
    total = batch.anchor_energy.sum(1) + batch.ambient[:, 0] * math.sqrt(4 * math.pi)
    torch.testing.assert_close(total, equirect.integrate(batch.small_map), rtol=1e-3, atol=0)


def test_even_light_is_the_photos_mean_whatever_the_camera(tmp_path: Path) -> None:
    """Any curve, balance, blur and JPEG: the light is on the scale that the photo shows."""
    even = torch.tensor([0.9, 0.7, 0.5]).expand(32, 64, 3).contiguous()
    lens = CameraSettings(exposure_ev=0.3, curve_share=1.0, vignetting=0.0, noise=0.0)
    batch = make(tmp_path, store(tmp_path, {"a": even}), camera=lens).batch(0, 0, 12)
    shown = decoded(batch.photo).mean((1, 2))
    whole = harmonics.evaluate(batch.ambient, torch.tensor([0.0, 0.0, -1.0]))
    assert float(batch.anchor_energy.sum()) == 0
    torch.testing.assert_close(whole, batch.small_map[:, 8, 8], rtol=2e-3, atol=0)
    y = torch.tensor([0.2126, 0.7152, 0.0722])
    # Curves bend the colours, and match at the median of the luminance.
    torch.testing.assert_close(whole @ y, shown @ y, rtol=0.03, atol=0)


def test_the_roll_of_the_label_is_the_tilt_of_the_horizon(tmp_path: Path) -> None:
    """Bright above and dark below: the direction to the light in the picture, mirrored views included."""
    y = equirect.pixel_directions(180)[..., 1:2]
    horizon = torch.where(y > 0, 1.0, 0.2).expand(-1, -1, 3).contiguous()
    crops = dataclasses.replace(LEVEL, roll_deg=10)
    batch = make(tmp_path, store(tmp_path, {"a": horizon}), crops=crops, camera=PLAIN).batch(0, 0, 10)
    down, across = torch.meshgrid(torch.arange(48) - 23.5, torch.arange(64) - 31.5, indexing="ij")
    disc = down**2 + across**2 < 22**2
    for photo, (pitch, roll) in zip(decoded(batch.photo), batch.camera.tolist(), strict=True):
        light = photo[..., 0] * disc
        right, up = float((light * across).sum()), float((light * -down).sum())
        # A camera turned clockwise sees "up" tilt to the left.
        assert math.atan2(-right, up) == pytest.approx(roll, abs=math.radians(1.5))
        assert pitch == 0
    assert float(batch.camera[:, 1].std()) > math.radians(3)


# --------------------------------------------------------------------------------------------------- sampling


def test_weights_choose_the_categories(tmp_path: Path) -> None:
    bright, dark = torch.full((16, 32, 3), 1.0), torch.full((16, 32, 3), 0.01)
    records = store(tmp_path, {"a": bright}) + store(tmp_path, {"b": dark}, "outdoor")
    weights = {"indoor": 1.0, "outdoor": 0.0}
    only = make(tmp_path, records, sampling=SamplingSettings(weights))
    assert [r.scene for r in only.records] == ["a"]
    both = make(tmp_path, records, sampling=SamplingSettings(weights | {"outdoor": 3.0}), camera=PLAIN)
    gains = both.batch(0, 0, 60).small_map[:, 0, 0, 0] / 0.18
    torch.testing.assert_close(gains, torch.ones(60), rtol=1e-3, atol=0)
    drawn = [int(both._share.argmax()), float(both._share.max())]
    assert drawn == [1, 0.75]


def test_viewpoints_share_the_weight_of_their_panorama_and_are_counted_once(tmp_path: Path) -> None:
    records = store(tmp_path, {"a": room(32)})
    records += store(tmp_path, {"r": room(32, 1)}, "room") + store(tmp_path, {"o": room(32, 2)}, "outdoor")
    weights = {"indoor": 2.0, "room": 1.0, "outdoor": 1.0}
    sampling = SamplingSettings(weights, moved_real=3, moved_rooms=1)
    training = make(tmp_path, records, sampling=sampling)
    assert training.records == records
    shares = dict.fromkeys("aro", 0.0)
    for record, share in zip(training._seen, training._share, strict=True):
        shares[record.scene] += share
    assert shares == {"a": pytest.approx(0.5), "r": pytest.approx(0.25), "o": pytest.approx(0.25)}
    assert [record.scene for record in training._seen] == ["a"] * 4 + ["r"] * 2 + ["o"]  # not from outdoors
    # The same viewpoints in any table.
    again = make(tmp_path, records[::-1], sampling=sampling)
    assert torch.equal(again._panoramas[3], training._panoramas[0])
    assert torch.equal(again._panoramas[6], training._panoramas[3])


def test_a_category_without_a_weight_is_refused(tmp_path: Path) -> None:
    records = store(tmp_path, {"a": room(16)}, "cave")
    with pytest.raises(ValueError, match="got none for cave"):
        make(tmp_path, records)
    with pytest.raises(ValueError, match="expected training panoramas"):
        make(tmp_path, records, sampling=SamplingSettings({"cave": 0.0}))
    with pytest.raises(ValueError, match="expected training panoramas"):
        make(tmp_path, [])


def test_panoramas_that_no_exposure_can_show_are_named(tmp_path: Path) -> None:
    training = make(tmp_path, store(tmp_path, {"night": torch.full((16, 32, 3), 1e-4)}))
    with pytest.raises(
        ValueError, match=r"night\.exr: expected views that an exposure gain between 0.02 and 50"
    ):
        training.batch(0, 0, 1)


def test_rendered_rooms_are_white_balanced_and_photographed_ones_are_not(tmp_path: Path) -> None:
    orange = torch.tensor([1.5, 1.0, 0.5]).expand(16, 32, 3).contiguous()
    full = SamplingSettings(room_white_balance=(1.0, 1.0))
    casts = {}
    for category in ("room", "indoor"):
        folder = tmp_path / category
        folder.mkdir()
        training = make(folder, store(folder, {"a": orange}, category), camera=PLAIN, sampling=full)
        batch = training.batch(0, 0, 2)
        casts[category] = batch.small_map[0, 0, 0] / batch.small_map[0, 0, 0, 1]
        torch.testing.assert_close(
            decoded(batch.photo).mean((1, 2)), batch.small_map[:, 0, 0], rtol=0.02, atol=0
        )
    torch.testing.assert_close(casts["room"], torch.ones(3))
    torch.testing.assert_close(casts["indoor"], torch.tensor([1.5, 1.0, 0.5]), rtol=1e-3, atol=0)


def test_light_beyond_half_precision_counts_in_the_labels(tmp_path: Path) -> None:
    from mixlight.image import radiance

    sun = torch.full((32, 64, 3), 1.0)
    sun[8, 20] = 1e6
    radiance.write(tmp_path / "sun.hdr", sun.numpy())
    record = PanoramaRecord("sun", tmp_path / "sun.hdr", "train", "indoor", "sun")
    batch = make(tmp_path, [record], camera=PLAIN).batch(0, 0, 2)
    expected = float(equirect.integrate(sun)[0]) * 0.18
    assert float(equirect.integrate(batch.small_map)[0, 0]) == pytest.approx(expected, rel=0.01)
    assert bool(batch.photo.isfinite().all())


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"weights": {"indoor": -1.0}}, "for indoor, got -1"),
        ({"room_white_balance": (0.9, 0.1)}, "room_white_balance"),
        ({"room_white_balance": (0.0, 1.5)}, "room_white_balance"),
    ],
)
def test_settings_that_cannot_be_are_refused(changes: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        SamplingSettings(**changes)  # type: ignore[arg-type]
