"""OpenEXR pictures, through the Academy's own library."""

import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Float32

from mixlight.image._array import Array
from mixlight.image.atomic import atomic_path
from mixlight.image.color import REC709, convert_to_rec709, is_rec709
from mixlight.image.errors import file_error, reworded
from mixlight.image.exr_structure import Part, read_parts

__all__ = ["MAX_HALF", "Attribute", "read", "read_size", "write"]

Attribute = str | int | float | tuple[float, ...]
"""A header entry; chromaticities are (red x, red y, green x, ..., white y)."""

MAX_HALF = 65504.0
"""The largest half float; brighter values are written as this."""

_STRUCTURE = {
    *("channels", "chunkCount", "compression", "dataWindow", "displayWindow", "lineOrder", "name"),
    *("pixelAspectRatio", "screenWindowCenter", "screenWindowWidth", "tiles", "type", "version", "view"),
    *("chromaticities", "envmap"),
}


def read(
    path: str | os.PathLike[str], *, max_pixels: int = 2**28
) -> tuple[Float32[Array, "height width 3"], dict[str, Attribute]]:
    """Reads an OpenEXR picture as linear Rec.709.

    The colour is taken from the channels R, G and B (half or float, of one kind or mixed), from Y alone as
    grey, or from a single layer whose channels end in .R, .G and .B; the first part that has one of these
    counts. Alpha is left out: OpenEXR colour is premultiplied, so this is the picture over black.

    Convention: chromaticities other than Rec.709 are adapted white to white, and what they put outside
    Rec.709 is clipped at 0. The result is the display window; black where the file holds no data. Values are
    not judged: NaN and negative ones come back as they are.

    Returns:
        The picture, row 0 at the top, and the header's texts and numbers, with `envmap` as "latlong" or
        "cube".

    Raises:
        ImageFileError: (a ValueError) no OpenEXR picture, truncated, corrupt, without colour, or too large.
        OSError: the file cannot be opened.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(folder + "/a.exr", np.full((2, 4, 3), 0.5, np.float32), {"frame": "mixlight"})
    ...     rgb, attributes = read(folder + "/a.exr")
    >>> rgb[0, 0].tolist(), attributes["frame"], attributes["envmap"]
    ([0.5, 0.5, 0.5], 'mixlight', 'latlong')
    """
    parts = _structure(path)
    for part in parts:
        if part.pixels > max_pixels:
            height, width = part.size
            raise file_error(
                path, f"at most {max_pixels} pixels", f"{width} x {height} (stored: {part.pixels})"
            )
        if part.deep:
            raise file_error(path, "a flat picture", "deep data")
    # Channels of several kinds do not fit in one array: new releases of the library say so, old ones garble.
    separate = any(part.mixed for part in parts)
    file = _open(path, separate=separate)
    found = _find_colour([file.channels(i) for i in range(len(parts))])
    if found is None and not separate:
        file = _open(path, separate=True)
        found = _find_colour([file.channels(i) for i in range(len(parts))])
    if found is None:
        names = [name for i in range(len(parts)) for name in file.channels(i)]
        raise file_error(
            path, "half or float channels R, G, B or Y, or one layer with them", ", ".join(names)
        )
    index, planes = found
    header = file.header(index)
    rgb = _to_display_window(_interleaved(planes), parts[index])
    primaries = header.get("chromaticities")
    if primaries is not None and not is_rec709(tuple(primaries)):
        try:
            rgb = convert_to_rec709(rgb, tuple(float(c) for c in primaries))
        except ValueError as error:
            raise reworded(path, error, "chromaticities: ") from None
    return rgb, _attributes(header)


def read_size(path: str | os.PathLike[str]) -> tuple[int, int]:
    """(height, width) of the first part, from the header alone."""
    return _structure(path)[0].size


def write(
    path: str | os.PathLike[str],
    rgb: Float[Array, "height width 3"],
    attributes: dict[str, str | int | float] | None = None,
) -> None:
    """Writes linear Rec.709 radiance as half floats, ZIP compressed, atomically.

    The header gets the chromaticities of Rec.709 and, for a 2:1 picture, `envmap` = latlong. Values above
    65504 are written as 65504, the largest half.

    Args:
        path: the file to make.
        rgb: radiance, finite and not negative.
        attributes: further header entries; numbers are kept as 32-bit integers and floats.

    Raises:
        ValueError: shape, values or attributes cannot be written.
        OSError: the file cannot be made.
    """
    import OpenEXR

    if rgb.ndim != 3 or rgb.shape[-1] != 3 or 0 in rgb.shape:
        raise ValueError(f"{path}: expected values of shape [height, width, 3], received {list(rgb.shape)}")
    low, high = float(rgb.min()), float(rgb.max())  # NaN passes through both
    if not (low >= 0.0 and high < math.inf):
        received = "NaN" if math.isnan(low) else f"{low if low < 0.0 else high:g}"
        raise ValueError(f"{path}: expected finite values from 0 on, received {received}")
    header: dict[str, Any] = {name: _checked(path, name, value) for name, value in (attributes or {}).items()}
    header |= {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC709,
    }
    if rgb.shape[1] == 2 * rgb.shape[0]:
        header["envmap"] = OpenEXR.ENVMAP_LATLONG
    pixels = np.minimum(rgb, rgb.dtype.type(MAX_HALF)).astype(np.float16)
    with atomic_path(path) as temporary:
        try:
            OpenEXR.File(header, {"RGB": pixels}).write(str(temporary))
        except RuntimeError as error:
            reason = str(error).replace(str(temporary), str(path))
            raise OSError(f"{path}: expected to write an OpenEXR file, received: {reason}") from None


