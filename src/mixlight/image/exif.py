"""What EXIF data tell about a picture's geometry: which way is up, and how wide the lens saw.

Source: CIPA DC-008-2023 (EXIF 3.0); CIPA DCG-001 for the 35 mm equivalent.
"""

import math
from dataclasses import dataclass

from jaxtyping import Shaped

from mixlight.image._array import Array
from mixlight.image.tiff_structure import Directory, read_directory

__all__ = ["Exif", "field_of_view", "parse", "turn_upright"]

FULL_FRAME_DIAGONAL = math.hypot(36.0, 24.0)
"""Millimetres; the diagonal of the 35 mm frame that equivalent focal lengths refer to."""

_ORIENTATION, _EXIF_DIRECTORY = 274, 34665
_FOCAL_LENGTH, _FOCAL_LENGTH_35MM = 37386, 41989
_WIDTH, _HEIGHT = 40962, 40963
_PLANE_X, _PLANE_Y, _PLANE_UNIT = 41486, 41487, 41488
_MILLIMETRES = {1: 25.4, 2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}  # 1 (no unit) is written where inches are meant


@dataclass(frozen=True)
class Exif:
    """The tags that matter here; numbers that are absent or senseless are None."""

    orientation: int = 1
    """1 to 8, as stored; 1 is upright."""
    focal_length: float | None = None
    """Millimetres."""
    focal_length_35mm: float | None = None
    """Millimetres on the 35 mm frame."""
    pixel_pitch: tuple[float, float] | None = None
    """Millimetres of sensor for each pixel of the original picture, horizontally and vertically."""
    original_size: tuple[int, int] | None = None
    """Width and height of the picture as the camera wrote it."""


def parse(data: bytes | bytearray) -> Exif:
    r"""Reads EXIF data, with or without the leading `Exif\0\0`, or a whole TIFF file.

    Raises:
        ValueError: the data are no EXIF data.

    >>> entry = bytes([18, 1, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0])
    >>> parse(b"Exif\0\0II*\0" + bytes([8, 0, 0, 0, 1, 0]) + entry).orientation
    6
    """
    if data[:6] == b"Exif\0\0":
        data = data[6:]
    main = read_directory(data)
    orientation = main.first(_ORIENTATION, 1)
    details = main
    if _EXIF_DIRECTORY in main.numbers:
        details = read_directory(data, int(main.first(_EXIF_DIRECTORY, 0)))
    unit = _MILLIMETRES.get(int(details.first(_PLANE_UNIT, 2)))
    x, y = _positive(details, _PLANE_X), _positive(details, _PLANE_Y)
    width, height = _positive(details, _WIDTH), _positive(details, _HEIGHT)
    return Exif(
        orientation=int(orientation) if orientation in range(1, 9) else 1,
        focal_length=_positive(details, _FOCAL_LENGTH),
        focal_length_35mm=_positive(details, _FOCAL_LENGTH_35MM),
        pixel_pitch=(unit / x, unit / (y or x)) if unit and x else None,
        original_size=(int(width), int(height)) if width and height else None,
    )


def _positive(directory: Directory, tag: int) -> float | None:
    value = directory.first(tag, math.nan)
    return float(value) if 0.0 < value < math.inf else None


def field_of_view(exif: Exif, width: int, height: int) -> tuple[float | None, str | None]:
    """The horizontal field of view of the upright picture, and in words where it comes from.

    From the 35 mm equivalent f it is 2 atan(d w / (2 f sqrt(w^2 + h^2))), d = 43.27 mm: equivalence means an
    equal diagonal. Otherwise from the focal length and the sensor's side s (pixels times pitch): 2 atan(s /
    (2 f)). The sensor's longer side belongs to the picture's longer side, whichever way the camera was held
    and whether or not some program turned the pixels without correcting the tags.

    Convention: radians, between 1 and 170 degrees; 26 mm on a 4:3 phone is 67.4 degrees held level and 53.1
    degrees held upright. A picture that is cropped (its aspect is not the original's by more than 2 %) gives
    None, with the reason in words; so does a value out of range. Without tags both are None.

    Args:
        exif: from `parse`.
        width: columns of the upright picture.
        height: rows of it.

    >>> [round(math.degrees(field_of_view(Exif(focal_length_35mm=26.0), *s)[0]), 1) for s in ((4, 3), (3, 4))]
    [67.3, 53.1]
    """
    if exif.focal_length_35mm is None and (exif.focal_length is None or exif.pixel_pitch is None):
        return None, None
    original = exif.original_size or (width, height)
    aspect = max(original) / min(original) * min(width, height) / max(width, height)
    if not 1.0 / 1.02 < aspect < 1.02:
        return (
            None,
            f"EXIF focal length not used: {width} x {height} is a crop of {original[0]} x {original[1]}",
        )
    if exif.focal_length_35mm is not None:
        half = FULL_FRAME_DIAGONAL * width / math.hypot(width, height) / (2.0 * exif.focal_length_35mm)
        source = f"EXIF FocalLengthIn35mmFilm {exif.focal_length_35mm:g} mm"
    else:
        assert exif.pixel_pitch is not None
        assert exif.focal_length is not None
        sensor = sorted(pixels * pitch for pixels, pitch in zip(original, exif.pixel_pitch, strict=True))
        half = sensor[width >= height] / (2.0 * exif.focal_length)
        source = f"EXIF FocalLength {exif.focal_length:g} mm on {sensor[1]:.1f} x {sensor[0]:.1f} mm"
    angle = 2.0 * math.atan(half)
    if not 1.0 < math.degrees(angle) < 170.0:
        return None, f"{source} not used: {math.degrees(angle):.3g} degrees are out of range (1 to 170)"
    return angle, source


def turn_upright(
    stored: Shaped[Array, "rows columns *channels"], orientation: int
) -> Shaped[Array, "height width *channels"]:
    """The picture as it is meant to be seen, as a view of the stored pixels.

    Convention: 1 as stored, 2 mirrored, 3 turned by half, 4 upside down mirrored, 5 transposed, 6 to be
    turned right by a quarter, 7 transposed over the other diagonal, 8 to be turned left.

    Raises:
        ValueError: an orientation other than 1 to 8.

    >>> import numpy as np
    >>> turn_upright(np.array([[1, 2], [3, 4]]), 6).tolist()
    [[3, 1], [4, 2]]
    """
    if orientation not in range(1, 9):
        raise ValueError(f"expected an orientation from 1 to 8, received {orientation}")
    if orientation >= 5:
        stored = stored.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        stored = stored[::-1]
    if orientation in (2, 3, 6, 7):
        stored = stored[:, ::-1]
    return stored
