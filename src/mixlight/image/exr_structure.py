"""The structure of an OpenEXR file, read before anything is decoded.

The official library decodes on opening, and of a truncated file it prints to the standard error and returns
no channels. What is read here (the header's windows and the table of chunks) tells the size and the
truncation first.

Source: "OpenEXR File Layout", the Academy Software Foundation.
"""

import io
import math
import struct
from dataclasses import dataclass

__all__ = ["MAGIC", "Part", "read_parts"]

MAGIC = b"\x76\x2f\x31\x01"

_LINES_IN_CHUNK = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256, 10: 256, 11: 32}
_MAX_HEADER = 2**26


@dataclass(frozen=True)
class Part:
    """One image of a file: its windows as (x min, y min, x max, y max), all inclusive."""

    data_window: tuple[int, int, int, int]
    display_window: tuple[int, int, int, int]
    deep: bool
    mixed: bool
    """Whether the channels are of several kinds (half, float, integer)."""

    @property
    def size(self) -> tuple[int, int]:
        """(height, width) of the display window, which is the picture."""
        x0, y0, x1, y1 = self.display_window
        return y1 - y0 + 1, x1 - x0 + 1

    @property
    def pixels(self) -> int:
        """The larger of the pixels stored and the pixels shown."""
        return max((b[2] - b[0] + 1) * (b[3] - b[1] + 1) for b in (self.data_window, self.display_window))


def read_parts(file: io.BufferedIOBase) -> list[Part]:
    """Reads the headers and checks that the last chunk lies whole in the file.

    Args:
        file: an OpenEXR file, at its beginning.

    Raises:
        ValueError: no OpenEXR file, or a truncated or senseless one ("expected ..., received ...").

    >>> import io
    >>> read_parts(io.BytesIO(b"GIF89a"))
    Traceback (most recent call last):
    ...
    ValueError: expected an OpenEXR file, received a file that begins with b'GIF89a'
    """
    head = file.read(_MAX_HEADER)
    if head[:4] != MAGIC:
        received = f"a file that begins with {head[:8]!r}" if head else "an empty file"
        raise ValueError(f"expected an OpenEXR file, received {received}")
    size = file.seek(0, 2)
    try:
        flags = struct.unpack_from("<i", head, 4)[0]
        multipart, position = bool(flags & 0x1000), 8
        headers: list[dict[str, bytes]] = []
        while not headers or (multipart and head[position] != 0):
            attributes, position = _attributes(head, position)
            headers.append(attributes)
        position += multipart
        parts = [_part(attributes, bool(flags & 0x800)) for attributes in headers]
        _check_chunks(file, size, position, headers, multipart, bool(flags & 0x200))
    except (struct.error, IndexError, KeyError, UnicodeDecodeError) as error:
        missing = (
            f"no {error.args[0]} in it"
            if isinstance(error, KeyError)
            else f"{size} bytes (truncated or corrupt)"
        )
        raise ValueError(f"expected a complete OpenEXR header, received {missing}") from None
    return parts


def _attributes(head: bytes, position: int) -> tuple[dict[str, bytes], int]:
    """One header's raw attributes, and where it ends."""
    attributes = {}
    while head[position] != 0:
        name_end = head.find(0, position)
        type_end = head.find(0, name_end + 1)
        if name_end < 0 or type_end < 0:
            raise IndexError
        (size,) = struct.unpack_from("<i", head, type_end + 1)
        begin = type_end + 5
        if size < 0 or begin + size >= len(head):
            raise IndexError
        attributes[head[position:name_end].decode()] = head[begin : begin + size]
        position = begin + size
    return attributes, position + 1


def _part(attributes: dict[str, bytes], deep: bool) -> Part:
    data: tuple[int, int, int, int] = struct.unpack("<4i", attributes["dataWindow"])
    display: tuple[int, int, int, int] = struct.unpack("<4i", attributes["displayWindow"])
    for window in (data, display):
        if window[2] < window[0] or window[3] < window[1]:
            raise ValueError(f"expected windows with pixels in them, received {list(window)}")
    deep = deep or attributes.get("type", b"").startswith(b"deep")
    return Part(data, display, deep, mixed=len(set(_channel_kinds(attributes["channels"]))) > 1)


def _channel_kinds(channels: bytes) -> list[int]:
    """Each channel is a name, a zero, its kind, four bytes of flags, and how it is sampled."""
    kinds, position = [], 0
    while channels[position] != 0:
        position = channels.index(b"\0", position) + 1
        kinds.append(int(struct.unpack_from("<i", channels, position)[0]))
        position += 16
    return kinds


def _check_chunks(
    file: io.BufferedIOBase,
    size: int,
    position: int,
    headers: list[dict[str, bytes]],
    multipart: bool,
    tiled: bool,
) -> None:
    """Each part's table of chunk offsets follows the headers; truncation takes the last chunk first."""
    counts = [_chunk_count(attributes, tiled) for attributes in headers]
    if None in counts:
        return  # a compression or a kind of tiling that is newer than this table; the library will know
    table = sum(count for count in counts if count is not None)
    if position + 8 * table > size:
        raise ValueError(f"expected a table of {table} chunks, received {size} bytes in all (truncated)")
    file.seek(position)
    offsets = struct.unpack(f"<{table}Q", file.read(8 * table))
    last = max(offsets)
    leader = 4 * multipart + (16 if tiled or headers[-1].get("type", b"").startswith(b"tiled") else 4)
    file.seek(last + leader if last < size else 0)
    word = file.read(4)
    end = last + leader + 4 + (struct.unpack("<i", word)[0] if len(word) == 4 else 0)
    if min(offsets) < position + 8 * table or last >= size or end > size:
        raise ValueError(
            f"expected {table} chunks up to byte {max(end, last)}, received {size} bytes (truncated)"
        )


def _chunk_count(attributes: dict[str, bytes], tiled: bool) -> int | None:
    if "chunkCount" in attributes:
        return int(struct.unpack("<i", attributes["chunkCount"])[0])
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    if tiled or attributes.get("type", b"").startswith(b"tiled"):
        width, height, mode = struct.unpack("<2IB", attributes["tiles"])
        one_level = mode & 15 == 0
        return math.ceil((x1 - x0 + 1) / width) * math.ceil((y1 - y0 + 1) / height) if one_level else None
    lines = _LINES_IN_CHUNK.get(attributes["compression"][0])
    return math.ceil((y1 - y0 + 1) / lines) if lines else None
