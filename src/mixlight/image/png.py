"""PNG files as photos need them: 8 or 16 bits, with the colour profile or gamma of the pixels.

Pillow writes no 16-bit colour and OpenCV no profile, so that neither keeps a photo's own pixels as they are.

Source: W3C, Portable Network Graphics (third edition), 2025.
"""

import os
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from jaxtyping import Shaped

from mixlight.image._array import Array
from mixlight.image.atomic import atomic_path

__all__ = ["write"]

_COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}


def write(
    path: str | os.PathLike[str],
    samples: Shaped[Array, "height width channels"],
    *,
    profile: bytes = b"",
    gamma: float | None = None,
) -> None:
    """Writes samples as they are, atomically.

    Args:
        path: the file to make.
        samples: uint8 or uint16; grey, grey with alpha, RGB, or RGB with straight alpha.
        profile: an ICC profile to embed; without one the file says sRGB.
        gamma: the exponent that decodes the samples, where the file is neither sRGB nor has a profile.

    Raises:
        ValueError: samples of another type or shape.
        OSError: the file cannot be made.

    >>> import tempfile
    >>> from mixlight.image.ldr import read_photo
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(folder + "/grey.png", np.full((16, 24, 3), 32768, np.uint16))
    ...     photo = read_photo(folder + "/grey.png")
    >>> photo.bit_depth, round(float(photo.linear[0, 0, 0]), 4)
    (16, 0.2140)
    """
    if (
        samples.dtype not in (np.uint8, np.uint16)
        or samples.ndim != 3
        or samples.shape[2] not in _COLOUR_TYPES
    ):
        raise ValueError(
            f"{path}: expected [height, width, 1 to 4] of 8 or 16 bits, "
            f"received {list(samples.shape)} of {samples.dtype}"
        )
    height, width, channels = samples.shape
    if 0 in samples.shape:
        raise ValueError(f"{path}: expected a picture of at least 1 x 1, received {width} x {height}")
    bits = 8 * samples.dtype.itemsize
    header = struct.pack(">IIBBBBB", width, height, bits, _COLOUR_TYPES[channels], 0, 0, 0)
    with atomic_path(path) as temporary, open(temporary, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(_chunk(b"IHDR", header))
        if profile:
            file.write(_chunk(b"iCCP", b"ICC profile\0\0" + zlib.compress(profile)))
        elif gamma is not None:
            file.write(_chunk(b"gAMA", struct.pack(">I", round(1e5 / gamma))))
        else:
            file.write(_chunk(b"sRGB", b"\0"))
        for data in _compressed(samples):
            file.write(_chunk(b"IDAT", data))
        file.write(_chunk(b"IEND", b""))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _compressed(samples: Shaped[Array, "height width channels"]) -> Iterator[bytes]:
    """Rows as differences to the row above (filter 2), deflated, a strip at a time."""
    height = len(samples)
    big_endian = samples.dtype.newbyteorder(">")
    deflate = zlib.compressobj(6)
    above = np.zeros((1, samples.shape[1] * samples.shape[2] * samples.dtype.itemsize), np.uint8)
    rows = max(1, 2**20 // above.shape[1])
    for start in range(0, height, rows):
        strip = np.ascontiguousarray(samples[start : start + rows], dtype=big_endian)
        data = strip.reshape(len(strip), -1).view(np.uint8)
        difference = data - np.concatenate([above, data[:-1]])
        above = data[-1:]
        filtered = np.concatenate([np.full((len(data), 1), 2, np.uint8), difference], axis=1)
        if out := deflate.compress(filtered.tobytes()):
            yield out
    yield deflate.flush()
