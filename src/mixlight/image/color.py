"""Colour spaces: the sRGB curve, Rec.709 luminance, and other primaries turned into Rec.709."""

import numpy as np
from jaxtyping import Float, Float64, Num

from mixlight.image._array import Array

__all__ = [
    "LUMINANCE_WEIGHTS",
    "REC709",
    "convert_to_rec709",
    "is_rec709",
    "linear_to_srgb",
    "luminance",
    "rgb_to_rec709_matrix",
    "rgb_to_xyz_matrix",
    "srgb_to_linear",
    "xyz_to_rec709",
]

LUMINANCE_WEIGHTS = (0.2126, 0.7152, 0.0722)
"""Rec.709 luminance of linear red, green and blue (ITU-R BT.709-6, item 3.2)."""

REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
"""CIE xy of red, green, blue and the white D65 (ITU-R BT.709-6, item 1)."""

_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def srgb_to_linear(encoded: Num[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Decodes sRGB values into linear light: c/12.92 up to 0.04045, ((c + 0.055)/1.055)^2.4 above.

    Values above 1 follow the power, negative ones the straight part.

    Convention: both sides run from 0 to 1 = white; mid-grey 0.5 is 0.214 of the light.
    Source: IEC 61966-2-1:1999. The dtype is kept; integers become float64 (they are not divided by 255).

    >>> round(float(srgb_to_linear(np.array(0.5))), 6)
    0.214041
    """
    c = _floating(encoded)
    # The base is clamped because NumPy evaluates both branches, and a power of a negative number is NaN.
    curve = ((np.maximum(c, 0.0) + 0.055) / 1.055) ** 2.4
    return np.where(c <= 0.04045, c / 12.92, curve).astype(c.dtype)


def linear_to_srgb(linear: Num[Array, "*shape"]) -> Float[Array, "*shape"]:
    """Encodes linear light as sRGB: 12.92 c up to 0.0031308, 1.055 c^(1/2.4) - 0.055 above.

    Convention: the inverse of `srgb_to_linear`; 18 % grey becomes 0.4614. Source: IEC 61966-2-1:1999.

    >>> round(float(linear_to_srgb(np.array(0.18))), 4)
    0.4614
    """
    c = _floating(linear)
    curve = 1.055 * np.maximum(c, 0.0) ** (1.0 / 2.4) - 0.055
    return np.where(c <= 0.0031308, 12.92 * c, curve).astype(c.dtype)


def luminance(rgb: Num[Array, "*shape 3"]) -> Float[Array, "*shape"]:
    """Rec.709 luminance 0.2126 R + 0.7152 G + 0.0722 B of linear light.

    >>> round(float(luminance(np.array([1.0, 0.5, 0.0]))), 4)
    0.5702
    """
    c = _floating(rgb)
    return np.asarray(c @ np.asarray(LUMINANCE_WEIGHTS, dtype=c.dtype))


def rgb_to_xyz_matrix(chromaticities: tuple[float, ...]) -> Float64[Array, "3 3"]:
    """The matrix M with XYZ = M rgb for primaries and white given as CIE xy.

    Its columns are the primaries' XYZ, scaled so that rgb = (1, 1, 1) is the white with Y = 1.

    Args:
        chromaticities: (red x, red y, green x, green y, blue x, blue y, white x, white y).

    Raises:
        ValueError: not eight finite numbers, a y of 0, or primaries on one line.

    Source: SMPTE RP 177-1993.

    >>> rgb_to_xyz_matrix(REC709).round(4)[1]
    array([0.2126, 0.7152, 0.0722])
    """
    xy = np.asarray(chromaticities, dtype=np.float64)
    if xy.shape != (8,) or not np.isfinite(xy).all() or (xy[1::2] == 0.0).any():
        raise ValueError(
            f"chromaticities: expected 8 finite numbers with y above 0, received {tuple(xy.tolist())}"
        )
    x, y = xy.reshape(4, 2).T
    xyz = np.stack([x / y, np.ones(4), (1.0 - x - y) / y])
    if abs(np.linalg.det(xyz[:, :3])) < 1e-9:
        raise ValueError(
            f"chromaticities: expected three independent primaries, received {tuple(xy.tolist())}"
        )
    return np.asarray(xyz[:, :3] * np.linalg.solve(xyz[:, :3], xyz[:, 3]))


def rgb_to_rec709_matrix(chromaticities: tuple[float, ...]) -> Float64[Array, "3 3"]:
    """The matrix M with rec709 = M rgb for linear rgb of other primaries, white kept white.

    M = inverse(M709) A M_rgb, where A adapts the white to D65 in Bradford's cone space; a picture that was
    white balanced for its own white stays so.

    Convention: (1, 1, 1) maps to (1, 1, 1). The pure red of Display P3 lies outside Rec.709 and gets a
    negative green of -0.042.

    Source: ICC.1:2022, annex E (Bradford); primaries as for `rgb_to_xyz_matrix`.

    >>> p3 = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.3290)
    >>> rgb_to_rec709_matrix(p3)[:, 0].round(4)
    array([ 1.2249, -0.0421, -0.0196])
    """
    source, target = rgb_to_xyz_matrix(chromaticities), rgb_to_xyz_matrix(REC709)
    ratio = (_BRADFORD @ target.sum(1)) / (_BRADFORD @ source.sum(1))
    adapt = np.linalg.solve(_BRADFORD, ratio[:, None] * _BRADFORD)
    return np.asarray(np.linalg.solve(target, adapt @ source))


def convert_to_rec709(
    rgb: Float[Array, "*shape 3"], chromaticities: tuple[float, ...]
) -> Float[Array, "*shape 3"]:
    """Linear rgb of other primaries in Rec.709, white kept white, without negative light.

    Colours outside Rec.709 get a negative component; it is clipped at 0, because radiance is never negative.
    What is negative, infinite or NaN in the input stays so, for the caller to find.

    Raises:
        ValueError: the chromaticities span no colour space.

    >>> p3 = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.3290)
    >>> convert_to_rec709(np.array([1.0, 0.0, 0.0]), p3).round(3)
    array([1.225, 0.   , 0.   ])
    """
    matrix = rgb_to_rec709_matrix(chromaticities).astype(rgb.dtype)
    with np.errstate(invalid="ignore"):  # infinity - infinity
        converted = np.asarray(rgb @ matrix.T)
    converted[(converted < 0.0) & (rgb >= 0.0).all(axis=-1, keepdims=True)] = 0.0
    return converted


def is_rec709(chromaticities: tuple[float, ...]) -> bool:
    """Whether primaries and white are those of Rec.709, as far as files round them (three decimals).

    >>> is_rec709((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))
    True
    """
    return len(chromaticities) == 8 and bool(np.allclose(chromaticities, REC709, rtol=0.0, atol=1.1e-3))


def xyz_to_rec709(xyz: Float[Array, "*shape 3"]) -> Float[Array, "*shape 3"]:
    """CIE XYZ to linear Rec.709, colorimetrically (no white adaptation): D65 white (0.9505, 1, 1.0891) is (1,
    1, 1).

    Colours outside Rec.709 get negative components; the caller decides what becomes of them.

    >>> xyz_to_rec709(np.array([0.95046, 1.0, 1.08906])).round(3)
    array([1., 1., 1.])
    """
    matrix = np.linalg.inv(rgb_to_xyz_matrix(REC709)).astype(xyz.dtype)
    return np.asarray(xyz @ matrix.T)


def _floating(values: Num[Array, "*shape"]) -> Float[Array, "*shape"]:
    array = np.asarray(values)
    return array if np.issubdtype(array.dtype, np.floating) else array.astype(np.float64)
