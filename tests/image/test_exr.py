"""OpenEXR in and out: against OpenImageIO, every layout of channels, attributes, windows and broken files."""

import io
from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from mixlight.image import exr
from mixlight.image.errors import ImageFileError
from mixlight.image.exr_structure import read_parts
from tests.image.build import write_oiio
from tests.tolerances import HALF_FILE

SCANLINES = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}


@pytest.fixture
def picture() -> np.ndarray:
    return np.exp(np.random.default_rng(0).normal(0.0, 2.0, (20, 40, 3))).astype(np.float32)


def half(*shape: int) -> np.ndarray:
    return np.random.default_rng(sum(shape)).random(shape).astype(np.float16)


def store(path: Path, channels: dict[str, object], **header: object) -> Path:
    OpenEXR.File({**SCANLINES, **header}, channels).write(str(path))
    return path


def test_what_is_written_is_read_with_its_attributes(tmp_path: Path, picture: np.ndarray) -> None:
    entries = {"frame": "mixlight", "model": "größer", "exposure_gain": 0.25, "count": 3, "empty": ""}
    exr.write(tmp_path / "a.exr", picture, entries)
    read, attributes = exr.read(tmp_path / "a.exr")
    assert read.dtype == np.float32
    np.testing.assert_allclose(read, picture, **HALF_FILE)
    assert entries.items() <= attributes.items()
    assert attributes["envmap"] == "latlong"
    assert attributes["compression"] == "zip"
    np.testing.assert_allclose(
        attributes["chromaticities"], (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
    )
    assert exr.read_size(tmp_path / "a.exr") == (20, 40)
    assert [p.name for p in tmp_path.iterdir()] == ["a.exr"]


def test_openimageio_reads_what_we_write(tmp_path: Path, picture: np.ndarray) -> None:
    exr.write(tmp_path / "a.exr", picture, {"frame": "mixlight", "exposure_gain": 0.25})
    theirs = oiio.ImageBuf(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(theirs.get_pixels(oiio.FLOAT), exr.read(tmp_path / "a.exr")[0])
    spec = theirs.spec()
    assert (str(spec.format), spec.getattribute("compression")) == ("half", "zip")
    assert (spec.getattribute("frame"), spec.getattribute("exposure_gain")) == ("mixlight", 0.25)
    assert "latlong" in str(spec.getattribute("textureformat")).lower()
    np.testing.assert_allclose(spec.getattribute("chromaticities")[:2], (0.64, 0.33))


@pytest.mark.parametrize("compression", ["none", "rle", "zips", "zip", "piz", "pxr24", "dwaa", "dwab"])
@pytest.mark.parametrize("kind", ["half", "float"])
def test_we_read_what_openimageio_writes(
    tmp_path: Path, picture: np.ndarray, compression: str, kind: str
) -> None:
    path = write_oiio(tmp_path / "a.exr", picture, kind, compression=compression)
    theirs = oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)
    np.testing.assert_array_equal(exr.read(path)[0], theirs)


def test_tiles_are_read(tmp_path: Path, picture: np.ndarray) -> None:
    buffer = oiio.ImageBuf(oiio.ImageSpec(40, 20, 3, "half"))
    buffer.set_pixels(oiio.ROI(), picture)
    buffer.set_write_tiles(16, 16)
    assert buffer.write(str(tmp_path / "a.exr"))
    np.testing.assert_allclose(exr.read(tmp_path / "a.exr")[0], picture, **HALF_FILE)


@pytest.mark.parametrize(
    "channels",
    [
        {"RGB": half(4, 8, 3)},
        {"RGB": half(4, 8, 3).astype(np.float32)},
        {"RGBA": half(4, 8, 4)},
        {"R": half(4, 8), "G": half(4, 8), "B": half(4, 8)},
        {"R": half(4, 8), "G": half(4, 8).astype(np.float32), "B": half(4, 8)},
        {"R": half(4, 8), "G": half(4, 8), "B": half(4, 8), "Z": half(4, 8).astype(np.float32)},
        {"RGB": half(4, 8, 3), "normal.RGB": half(4, 8, 3)},
        {"Y": half(4, 8)},
        {"Y": half(4, 8).astype(np.float32), "A": half(4, 8).astype(np.float32)},
        {"view.combined.R": half(4, 8), "view.combined.G": half(4, 8), "view.combined.B": half(4, 8)},
        {f"view.combined.{c}": half(4, 8) for c in "RGBA"} | {"view.depth.Z": half(4, 8).astype(np.float32)},
        {"l.R": half(4, 8), "l.G": half(4, 8).astype(np.float32), "l.B": half(4, 8)},
    ],
)
def test_colour_is_found_in_every_layout(tmp_path: Path, channels: dict[str, np.ndarray]) -> None:
    read, _ = exr.read(store(tmp_path / "a.exr", dict(channels)))
    first = next(iter(channels.values()))
    if first.ndim == 3:
        expected = first[..., :3]
    else:
        names = [n for n in channels if n.split(".")[-1] in ("R", "G", "B")] or ["Y"] * 3
        by_letter = sorted(names, key=lambda n: "RGBY".index(n.split(".")[-1]))
        expected = np.stack([channels[n] for n in by_letter], axis=-1)
    np.testing.assert_array_equal(read, expected.astype(np.float32))
    assert read.flags["C_CONTIGUOUS"]
    assert read.flags["WRITEABLE"]


def test_the_first_part_with_colour_counts(tmp_path: Path) -> None:
    colour = half(4, 8, 3)
    parts = [
        OpenEXR.Part(dict(SCANLINES), {"Z": half(4, 8)}, "depth"),
        OpenEXR.Part({**SCANLINES, "note": "here"}, {"RGB": colour}, "colour"),
    ]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    read, attributes = exr.read(tmp_path / "a.exr")
    np.testing.assert_array_equal(read, colour.astype(np.float32))
    assert attributes["note"] == "here"


@pytest.mark.parametrize(
    ("channels", "named"),
    [
        ({"Z": half(4, 8)}, "received Z"),
        ({"R": half(4, 8)}, "received R"),
        ({"RGB": half(4, 8, 3).astype(np.uint32)}, "received B, G, R"),
        (
            {f"{layer}.{c}": half(4, 8) for layer in "ab" for c in "RGB"},
            "received a.B, a.G, a.R, b.B, b.G, b.R",
        ),
    ],
)
def test_pictures_without_a_colour_name_their_channels(
    tmp_path: Path, channels: dict[str, np.ndarray], named: str
) -> None:
    with pytest.raises(
        ImageFileError, match=r"a\.exr: expected half or float channels R, G, B or Y"
    ) as caught:
        exr.read(store(tmp_path / "a.exr", channels))
    assert named in str(caught.value)


def window(x0: int, y0: int, x1: int, y1: int) -> tuple[np.ndarray, np.ndarray]:
    return np.array([x0, y0], np.int32), np.array([x1, y1], np.int32)


@pytest.mark.parametrize(
    ("data", "display"),
    [
        ((2, 1, 9, 4), (0, 0, 11, 6)),
        ((-2, -1, 5, 2), (0, 0, 11, 6)),
        ((5, 5, 12, 8), (0, 0, 11, 6)),
        ((-1, -1, 6, 2), (0, 0, 3, 1)),
        ((20, 20, 27, 23), (0, 0, 3, 1)),
        ((3, 2, 10, 5), (3, 2, 10, 5)),
    ],
)
def test_the_display_window_is_the_picture(
    tmp_path: Path, data: tuple[int, int, int, int], display: tuple[int, int, int, int]
) -> None:
    colour = half(4, 8, 3)
    path = store(
        tmp_path / "a.exr", {"RGB": colour}, dataWindow=window(*data), displayWindow=window(*display)
    )
    read, _ = exr.read(path)
    expected = np.zeros((display[3] - display[1] + 1, display[2] - display[0] + 1, 3), np.float32)
    for y in range(4):
        for x in range(8):
            row, column = y + data[1] - display[1], x + data[0] - display[0]
            if 0 <= row < expected.shape[0] and 0 <= column < expected.shape[1]:
                expected[row, column] = colour[y, x]
    np.testing.assert_array_equal(read, expected)


def test_other_primaries_become_rec709(tmp_path: Path) -> None:
    ap0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)  # ACES
    colour = np.array([[[0.5, 0.5, 0.5], [0.0, 1.0, 0.0]]], np.float16)
    read, attributes = exr.read(store(tmp_path / "a.exr", {"RGB": colour}, chromaticities=ap0))
    np.testing.assert_allclose(read[0, 0], 0.5, rtol=1e-4)
    # ACES 2065-1 green in Rec.709 is published as (-1.134, 1.373, -0.148).
    np.testing.assert_allclose(read[0, 1], [0.0, 1.373, 0.0], atol=2e-3)
    np.testing.assert_allclose(attributes["chromaticities"], ap0, atol=1e-6)