def _structure(path: str | os.PathLike[str]) -> list[Part]:
    with open(path, "rb") as file:
        try:
            return read_parts(file)
        except ValueError as error:
            raise reworded(path, error) from None


def _open(path: str | os.PathLike[str], *, separate: bool) -> Any:
    import OpenEXR

    try:
        file = OpenEXR.File(str(Path(path)), separate_channels=separate)
    except (RuntimeError, ValueError) as error:
        raise file_error(path, "an OpenEXR picture that can be decoded", error) from None
    # The library returns quietly without the parts or channels that it could not decode.
    if not file.parts or not all(file.channels(i) for i in range(len(file.parts))):
        raise file_error(path, "an OpenEXR picture that can be decoded", "corrupt pixel data")
    return file


def _find_colour(parts: list[dict[str, Any]]) -> tuple[int, list[Array]] | None:
    """The first part with colour: its index, and one array [h, w, 3 or 4] or three, or one, [h, w]."""
    for index, channels in enumerate(parts):
        pixels = {name: channel.pixels for name, channel in channels.items()}
        pixels = {name: p for name, p in pixels.items() if p.dtype in (np.float16, np.float32)}
        layers = {name.rpartition(".")[0] for name in pixels if re.search(r"\.[RGB]$", name)}
        whole = [name for name, p in pixels.items() if p.ndim == 3 and name not in ("RGB", "RGBA")]
        split = [name for name in layers if all(f"{name}.{c}" in pixels for c in "RGB")]
        for name in ("RGB", "RGBA"):
            if name in pixels:
                return index, [pixels[name]]
        if all(c in pixels for c in "RGB"):
            return index, [pixels[c] for c in "RGB"]
        if "Y" in pixels and not {"RY", "BY"} & set(channels):
            return index, [pixels["Y"]]
        if len(whole) + len(split) == 1:
            return index, [pixels[n] for n in whole] or [pixels[f"{split[0]}.{c}"] for c in "RGB"]
    return None


def _interleaved(planes: list[Array]) -> Float32[Array, "height width 3"]:
    first = planes[0]
    if first.ndim == 3:
        return np.ascontiguousarray(first[..., :3], dtype=np.float32)
    rgb = np.empty((*first.shape, 3), dtype=np.float32)
    for channel in range(3):
        rgb[..., channel] = planes[channel % len(planes)]
    return rgb


def _to_display_window(
    data: Float32[Array, "rows columns 3"], part: Part
) -> Float32[Array, "height width 3"]:
    if part.data_window == part.display_window:
        return data
    height, width = part.size
    picture = np.zeros((height, width, 3), dtype=np.float32)
    x, y = (part.data_window[i] - part.display_window[i] for i in (0, 1))
    rows, columns = data.shape[:2]
    picture[max(y, 0) : max(y + rows, 0), max(x, 0) : max(x + columns, 0)] = data[
        max(-y, 0) : max(height - y, 0), max(-x, 0) : max(width - x, 0)
    ]
    return picture


def _attributes(header: dict[str, Any]) -> dict[str, Attribute]:
    attributes: dict[str, Attribute] = {}
    for name, value in header.items():
        if isinstance(value, str | int | float):
            attributes[name] = value
        elif name == "chromaticities":
            attributes[name] = tuple(float(c) for c in value)
        elif name in ("envmap", "compression"):
            attributes[name] = value.name.removeprefix("ENVMAP_").removesuffix("_COMPRESSION").lower()
    return attributes


def _checked(path: str | os.PathLike[str], name: str, value: object) -> str | int | float:
    if name in _STRUCTURE or not re.fullmatch(r"[\x21-\x7e]{1,255}", name):
        raise ValueError(
            f"{path}: expected attribute names of up to 255 letters other than those of OpenEXR itself, "
            f"received {name!r}"
        )
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ValueError(f"{path}: expected a text or a number for the attribute {name}, received {value!r}")
    if isinstance(value, int) and not -(2**31) <= value < 2**31:
        raise ValueError(f"{path}: expected a 32-bit integer for the attribute {name}, received {value}")
    if isinstance(value, np.generic):
        raise ValueError(f"{path}: expected a plain number for the attribute {name}, received {value!r}")
    return value
