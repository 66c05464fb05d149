"""Relit rooms in training: exact, kept, deterministic, and in the training set."""

import logging
from pathlib import Path

import pytest
import torch

from mixlight.data.labels import LabelSettings
from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.relit import has_groups, relightings
from mixlight.data.rooms.store import read_room
from mixlight.data.training_set import SamplingSettings, TrainingSet
from mixlight.image import exr
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect
from tests.data.rooms.lit import lit_plan, write_room
from tests.synthetic import room

LUMINANCE = torch.tensor([0.2126, 0.7152, 0.0722])


@pytest.fixture
def record(tmp_path: Path) -> PanoramaRecord:
    path = write_room(tmp_path / "room-00007", lit_plan(), height=32)[0]
    return PanoramaRecord("room-00007-camera-0", path, "train", "room", "room-00007")


def test_relightings_are_mixes_of_the_groups(record: PanoramaRecord, tmp_path: Path) -> None:
    groups = torch.stack([g.flatten() for g in read_room(record.path).groups.values()], -1).double()
    pixels = groups.view(-1, 3, groups.shape[-1])
    for _, panorama in relightings(record, 5, tmp_path / "cache"):
        equirect.check(panorama.float())
        mean = float(equirect.integrate(panorama.float()) @ LUMINANCE) / (4 * torch.pi)
        assert mean == pytest.approx(1.0, abs=2e-3)
        for channel in range(3):
            seen = panorama[..., channel].flatten().double()
            weights = 1 / seen.clamp(min=1e-3)  # half floats are relatively exact
            a = pixels[:, channel] * weights[:, None]
            solution = torch.linalg.lstsq(a, (seen * weights)[:, None]).solution
            assert float((a @ solution - (seen * weights)[:, None]).abs().max()) < 2e-3
            assert float(solution.min()) > -1e-3


def test_they_differ_and_do_not_hang_on_their_number(record: PanoramaRecord, tmp_path: Path) -> None:
    few = dict(relightings(record, 2, tmp_path / "a"))
    many = dict(relightings(record, 4, tmp_path / "b"))
    assert len(many) == 4
    for name, panorama in few.items():
        assert torch.equal(many[name], panorama)
    first, second, *_ = many.values()
    assert not torch.equal(first, second)


def test_they_are_kept_and_mapped(record: PanoramaRecord, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    made = list(relightings(record, 2, cache))
    files = sorted(cache.iterdir())
    assert [file.suffix for file in files] == [".npy", ".npy"]
    before = [file.stat().st_mtime_ns for file in files]
    again = list(relightings(record, 2, cache))
    assert [file.stat().st_mtime_ns for file in files] == before
    for (name, panorama), (other, kept) in zip(made, again, strict=True):
        assert name == other
        assert torch.equal(panorama, kept)


def test_a_damaged_entry_is_made_anew(
    record: PanoramaRecord, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    cache = tmp_path / "cache"
    ((_, made),) = relightings(record, 1, cache)
    made = made.clone()
    (entry,) = cache.iterdir()
    entry.write_bytes(b"\x93NUMPY broken")
    with caplog.at_level(logging.WARNING):
        ((_, again),) = relightings(record, 1, cache)
    assert torch.equal(again, made)
    assert "damaged" in caplog.text


def test_a_cache_that_cannot_be_written_costs_memory_only(
    record: PanoramaRecord, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    with caplog.at_level(logging.WARNING):
        made = list(relightings(record, 2, tmp_path / "file"))
    assert len(made) == 2
    assert "not kept" in caplog.text


def test_a_changed_room_is_not_served_old_light(record: PanoramaRecord, tmp_path: Path) -> None:
    before = dict(relightings(record, 1, tmp_path / "cache"))
    document = record.path.with_name("room.json")
    document.write_text(document.read_text().replace('"power": 800.0', '"power": 900.0'))
    assert not set(dict(relightings(record, 1, tmp_path / "cache"))) & set(before)


def test_tall_panoramas_are_made_smaller(record: PanoramaRecord, tmp_path: Path) -> None:
    ((_, small),) = relightings(record, 1, tmp_path / "cache", max_height=16)
    assert small.shape == (16, 32, 3)


def training_set(folder: Path, record: PanoramaRecord, remixes: int) -> TrainingSet:
    labels = LabelSettings(height=32, map_height=16, azimuths=32)
    sampling = SamplingSettings(remixes_rooms=remixes)
    return TrainingSet([record], CanonicalView(24, 32), labels, folder, sampling=sampling)


def test_training_sees_relit_rooms(record: PanoramaRecord, tmp_path: Path) -> None:
    relit, plain = (training_set(tmp_path / "cache", record, n) for n in (3, 0))
    again = training_set(tmp_path / "other", record, 3)
    assert relit.records == plain.records == [record]
    seen = [relit.batch(0, step, 2) for step in range(4)]
    for step, batch in enumerate(seen):
        other = again.batch(0, step, 2)
        assert torch.equal(batch.photo, other.photo)
        assert torch.equal(batch.anchor_energy, other.anchor_energy)
        assert torch.equal(batch.ambient, other.ambient)
    assert any(not torch.equal(b.photo, plain.batch(0, s, 2).photo) for s, b in enumerate(seen))


def test_a_room_without_groups_is_seen_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "plain.exr"
    exr.write(path, room(32).numpy())
    record = PanoramaRecord("plain", path, "train", "room", "plain")
    assert not has_groups(record)
    relit, plain = (training_set(tmp_path / "cache", record, n) for n in (3, 0))
    assert torch.equal(relit.batch(0, 0, 2).photo, plain.batch(0, 0, 2).photo)
    assert not list((tmp_path / "cache").glob("*.npy"))


def test_a_negative_number_is_refused() -> None:
    with pytest.raises(ValueError, match="remixes_rooms"):
        SamplingSettings(remixes_rooms=-1)