def test_senseless_values_come_back_for_the_caller_to_judge(tmp_path: Path) -> None:
    colour = np.array([[[np.nan, -1.0, np.inf]]], np.float16)
    read, _ = exr.read(store(tmp_path / "a.exr", {"RGB": colour}))
    np.testing.assert_array_equal(read[0, 0], [np.nan, -1.0, np.inf])
    p3 = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329)
    read, _ = exr.read(store(tmp_path / "b.exr", {"RGB": colour}, chromaticities=p3))
    assert np.isnan(read).any()


def test_bright_values_are_clamped_and_dark_ones_kept(tmp_path: Path) -> None:
    values = np.array([[[1e6, 65504.0, 65519.0], [6e-8, 1e-9, 0.0]]], np.float32)
    exr.write(tmp_path / "a.exr", values)
    read, attributes = exr.read(tmp_path / "a.exr")
    np.testing.assert_array_equal(read[0, 0], [65504.0] * 3)
    np.testing.assert_allclose(read[0, 1], [6e-8, 0.0, 0.0], rtol=0.01)
    assert attributes["envmap"] == "latlong"  # 2:1
    exr.write(tmp_path / "b.exr", values[:, :1])
    assert "envmap" not in exr.read(tmp_path / "b.exr")[1]


@pytest.mark.parametrize(("value", "received"), [(np.nan, "NaN"), (np.inf, "inf"), (-1.5, "-1.5")])
def test_values_that_are_no_radiance_are_refused(tmp_path: Path, value: float, received: str) -> None:
    values = np.ones((2, 4, 3), np.float32)
    values[1, 2, 0] = value
    with pytest.raises(ValueError, match=rf"a\.exr: expected finite values from 0 on, received {received}"):
        exr.write(tmp_path / "a.exr", values)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "attributes",
    [
        {"channels": "x"},
        {"chromaticities": "x"},
        {"two words": "x"},
        {"": "x"},
        {"n" * 256: "x"},
        {"flag": True},
        {"big": 2**31},
        {"number": np.float64(1.0)},
    ],
)
def test_attributes_that_break_the_file_are_refused(tmp_path: Path, attributes: dict[str, str]) -> None:
    with pytest.raises(ValueError, match=r"a\.exr: expected .* received"):
        exr.write(tmp_path / "a.exr", np.ones((2, 4, 3), np.float32), attributes)
    assert list(tmp_path.iterdir()) == []


