"""Orientation and field of view of whole files: each orientation in each kind of file that can carry it."""

import io
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

from mixlight.image.ldr import Photo, read_photo
from tests.image.build import encoded, exif_bytes, png_bytes, png_chunk, write_oiio

H, W = 30, 40


def card() -> np.ndarray:
    """A picture whose four corners differ, in 16-pixel blocks that JPEG keeps apart."""
    pixels = np.full((H, W, 3), 40, np.uint8)
    pixels[:15, :20] = (250, 30, 30)
    pixels[:15, 20:] = (30, 250, 30)
    pixels[15:, :20] = (30, 30, 250)
    return pixels


def corners(photo: Photo) -> str:
    """The corners' colours, clockwise from the top left."""
    spots = (photo.linear[c] for c in ((2, 2), (2, -3), (-3, -3), (-3, 2)))
    return "".join("rgb"[int(s.argmax())] if s.max() > 0.5 else "k" for s in spots)


def expected_corners(orientation: int) -> str:
    image = Image.fromarray(card())
    image.getexif()[274] = orientation
    photo = Photo(np.asarray(ImageOps.exif_transpose(image)) / np.float32(255), "", "", "ldr", 8, (0, 0))
    return corners(photo)


def test_the_card_upright_is_read_clockwise() -> None:
    assert expected_corners(1) == "rgkb"
    assert expected_corners(6) == "brgk"  # turned right: what was at the left is on top


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "PNG16", "TIFF", "TIFF16", "TIFFfloat"])
def test_every_orientation_in_every_kind(tmp_path: Path, kind: str, orientation: int) -> None:
    path, exif = tmp_path / "a", exif_bytes(orientation=orientation)
    if kind == "JPEG":
        path.write_bytes(encoded(card(), kind, exif=exif, quality=95, subsampling=0))
    elif kind == "WEBP":
        path.write_bytes(encoded(card(), kind, exif=exif, lossless=True))
    elif kind == "PNG":
        path.write_bytes(encoded(card(), kind, exif=exif))
    elif kind == "PNG16":
        path.write_bytes(png_bytes(card().astype(np.uint16) * 257, png_chunk(b"eXIf", exif[6:])))
    else:
        scale = {"TIFF": np.uint8(1), "TIFF16": np.uint16(257), "TIFFfloat": np.float32(1 / 255)}[kind]
        name = {"TIFF": "uint8", "TIFF16": "uint16", "TIFFfloat": "float"}[kind]
        write_oiio(tmp_path / "a.tif", card() * scale, name, Orientation=orientation)
        path = tmp_path / "a.tif"
    photo = read_photo(path)
    assert photo.size == ((W, H) if orientation < 5 else (H, W))
    assert photo.linear.flags["C_CONTIGUOUS"]
    assert corners(photo) == expected_corners(orientation)


def degrees(photo: Photo) -> float:
    assert photo.exif_fov is not None
    return math.degrees(photo.exif_fov)


def test_field_of_view_follows_the_orientation(tmp_path: Path) -> None:
    for orientation in range(1, 9):
        data = exif_bytes(orientation=orientation, focal_length_35mm=26)
        (tmp_path / "a.jpg").write_bytes(encoded(card(), "JPEG", exif=data))
        photo = read_photo(tmp_path / "a.jpg")
        # 43.27 mm diagonal of a 4:3 picture: 34.6 x 26.0 mm.
        side = math.hypot(36, 24) * (0.8 if orientation < 5 else 0.6)
        assert degrees(photo) == pytest.approx(math.degrees(2 * math.atan(side / 52)))
        assert photo.exif_fov_source == "EXIF FocalLengthIn35mmFilm 26 mm"


def test_field_of_view_from_the_sensor(tmp_path: Path) -> None:
    tags = {"focal_length": (50, 10), "plane_x": (4000 * 10, 64), "plane_y": (3000 * 10, 48), "plane_unit": 4}
    data = exif_bytes(orientation=6, width=4000, height=3000, **tags)
    (tmp_path / "a.jpg").write_bytes(encoded(card(), "JPEG", exif=data))
    photo = read_photo(tmp_path / "a.jpg")
    assert photo.size == (H, W)
    assert degrees(photo) == pytest.approx(math.degrees(2 * math.atan(2.4 / 5)))
    assert photo.exif_fov_source == "EXIF FocalLength 5 mm on 6.4 x 4.8 mm"


def test_a_photo_without_exif_has_no_angle(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_bytes(encoded(card(), "JPEG"))
    photo = read_photo(tmp_path / "a.jpg")
    assert (photo.exif_fov, photo.exif_fov_source, photo.notes) == (None, None, ())


def test_broken_exif_is_told_and_does_not_stop_the_photo(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_bytes(encoded(card(), "JPEG", exif=b"Exif\0\0broken"))
    photo = read_photo(tmp_path / "a.jpg")
    assert photo.exif_fov is None
    assert photo.notes == ("EXIF data not usable: expected a TIFF header, received b'brok'",)


def test_exif_behind_the_pixels_and_as_text(tmp_path: Path) -> None:
    exif = exif_bytes(orientation=6)[6:]
    data = png_bytes(card())
    (tmp_path / "a.png").write_bytes(data[:-12] + png_chunk(b"eXIf", exif) + data[-12:])
    assert corners(read_photo(tmp_path / "a.png")) == expected_corners(6)
    digits = (b"Exif\0\0" + exif).hex()
    text = f"\nexif\n{len(exif) + 6:8d}\n{digits[:72]}\n{digits[72:]}\n".encode()
    chunk = png_chunk(b"tEXt", b"Raw profile type exif\0" + text)
    (tmp_path / "b.png").write_bytes(png_bytes(card(), chunk))
    assert corners(read_photo(tmp_path / "b.png")) == expected_corners(6)


def test_pillow_and_we_turn_the_same_file_the_same_way() -> None:
    for orientation in range(1, 9):
        data = encoded(card(), "PNG", exif=exif_bytes(orientation=orientation))
        with Image.open(io.BytesIO(data)) as image:
            theirs = np.asarray(ImageOps.exif_transpose(image))
        photo = Photo(theirs / np.float32(255), "", "", "ldr", 8, (0, 0))
        assert corners(photo) == expected_corners(orientation)
