"""The run-length codings of Radiance scanlines, on bytes: new (per component), old (per pixel) and none.

New: each scanline begins with 2 2 hi lo (its width), then R, G, B and E of the whole scanline, each as codes:
a byte n > 128 and a value repeat that value n - 128 times; a byte n <= 128 is followed by n literal values.
Old: pixels of four bytes; (1, 1, 1, n) repeats the pixel before n times, directly following repeats count n *
256, n * 65536 and so on. A file without any coding is an old file without repeats.

Where a code begins is known only when the code before it is. The new coding is therefore walked for all
scanlines abreast, one code a step: the scanlines' first bytes are found by their 2 2 hi lo, and those that
are no beginnings but pixels that look alike drop out, because no scanline before them ends there. Where the
scanlines are few, or such pixels many, a plain loop over the codes is faster.

Source: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the Radiance file format reference.
"""

import numpy as np
from jaxtyping import Int64, UInt8

from mixlight.image._array import Array

__all__ = ["MAX_WIDTH", "MIN_WIDTH", "PADDING", "decode", "encode"]

MIN_WIDTH, MAX_WIDTH = 8, 32767
"""Scanlines of these widths are written in the new coding, others flat."""

PADDING = 260
"""Zero bytes that must follow the data handed to `decode`: a step may look that far beyond its end."""

_CODE = np.arange(256)
_COUNT = np.where(_CODE > 128, _CODE - 128, _CODE)  # bytes that a code yields
_ADVANCE = np.where(_CODE > 128, 2, _CODE + 1)  # bytes that it takes
_REPEAT = np.where(_CODE > 128, _CODE - 128, 1).astype(np.uint8)  # how often the byte behind it comes out
_MIN_RUN, _MAX_RUN, _MAX_LITERAL = 4, 127, 128
_FEW_LINES = 300


def decode(data: UInt8[Array, " bytes"], start: int, lines: int, width: int) -> UInt8[Array, "lines width 4"]:
    """Decodes the scanlines that begin at `start`, in the coding that the first one shows.

    Args:
        data: the file, followed by `PADDING` zeros.
        start: where the first scanline begins.
        lines: how many scanlines there are.
        width: pixels in each of them.

    Raises:
        ValueError: the data end early or hold what no encoder writes; the message has the form "expected ...,
            received ..." and names the scanline. Bytes behind the last scanline are not looked at.

    >>> run = bytes([2, 2, 0, 8]) + bytes([128 + 8, 7]) * 3 + bytes([8, 1, 2, 3, 4, 5, 6, 7, 8])
    >>> decode(np.frombuffer(run + bytes(PADDING), np.uint8), 0, 1, 8)[0, 2].tolist()
    [7, 7, 7, 3]
    """
    size = len(data) - PADDING
    mark = [2, 2, width >> 8, width & 255]
    if MIN_WIDTH <= width <= MAX_WIDTH and data[start : start + 4].tolist() == mark:
        return _decode_new(data, start, lines, width)
    return _decode_old(data[start:size], lines, width)