def test_every_truncation_is_one_error(
    tmp_path: Path, picture: np.ndarray, capfd: pytest.CaptureFixture[str]
) -> None:
    exr.write(tmp_path / "a.exr", picture, {"frame": "mixlight"})
    data = (tmp_path / "a.exr").read_bytes()
    for length in [*range(0, len(data), 61), len(data) - 1]:
        (tmp_path / "b.exr").write_bytes(data[:length])
        with pytest.raises(ImageFileError, match=r"b\.exr: expected .* received .*") as caught:
            exr.read(tmp_path / "b.exr")
        assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""  # the library never gets to see, and to comment on, such a file


@pytest.mark.parametrize("layout", ["multipart", "tiled", "tall"])
def test_truncation_is_seen_in_every_layout(
    tmp_path: Path, layout: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.exr"
    if layout == "multipart":
        OpenEXR.File([OpenEXR.Part(dict(SCANLINES), {"RGB": half(30, 8, 3)}, n) for n in "ab"]).write(
            str(path)
        )
    elif layout == "tiled":
        buffer = oiio.ImageBuf(oiio.ImageSpec(40, 30, 3, "half"))
        buffer.set_pixels(oiio.ROI(), half(30, 40, 3).astype(np.float32))
        buffer.set_write_tiles(16, 16)
        assert buffer.write(str(path))
    else:
        store(path, {"RGB": half(70, 8, 3)})
    exr.read(path)
    data = path.read_bytes()
    for cut in (1, 200, len(data) // 2):
        path.write_bytes(data[:-cut])
        with pytest.raises(ImageFileError, match=r"truncated"):
            exr.read(path)
    assert capfd.readouterr().err == ""


def test_corrupt_pixels_are_an_error(tmp_path: Path) -> None:
    path = store(tmp_path / "a.exr", {"RGB": half(40, 50, 3)})
    data = bytearray(path.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 300] = bytes(300)
    path.write_bytes(data)
    with pytest.raises(
        ImageFileError, match=r"a\.exr: expected an OpenEXR picture that can be decoded, received"
    ):
        exr.read(path)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "expected an OpenEXR file, received an empty file"),
        (b"#?RADIANCE\n", r"received a file that begins with b'#\?RADIAN'"),
        (b"\x76\x2f\x31\x01\x02\0\0\0\0", "expected a complete OpenEXR header, received no dataWindow in it"),
        (
            b"\x76\x2f\x31\x01\x02\0\0\0" + b"x" * 300,
            "expected a complete OpenEXR header, received 308 bytes",
        ),
    ],
)
def test_other_files_are_named_for_what_they_are(tmp_path: Path, data: bytes, message: str) -> None:
    (tmp_path / "a.exr").write_bytes(data)
    with pytest.raises(ImageFileError, match=message):
        exr.read(tmp_path / "a.exr")
    with pytest.raises(ValueError, match=message):
        read_parts(io.BytesIO(data))


def test_size_is_capped_from_the_header(tmp_path: Path, picture: np.ndarray) -> None:
    exr.write(tmp_path / "a.exr", picture)
    with pytest.raises(ImageFileError, match=r"expected at most 799 pixels, received 40 x 20"):
        exr.read(tmp_path / "a.exr", max_pixels=799)
    path = store(tmp_path / "b.exr", {"RGB": half(2, 4, 3)}, displayWindow=window(0, 0, 99999, 99999))
    with pytest.raises(ImageFileError, match=r"expected at most 268435456 pixels, received 100000 x 100000"):
        exr.read(path)


def test_files_that_cannot_be_opened_or_made_are_oserrors(tmp_path: Path, picture: np.ndarray) -> None:
    with pytest.raises(FileNotFoundError, match=r"none\.exr"):
        exr.read(tmp_path / "none.exr")
    with pytest.raises(IsADirectoryError):
        exr.read(tmp_path)
    with pytest.raises(FileNotFoundError, match="a.exr"):  # noqa: RUF043
        exr.write(tmp_path / "none" / "a.exr", picture)
