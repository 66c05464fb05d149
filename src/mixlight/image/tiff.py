"""Samples of TIFF files that Pillow does not decode as they are: 16-bit integers and floats.

Decompression is left to libtiff, through Pillow: a directory is appended to the file that describes the same
strips or tiles as a grey picture of bytes. What that gives are the rows' decompressed bytes; byte order,
predictor and the meaning of the channels are dealt with here.

Source: TIFF revision 6.0 (Adobe, 1992); Adobe Photoshop TIFF technical note 3 (floating point predictor),
2005.
"""

import io
import struct
from typing import Any

import numpy as np
from jaxtyping import Shaped, UInt8

from mixlight.image._array import Array
from mixlight.image.tiff_structure import Directory

__all__ = ["read_samples"]

_DTYPES = {(16, 1): "u2", (16, 3): "f2", (32, 3): "f4", (64, 3): "f8"}
_WIDTH, _HEIGHT, _BITS, _COMPRESSION, _PHOTOMETRIC, _FILL_ORDER = 256, 257, 258, 259, 262, 266
_STRIPS, _STRIP_SIZES, _ROWS = 273, 279, 278
_TILE_WIDTH, _TILE_HEIGHT, _TILES, _TILE_SIZES = 322, 323, 324, 325
_SAMPLES, _PLANAR, _PREDICTOR, _EXTRA, _FORMAT = 277, 284, 317, 338, 339
_LOSSLESS = (1, 5, 8, 32773, 32946, 34925, 50000)  # none, LZW, deflate, PackBits, deflate, LZMA, Zstandard


