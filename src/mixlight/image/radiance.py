"""Radiance pictures (.hdr, .pic): the codec.

A file is `#?RADIANCE`, header lines, an empty line, a line with the axes and the size, and the scanlines. The
header lines that change the meaning of the pixels are honoured on reading: EXPOSURE and COLORCORR are divided
out, PRIMARIES other than Rec.709 are converted, XYZE becomes Rec.709, and each of the eight axis orders is
turned upright.
"""

import os
import re
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from mixlight.image import rgbe, runlength
from mixlight.image._array import Array
from mixlight.image.atomic import atomic_path
from mixlight.image.color import convert_to_rec709, is_rec709, xyz_to_rec709
from mixlight.image.errors import file_error, one_line, reworded

__all__ = ["read", "read_size", "write"]

_RESOLUTION = re.compile(rb"([-+])([XY])[ \t]+(\d{1,9})[ \t]+([-+])([XY])[ \t]+(\d{1,9})[ \t]*\r?$")
_RESERVED = ("FORMAT", "EXPOSURE", "COLORCORR", "PRIMARIES", "RESOLUTION")
_MAX_HEADER = 2**20


@dataclass(frozen=True)
class _Header:
    """What stands before the pixels."""

    entries: dict[str, str]
    exposure: float
    colour_correction: tuple[float, float, float]
    primaries: tuple[float, ...] | None
    xyz: bool
    lines: int
    width: int
    axes: str  # such as "-Y+X": how scanlines follow each other, then how pixels do
    end: int

    @property
    def size(self) -> tuple[int, int]:
        """(height, width) of the upright picture."""
        return (self.lines, self.width) if self.axes[1] == "Y" else (self.width, self.lines)


def read(
    source: str | os.PathLike[str] | bytes, *, max_pixels: int = 2**28
) -> tuple[Float32[Array, "height width 3"], dict[str, str]]:
    r"""Reads a Radiance picture as linear Rec.709.

    Args:
        source: a path, or the file's bytes.
        max_pixels: larger pictures are refused before anything is decoded.

    Returns:
        The upright picture, row 0 at the top, and the header's `KEY=value` lines as text (the product of all
        EXPOSURE lines, the axes under RESOLUTION, and the words of the first line under MAGIC).

    Convention: a pixel (128, 128, 128, 129) is 1.0 in each channel. EXPOSURE and COLORCORR say by what the
    values have been multiplied, so the values are divided by them: the result is what the file's author
    measured or rendered. PRIMARIES of zeros, as Photoshop writes them, mean none. Other PRIMARIES are adapted
    white to white. XYZE values are converted colorimetrically, and what lies outside Rec.709 is clipped at 0,
    because radiance is never negative.

    Raises:
        ImageFileError: (a ValueError) the file is no Radiance picture, truncated, corrupt or too large.
        OSError: the file cannot be opened.

    Source: the Radiance picture file format, G. Ward.

    >>> head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n"
    >>> rgb, header = read(head + bytes([128, 64, 0, 129]))
    >>> rgb.tolist(), header["RESOLUTION"]
    ([[[1.0, 0.5, 0.0]]], '-Y 1 +X 1')
    """
    data = _load(source)
    header = _parse_header(source, data)
    if header.lines * header.width > max_pixels:
        height, width = header.size
        raise file_error(source, f"at most {max_pixels} pixels", f"{width} x {height} = {width * height}")
    try:
        pixels = runlength.decode(data, header.end, header.lines, header.width)
    except ValueError as error:
        raise reworded(source, error) from None
    del data
    return _upright(_to_rec709(source, rgbe.decode(pixels), header), header.axes), header.entries


def read_size(source: str | os.PathLike[str] | bytes) -> tuple[int, int]:
    r"""(height, width) of the upright picture, from the header alone.

    >>> read_size(b"#?RADIANCE\n\n+X 7 +Y 5\n")
    (5, 7)
    """
    if isinstance(source, bytes):
        return _parse_header(source, _load(source)).size
    with open(source, "rb") as file:
        return _parse_header(source, np.frombuffer(file.read(_MAX_HEADER), dtype=np.uint8)).size


def write(
    path: str | os.PathLike[str], rgb: Float[Array, "height width 3"], header: dict[str, str] | None = None
) -> None:
    """Writes linear Rec.709 radiance as `32-bit_rle_rgbe`, atomically.

    The brightest channel of a pixel keeps 8 bits. Widths from 8 to 32767 are run-length coded.

    Args:
        path: the file to make.
        rgb: radiance, finite and not negative.
        header: further `KEY=value` lines; keys that change the meaning of the pixels are refused.

    Raises:
        ValueError: shape, values or header cannot be written.
        OSError: the file cannot be made.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(folder + "/a.hdr", np.full((4, 8, 3), 0.18, np.float32), {"SOFTWARE": "mixlight"})
    ...     rgb, header = read(folder + "/a.hdr")
    >>> round(float(rgb[0, 0, 0]), 4), header["SOFTWARE"]
    (0.1797, 'mixlight')
    """
    if rgb.ndim != 3 or rgb.shape[-1] != 3 or 0 in rgb.shape:
        raise ValueError(f"{path}: expected values of shape [height, width, 3], received {list(rgb.shape)}")
    lines = ["#?RADIANCE"]
    for key, value in (header or {}).items():
        if (
            key in _RESERVED
            or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_.:-]*", key)
            or one_line(value, 2**16) != value
        ):
            raise ValueError(
                f"{path}: expected header words other than {', '.join(_RESERVED)} with one-line values, "
                f"received {key!r}: {value!r}"
            )
        lines.append(f"{key}={value}")
    lines += ["FORMAT=32-bit_rle_rgbe", "", f"-Y {rgb.shape[0]} +X {rgb.shape[1]}", ""]
    try:
        pixels = rgbe.encode(rgb)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    with atomic_path(path) as temporary, open(temporary, "wb") as file:
        file.write("\n".join(lines).encode())
        file.write(runlength.encode(pixels))


