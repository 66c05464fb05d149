"""EXIF: against Pillow's orientation, fields of view worked out by hand, and senseless tags."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageOps

from mixlight.image.exif import Exif, field_of_view, parse, turn_upright
from tests.image.build import encoded, exif_bytes


def degrees(exif: Exif, width: int, height: int) -> float:
    angle, _ = field_of_view(exif, width, height)
    assert angle is not None
    return math.degrees(angle)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pillow_turns_the_same_way(orientation: int) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    image = Image.fromarray(pixels)
    exif = image.getexif()
    exif[274] = orientation
    theirs = ImageOps.exif_transpose(image)
    np.testing.assert_array_equal(turn_upright(pixels, orientation), np.asarray(theirs))


@pytest.mark.parametrize("orientation", [0, 9, -1])
def test_orientations_that_are_none(orientation: int) -> None:
    with pytest.raises(ValueError, match=f"expected an orientation from 1 to 8, received {orientation}"):
        turn_upright(np.zeros((2, 2)), orientation)


@pytest.mark.parametrize("order", ["<", ">"])
def test_all_tags_in_both_byte_orders(order: str) -> None:
    data = exif_bytes(
        order,
        orientation=6,
        focal_length=(50, 10),
        focal_length_35mm=28,
        width=4000,
        height=3000,
        plane_x=(4000 * 10, 64),
        plane_y=(3000 * 10, 48),
        plane_unit=4,
    )
    exif = parse(data)
    assert exif == Exif(6, 5.0, 28.0, (64 / 40000, 48 / 30000), (4000, 3000))
    assert parse(data[6:]) == exif  # as PNG stores it


def test_pillow_writes_what_we_read() -> None:
    tags = Image.Exif()
    tags[274] = 8
    tags.get_ifd(34665).update({37386: 4.25, 41989: 26, 40962: 4032, 40963: 3024})
    image = Image.new("RGB", (8, 8))
    with Image.open(__import__("io").BytesIO(encoded(image, "JPEG", exif=tags))) as reread:
        exif = parse(reread.info["exif"])
    assert exif == Exif(8, 4.25, 26.0, None, (4032, 3024))


def test_equivalent_focal_length_level_and_upright() -> None:
    # 43.27 mm diagonal: a 3:2 picture sees through the 36 mm side, held upright through the 24 mm side.
    exif = Exif(focal_length_35mm=36.0)
    assert degrees(exif, 6000, 4000) == pytest.approx(math.degrees(2 * math.atan(36 / 72)))
    assert degrees(exif, 4000, 6000) == pytest.approx(math.degrees(2 * math.atan(24 / 72)))
    assert field_of_view(exif, 6000, 4000)[1] == "EXIF FocalLengthIn35mmFilm 36 mm"


def test_sensor_size_from_pitch_level_and_upright() -> None:
    # A 6.4 x 4.8 mm sensor behind 5 mm.
    exif = Exif(focal_length=5.0, pixel_pitch=(6.4 / 4000, 4.8 / 3000), original_size=(4000, 3000))
    assert degrees(exif, 4000, 3000) == pytest.approx(math.degrees(2 * math.atan(3.2 / 5)))
    assert degrees(exif, 3000, 4000) == pytest.approx(math.degrees(2 * math.atan(2.4 / 5)))
    # Scaled down afterwards: the tags speak of the original.
    assert degrees(exif, 800, 600) == pytest.approx(math.degrees(2 * math.atan(3.2 / 5)))
    assert field_of_view(exif, 800, 600)[1] == "EXIF FocalLength 5 mm on 6.4 x 4.8 mm"
    # Without the original's size the picture counts as the original.
    plain = Exif(focal_length=5.0, pixel_pitch=(6.4 / 4000, 4.8 / 3000))
    assert degrees(plain, 4000, 3000) == pytest.approx(math.degrees(2 * math.atan(3.2 / 5)))


@given(st.floats(8.0, 300.0), st.integers(100, 5000), st.integers(100, 5000))
def test_both_ways_agree_and_the_long_side_sees_more(focal: float, width: int, height: int) -> None:
    diagonal = math.hypot(36.0, 24.0)
    pitch = diagonal / math.hypot(width, height)
    by_equivalent = field_of_view(Exif(focal_length_35mm=focal), width, height)[0]
    by_sensor = field_of_view(Exif(focal_length=focal, pixel_pitch=(pitch, pitch)), width, height)[0]
    assert by_equivalent == pytest.approx(by_sensor)
    turned = field_of_view(Exif(focal_length_35mm=focal), height, width)[0]
    if by_equivalent is not None and turned is not None:
        assert (by_equivalent >= turned) == (width >= height)


def test_a_crop_is_recognised() -> None:
    exif = Exif(focal_length_35mm=26.0, original_size=(4000, 3000))
    angle, reason = field_of_view(exif, 3000, 3000)
    assert angle is None
    assert reason == "EXIF focal length not used: 3000 x 3000 is a crop of 4000 x 3000"
    assert field_of_view(exif, 1000, 752)[0] is not None


def test_without_tags_there_is_no_angle() -> None:
    assert field_of_view(Exif(), 4, 3) == (None, None)
    assert field_of_view(Exif(focal_length=5.0), 4, 3) == (None, None)


@pytest.mark.parametrize("focal", [1.0, 5000.0])
def test_angles_out_of_range_are_not_used(focal: float) -> None:
    angle, reason = field_of_view(Exif(focal_length_35mm=focal), 4, 3)
    assert angle is None
    assert "out of range" in str(reason)


@pytest.mark.parametrize("unit", [0, 9])
def test_unknown_units_and_senseless_numbers_are_absent(unit: int) -> None:
    data = exif_bytes(
        orientation=77, focal_length=(1, 0), focal_length_35mm=0, plane_x=(9, 1), plane_unit=unit
    )
    assert parse(data) == Exif()


def test_units_of_the_focal_plane() -> None:
    for unit, millimetres in ((2, 25.4), (3, 10.0), (4, 1.0), (5, 0.001)):
        assert parse(exif_bytes(plane_x=(100, 1), plane_unit=unit)).pixel_pitch == (millimetres / 100,) * 2
    assert parse(exif_bytes(plane_x=(100, 1))).pixel_pitch == (0.254, 0.254)


def test_broken_data_are_errors_or_ignored_but_never_a_crash() -> None:
    with pytest.raises(ValueError, match="expected a TIFF header"):
        parse(b"Exif\0\0nonsense")
    data = exif_bytes(orientation=6, focal_length=(50, 10), focal_length_35mm=28)
    generator = np.random.default_rng(0)
    for _ in range(300):
        broken = bytearray(data[: int(generator.integers(6, len(data) + 1))])
        broken[int(generator.integers(6, len(broken) + 1)) - 1] = int(generator.integers(0, 256))
        try:
            parse(bytes(broken))
        except ValueError as error:
            assert "expected" in str(error)  # noqa: PT017
