"""The Radiance codec: against OpenCV and OpenImageIO in both directions, headers, axes and broken files."""

from pathlib import Path

import cv2
import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.image import radiance, rgbe
from mixlight.image.color import REC709, rgb_to_xyz_matrix
from mixlight.image.errors import ImageFileError
from tests.image.build import radiance_bytes, random_rgbe


@pytest.fixture
def picture() -> np.ndarray:
    """Radiance over eight decades, with flat stretches and a black patch."""
    generator = np.random.default_rng(7)
    coarse = np.exp(generator.normal(0.0, 3.0, (6, 10, 3))).astype(np.float32)
    values = coarse.repeat(8, axis=0).repeat(9, axis=1)
    values[20:30, 30:60] *= generator.random((10, 30, 3)).astype(np.float32)
    values[:4, :20] = 0.0
    return values


@pytest.mark.parametrize("shape", [(5, 3), (4, 8), (3, 130), (48, 90), (1, 1), (2, 40000)])
def test_what_is_written_is_read(tmp_path: Path, shape: tuple[int, int]) -> None:
    values = np.exp(np.random.default_rng(0).normal(0.0, 4.0, (*shape, 3))).astype(np.float32)
    radiance.write(tmp_path / "a.hdr", values)
    read, header = radiance.read(tmp_path / "a.hdr")
    assert read.dtype == np.float32
    assert header["RESOLUTION"] == f"-Y {shape[0]} +X {shape[1]}"
    error = np.abs(read - values) / values.max(axis=-1, keepdims=True)
    assert error.max() <= 1.0 / 255.0
    # Rounding, not truncation: the mean does not drift.
    if values.size > 1000:
        assert abs(float((read - values).sum() / values.sum())) < 1e-3


def test_a_second_writing_changes_nothing(tmp_path: Path, picture: np.ndarray) -> None:
    radiance.write(tmp_path / "a.hdr", picture)
    once, _ = radiance.read(tmp_path / "a.hdr")
    radiance.write(tmp_path / "b.hdr", once)
    assert (tmp_path / "a.hdr").read_bytes() == (tmp_path / "b.hdr").read_bytes()


def test_opencv_reads_what_we_write(tmp_path: Path, picture: np.ndarray) -> None:
    radiance.write(tmp_path / "a.hdr", picture)
    theirs = cv2.imread(str(tmp_path / "a.hdr"), cv2.IMREAD_UNCHANGED)[..., ::-1]
    np.testing.assert_array_equal(radiance.read(tmp_path / "a.hdr")[0], theirs)


def test_we_read_what_opencv_writes(tmp_path: Path, picture: np.ndarray) -> None:
    for options in ([], [cv2.IMWRITE_HDR_COMPRESSION, cv2.IMWRITE_HDR_COMPRESSION_NONE]):
        cv2.imwrite(str(tmp_path / "a.hdr"), np.ascontiguousarray(picture[..., ::-1]), options)
        theirs = cv2.imread(str(tmp_path / "a.hdr"), cv2.IMREAD_UNCHANGED)[..., ::-1]
        np.testing.assert_array_equal(radiance.read(tmp_path / "a.hdr")[0], theirs)


def test_openimageio_reads_what_we_write(tmp_path: Path, picture: np.ndarray) -> None:
    radiance.write(tmp_path / "a.hdr", picture, {"SOFTWARE": "mixlight"})
    theirs = oiio.ImageBuf(str(tmp_path / "a.hdr")).get_pixels(oiio.FLOAT)
    np.testing.assert_array_equal(radiance.read(tmp_path / "a.hdr")[0], theirs)


def test_we_read_what_openimageio_writes(tmp_path: Path, picture: np.ndarray) -> None:
    buffer = oiio.ImageBuf(oiio.ImageSpec(picture.shape[1], picture.shape[0], 3, "float"))
    buffer.set_pixels(oiio.ROI(), picture)
    assert buffer.write(str(tmp_path / "a.hdr"))
    theirs = oiio.ImageBuf(str(tmp_path / "a.hdr")).get_pixels(oiio.FLOAT)
    np.testing.assert_array_equal(radiance.read(tmp_path / "a.hdr")[0], theirs)


AXES = ["-Y +X", "-Y -X", "+Y +X", "+Y -X", "+X -Y", "-X -Y", "+X +Y", "-X +Y"]