def read_samples(data: bytes, directory: Directory) -> tuple[Shaped[Array, "rows columns channels"], bool]:
    """The first picture's samples as uint16 or float32, and whether its colour is multiplied by alpha.

    There are 1 or 3 channels, or 2 or 4 where alpha is declared; other extra channels are left out. Grey
    whose 0 is white is inverted.

    Raises:
        ValueError: samples or a layout of another kind ("expected ..., received ...").
        Exception: whatever libtiff says through Pillow about corrupt data.
    """
    bits, kind = int(directory.first(_BITS, 1)), int(directory.first(_FORMAT, 1))
    photometric, channels = directory.first(_PHOTOMETRIC, -1), int(directory.first(_SAMPLES, 1))
    colours = {0: 1, 1: 1, 2: 3}.get(int(photometric), 0)
    planar, compression = directory.first(_PLANAR, 1), directory.first(_COMPRESSION, 1)
    mixed = len(set(directory.numbers.get(_BITS, ()))) > 1 or len(set(directory.numbers.get(_FORMAT, ()))) > 1
    if (bits, kind) not in _DTYPES or mixed or not 0 < colours <= channels:
        raise ValueError(
            "expected grey or RGB with 8 or 16 bits or as floats, received "
            f"{channels} channels of {bits} bits, sample format {kind}, photometric {photometric}"
        )
    if compression not in _LOSSLESS or planar not in (1, 2):
        raise ValueError(
            "expected compression without loss (none, LZW, deflate, PackBits, LZMA, Zstandard), "
            f"received compression {compression}, planar configuration {planar}"
        )
    dtype = np.dtype(directory.byte_order + _DTYPES[bits, kind])
    width, height = int(directory.first(_WIDTH, 0)), int(directory.first(_HEIGHT, 0))
    block_width = int(directory.first(_TILE_WIDTH, width))
    block_height = int(directory.first(_TILE_HEIGHT, 1))
    columns, rows = -(-width // block_width) * block_width, -(-height // block_height) * block_height
    planes = channels if planar == 2 else 1
    together = channels // planes
    pixel = together * dtype.itemsize
    predictor = int(directory.first(_PREDICTOR, 1))
    parts = []
    for plane in range(planes):
        raw = _decompress(data, directory, columns * pixel, rows, block_width * pixel, plane, planes)
        blocks = raw.reshape(rows, columns // block_width, block_width * pixel)
        part = _without_predictor(blocks, dtype, together, predictor)
        parts.append(part.reshape(rows, columns, together)[:height, :width])
    samples = np.concatenate(parts, axis=2) if planes > 1 else parts[0]
    if photometric == 0 and dtype.kind == "u":
        samples = np.iinfo(np.uint16).max - samples
    extra = [int(e) for e in directory.numbers.get(_EXTRA, ())]
    has_alpha = len(extra) > 0 and extra[0] in (1, 2) and channels > colours
    return samples[..., : colours + has_alpha], has_alpha and extra[0] == 1


def _decompress(
    data: bytes, directory: Directory, width: int, height: int, block_width: int, plane: int, planes: int
) -> UInt8[Array, "height width"]:
    """One plane's bytes, as a grey picture."""
    from PIL.TiffImagePlugin import TiffImageFile

    entries: dict[int, tuple[float, ...]] = {
        _WIDTH: (width,),
        _HEIGHT: (height,),
        _BITS: (8,),
        _COMPRESSION: (directory.first(_COMPRESSION, 1),),
        _PHOTOMETRIC: (1,),
        _FILL_ORDER: (directory.first(_FILL_ORDER, 1),),
        _SAMPLES: (1,),
    }
    if _TILES in directory.numbers:
        blocks = (_TILES, _TILE_SIZES)
        entries |= {_TILE_WIDTH: (block_width,), _TILE_HEIGHT: directory.numbers[_TILE_HEIGHT]}
    else:
        blocks = (_STRIPS, _STRIP_SIZES)
        entries |= {_ROWS: (min(directory.first(_ROWS, height), height),)}
    for tag in blocks:
        values = directory.numbers[tag]
        entries[tag] = values[len(values) // planes * plane :][: len(values) // planes]
    image = TiffImageFile(io.BytesIO(_with_directory(data, directory, entries)))
    image.load()
    return np.asarray(image)


def _with_directory(data: bytes, directory: Directory, entries: dict[int, tuple[float, ...]]) -> bytes:
    """The file with another first directory, appended, whose values are 32-bit integers (64 in a BigTIFF)."""
    order, big = directory.byte_order, directory.big
    word, kind, size = ("Q", 16, 8) if big else ("I", 4, 4)
    at = len(data) + len(data) % 2
    values_at = at + (8 if big else 2) + len(entries) * (20 if big else 12) + size
    table = struct.pack(f"{order}{'Q' if big else 'H'}", len(entries))
    tail = b""
    for tag, values in sorted(entries.items()):
        packed = struct.pack(f"{order}{len(values)}{word}", *(int(v) for v in values))
        if len(values) > 1:
            place = struct.pack(order + word, values_at + len(tail))
            tail += packed
        else:
            place = packed
        table += struct.pack(f"{order}HH{word}", tag, kind, len(values)) + place
    head_size = 16 if big else 8
    head = data[: head_size - size] + struct.pack(order + word, at)
    return b"".join((head, data[head_size:], bytes(at - len(data)), table, bytes(size), tail))


def _without_predictor(
    blocks: UInt8[Array, "rows blocks bytes"], dtype: np.dtype[Any], channels: int, predictor: int
) -> Shaped[Array, "rows blocks samples"]:
    """Undoes the differences that each row of a block was stored as, and the byte order."""
    rows, count, size = blocks.shape
    native = np.dtype(np.uint16 if dtype.kind == "u" else np.float32)
    if predictor == 3 and dtype.kind == "f":
        # Differences between bytes that lie `channels` apart; the samples' first bytes stand together, then
        # the second ones and so on, the most significant first whatever the file's byte order.
        planes = blocks.reshape(rows, count, size // channels, channels).cumsum(axis=2, dtype=np.uint8)
        planes = planes.reshape(rows, count, dtype.itemsize, -1).swapaxes(2, 3)
        return np.ascontiguousarray(planes).view(dtype.newbyteorder(">"))[..., 0].astype(native)
    if predictor not in (1, 2):
        raise ValueError(f"expected predictor 1, 2 or 3, received {predictor}")
    values = np.ascontiguousarray(blocks).view(dtype)
    if predictor == 2:
        words = values.view(values.dtype.str.replace("f", "u")).reshape(rows, count, -1, channels)
        words = words.astype(words.dtype.newbyteorder("="))
        summed = words.cumsum(axis=2, dtype=words.dtype).reshape(rows, count, -1)
        return summed.view(dtype.newbyteorder("=")).astype(native)
    return values.astype(native)
