"""`mixlight rooms sheet`: a picture of the size asked for, or one line that says why not."""

import json
from pathlib import Path

import pytest
from PIL import Image

from mixlight.image import radiance
from tests.app.conftest import Run
from tests.synthetic import room


@pytest.fixture
def rooms(tmp_path: Path) -> Path:
    folder = tmp_path / "rooms"
    folder.mkdir()
    rows = ["file,split"]
    for k in range(3):
        radiance.write(folder / f"{k}.hdr", room(32, k).numpy())
        rows.append(f"{k}.hdr,train")
    (folder / "rooms.csv").write_text("\n".join(rows) + "\n")
    return folder


def size(path: Path) -> tuple[int, int]:
    with Image.open(path) as picture:
        assert picture.format == "JPEG"
        return picture.size


def test_panoramas(run: Run, rooms: Path, tmp_path: Path) -> None:
    status, out, err = run("rooms", "sheet", rooms, "--out", tmp_path / "a.jpg", "--count", 4, "--columns", 2)
    assert (status, err) == (0, "")
    assert "4 panoramas, 524 x 268" in out
    assert size(tmp_path / "a.jpg") == (524, 268)


def test_crops(run: Run, rooms: Path, tmp_path: Path) -> None:
    out_file = tmp_path / "a.jpg"
    status, out, _ = run(
        "rooms", "sheet", rooms, "--crops", "--out", out_file, "--count", 3, "--columns", 3, "--json"
    )
    line = json.loads(out)
    assert status == 0
    assert line["ok"]
    assert line["kind"] == "crops"
    assert sorted(line["scenes"]) == ["0", "1", "2"]
    assert size(out_file) == (line["width"], line["height"]) == (3 * 164 + 4, 128)


def test_the_same_seed_is_the_same_picture(run: Run, rooms: Path, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        run(
            "rooms",
            "sheet",
            rooms,
            "--crops",
            "--out",
            tmp_path / f"{name}.jpg",
            "--count",
            2,
            "--seed",
            seed,
        )
    first, again, other = ((tmp_path / f"{name}.jpg").read_bytes() for name in "abc")
    assert first == again != other


def test_no_set_leaves_nothing(run: Run, tmp_path: Path) -> None:
    status, out, err = run("rooms", "sheet", tmp_path, "--out", tmp_path / "a.jpg", "--json")
    assert status == 1
    assert err.count("\n") == 1
    assert not json.loads(out)["ok"]
    assert not list(tmp_path.iterdir())


def test_a_damaged_room_is_named_once_and_others_take_its_place(
    run: Run, rooms: Path, tmp_path: Path
) -> None:
    (rooms / "1.hdr").write_bytes(b"#?RADIANCE\nnothing")
    status, out, err = run("rooms", "sheet", rooms, "--out", tmp_path / "a.jpg", "--count", 5, "--json")
    line = json.loads(out)
    assert status == 1
    assert err.count("\n") == err.count("1.hdr") == 1
    assert not line["ok"]
    assert len(line["scenes"]) == 5
    assert set(line["scenes"]) == {"0", "2"}
    assert size(tmp_path / "a.jpg")[0] == line["width"]


def test_nothing_to_be_shown_leaves_nothing(run: Run, rooms: Path, tmp_path: Path) -> None:
    for k in range(3):
        (rooms / f"{k}.hdr").write_bytes(b"#?RADIANCE\nnothing")
    status, _, err = run("rooms", "sheet", rooms, "--out", tmp_path / "a.jpg")
    assert status == 1
    assert "can be shown, got none" in err
    assert not (tmp_path / "a.jpg").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "a.png"], "ends in .jpg"),
        (["--out", "a.jpg", "--count", "0"], "above 0"),
        (["--out", "a.jpg", "--columns", "x"], "above 0"),
        (["--out", "a.jpg", "--seed", "-1"], "from 0 on"),
        ([], "--out"),
    ],
)
def test_wrong_calls(run: Run, rooms: Path, options: list[str], words: str) -> None:
    status, _, err = run("rooms", "sheet", rooms, *options)
    assert status == 2
    assert words in err