@pytest.mark.parametrize("axes", AXES)
def test_every_axis_order_is_turned_upright(axes: str) -> None:
    # In the file's words the first axis runs over scanlines, the second along them; +Y is up, +X is right.
    upright = random_rgbe(np.random.default_rng(1), 5, 3)
    stored = np.zeros((5, 3, 4) if axes[1] == "Y" else (3, 5, 4), np.uint8)
    for row in range(5):
        for column in range(3):
            place = {
                "Y": row if "-Y" in axes else 4 - row,
                "X": column if "+X" in axes else 2 - column,
            }
            stored[place[axes[1]], place[axes[4]]] = upright[row, column]
    data = radiance_bytes(stored, axes)
    read, header = radiance.read(data)
    np.testing.assert_array_equal(read, rgbe.decode(upright))
    assert read.flags["C_CONTIGUOUS"]
    assert radiance.read_size(data) == (5, 3)
    assert header["RESOLUTION"].split()[0] == axes.split()[0]


def test_openimageio_agrees_on_flips_and_transposes(tmp_path: Path) -> None:
    # OpenImageIO exchanges the two quarter turns: Ward's table calls a file with "+X +Y" turned clockwise, so
    # that a viewer has to turn it back. The test above follows the words of the format for all eight.
    for axes in [a for a in AXES if a not in ("+X +Y", "-X -Y")]:
        stored = random_rgbe(np.random.default_rng(2), 6, 9)
        (tmp_path / "a.hdr").write_bytes(radiance_bytes(stored, axes))
        buffer = oiio.ImageBuf(str(tmp_path / "a.hdr"))
        theirs = oiio.ImageBufAlgo.reorient(buffer).get_pixels(oiio.FLOAT)
        np.testing.assert_array_equal(radiance.read(tmp_path / "a.hdr")[0], theirs, err_msg=axes)


def test_xyz_becomes_rec709() -> None:
    generator = np.random.default_rng(3)
    rgb = generator.random((8, 8, 3)).astype(np.float32) + 0.2
    xyz = (rgb @ rgb_to_xyz_matrix(REC709).T).astype(np.float32)
    data = radiance_bytes(rgbe.encode(xyz), header="FORMAT=32-bit_rle_xyze\n")
    read, header = radiance.read(data)
    assert header["FORMAT"] == "32-bit_rle_xyze"
    np.testing.assert_allclose(read, rgb, atol=0.02)
    # A colour that Rec.709 does not hold (pure X) is clipped, not negative.
    pure = radiance_bytes(np.array([[[128, 0, 0, 129]]], np.uint8), header="FORMAT=32-bit_rle_xyze\n")
    assert radiance.read(pure)[0].min() == 0.0


def test_exposure_and_colour_correction_are_divided_out() -> None:
    pixel = np.array([[[128, 128, 128, 129]]], np.uint8)
    header = "EXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR=1 2 .5\nFORMAT=32-bit_rle_rgbe\n"
    read, entries = radiance.read(radiance_bytes(pixel, header=header))
    np.testing.assert_allclose(read[0, 0], [1 / 8, 1 / 16, 1 / 4])
    assert entries["EXPOSURE"] == "8.0"


def test_primaries_are_adapted_white_to_white_and_zeros_mean_none() -> None:
    pixel = np.array([[[200, 200, 200, 129], [200, 0, 0, 129]]], np.uint8)
    plain, _ = radiance.read(radiance_bytes(pixel))
    zeros, _ = radiance.read(radiance_bytes(pixel, header="PRIMARIES=0 0 0 0 0 0 0 0\n"))
    np.testing.assert_array_equal(zeros, plain)
    p3, _ = radiance.read(radiance_bytes(pixel, header="PRIMARIES=.68 .32 .265 .69 .15 .06 .3127 .329\n"))
    np.testing.assert_allclose(p3[0, 0], plain[0, 0], rtol=1e-5)
    assert p3[0, 1, 0] > 1.2 * plain[0, 1, 0]
    assert p3[0, 1, 1] == 0.0


