"""Panorama tables and files: what is listed, what is refused, and what is undone on reading."""

import logging
from pathlib import Path

import numpy as np
import pytest
import torch

from mixlight.data import panoramas
from mixlight.data.panoramas import (
    PanoramaRecord,
    load_panorama,
    read_folder,
    read_radiance,
    read_table,
    select,
)
from mixlight.image import exr, radiance
from mixlight.sphere import equirect
from tests.synthetic import room


def record(scene: str, split: str = "train", category: str = "indoor", group: str = "") -> PanoramaRecord:
    return PanoramaRecord(scene, Path(f"{scene}.hdr"), split, category, group or scene)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("a", "b", "c"):
        radiance.write(tmp_path / f"{name}.hdr", np.ones((8, 16, 3), np.float32))
    return tmp_path


def table(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "table.csv"
    path.write_bytes(text.encode(encoding))
    return path


# ----------------------------------------------------------------------------------------------------- tables


def test_a_table_gives_its_records_with_defaults_for_what_it_does_not_say(folder: Path) -> None:
    path = table(
        folder, "file,split,category,group,remark\na.hdr,train,studio,x,old\nb.hdr,train,,x\nc.hdr,val\n"
    )
    assert read_table(path) == [
        PanoramaRecord("a", folder / "a.hdr", "train", "studio", "x"),
        PanoramaRecord("b", folder / "b.hdr", "train", "room", "x"),
        PanoramaRecord("c", folder / "c.hdr", "val", "room", "c"),
    ]


def test_a_table_written_by_a_spreadsheet_with_a_byte_order_mark_is_read(folder: Path) -> None:
    assert read_table(table(folder, "\ufefffile,split\r\na.hdr,test\r\n"))[0].scene == "a"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "columns file and split, missing file and split"),
        ("file,category\na.hdr,indoor\n", "columns file and split, missing split"),
        (
            "file,split\na.hdr,training\n",
            "line 2: a.hdr: expected a split of train, val, test, got 'training'",
        ),
        ("file,split\na.hdr,train\nb.hdr\n", "line 3: b.hdr: expected a split of train, val, test, got ''"),
        ("file,split\n,train\n", "line 2: expected the name of a file"),
        ("file,split,scene\na.hdr,train,s\nb.hdr,train,s\n", "expected every scene once, got 's' twice"),
        (
            "file,split,group\na.hdr,train,g\nb.hdr,val,g\n",
            "expected a group on one side of the split, got 'g' in both train and val",
        ),
    ],
)
def test_a_wrong_table_is_refused_by_name_and_line(folder: Path, text: str, says: str) -> None:
    path = table(folder, text)
    with pytest.raises(ValueError, match="table") as caught:
        read_table(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert says in str(caught.value)


def test_a_table_of_another_encoding_is_refused(folder: Path) -> None:
    with pytest.raises(ValueError, match=r"table\.csv"):
        read_table(table(folder, "file,split\nhütte.hdr,train\n", "latin-1"))


def test_what_is_missing_is_named(folder: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nowhere\.csv: expected a CSV table"):
        read_table(folder / "nowhere.csv")
    with pytest.raises(FileNotFoundError, match=r"table\.csv: line 2: lists d\.hdr, which does not exist"):
        read_table(table(folder, "file,split\nd.hdr,train\n"))


def test_groups_are_held_together_across_tables() -> None:
    with pytest.raises(ValueError, match="'g' in both train and val"):
        panoramas.check_split([record("a", "train", group="g"), record("b", "val", group="g")])
    panoramas.check_split([record("a", "val", group="g"), record("b", "val", group="g")])


def test_select_by_split_and_category() -> None:
    records = [record("a"), record("b", category="room"), record("c", "val")]
    assert [r.scene for r in select(records, "train")] == ["a", "b"]
    assert [r.scene for r in select(records, "train", ["room", "studio"])] == ["b"]
    assert select(records, "test") == []
    with pytest.raises(ValueError, match="got 'validation'"):
        select(records, "validation")


# ---------------------------------------------------------------------------------------------------- folders


def test_a_folder_is_listed_with_what_lies_below(folder: Path) -> None:
    (folder / "more").mkdir()
    for name in ("more/a.EXR", "more/.hidden.exr", "notes.txt"):
        (folder / name).touch()
    (folder / "looks_like_a_file.hdr").mkdir()
    found = read_folder(folder, "val", "studio")
    assert [r.scene for r in found] == ["a", "b", "c", "more/a"]
    assert {(r.split, r.category) for r in found} == {("val", "studio")}
    assert all(r.group == r.scene for r in found)


def test_a_folder_without_panoramas_or_with_twins_is_refused(folder: Path) -> None:
    with pytest.raises(FileNotFoundError, match="found none"):
        read_folder(folder / "nowhere")
    with pytest.raises(ValueError, match="expected a split"):
        read_folder(folder, "all")
    (folder / "a.exr").touch()
    with pytest.raises(ValueError, match="'a' twice"):
        read_folder(folder)


# ------------------------------------------------------------------------------------------------------ files


def test_panoramas_of_either_kind_are_read(tmp_path: Path) -> None:
    panorama = room(16)
    radiance.write(tmp_path / "a.hdr", panorama.numpy())
    exr.write(tmp_path / "a.exr", panorama.numpy(), {})
    torch.testing.assert_close(read_radiance(tmp_path / "a.exr"), panorama, rtol=1e-3, atol=1e-6)
    brightest = panorama.amax(-1, keepdim=True)
    assert bool(((read_radiance(tmp_path / "a.hdr") - panorama).abs() <= brightest / 128).all())


def fake_exr(monkeypatch: pytest.MonkeyPatch, pixels: torch.Tensor) -> None:
    monkeypatch.setattr(panoramas.exr, "read", lambda path: (pixels.numpy().copy(), {}))


def test_ringing_of_lossy_files_is_undone_and_logged(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    pixels = torch.ones(8, 16, 3)
    pixels[3, 4, 1] = -0.009
    fake_exr(monkeypatch, pixels)
    with caplog.at_level(logging.INFO):
        panorama = read_radiance("ringing.exr")
    assert panorama.min() == 0
    assert panorama.sum() == 8 * 16 * 3 - 1
    assert "ringing.exr: values down to -0.009 taken as 0" in caplog.text


def test_overflow_of_half_precision_is_undone_and_logged(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    pixels = torch.ones(8, 16, 3)
    pixels[3, 4] = torch.inf
    fake_exr(monkeypatch, pixels)
    with caplog.at_level(logging.INFO):
        assert read_radiance("sun.exr").max() == 65504
    assert "sun.exr: 3 values beyond half precision" in caplog.text


@pytest.mark.parametrize(
    ("value", "says"), [(torch.nan, "received nan"), (-0.5, "received -0.5"), (-torch.inf, "received -inf")]
)
def test_bad_values_are_refused_by_name(monkeypatch: pytest.MonkeyPatch, value: float, says: str) -> None:
    pixels = torch.ones(8, 16, 3)
    pixels[3, 4, 1] = value
    fake_exr(monkeypatch, pixels)
    with pytest.raises(ValueError, match=rf"bad\.exr: .*{says} at row 3, column 4"):
        read_radiance("bad.exr")


def test_what_is_no_panorama_is_refused_by_name(tmp_path: Path) -> None:
    radiance.write(tmp_path / "flat.hdr", np.ones((8, 24, 3), np.float32))
    (tmp_path / "text.exr").write_text("no picture")
    for name, says in (
        ("flat.hdr", "2:1"),
        ("text.exr", "expected"),
        ("photo.jpg", "got .jpg"),
        ("x", "no suffix"),
    ):
        with pytest.raises(ValueError, match=says) as caught:
            read_radiance(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path / name))
    with pytest.raises(FileNotFoundError):
        read_radiance(tmp_path / "missing.hdr")


def test_large_panoramas_are_reduced_with_their_energy(tmp_path: Path) -> None:
    radiance.write(tmp_path / "a.hdr", room(32).numpy())
    whole, small = load_panorama(tmp_path / "a.hdr"), load_panorama(tmp_path / "a.hdr", max_height=12)
    assert (whole.shape, small.shape) == ((32, 64, 3), (12, 24, 3))
    torch.testing.assert_close(equirect.integrate(small), equirect.integrate(whole))
