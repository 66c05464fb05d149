"""ICC profiles of the common kind: three curves and a matrix (or one curve for grey).

sRGB, Display P3, Adobe RGB, ProPhoto and most camera profiles are of this kind. Reading them ourselves gives
linear light directly, for 16 bits as well as for 8, and without clipping to sRGB on the way.

Source: ICC.1:2022 (profile version 4.4), sections 7 to 10.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from mixlight.image._array import Array
from mixlight.image.color import REC709, rgb_to_rec709_matrix, rgb_to_xyz_matrix, srgb_to_linear

__all__ = ["Profile", "parse"]

Curve = Callable[[Float64[Array, "*shape"]], Float64[Array, "*shape"]]
_D50 = np.array([0.9642, 1.0, 0.8249])


@dataclass(frozen=True)
class Profile:
    """How encoded values become linear Rec.709."""

    name: str
    """The profile's description, such as "Display P3"."""
    curves: tuple[Curve, ...]
    """From the encoded value in [0, 1] to linear light: three, or one for grey."""
    matrix: Float64[Array, "3 3"] | None
    """From linear device colour to linear Rec.709; None where both are the same."""


def parse(data: bytes) -> Profile | None:
    """Reads a profile; None if it is of another kind (tables, CMYK), which a colour engine has to deal with.

    Convention: device white (1, 1, 1) becomes Rec.709 white (1, 1, 1), as with the media-relative intent. A
    curve that is sRGB's within a thousandth, and a matrix that is the identity within half a percent, are
    taken for it, so that a picture means the same with and without an sRGB profile.

    Raises:
        ValueError: the data are no ICC profile.

    >>> parse(b"no profile")
    Traceback (most recent call last):
    ...
    ValueError: expected an ICC profile, received 10 bytes that are none
    """
    if len(data) < 132 or data[36:40] != b"acsp":
        raise ValueError(f"expected an ICC profile, received {len(data)} bytes that are none")
    try:
        tags = _tags(data)
        name = _description(tags.get(b"desc", b""))
        if data[16:20] == b"GRAY" and b"kTRC" in tags:
            return Profile(name, (_curve(tags[b"kTRC"]),), None)
        wanted = (b"rXYZ", b"gXYZ", b"bXYZ", b"rTRC", b"gTRC", b"bTRC")
        if (
            data[16:20] != b"RGB "
            or data[20:24] != b"XYZ "
            or b"A2B0" in tags
            or not tags.keys() >= set(wanted)
        ):
            return None
        colorants = np.stack([_numbers(tags[t], 8, 3) for t in wanted[:3]], axis=1)
        curves = tuple(_curve(tags[t]) for t in wanted[3:])
        return Profile(name, curves, _matrix(colorants))
    except (struct.error, IndexError, ZeroDivisionError, np.linalg.LinAlgError) as error:
        raise ValueError(f"expected a complete ICC profile, received {len(data)} bytes ({error})") from None


def _tags(data: bytes) -> dict[bytes, bytes]:
    (count,) = struct.unpack_from(">I", data, 128)
    if count > 1000:
        raise IndexError(f"{count} tags")
    entries = [struct.unpack_from(">4sII", data, 132 + 12 * i) for i in range(count)]
    if any(offset + size > len(data) for _, offset, size in entries):
        raise IndexError("truncated")
    return {tag: data[offset : offset + size] for tag, offset, size in entries}


def _description(tag: bytes) -> str:
    if tag[:4] == b"desc":
        (length,) = struct.unpack_from(">I", tag, 8)
        return tag[12 : 12 + length].rstrip(b"\0").decode("ascii", "replace")
    if tag[:4] == b"mluc":
        length, offset = struct.unpack_from(">II", tag, 20)
        return tag[offset : offset + length].decode("utf-16-be", "replace").rstrip("\0")
    return "ICC profile"


def _numbers(tag: bytes, offset: int, count: int) -> Float64[Array, " count"]:
    """Signed fixed-point numbers with 16 bits behind the point."""
    return np.array(struct.unpack_from(f">{count}i", tag, offset)) / 65536.0


def _matrix(colorants: Float64[Array, "3 3"]) -> Float64[Array, "3 3"] | None:
    """Device to Rec.709, from the primaries' XYZ, which profiles give relative to D50."""
    x, y, _ = _D50 / _D50.sum()
    d50_rgb = (*REC709[:6], float(x), float(y))  # Rec.709's primaries with the white of the profile space
    to_d50_rgb = np.linalg.solve(rgb_to_xyz_matrix(d50_rgb), colorants)
    matrix = rgb_to_rec709_matrix(d50_rgb) @ to_d50_rgb
    white = matrix.sum(axis=1, keepdims=True)
    if not (np.abs(white - 1.0) < 0.2).all():
        raise IndexError(f"white at {white[:, 0].round(2).tolist()} of Rec.709's")
    matrix = matrix / white
    return None if np.abs(matrix - np.eye(3)).max() < 5e-3 else np.asarray(matrix)


def _curve(tag: bytes) -> Curve:
    if tag[:4] == b"curv":
        (count,) = struct.unpack_from(">I", tag, 8)
        table = np.array(struct.unpack_from(f">{count}H", tag, 12), dtype=np.float64)
        if count == 0:
            curve: Curve = lambda x: x  # noqa: E731
        elif count == 1:
            curve = _parametric(0, table / 256.0)
        else:
            curve = lambda x: np.interp(x, np.linspace(0.0, 1.0, count), table / 65535.0)  # noqa: E731
    elif tag[:4] == b"para":
        (kind,) = struct.unpack_from(">H", tag, 8)
        curve = _parametric(kind, _numbers(tag, 12, (1, 3, 4, 5, 7)[kind]))
    else:
        raise IndexError(f"curve of type {tag[:4]!r}")
    x = np.linspace(0.0, 1.0, 256)
    return srgb_to_linear if np.abs(curve(x) - srgb_to_linear(x)).max() < 1e-3 else curve


def _parametric(kind: int, parameters: Float64[Array, " n"]) -> Curve:
    """ICC.1 table 68: (a x + b)^g + e from d on, c x + f below."""
    p = [float(v) for v in parameters]
    if p[0] <= 0.0:
        raise IndexError(f"exponent {p[0]:g}")
    if kind == 0:
        g, a, b, c, d, e, f = p[0], 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    elif kind < 3:
        g, a, b = p[:3]
        c, d = 0.0, -b / a
        e = f = p[3] if kind == 2 else 0.0
    else:
        g, a, b, c, d, e, f = (*p, 0.0, 0.0)[:7]

    def curve(x: Float64[Array, "*shape"]) -> Float64[Array, "*shape"]:
        power = np.maximum(a * x + b, 0.0) ** g + e
        return np.clip(np.where(x >= d, power, c * x + f), 0.0, 1.0)

    return curve
