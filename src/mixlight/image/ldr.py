"""Photos: any common file becomes linear Rec.709 light; 1.0 is the photo's own white."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float32, Shaped, UInt8

from mixlight.image import container, exr, radiance
from mixlight.image._array import Array
from mixlight.image.atomic import atomic_path
from mixlight.image.color import srgb_to_linear
from mixlight.image.errors import ImageFileError, one_line
from mixlight.image.exif import field_of_view, turn_upright
from mixlight.image.stored import Stored, load

__all__ = ["MAX_PIXELS", "MIN_SIDE", "WHITE", "Photo", "PhotoError", "read_photo", "write_png"]

MAX_PIXELS = 120_000_000
"""Larger pictures are refused unless the caller raises the cap."""
MIN_SIDE = 16
"""Pictures with a shorter side hold no scene."""

_DARKEST = 2.5 / 255.0 / 12.92
"""Nothing above code 2 of 255: what is left of a black picture is rounding."""
WHITE = float(((253.5 / 255.0 + 0.055) / 1.055) ** 2.4)
"""From code 254 of 255 on a sample counts as clipped."""
_FORMATS = "a photo (JPEG, PNG, WebP, TIFF, OpenEXR or Radiance)"


class PhotoError(ImageFileError):
    """A file cannot serve as a photo; the message names the file, what was expected and what was received."""


@dataclass(frozen=True, eq=False)
class Photo:
    """A photo, upright and in linear light."""

    linear: Float32[Array, "height width 3"]
    """Linear Rec.709, finite and not negative; 1.0 is the photo's white. Colours outside Rec.709 may exceed
    it.
    """
    name: str
    """The file's name without its folder."""
    format: str
    """JPEG, PNG, WebP, TIFF, OpenEXR or Radiance."""
    source: Literal["ldr", "hdr"]
    """hdr: linear floats (OpenEXR, Radiance, float TIFF); ldr: integers on a display curve."""
    bit_depth: int
    """Bits a sample; 32 for linear floats."""
    size: tuple[int, int]
    """Width and height, upright."""
    exif_fov: float | None = None
    """Horizontal field of view in radians, upright, where EXIF tells it."""
    exif_fov_source: str | None = None
    """Which tags it is from, or why they were not used; None without such tags."""
    notes: tuple[str, ...] = ()
    """What a user may want to know about the reading: a profile, alpha, further pages."""

    @property
    def clipped(self) -> Bool[Array, "height width"]:
        """Where a channel reaches white, so that the light may have been brighter; nowhere if hdr."""
        if self.source == "hdr":
            return np.zeros(self.linear.shape[:2], dtype=bool)
        return np.asarray((self.linear >= WHITE).any(axis=-1))


def read_photo(path: str | os.PathLike[str], *, max_pixels: int = MAX_PIXELS) -> Photo:
    """Reads a photo as linear Rec.709 light.

    JPEG, PNG, WebP and TIFF with 8 or 16 bits, grey, palette, CMYK or RGB, with or without alpha; linear
    floats from OpenEXR, Radiance and TIFF. The kind is taken from the file's bytes. Integers are decoded with
    the embedded ICC profile, else with a PNG's gamma, else as sRGB; what a profile puts outside Rec.709 is
    clipped at 0 and may exceed 1. Alpha is composited over black in linear light: what is transparent sends
    no light. EXIF orientation is applied. Of a file with several pages or frames the first counts.

    Convention: the sRGB value 128 of 255 becomes 0.2159; row 0 is the top of the upright picture.

    Args:
        path: the file.
        max_pixels: larger pictures are refused from their header, before anything is decoded.

    Raises:
        PhotoError: (a ValueError) the file is missing, a folder, unreadable, empty, truncated, corrupt or of
            another
            kind; the picture has a side below 16 pixels, more than `max_pixels` pixels, values that are NaN,
            infinite or negative, or is all black (nothing above code 2 of 255).

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_png(folder + "/grey.png", np.full((16, 24, 3), 128, np.uint8))
    ...     photo = read_photo(folder + "/grey.png")
    >>> photo.size, photo.format, round(float(photo.linear[0, 0, 0]), 4)
    ((24, 16), 'PNG', 0.2159)
    """
    path = Path(path)
    try:
        with open(path, "rb") as file:
            head = file.read(64)
        kind, received = container.kind(head)
        if kind is None:
            raise _error(path, _FORMATS, received)
        if kind in ("OpenEXR", "Radiance"):
            photo = _read_hdr(path, kind, max_pixels)
        else:
            photo = _read_ldr(path, kind, max_pixels)
    except OSError as error:
        reason = {"FileNotFoundError": "no such file", "IsADirectoryError": "a folder"}
        raise _error(path, _FORMATS, reason.get(type(error).__name__, error.strerror or error)) from None
    _check_light(path, photo)
    return photo


def write_png(path: str | os.PathLike[str], rgb: UInt8[Array, "height width 3"]) -> None:
    """Writes an 8-bit sRGB picture, atomically.

    Raises:
        OSError: the file cannot be made.
    """
    from PIL import Image

    with atomic_path(path) as temporary:
        Image.fromarray(rgb).save(temporary, format="PNG")


