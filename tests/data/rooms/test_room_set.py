"""The folder of a set says how it was made, and which rooms are done."""

import json
from pathlib import Path

import pytest

from mixlight.data.rooms.room_set import DOCUMENT, HEADER, TABLE, RoomSet, SetError


def add(folder: Path, seed: int, cameras: int = 2) -> None:
    room = RoomSet(folder).room(seed)
    room.mkdir(parents=True)
    for k in range(cameras):
        (room / f"camera-{k}.exr").touch()
    (room / DOCUMENT).touch()


def test_a_new_set(tmp_path: Path) -> None:
    rooms = RoomSet(tmp_path / "new" / "set")
    rooms.open({"width": 64})
    rooms.open({"width": 64})
    assert json.loads((rooms.folder / HEADER).read_text())["width"] == 64
    assert rooms.rooms() == {}


def test_rooms_count_when_they_are_whole(tmp_path: Path) -> None:
    add(tmp_path, 12, cameras=11)
    add(tmp_path, 3)
    (tmp_path / "room-00004").mkdir()
    (tmp_path / ".room-00005.77.new").mkdir()
    (tmp_path / "room-x").mkdir()
    found = RoomSet(tmp_path).rooms()
    assert list(found) == [3, 12]
    assert found[12][9:] == ("camera-9.exr", "camera-10.exr")


def test_a_seed_of_many_digits(tmp_path: Path) -> None:
    add(tmp_path, 1234567)
    assert list(RoomSet(tmp_path).rooms()) == [1234567]


def test_table(tmp_path: Path) -> None:
    add(tmp_path, 19, cameras=1)
    RoomSet(tmp_path).write_table()
    assert (tmp_path / TABLE).read_text().splitlines()[1] == (
        "room-00019-camera-0,room-00019/camera-0.exr,19,val,room,room-00019"
    )


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("{", "found no JSON"),
        ('{"format": "other"}', "found something else"),
        ('{"format": "mixlight-rooms", "version": 0}', "expected rooms of version 1, found version 0"),
        ('{"format": "mixlight-rooms", "version": 1, "width": 32}', "made with width 32, expected 64"),
        ('{"format": "mixlight-rooms", "version": 1}', "made with width none, expected 64"),
    ],
)
def test_a_folder_of_something_else_is_left_alone(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / HEADER).write_text(content)
    with pytest.raises(SetError, match=said):
        RoomSet(tmp_path).open({"width": 64})
    assert [p.name for p in tmp_path.iterdir()] == [HEADER]
    assert (tmp_path / HEADER).read_text() == content


def test_rooms_without_a_description_are_left_alone(tmp_path: Path) -> None:
    add(tmp_path, 1)
    with pytest.raises(SetError, match=f"expected a set of rooms with its {HEADER}"):
        RoomSet(tmp_path).open({"width": 64})
    assert not (tmp_path / HEADER).exists()


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "set").write_text("mine")
    with pytest.raises(OSError, match="set"):
        RoomSet(tmp_path / "set").open({})
    assert (tmp_path / "set").read_text() == "mine"
