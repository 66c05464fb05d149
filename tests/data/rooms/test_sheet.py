"""Contact sheets: which rooms, how they are exposed, where each lies, and how large the file is."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mixlight.data.camera_model import PLAIN
from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.rooms.sheet import choose, crop_tile, lay_out, panorama_tile, write_jpeg
from mixlight.image import radiance
from tests.synthetic import room


def records(rooms: int, cameras: int) -> list[PanoramaRecord]:
    return [
        PanoramaRecord(f"{r}-{c}", Path(f"{r}-{c}.exr"), "train", "room", f"room-{r}")
        for r in range(rooms)
        for c in range(cameras)
    ]


@pytest.fixture
def record(tmp_path: Path) -> PanoramaRecord:
    radiance.write(tmp_path / "a.hdr", room(64).numpy())
    return PanoramaRecord("a", tmp_path / "a.hdr", "train", "room", "a")


def test_every_room_comes_before_one_comes_twice() -> None:
    for count in (5, 10, 14, 25):
        found = choose(records(10, 2), count, seed=3)
        assert len(found) == count
        times = Counter(record.group for record in found)
        assert max(times.values()) - min([*times.values(), 0] if count < 10 else times.values()) <= 1


def test_cameras_of_a_room_follow_each_other() -> None:
    found = choose(records(4, 3), 12, seed=0)
    assert Counter(record.scene for record in found).most_common(1)[0][1] == 1


def test_the_choice_is_the_seeds() -> None:
    many = records(30, 1)
    assert choose(many, 8, seed=1) == choose(many, 8, seed=1)
    assert choose(many, 8, seed=1) != choose(many, 8, seed=2)
    assert choose(many, 8, seed=1) != many[:8]


@pytest.mark.parametrize(("count", "given"), [(0, 3), (2, 0)])
def test_nothing_to_choose(count: int, given: int) -> None:
    with pytest.raises(ValueError, match="expected records"):
        choose(records(given, 1), count, 0)


@pytest.mark.parametrize("gain", [1e-3, 1.0, 50.0])
def test_a_room_is_exposed_whatever_its_scale(tmp_path: Path, record: PanoramaRecord, gain: float) -> None:
    radiance.write(tmp_path / "b.hdr", (room(64) * gain).numpy())
    tile = panorama_tile(PanoramaRecord("b", tmp_path / "b.hdr", "train", "room", "b"), 0, rows=32)
    assert tile.shape == (32, 64, 3)
    assert 100 < np.median(tile[5:-5]) < 135
    difference = np.abs(tile.astype(int) - panorama_tile(record, 0, rows=32).astype(int))
    assert difference.mean() < 1.5  # RGBE rounds each scale its own way


def test_a_crop_is_a_photo_of_the_room(record: PanoramaRecord) -> None:
    tile = crop_tile(record, 4, (48, 64), PLAIN)
    assert tile.shape == (48, 64, 3)
    assert np.array_equal(tile, crop_tile(record, 4, (48, 64), PLAIN))
    assert not np.array_equal(tile, crop_tile(record, 5, (48, 64), PLAIN))
    assert 100 < np.median(tile) < 135  # exposed for its own median


def test_a_room_too_dark_to_be_photographed_says_so(tmp_path: Path) -> None:
    """All its light comes from one lamp, ten thousand times as bright as the rest."""
    dark = torch.full((32, 64, 3), 1e-4)
    dark[0] = 1000.0
    radiance.write(tmp_path / "dark.hdr", dark.numpy())
    with pytest.raises(ValueError, match=r"dark\.hdr"):
        crop_tile(PanoramaRecord("dark", tmp_path / "dark.hdr", "train", "room", "dark"), 0, (12, 16))


def test_tiles_lie_in_reading_order() -> None:
    tiles = [np.full((2, 4, 3), value, np.uint8) for value in (10, 20, 30, 40, 50)]
    sheet = lay_out(tiles, 3)
    assert sheet.shape == (2 * 6 + 4, 3 * 8 + 4, 3)
    assert sheet[4:16:6, 4:28:8, 0].tolist() == [[10, 20, 30], [40, 50, 24]]
    assert lay_out(tiles[:2], 7).shape == (10, 20, 3)


def test_tiles_of_one_size_only() -> None:
    with pytest.raises(ValueError, match="one size"):
        lay_out([np.zeros((2, 4, 3), np.uint8), np.zeros((4, 4, 3), np.uint8)], 2)
    with pytest.raises(ValueError, match="one size"):
        lay_out([], 2)


def test_a_sheet_is_compressed_until_it_fits(tmp_path: Path) -> None:
    generator = torch.Generator().manual_seed(0)
    noise = (torch.rand(300, 400, 3, generator=generator) * 255).to(torch.uint8).numpy()
    fine, small = (write_jpeg(noise, tmp_path / f"{limit}.jpg", limit) for limit in (300_000, 90_000))
    assert fine == 90
    assert small < fine
    assert (tmp_path / "90000.jpg").stat().st_size <= 90_000
    with Image.open(tmp_path / "90000.jpg") as picture:
        assert picture.size == (400, 300)
    with pytest.raises(ValueError, match="at most 5000 bytes"):
        write_jpeg(noise, tmp_path / "never.jpg", 5000)
    assert not (tmp_path / "never.jpg").exists()