def test_headers_of_other_programs_are_read() -> None:
    pixel = np.array([[[128, 64, 32, 130]]], np.uint8)
    data = radiance_bytes(pixel, header="# Made with something = else\r\nGAMMA=1\r\n\tVIEW= -vtl\n")
    read, header = radiance.read(data)
    np.testing.assert_allclose(read[0, 0], [2.0, 1.0, 0.5])
    assert header == {"MAGIC": "RADIANCE", "GAMMA": "1", "VIEW": "-vtl", "RESOLUTION": "-Y 1 +X 1"}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "begins with '#\\?RADIANCE', received an empty file"),
        (b"\x89PNG....", "a Radiance picture, which begins with"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "a header that ends in an empty line, received none"),
        (
            b"#?RADIANCE\nFORMAT=ascii\n\n-Y 1 +X 1\n",
            "FORMAT 32-bit_rle_rgbe or 32-bit_rle_xyze, received ascii",
        ),
        (b"#?RADIANCE\n\n-Y 1 +Y 1\n1234", "a size such as '-Y 512 \\+X 1024'"),
        (b"#?RADIANCE\n\n-Y 0 +X 5\n1234", "a size such as"),
        (b"#?RADIANCE\n\nnonsense", "a size such as"),
        (
            b"#?RADIANCE\nEXPOSURE=zero\n\n-Y 1 +X 1\n1234",
            "1 positive number after EXPOSURE, received 'zero'",
        ),
        (b"#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n1234", "1 positive number after EXPOSURE, received '0'"),
        (b"#?RADIANCE\nCOLORCORR=1 2\n\n-Y 1 +X 1\n1234", "3 positive numbers after COLORCORR"),
        (
            b"#?RADIANCE\nPRIMARIES=1 1 1 1 1 1 1 1\n\n-Y 1 +X 1\n1234",
            "expected PRIMARIES: three independent",
        ),
        (b"#?RADIANCE\n\n-Y 999999 +X 999999\n", "at most 268435456 pixels, received 999999 x 999999"),
        (b"#?RADIANCE\n\n-Y 2 +X 2\n123412341234", "2 scanlines, received 1 and a part \\(truncated\\)"),
    ],
)
def test_broken_files_name_the_file_and_the_reason(tmp_path: Path, data: bytes, message: str) -> None:
    (tmp_path / "bad.hdr").write_bytes(data)
    with pytest.raises(ImageFileError, match=message) as caught:
        radiance.read(tmp_path / "bad.hdr")
    assert str(tmp_path / "bad.hdr") in str(caught.value)
    assert "\n" not in str(caught.value)


def test_truncation_anywhere_is_an_error(tmp_path: Path, picture: np.ndarray) -> None:
    radiance.write(tmp_path / "a.hdr", picture)
    data = (tmp_path / "a.hdr").read_bytes()
    for length in range(0, len(data), 97):
        with pytest.raises(ImageFileError):
            radiance.read(data[:length])


def test_a_huge_size_in_a_small_file_allocates_nothing() -> None:
    with pytest.raises(ImageFileError, match="truncated"):
        radiance.read(
            b"#?RADIANCE\n\n-Y 16000 +X 16000\n" + bytes([2, 2, 16000 >> 8, 16000 & 255]) + bytes(500)
        )


def test_a_missing_file_is_an_oserror(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"none\.hdr"):
        radiance.read(tmp_path / "none.hdr")


@pytest.mark.parametrize("value", [np.nan, np.inf, -0.5, 2e38])
def test_values_without_a_place_are_refused(tmp_path: Path, value: float) -> None:
    values = np.ones((4, 9, 3), np.float32)
    values[2, 3, 1] = value
    with pytest.raises(ValueError, match=r"a\.hdr: expected finite values from 0"):
        radiance.write(tmp_path / "a.hdr", values)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "header", [{"FORMAT": "x"}, {"A B": "x"}, {"NOTE": "two\nlines"}, {"EXPOSURE": "1"}, {"": ""}]
)
def test_header_words_that_break_the_file_are_refused(tmp_path: Path, header: dict[str, str]) -> None:
    with pytest.raises(ValueError, match="expected header words other than FORMAT"):
        radiance.write(tmp_path / "a.hdr", np.ones((2, 9, 3), np.float32), header)


def test_shapes_are_checked(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"expected values of shape \[height, width, 3\], received \[0, 4, 3\]"
    ):
        radiance.write(tmp_path / "a.hdr", np.ones((0, 4, 3), np.float32))


@given(st.floats(2.0**-120, 2.0**126, width=32), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_pixels_are_rounded_to_the_nearest(brightest: float, second: float, third: float) -> None:
    values = np.array([[[third * brightest, brightest, second * brightest]]], np.float32)
    pixel = rgbe.encode(values)[0, 0]
    decoded = rgbe.decode(pixel[None, None])[0, 0].astype(np.float64)
    step = 2.0 ** (float(pixel[3]) - 136.0)
    assert pixel[:3].max() >= 128
    assert np.abs(decoded - values[0, 0]).max() <= 0.5 * step


def test_the_ends_of_the_range() -> None:
    values = np.array(
        [[[0.0, 0.0, 0.0], [1e-39, 0.0, 0.0], [1.69e38, 0.0, 0.0], [255.6, 255.4, 127.9]]], np.float32
    )
    assert rgbe.encode(values)[0].tolist() == [
        [0, 0, 0, 0],
        [0, 0, 0, 0],
        [254, 0, 0, 255],
        [128, 128, 64, 137],
    ]
    assert rgbe.decode(
        np.array([[[255, 255, 255, 255], [255, 0, 0, 1], [255, 9, 9, 0]]], np.uint8)
    ).tolist() == [[[255 * 2.0**119] * 3, [255 * 2.0**-135, 0.0, 0.0], [0.0, 0.0, 0.0]]]