def _error(path: Path, expected: str, received: object) -> PhotoError:
    return PhotoError(f"{one_line(path, 4096)}: expected {expected}, received {one_line(received)}")


def _check_size(path: Path, width: int, height: int, max_pixels: int) -> None:
    if min(width, height) < MIN_SIDE:
        raise _error(path, f"a picture of at least {MIN_SIDE} pixels a side", f"{width} x {height}")
    if width * height > max_pixels:
        raise _error(path, f"at most {max_pixels} pixels", f"{width} x {height} = {width * height}")


def _check_light(path: Path, photo: Photo) -> None:
    high = float(photo.linear.max())  # NaN passes through
    low = float(photo.linear.min()) if photo.source == "hdr" else 0.0  # integers cannot be wrong
    if not (low >= 0.0 and high < np.inf):
        received = "NaN" if np.isnan(low) else f"{low if low < 0.0 else high:g}"
        raise _error(path, "finite values from 0 on", received)
    if high <= (0.0 if photo.source == "hdr" else _DARKEST):
        raise _error(path, "a picture with light in it", "an all-black one")


def _read_hdr(path: Path, kind: str, max_pixels: int) -> Photo:
    codec = exr if kind == "OpenEXR" else radiance
    try:
        height, width = codec.read_size(path)
        _check_size(path, width, height, max_pixels)
        linear, _ = codec.read(path, max_pixels=max_pixels)
    except PhotoError:
        raise
    except ImageFileError as error:
        raise PhotoError(str(error)) from None
    size = (linear.shape[1], linear.shape[0])
    _check_size(
        path, *size, max_pixels
    )  # a file of several parts announces the first and gives the first with colour
    return Photo(linear, path.name, kind, "hdr", 32, size)


def _read_ldr(path: Path, kind: str, max_pixels: int) -> Photo:
    data = path.read_bytes()
    try:
        _check_size(path, *container.announced_size(kind, data), max_pixels)
        stored = load(kind, data)
    except (PhotoError, MemoryError):
        raise
    except Exception as error:  # decoders of foreign data raise whatever they stumble over
        if isinstance(error, ValueError) and str(error).startswith("expected "):
            raise PhotoError(f"{one_line(path, 4096)}: {one_line(error)}") from None
        raise _error(path, f"a complete {kind} picture", error) from None
    del data
    samples = turn_upright(stored.samples, stored.exif.orientation)
    height, width = samples.shape[:2]
    fov, fov_source = field_of_view(stored.exif, width, height)
    alpha = samples.ndim == 3 and samples.shape[2] in (2, 4)
    return Photo(
        linear=_linear(samples, stored),
        name=path.name,
        format=kind,
        source="hdr" if samples.dtype == np.float32 else "ldr",
        bit_depth=8 * samples.dtype.itemsize,
        size=(width, height),
        exif_fov=fov,
        exif_fov_source=fov_source,
        notes=(*stored.notes, *(("alpha composited over black",) if alpha else ())),
    )


def _linear(
    samples: Shaped[Array, "height width *channels"], stored: Stored
) -> Float32[Array, "height width 3"]:
    """Curve, matrix and alpha, a cache-sized strip of rows at a time."""
    linear = np.empty((*samples.shape[:2], 3), dtype=np.float32)
    if samples.ndim == 2:
        samples = samples[..., None]
    has_alpha = samples.shape[2] in (2, 4)
    grey = samples.shape[2] < 3
    is_float = samples.dtype == np.float32
    largest = 1 if is_float else int(np.iinfo(samples.dtype).max)
    tables = [] if is_float else _tables(stored, largest)
    matrix = stored.profile.matrix if stored.profile is not None else None
    rows = max(1, 2**16 // samples.shape[1])
    for row in range(0, len(samples), rows):
        part, out = samples[row : row + rows], linear[row : row + rows]
        colour = part[..., :1] if grey else part[..., :3]
        if is_float:
            out[:] = colour
        elif len(tables) == 1 and not grey:
            np.take(tables[0], colour, mode="clip", out=out)
        else:
            for channel in range(3):
                out[..., channel] = tables[channel % len(tables)][colour[..., 0 if grey else channel]]
        if matrix is not None:
            out[:] = np.maximum(out @ matrix.T.astype(np.float32), 0.0)
        if has_alpha and not stored.premultiplied:
            out *= part[..., -1:] * np.float32(1.0 / largest)
    return linear


def _tables(stored: Stored, largest: int) -> list[Float32[Array, " levels"]]:
    """Linear light for each sample value: one table, or one for each channel."""
    encoded = np.linspace(0.0, 1.0, largest + 1)
    if stored.profile is not None:
        return [curve(encoded).astype(np.float32) for curve in stored.profile.curves]
    if stored.gamma is not None:
        return [(encoded**stored.gamma).astype(np.float32)]
    return [srgb_to_linear(encoded).astype(np.float32)]
