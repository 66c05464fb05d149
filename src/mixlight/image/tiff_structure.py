"""Directories of TIFF files, which are also what EXIF data are made of.

Source: TIFF revision 6.0 (Adobe, 1992); BigTIFF (libtiff).
"""

import struct
from dataclasses import dataclass, field

__all__ = ["Directory", "end_of_pixels", "read_directory"]

# Size and struct code of the value types; rationals are pairs.
_TYPES = {
    1: (1, "B"),
    3: (2, "H"),
    4: (4, "I"),
    5: (8, "II"),
    6: (1, "b"),
    8: (2, "h"),
    9: (4, "i"),
    10: (8, "ii"),
    11: (4, "f"),
    12: (8, "d"),
    13: (4, "I"),
    16: (8, "Q"),
    17: (8, "q"),
    18: (8, "Q"),
}
_MAX_VALUES = 2**24


@dataclass(frozen=True)
class Directory:
    """The entries of one directory."""

    byte_order: str
    """'<' or '>', as struct writes it."""
    big: bool = False
    """Whether the file is a BigTIFF, with 64-bit positions."""
    numbers: dict[int, tuple[float, ...]] = field(default_factory=dict)
    """Numeric values by tag; a rational with denominator 0 is NaN."""
    raw: dict[int, bytes] = field(default_factory=dict)
    """The bytes of all values by tag."""
    position: dict[int, int] = field(default_factory=dict)
    """Where the value of a tag stands in the file."""

    def first(self, tag: int, default: float) -> float:
        """The first value of a numeric tag."""
        values = self.numbers.get(tag, ())
        return values[0] if values else default


def read_directory(data: bytes | bytearray, at: int | None = None) -> Directory:
    r"""Reads the first directory, or the one at a given position.

    Entries of unknown type, or whose values lie outside the data, are left out, as in other readers.

    Raises:
        ValueError: the data are no TIFF, or the directory lies outside them.

    >>> entry = struct.pack("<HHIHH", 274, 3, 1, 6, 0)
    >>> read_directory(b"II*\0" + struct.pack("<IH", 8, 1) + entry + bytes(4)).first(274, 1)
    6
    """
    order = {b"II": "<", b"MM": ">"}.get(bytes(data[:2]))
    version = struct.unpack_from(f"{order}H", data, 2)[0] if order and len(data) >= 8 else 0
    if order is None or version not in (42, 43):
        raise ValueError(f"expected a TIFF header, received {bytes(data[:4])!r}")
    big = version == 43
    count_code, entry_size, inline, offset_code = ("Q", 20, 8, "Q") if big else ("H", 12, 4, "I")
    try:
        if at is None:
            (at,) = struct.unpack_from(order + offset_code, data, 8 if big else 4)
        (count,) = struct.unpack_from(order + count_code, data, at)
    except struct.error:
        raise ValueError(f"expected a directory, received {len(data)} bytes (truncated)") from None
    start = at + struct.calcsize("=" + count_code)
    if start + count * entry_size > len(data):
        raise ValueError(f"expected a directory of {count} entries, received {len(data)} bytes (truncated)")
    directory = Directory(order, big)
    for position in range(start, start + count * entry_size, entry_size):
        tag, kind, length = struct.unpack_from(f"{order}HH{offset_code}", data, position)
        size, code = _TYPES.get(kind, (1, ""))
        value_at = position + entry_size - inline
        if size * length > inline:
            (value_at,) = struct.unpack_from(order + offset_code, data, value_at)
        if length > _MAX_VALUES or value_at + size * length > len(data):
            continue
        directory.raw[tag] = bytes(data[value_at : value_at + size * length])
        directory.position[tag] = value_at
        if code:
            values = struct.unpack_from(f"{order}{length * len(code)}{code[0]}", data, value_at)
            if len(code) == 2:
                pairs = zip(values[::2], values[1::2], strict=True)
                values = tuple(n / d if d else float("nan") for n, d in pairs)
            directory.numbers[tag] = values
    return directory


def end_of_pixels(directory: Directory) -> float:
    """Where the last strip or tile ends; 0 without any.

    >>> end_of_pixels(Directory("<", numbers={273: (8, 108), 279: (100, 50)}))
    158
    """
    ends = [0.0]
    for offset_tag, count_tag in ((273, 279), (324, 325)):
        offsets, counts = directory.numbers.get(offset_tag, ()), directory.numbers.get(count_tag, ())
        ends += [offset + count for offset, count in zip(offsets, counts, strict=False)]
    return max(ends)