def _load(source: str | os.PathLike[str] | bytes) -> Array:
    """The file's bytes, followed by the padding that the decoder needs."""
    if isinstance(source, bytes):
        return np.frombuffer(source + bytes(runlength.PADDING), dtype=np.uint8)
    with open(source, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        data = np.zeros(size + runlength.PADDING, dtype=np.uint8)
        received = file.readinto(data[:size].data)
        return data[: received + runlength.PADDING]


def _parse_header(source: str | os.PathLike[str] | bytes, data: Array) -> _Header:
    head = data[:_MAX_HEADER].tobytes()
    if not head.startswith(b"#?"):
        received = f"a file that begins with {head[:8]!r}" if head.strip(b"\0") else "an empty file"
        raise file_error(source, "a Radiance picture, which begins with '#?RADIANCE'", received)
    entries: dict[str, str] = {}
    exposure, correction = 1.0, np.ones(3)
    primaries: tuple[float, ...] | None = None
    position = 0
    while True:
        end = head.find(b"\n", position)
        if end < 0:
            raise file_error(source, "a header that ends in an empty line", "none (truncated)")
        line = head[position:end].strip().decode("utf-8", "replace")
        position = end + 1
        if not line:
            break
        if line.startswith("#?") and "MAGIC" not in entries:
            entries["MAGIC"] = line[2:]
        key, equals, value = (part.strip() for part in line.partition("="))
        if line.startswith("#") or not equals:
            continue
        if key == "EXPOSURE":
            exposure *= _numbers(source, key, value, 1)[0]
            value = repr(exposure)
        elif key == "COLORCORR":
            correction *= _numbers(source, key, value, 3)
        elif key == "PRIMARIES":
            numbers = _numbers(source, key, value, 8, positive=False)
            primaries = numbers if any(numbers) and not is_rec709(numbers) else None
        entries[key] = value
    coding = entries.get("FORMAT", "32-bit_rle_rgbe")
    if coding not in ("32-bit_rle_rgbe", "32-bit_rle_xyze"):
        raise file_error(source, "FORMAT 32-bit_rle_rgbe or 32-bit_rle_xyze", coding)
    end = head.find(b"\n", position)
    match = _RESOLUTION.match(head[position:end]) if end >= 0 else None
    if match is None or match[2] == match[5] or not int(match[3]) * int(match[6]):
        received = repr(head[position : end if end >= 0 else position + 20][:40])
        raise file_error(source, "a size such as '-Y 512 +X 1024' after the header", received)
    entries["RESOLUTION"] = b" ".join(match.group(0).split()).decode()
    return _Header(
        entries=entries,
        exposure=exposure,
        colour_correction=(float(correction[0]), float(correction[1]), float(correction[2])),
        primaries=primaries,
        xyz=coding.endswith("xyze"),
        lines=int(match[3]),
        width=int(match[6]),
        axes=(match[1] + match[2] + match[4] + match[5]).decode(),
        end=end + 1,
    )


def _numbers(
    source: str | os.PathLike[str] | bytes, key: str, value: str, count: int, *, positive: bool = True
) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in value.split())
    except ValueError:
        numbers = ()
    usable = all(np.isfinite(n) and (n > 0.0 or not positive) for n in numbers)
    if len(numbers) != count or not usable:
        kind = "positive" if positive else "finite"
        raise file_error(source, f"{count} {kind} number{'s' * (count > 1)} after {key}", repr(value))
    return numbers


def _to_rec709(
    source: str | os.PathLike[str] | bytes, rgb: Float32[Array, "height width 3"], header: _Header
) -> Float32[Array, "height width 3"]:
    divisor = header.exposure * np.array(header.colour_correction)
    if (divisor != 1.0).any():
        rgb /= divisor.astype(np.float32)
    if header.xyz:
        return np.asarray(np.maximum(xyz_to_rec709(rgb), np.float32(0.0)))
    if header.primaries is None:
        return rgb
    try:
        return convert_to_rec709(rgb, header.primaries)
    except ValueError as error:
        raise reworded(source, error, "PRIMARIES: ") from None


def _upright(rgb: Float32[Array, "lines width 3"], axes: str) -> Float32[Array, "height_ width_ 3"]:
    """Turns scanlines into rows from the top and pixels from the left."""
    if axes[1] == "X":
        rgb = rgb.transpose(1, 0, 2)
    if "+Y" in axes:
        rgb = rgb[::-1]
    if "-X" in axes:
        rgb = rgb[:, ::-1]
    return np.ascontiguousarray(rgb)
