"""Painting into a photo: what is not painted stays bit for bit, what is painted is read back as its light."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image, ImageCms

from mixlight.image.encoded import read_encoded
from mixlight.image.ldr import PhotoError, read_photo

RNG = np.random.default_rng(0)
CODES = RNG.integers(3, 250, (40, 60, 3), np.uint8)


def _gamma_profile() -> bytes:
    """sRGB with red and green exchanged: its linear light differs from that of the same codes in sRGB."""
    profile = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    red, green = (profile.index(tag) for tag in (b"rXYZ", b"gXYZ"))
    profile[red : red + 4], profile[green : green + 4] = b"gXYZ", b"rXYZ"
    return bytes(profile)


def _files(folder: Path) -> dict[str, Path]:
    Image.fromarray(CODES).save(folder / "plain.png")
    Image.fromarray(CODES).save(folder / "photo.jpg", quality=95)
    exif = Image.Exif()
    exif[274] = 6
    Image.fromarray(CODES).save(folder / "turned.jpg", quality=95, exif=exif)
    Image.fromarray(CODES).save(folder / "profile.png", icc_profile=_gamma_profile())
    Image.fromarray(CODES[..., 0]).save(folder / "grey.png")
    Image.fromarray(np.dstack([CODES, CODES[..., :1]])).save(folder / "alpha.png")
    deep = CODES.astype(np.uint16) * 257 + RNG.integers(0, 200, CODES.shape, np.uint16)
    cv2.imwrite(str(folder / "deep.png"), deep)
    cv2.imwrite(str(folder / "deep.tif"), deep)
    return {path.name: path for path in folder.iterdir()}


NAMES = [
    "plain.png",
    "photo.jpg",
    "turned.jpg",
    "profile.png",
    "grey.png",
    "alpha.png",
    "deep.png",
    "deep.tif",
]


@pytest.mark.parametrize("name", NAMES)
def test_painted_pixels_have_the_light_and_all_others_their_own_bits(tmp_path: Path, name: str) -> None:
    path = _files(tmp_path)[name]
    photo = read_photo(path)
    encoded = read_encoded(path, photo)
    width, height = photo.size
    where = np.zeros((height, width), bool)
    where[10:20, 10:30] = True
    linear = photo.linear.copy()
    linear[where] = [0.2, 0.3, 0.1]
    painted = encoded.paint(linear[where], where)
    own = encoded.samples if encoded.samples.shape[2] >= 3 else encoded.samples[..., [0, 0, 0]]
    np.testing.assert_array_equal(painted[~where], own[~where])
    out = tmp_path / "out.png"
    encoded.write_png(out, painted)
    again = read_photo(out)
    assert again.size == photo.size
    assert again.bit_depth == photo.bit_depth
    np.testing.assert_array_equal(again.linear[~where], photo.linear[~where])
    step = 0.006 if photo.bit_depth == 8 else 3e-5
    np.testing.assert_allclose(again.linear[where], np.tile([0.2, 0.3, 0.1], (200, 1)), atol=step)


@pytest.mark.parametrize("name", NAMES)
def test_encoding_is_the_inverse_of_reading(tmp_path: Path, name: str) -> None:
    path = _files(tmp_path)[name]
    photo = read_photo(path)
    encoded = read_encoded(path, photo)
    largest = np.iinfo(encoded.samples.dtype).max
    if name != "alpha.png":  # there the light is that over black
        codes = np.round(encoded.encode(photo.linear) * largest)
        own = encoded.samples.astype(float)
        # What the profile put outside Rec.709 was clipped on reading and cannot come back.
        kept = (photo.linear > 0).all(-1) & (photo.linear < 1).all(-1)
        assert kept.mean() > 0.3
        np.testing.assert_allclose(codes[kept], np.broadcast_to(own, codes.shape)[kept], atol=1)


def test_too_bright_is_white(tmp_path: Path) -> None:
    path = _files(tmp_path)["plain.png"]
    encoded = read_encoded(path, read_photo(path))
    np.testing.assert_allclose(encoded.encode(np.array([[7.0, 1.0, -1.0]])), [[1.0, 1.0, 0.0]], atol=1e-12)


def test_linear_floats_have_no_encoding(tmp_path: Path) -> None:
    from mixlight.image import exr

    exr.write(tmp_path / "a.exr", np.ones((20, 20, 3), np.float32))
    with pytest.raises(PhotoError, match="linear floats"):
        read_encoded(tmp_path / "a.exr", read_photo(tmp_path / "a.exr"))