def _decode_new(
    data: UInt8[Array, " padded"], start: int, lines: int, width: int
) -> UInt8[Array, "lines width 4"]:
    size = len(data) - PADDING
    least = lines * (4 + 4 * 2 * -(-width // _MAX_RUN))  # four components of full runs in each scanline
    if size - start < least:
        raise ValueError(f"expected at least {least} bytes of pixels, received {size - start} (truncated)")
    repeats = np.ones(len(data), dtype=np.uint8)  # how often each byte of the file comes out
    found = _line_starts(data[:size], start, width)
    if lines < _FEW_LINES or len(found) > 4 * lines:
        bounds = _walk_in_turn(data, repeats, start, lines, width)
    else:
        bounds = _walk_abreast(data, repeats, found, lines, width)
    planes = np.empty((lines, 4, width), dtype=np.uint8)
    batch = max(1, 2**18 // width)  # scanlines that fit the cache
    for line in range(0, lines, batch):
        end_line = min(line + batch, lines)
        first, last = bounds[line], bounds[end_line]
        planes[line:end_line] = np.repeat(data[first:last], repeats[first:last]).reshape(-1, 4, width)
    return planes.transpose(0, 2, 1)


def _line_starts(data: UInt8[Array, " bytes"], start: int, width: int) -> Int64[Array, " found"]:
    """All positions from `start` on where 2 2 hi lo stands."""
    found = np.flatnonzero(data[start:-3] == 2) + start
    for offset, value in enumerate((2, width >> 8, width & 255), start=1):
        found = found[data[found + offset] == value]
    return found


def _walk_in_turn(
    data: UInt8[Array, " padded"], repeats: UInt8[Array, " padded"], start: int, lines: int, width: int
) -> Int64[Array, " bounds"]:
    """Follows the codes one after the other; returns where each scanline begins, and the end of the last."""
    source, size = data.tobytes(), len(data) - PADDING
    mark = bytes((2, 2, width >> 8, width & 255))
    bounds, codes = [start], []
    position = start
    for line in range(lines):
        if source[position : position + 4] != mark:
            raise _broken(line, lines, position + 4 > size, marked=False)
        position += 4
        for _ in range(4):
            left = width
            while left > 0:
                code = source[position]
                codes.append(position)
                if code > 128:
                    left -= code - 128
                    position += 2
                else:
                    left -= code or width + 1
                    position += code + 1
                if position > size:
                    raise _broken(line, lines, True, marked=True)
            if left:
                raise _broken(line, lines, False, marked=True)
        bounds.append(position)
    ends = np.array(bounds)
    _note_codes(data, repeats, np.array(codes, dtype=np.int64))
    _note_marks(repeats, ends[:-1])
    return ends


def _walk_abreast(
    data: UInt8[Array, " padded"],
    repeats: UInt8[Array, " padded"],
    found: Int64[Array, " found"],
    lines: int,
    width: int,
) -> Int64[Array, " bounds"]:
    """The same for all marks at once; of their ends, the chain from the first mark counts."""
    size = len(data) - PADDING
    ends = _ends(data, repeats, found, width)
    end_of = dict(zip(found.tolist(), ends.tolist(), strict=True))
    bounds = [int(found[0])]
    for line in range(lines):
        end = end_of.get(bounds[-1])
        if end is None:
            raise _broken(line, lines, bounds[-1] + 4 > size, marked=False)
        if end < 0:
            raise _broken(line, lines, -end > size, marked=True)
        bounds.append(end)
    starts = np.array(bounds)
    if len(found) > lines:
        # Pixels that looked like a scanline's beginning have left notes where they do not belong.
        repeats.fill(1)
        _ends(data, repeats, starts[:-1], width)
    return starts


def _ends(
    data: UInt8[Array, " padded"],
    repeats: UInt8[Array, " padded"],
    starts: Int64[Array, " found"],
    width: int,
) -> Int64[Array, " found"]:
    """Where the scanlines that begin at `starts` end; minus the position where one breaks."""
    size = len(data) - PADDING
    ends = np.zeros(len(starts), dtype=np.int64)
    _note_marks(repeats, starts)
    row = np.arange(len(starts))
    position = starts + 4
    left = np.full(len(starts), width)  # bytes still missing from the present component
    component = np.zeros(len(starts), dtype=np.int64)
    while len(row):
        code = data[position]
        count = _COUNT[code]
        left -= count
        _note_codes(data, repeats, position)
        position += _ADVANCE[code]
        broken = (left < 0) | (count == 0) | (position > size)
        if broken.any():
            ends[row[broken]] = -position[broken]
            good = ~broken
            row, position, left, component = (a[good] for a in (row, position, left, component))
        full = np.flatnonzero(left == 0)
        if len(full):
            left[full] = width
            component[full] += 1
            done = full[component[full] == 4]
            if len(done):
                ends[row[done]] = position[done]
                keep = np.ones(len(row), dtype=bool)
                keep[done] = False
                row, position, left, component = (a[keep] for a in (row, position, left, component))
    return ends


def _note_marks(repeats: UInt8[Array, " padded"], starts: Int64[Array, " found"]) -> None:
    for offset in range(4):
        repeats[starts + offset] = 0


def _note_codes(
    data: UInt8[Array, " padded"], repeats: UInt8[Array, " padded"], position: Int64[Array, " codes"]
) -> None:
    repeats[position] = 0
    repeats[position + 1] = _REPEAT[data[position]]


def _broken(line: int, lines: int, truncated: bool, *, marked: bool) -> ValueError:
    if truncated:
        return ValueError(f"expected {lines} scanlines, received {line} and a part (truncated)")
    what = "codes that do not fit its width" if marked else "no mark of its beginning"
    return ValueError(f"expected run-length coded scanline {line + 1} of {lines}, received {what} (corrupt)")


def _decode_old(data: UInt8[Array, " bytes"], lines: int, width: int) -> UInt8[Array, "lines width 4"]:
    wanted = lines * width
    coded = data[: len(data) // 4 * 4].reshape(-1, 4)
    repeat = (coded[:, :3] == 1).all(axis=1)
    if len(coded) >= wanted and not repeat[:wanted].any():
        return coded[:wanted].reshape(lines, width, 4).copy()
    index = np.arange(len(coded))
    source = np.maximum.accumulate(np.where(repeat, -1, index))  # the pixel that a repeat repeats
    shift = 8 * np.minimum(index - source - 1, 3)  # grows by 8 with each repeat directly behind another
    count = np.where(repeat, np.minimum(coded[:, 3].astype(np.int64) << np.maximum(shift, 0), wanted + 1), 1)
    reached = np.cumsum(count)
    last = int(np.searchsorted(reached, wanted))
    if last >= len(coded):
        whole = int(reached[-1]) // width if len(coded) else 0
        raise ValueError(f"expected {lines} scanlines, received {whole} and a part (truncated)")
    source, count, repeat, reached = (a[: last + 1] for a in (source, count, repeat, reached))
    before = reached - count
    headless = repeat & (before % width == 0)
    crossing = (count > 0) & (before // width != (reached - 1) // width)
    wrong = np.flatnonzero(headless | crossing)
    if len(wrong):
        what = "a repeat with no pixel before it" if headless[wrong[0]] else "a repeat beyond its end"
        line = int(before[wrong[0]]) // width + 1
        raise ValueError(f"expected {width} pixels in scanline {line} of {lines}, received {what} (corrupt)")
    return np.repeat(coded[source], count, axis=0).reshape(lines, width, 4)


def encode(pixels: UInt8[Array, "lines width 4"]) -> bytes:
    """Codes scanlines: new coding for widths from 8 to 32767, flat otherwise.

    Four and more equal values become a run; shorter runs join the literals around them.

    >>> len(encode(np.zeros((1, 1000, 4), np.uint8)))
    68
    """
    lines, width = pixels.shape[:2]
    if not MIN_WIDTH <= width <= MAX_WIDTH:
        return pixels.tobytes()
    batch = max(1, 2**18 // width)
    return b"".join(_encode_batch(pixels[line : line + batch]) for line in range(0, lines, batch))


def _encode_batch(pixels: UInt8[Array, "lines width 4"]) -> bytes:
    lines, width = pixels.shape[:2]
    flat = np.ascontiguousarray(pixels.transpose(0, 2, 1)).reshape(-1)
    # Stretches of equal values, cut where a component ends.
    begins = np.empty(len(flat), dtype=bool)
    np.not_equal(flat[1:], flat[:-1], out=begins[1:])
    begins[::width] = True
    start = np.flatnonzero(begins)
    is_run = np.diff(start, append=len(flat)) >= _MIN_RUN
    # Neighbouring short stretches join into one literal, again within a component.
    keep = np.ones(len(start), dtype=bool)
    keep[1:] = is_run[1:] | is_run[:-1] | (start[1:] % width == 0)
    start, is_run = start[keep], is_run[keep]
    length = np.diff(start, append=len(flat))
    # Codes hold up to 127 repeats or 128 literals: long stretches are cut.
    longest = np.where(is_run, _MAX_RUN, _MAX_LITERAL)
    pieces = -(-length // longest)
    piece = np.arange(int(pieces.sum())) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    start, is_run, length, longest = (np.repeat(a, pieces) for a in (start, is_run, length, longest))
    start = start + piece * longest
    length = np.minimum(length - piece * longest, longest)
    # Where each code comes to stand, with four bytes before each scanline.
    taken = np.where(is_run, 2, length + 1)
    at = np.cumsum(taken) - taken + 4 * (start // (4 * width) + 1)
    out = np.empty(int(taken.sum()) + 4 * lines, dtype=np.uint8)
    literal = np.ones(len(out), dtype=bool)
    out[at] = np.where(is_run, length + 128, length)
    literal[at] = False
    run_at = at[is_run] + 1
    out[run_at] = flat[start[is_run]]
    literal[run_at] = False
    line_at = at[start % (4 * width) == 0] - 4
    for offset, value in enumerate((2, 2, width >> 8, width & 255)):
        out[line_at + offset] = value
        literal[line_at + offset] = False
    out[literal] = flat[np.repeat(~is_run, length)]
    return out.tobytes()
