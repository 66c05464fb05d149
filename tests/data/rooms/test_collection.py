"""The panoramas of a set: plain files balanced, light groups relit, the same every time."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.rooms.collection import BALANCE, read_set, relit
from mixlight.image import radiance
from mixlight.light.separate import luminance
from mixlight.sphere import equirect
from tests.data.rooms.lit import lit_plan, write_room
from tests.synthetic import room


@pytest.fixture
def grouped(tmp_path: Path) -> list[PanoramaRecord]:
    """A set of one room with two cameras."""
    files = write_room(tmp_path / "room-00007", lit_plan())
    rows = ["scene,file,seed,split,category,group"]
    rows += [f"room-00007-{k},room-00007/{p.name},7,train,room,room-00007" for k, p in enumerate(files)]
    (tmp_path / "rooms.csv").write_text("\n".join(rows) + "\n")
    return read_set(tmp_path)


def plain(folder: Path) -> PanoramaRecord:
    radiance.write(folder / "plain.hdr", (room(32) * torch.tensor([2.0, 1.0, 0.4])).numpy())
    return PanoramaRecord("plain", folder / "plain.hdr", "train", "room", "plain")


def test_a_folder_and_its_table_are_the_same_set(tmp_path: Path, grouped: list[PanoramaRecord]) -> None:
    assert read_set(tmp_path / "rooms.csv") == grouped
    assert [record.scene for record in grouped] == ["room-00007-0", "room-00007-1"]


def test_what_is_no_set_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"rooms\.csv"):
        read_set(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"no such file"):
        read_set(tmp_path / "nothing")
    (tmp_path / "rooms.csv").write_text("file,split\n")
    with pytest.raises(ValueError, match="without a row"):
        read_set(tmp_path)


def test_a_plain_room_loses_most_of_its_cast_and_its_scale(tmp_path: Path) -> None:
    record = plain(tmp_path)
    (found,) = relit(record)
    was = equirect.integrate(torch.from_numpy(radiance.read(record.path)[0]))
    mean = equirect.integrate(found)
    torch.testing.assert_close(luminance(mean), torch.tensor(4 * torch.pi), rtol=1e-5, atol=0)
    torch.testing.assert_close(mean[0] / mean[2], (was[0] / was[2]) ** (1 - BALANCE), rtol=1e-4, atol=0)


def test_relightings_are_draws_that_depend_on_seed_and_scene_alone(grouped: list[PanoramaRecord]) -> None:
    first = list(relit(grouped[0], 3, seed=5))
    assert len(first) == 3
    for a, b in zip(first, relit(grouped[0], 3, seed=5), strict=True):
        assert torch.equal(a, b)
    assert torch.equal(next(iter(relit(grouped[0], 1, seed=5))), first[0])
    others = [first[1], *relit(grouped[0], 1, seed=6), *relit(replace(grouped[0], scene="b"), 1, seed=5)]
    for other in others:
        ratio = luminance(other) / luminance(first[0])
        assert float(ratio.max() / ratio.min()) > 1.05  # not merely another exposure


def test_relightings_are_radiance(grouped: list[PanoramaRecord]) -> None:
    for panorama in relit(grouped[1], 4):
        equirect.check(panorama)
        mean = float(luminance(equirect.integrate(panorama))) / (4 * torch.pi)
        assert mean == pytest.approx(1.0, rel=1e-5)


def test_no_recipe_is_no_request(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="at least one recipe"):
        next(relit(plain(tmp_path), 0))


def test_what_is_no_panorama_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "text.exr").write_text("no picture")
    record = PanoramaRecord("text", tmp_path / "text.exr", "train", "room", "text")
    with pytest.raises(ValueError, match=r"text\.exr"):
        next(relit(record))
