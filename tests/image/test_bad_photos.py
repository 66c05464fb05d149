"""Files that are no photos: each ends in one line with the file, what was expected and what was received."""

import struct
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from mixlight.image import exr, radiance
from mixlight.image.ldr import MAX_PIXELS, PhotoError, read_photo
from tests.image.build import encoded, png_bytes, png_chunk, png_header, write_oiio


def noise(height: int = 64, width: int = 80) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (height, width, 3), dtype=np.uint8)


def refused(path: Path, message: str, **options: int) -> str:
    with pytest.raises(PhotoError, match=message) as caught:
        read_photo(path, **options)
    text = str(caught.value)
    assert text.startswith(f"{path}: expected ")
    assert ", received " in text
    assert "\n" not in text
    assert caught.value.__cause__ is None
    return text


def stored(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


KINDS = r"expected a photo \(JPEG, PNG, WebP, TIFF, OpenEXR or Radiance\), received "


def test_no_such_file(tmp_path: Path) -> None:
    refused(tmp_path / "none.jpg", KINDS + "no such file")
    refused(stored(tmp_path / "file", b"x") / "a.jpg", KINDS)


def test_a_folder(tmp_path: Path) -> None:
    refused(tmp_path, KINDS + "a folder")


def test_an_empty_file(tmp_path: Path) -> None:
    refused(stored(tmp_path / "a.jpg", b""), KINDS + "an empty file")


@pytest.mark.parametrize(
    ("data", "received"),
    [
        (
            b"Dear Sir or Madam, this is no picture.\nRegards",
            "a text that begins with 'Dear Sir or Madam, this",
        ),
        ("Größe: äöü, und so weiter, und so fort".encode(), "a text that begins with 'Größe"),
        (b"GIF89a" + bytes(50), "GIF"),
        (b"BM" + bytes(50), "BMP"),
        (b"\0\0\0\x18ftypheic" + bytes(50), "HEIF"),
        (b"\0\0\0\x18ftypavif" + bytes(50), "AVIF"),
        (b"%PDF-1.7\n" + bytes(50), "PDF"),
        (b"<!DOCTYPE html><html><body>404 Not Found", "a markup text"),
        (b"8BPS\0\1" + bytes(50), "Photoshop"),
        (b"\0\1\2\3\4\5\6\7" * 8, r"unknown data that begin with b'\\x00\\x01"),
    ],
)
def test_other_kinds_of_file_are_named(tmp_path: Path, data: bytes, received: str) -> None:
    refused(stored(tmp_path / "a.jpg", data), KINDS + received)


@pytest.mark.parametrize("kind", ["JPEG", "progressive", "PNG", "PNG16", "WEBP", "TIFF", "TIFF16"])
def test_truncated_anywhere(tmp_path: Path, kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    if kind == "PNG16":
        data = png_bytes(noise(24, 24).astype(np.uint16) * 257)
    elif kind == "TIFF16":
        path = write_oiio(tmp_path / "b.tif", noise().astype(np.uint16) * 257, "uint16", compression="lzw")
        data = path.read_bytes()
    elif kind == "progressive":
        data = encoded(noise(), "JPEG", progressive=True)
    else:
        data = encoded(noise(), kind)
    end = len(data)
    for length in sorted({*range(16, end, max(1, end // 40)), end - 1, end - 2, end - 9}):
        refused(stored(tmp_path / "a.jpg", data[:length]), r"expected .* received")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("fraction", [0.3, 0.6, 0.9])
def test_a_jpeg_whose_rest_is_zeros(tmp_path: Path, fraction: float) -> None:
    # What an interrupted download leaves: the right length, and grey bars in lenient viewers.
    data = encoded(noise(), "JPEG")
    keep = int(len(data) * fraction)
    path = stored(tmp_path / "a.jpg", data[:keep] + bytes(len(data) - keep))
    refused(path, r"expected a JPEG with its end, received \d+ bytes without one \(truncated\)")


def test_a_jpeg_that_announces_more_than_it_holds(tmp_path: Path) -> None:
    # Its end is there, so that a decoder fills 24 million pixels with grey.
    data = encoded(noise(), "JPEG")
    at = data.index(b"\xff\xc0")
    data = data[: at + 5] + struct.pack(">HH", 4000, 6000) + data[at + 9 :]
    refused(
        stored(tmp_path / "a.jpg", data), r"expected bits for 562500 blocks, received \d+ bytes \(truncated\)"
    )


@pytest.mark.parametrize("options", [{}, {"progressive": True, "optimize": True}, {"subsampling": "4:4:4"}])
def test_flat_pictures_need_few_bits_and_are_read(tmp_path: Path, options: dict[str, object]) -> None:
    path = stored(tmp_path / "a.jpg", encoded(Image.new("RGB", (900, 700), "white"), "JPEG", **options))
    assert read_photo(path).linear.min() > 0.99


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "TIFF"])
def test_damaged_bytes_give_a_photo_or_a_photo_error(
    tmp_path: Path, kind: str, recwarn: pytest.WarningsRecorder
) -> None:
    data, generator = encoded(noise(24, 24), kind), np.random.default_rng(1)
    for _ in range(80):
        broken = bytearray(data)
        for _ in range(3):
            broken[int(generator.integers(12, min(len(data), 400)))] = int(generator.integers(0, 256))
        path = stored(tmp_path / "a", bytes(broken))
        try:
            read_photo(path, max_pixels=10**6)
        except PhotoError as error:
            assert str(path) in str(error)  # noqa: PT017


@pytest.mark.parametrize("size", [(1, 1), (15, 400), (400, 15)])
def test_too_small(tmp_path: Path, size: tuple[int, int]) -> None:
    path = stored(tmp_path / "a.png", encoded(Image.new("RGB", size, "white"), "PNG"))
    refused(path, f"expected a picture of at least 16 pixels a side, received {size[0]} x {size[1]}")
    exr.write(tmp_path / "a.exr", np.ones((size[1], size[0], 3), np.float32))
    refused(tmp_path / "a.exr", "expected a picture of at least 16 pixels a side")


def bomb_png(side: int) -> bytes:
    """A picture of side x side black pixels in a few hundred kB, whole and correct."""
    row = zlib.compressobj(9)
    rows = row.compress(bytes(side // 8 + 1) * 1000) + row.flush()
    return png_header(side, side, 1, 0) + png_chunk(b"IDAT", rows) + png_chunk(b"IEND", b"")


@pytest.mark.parametrize(
    "kind", ["PNG", "JPEG", "VP8X", "VP8L", "VP8 ", "TIFF", "BigTIFF", "OpenEXR", "Radiance"]
)
def test_a_bomb_is_refused_from_its_header(tmp_path: Path, kind: str) -> None:
    side = 16000
    if kind == "PNG":
        data = bomb_png(side)
    elif kind == "JPEG":
        data = encoded(noise(), "JPEG")
        at = data.index(b"\xff\xc0")
        data = data[: at + 5] + struct.pack(">HH", side, side) + data[at + 9 :]
    elif kind == "VP8X":
        body = bytes(4) + (side - 1).to_bytes(3, "little") * 2
        data = b"RIFF" + struct.pack("<I", 22) + b"WEBPVP8X" + struct.pack("<I", 10) + body + bytes(20)
    elif kind == "VP8L":
        body = b"\x2f" + ((side - 1) | (side - 1) << 14).to_bytes(4, "little")
        data = b"RIFF" + struct.pack("<I", 30) + b"WEBPVP8L" + struct.pack("<I", 5) + body + bytes(20)
    elif kind == "VP8 ":
        body = b"\0\0\0\x9d\x01\x2a" + struct.pack("<HH", side, side)
        data = b"RIFF" + struct.pack("<I", 30) + b"WEBPVP8 " + struct.pack("<I", 10) + body + bytes(20)
    elif kind == "TIFF":
        entries = [struct.pack("<HHII", tag, 4, 1, side) for tag in (256, 257)]
        data = b"II*\0" + struct.pack("<IH", 8, 2) + b"".join(entries) + bytes(40)
    elif kind == "BigTIFF":
        entries = [struct.pack("<HHQQ", tag, 4, 1, side) for tag in (256, 257)]
        data = b"II+\0\x08\0\0\0" + struct.pack("<QQ", 16, 2) + b"".join(entries) + bytes(40)
    elif kind == "OpenEXR":
        window = (np.array([0, 0], np.int32), np.array([side - 1, side - 1], np.int32))
        header = {"type": OpenEXR.scanlineimage, "displayWindow": window}
        OpenEXR.File(header, {"RGB": np.ones((20, 20, 3), np.float16)}).write(str(tmp_path / "b.exr"))
        data = (tmp_path / "b.exr").read_bytes()
    else:
        data = f"#?RADIANCE\n\n-Y {side} +X {side}\n".encode() + bytes(100)
    path = stored(tmp_path / "bomb", data)
    refused(path, rf"expected at most {MAX_PIXELS} pixels, received 16000 x 16000 = 256000000")
    refused(path, "expected at most 255999999 pixels", max_pixels=255_999_999)
    # With a higher cap the file is refused for what it is.
    if kind not in ("PNG", "OpenEXR"):  # these are whole
        with pytest.raises(PhotoError) as caught:
            read_photo(path, max_pixels=256_000_000)
        assert "at most" not in str(caught.value)


def test_the_cap_of_other_libraries_does_not_matter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = stored(tmp_path / "a.png", encoded(noise(), "PNG"))
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 100)
    assert read_photo(path).size == (80, 64)
    refused(path, "expected at most 5119 pixels, received 80 x 64 = 5120", max_pixels=5119)


@pytest.mark.parametrize(("value", "received"), [(np.nan, "NaN"), (np.inf, "inf"), (-0.5, "-0.5")])
@pytest.mark.parametrize("kind", ["exr", "tif"])
def test_values_that_are_no_light(tmp_path: Path, kind: str, value: float, received: str) -> None:
    values = np.ones((20, 20, 3), np.float32)
    values[7, 8, 1] = value
    path = tmp_path / f"a.{kind}"
    if kind == "exr":
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGB": values}).write(str(path))
    else:
        write_oiio(path, values, "float")
    refused(path, f"expected finite values from 0 on, received {received}")


@pytest.mark.parametrize(
    "kind", ["JPEG", "PNG", "PNG16", "WEBP", "TIFF", "exr", "hdr", "transparent", "nearly"]
)
def test_all_black(tmp_path: Path, kind: str) -> None:
    path, black = tmp_path / "a", np.zeros((32, 32, 3), np.uint8)
    if kind == "exr":
        exr.write(path, black.astype(np.float32))
    elif kind == "hdr":
        radiance.write(path, black.astype(np.float32))
    elif kind == "PNG16":
        path.write_bytes(png_bytes(black.astype(np.uint16) + 400))
    elif kind == "transparent":
        path.write_bytes(encoded(np.dstack([noise(), np.zeros((64, 80), np.uint8)]), "PNG"))
    elif kind == "nearly":
        path.write_bytes(encoded(black + 2, "PNG"))
    else:
        path.write_bytes(encoded(black, kind))
    refused(path, "expected a picture with light in it, received an all-black one")


def test_a_dark_photo_is_a_photo(tmp_path: Path) -> None:
    dark = np.zeros((32, 32, 3), np.uint8)
    dark[5, 5] = 3
    assert read_photo(stored(tmp_path / "a.png", encoded(dark, "PNG"))).linear.max() > 0.0


def test_raw_files_are_not_taken_for_their_previews(tmp_path: Path) -> None:
    path = tmp_path / "a.dng"
    Image.fromarray(noise()).save(path, format="TIFF", tiffinfo={50706: b"\1\4\0\0"})
    refused(path, r"expected a developed picture, received a camera's raw file")
    Image.fromarray(noise()).save(path, format="TIFF", tiffinfo={254: 1})
    refused(path, r"expected a developed picture, received a camera's raw file")


@pytest.mark.parametrize("mode", ["I", "LAB"])
def test_pictures_without_colour_of_ours(tmp_path: Path, mode: str) -> None:
    path = tmp_path / "a.tif"
    Image.new(mode, (20, 20)).save(path)
    refused(path, r"expected grey")


def test_no_samples_of_32_bits(tmp_path: Path) -> None:
    path = write_oiio(tmp_path / "a.tif", noise().astype(np.uint32), "uint")
    refused(path, "expected grey or RGB with 8 or 16 bits or as floats, received 3 channels of 32 bits")


def test_names_with_line_breaks_stay_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(PhotoError) as caught:
        read_photo(tmp_path / "two\nlines.jpg")
    assert "\n" not in str(caught.value)
