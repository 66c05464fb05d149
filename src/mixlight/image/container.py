"""What kind of file some bytes are, how large a picture they announce, and whether they are all there.

Decided from the bytes, never from the file's name, and before anything is decoded.
"""

import codecs
import re
import struct
import zlib
from collections.abc import Iterator

import numpy as np

from mixlight.image.errors import one_line
from mixlight.image.tiff_structure import read_directory

__all__ = ["announced_size", "check_jpeg", "kind", "png_chunks"]

_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""JPEG markers that announce a size."""

_SIGNATURES = (
    (b"\xff\xd8\xff", "JPEG"),
    (b"\x89PNG\r\n\x1a\n", "PNG"),
    (b"II*\0", "TIFF"),
    (b"MM\0*", "TIFF"),
    (b"II+\0", "TIFF"),
    (b"MM\0+", "TIFF"),
    (b"\x76\x2f\x31\x01", "OpenEXR"),
    (b"#?", "Radiance"),
)
_FOREIGN = (
    (rb"GIF8", "GIF"),
    (rb"BM", "BMP"),
    (rb"%PDF", "PDF"),
    (rb"....ftyp(heic|heix|hevc|mif1|msf1)", "HEIF (convert it to JPEG)"),
    (rb"....ftypavi[fs]", "AVIF (convert it to PNG)"),
    (rb"....ftypcrx", "a camera's raw file (develop it to TIFF)"),
    (rb"FUJIFILM|II[RU]\0|IIRO|MMOR", "a camera's raw file (develop it to TIFF)"),
    (rb"\0\0\0\x0cjP  |\xff\x4f\xff\x51", "JPEG 2000"),
    (rb"\xff\x0a|\0\0\0\x0cJXL ", "JPEG XL"),
    (rb"8BPS", "Photoshop"),
    (rb"P[1-7]\s|P[fF]\s", "a Netpbm file"),
    (rb"<\?xml|<svg|<!DOCTYPE|<html", "a markup text"),
    (rb"PK\x03\x04", "a zip archive"),
)


def kind(head: bytes) -> tuple[str | None, str]:
    """The format that a file's first bytes (at least 32 of them) announce, or None and what they seem to be.

    >>> kind(b"#?RADIANCE")[0], kind(b"Dear Sir or Madam")
    ('Radiance', (None, "a text that begins with 'Dear Sir or Madam'"))
    """
    for signature, name in _SIGNATURES:
        if head.startswith(signature):
            return name, name
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "WebP", "WebP"
    for pattern, name in _FOREIGN:
        if re.match(pattern, head, re.DOTALL):
            return None, name
    if not head:
        return None, "an empty file"
    try:
        text = codecs.getincrementaldecoder("utf-8")().decode(head)  # which may end inside a character
        if text and all(c.isprintable() or c.isspace() for c in text):
            return None, f"a text that begins with {one_line(text, 24)!r}"
    except UnicodeDecodeError:
        pass
    return None, f"unknown data that begin with {head[:8]!r}"


def announced_size(name: str, data: bytes) -> tuple[int, int]:
    r"""(width, height) as stored, from the header of a JPEG, PNG, WebP or TIFF.

    Raises:
        ValueError: the header is cut off or senseless ("expected ..., received ...").

    >>> announced_size("PNG", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\1\0\0\0\0\x80\x08\2")
    (256, 128)
    """
    if name == "JPEG":
        return _jpeg_size(data)
    if name == "WebP":
        return _webp_size(data)
    if name == "TIFF":
        directory = read_directory(data)
        return int(directory.first(256, 0)), int(directory.first(257, 0))
    width, height = struct.unpack_from(">II", _long_enough(data, 26, "PNG"), 16)
    return int(width), int(height)


def png_chunks(data: bytes) -> dict[bytes, bytes]:
    """The first chunk of each kind but the pixels', after all have been checked.

    Raises:
        ValueError: a chunk is cut off or disagrees with its check sum, or IEND is missing.
    """
    chunks: dict[bytes, bytes] = {}
    position = 8
    while position + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, position)
        end = position + 12 + length
        if end > len(data):
            break
        chunk = memoryview(data)[position + 4 : end - 4]
        name = bytes(chunk[:4])
        if zlib.crc32(chunk) != struct.unpack_from(">I", data, end - 4)[0]:
            raise ValueError(
                f"expected PNG chunks that agree with their check sums, received a corrupt {name!r}"
            )
        if name != b"IDAT":
            chunks.setdefault(name, bytes(chunk[4:]))
        if name == b"IEND":
            return chunks
        position = end
    raise ValueError(f"expected PNG chunks up to IEND, received {len(data)} bytes (truncated)")


def _webp_size(data: bytes) -> tuple[int, int]:
    """The canvas (RFC 9649)."""
    coding = _long_enough(data, 30, "WebP")[12:16]
    if coding == b"VP8X":
        return 1 + int.from_bytes(data[24:27], "little"), 1 + int.from_bytes(data[27:30], "little")
    if coding == b"VP8L":
        bits = int.from_bytes(data[21:25], "little")
        return 1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF)
    width, height = struct.unpack_from("<HH", data, 26)
    return width & 0x3FFF, height & 0x3FFF


def _jpeg_size(data: bytes) -> tuple[int, int]:
    for marker, at in _jpeg_markers(data):
        if marker in _FRAMES and at + 8 <= len(data):
            height, width = struct.unpack_from(">HH", data, at + 3)
            return int(width), int(height)
    raise ValueError(f"expected a JPEG frame header, received {len(data)} bytes without one (truncated)")


def check_jpeg(data: bytes) -> None:
    """Checks that a JPEG has its end, and bits enough for each of its blocks.

    Decoders fill what is missing with grey and call it a warning, or nothing.

    Raises:
        ValueError: "expected ..., received ...".
    """
    complete, blocks, scans = False, 0, 0
    for marker, at in _jpeg_markers(data):
        complete |= marker == 0xD9
        scans += marker == 0xDA
        if marker in (0xC0, 0xC1, 0xC2) and at + 8 <= len(data):  # Huffman coded
            height, width, count = struct.unpack_from(">HHB", data, at + 3)
            factors = [data[at + 9 + 3 * i] for i in range(count) if at + 9 + 3 * i < len(data)]
            whole = 64 * max((f >> 4 for f in factors), default=1) * max((f & 15 for f in factors), default=1)
            blocks = sum(width * height * (f >> 4) * (f & 15) // max(whole, 1) for f in factors)
    if not complete:
        raise ValueError(f"expected a JPEG with its end, received {len(data)} bytes without one (truncated)")
    # A block's mean has a code of its own in one scan, of one bit at least.
    if scans == 0 or 8 * len(data) < blocks:
        raise ValueError(f"expected bits for {blocks} blocks, received {len(data)} bytes (truncated)")


def _jpeg_markers(data: bytes) -> Iterator[tuple[int, int]]:
    """Markers from the first on, each with the position behind it, up to the end of the first image.

    Behind a scan's header come coded bytes, in which 0xff stands only before 0 and before restart marks.
    """
    values = np.frombuffer(data, dtype=np.uint8)
    found = np.flatnonzero(values[:-1] == 0xFF) + 1
    follower = values[found]
    is_marker = (follower != 0) & (follower != 0xFF) & ((follower < 0xD0) | (follower > 0xD7))
    found = found[is_marker]
    position = 2
    while (index := int(np.searchsorted(found, position))) < len(found):
        marker, at = data[found[index]], int(found[index]) + 1
        yield marker, at
        if marker == 0xD9 or at + 2 > len(data):
            return
        position = at + struct.unpack_from(">H", data, at)[0]


def _long_enough(head: bytes, length: int, name: str) -> bytes:
    if len(head) < length:
        raise ValueError(f"expected a {name} header, received {len(head)} bytes (truncated)")
    return head
