"""Radiance pixels: three mantissas that share one exponent."""

import numpy as np
from jaxtyping import Float, Float32, UInt8

from mixlight.image._array import Array

__all__ = ["LARGEST", "decode", "encode"]

LARGEST = 255.5 * 2.0**119
"""Values from here on have no place in the format (8.5e37 times two: exponents end at 2^127)."""

_SCALE = np.where(np.arange(256) == 0, 0.0, np.ldexp(1.0, np.arange(256) - 136)).astype(np.float32)
_BATCH = 2**18  # pixels whose temporaries stay in the cache


def decode(pixels: UInt8[Array, "height width 4"]) -> Float32[Array, "height width 3"]:
    """The values m * 2^(E - 136) of pixels (m_r, m_g, m_b, E); E = 0 is black.

    Convention: (128, 64, 0, 129) is (1, 0.5, 0). Half a step is not added to the mantissa, as in OpenCV,
    OpenImageIO and three.js: whole powers of two come back exactly and an empty channel stays empty.

    Source: G. Ward, "Real Pixels", Graphics Gems II, 1991.

    >>> decode(np.array([[[128, 64, 0, 129]]], np.uint8))[0, 0].tolist()
    [1.0, 0.5, 0.0]
    """
    values = np.empty((*pixels.shape[:2], 3), dtype=np.float32)
    rows = max(1, _BATCH // max(pixels.shape[1], 1))
    for row in range(0, len(pixels), rows):
        part = pixels[row : row + rows]
        np.multiply(part[..., :3], _SCALE[part[..., 3]][..., None], out=values[row : row + rows])
    return values


def encode(values: Float[Array, "height width 3"]) -> UInt8[Array, "height width 4"]:
    """The nearest pixels to values, so that the brightest channel is off by at most 1/256 of itself.

    Pixels below 2^-128 become black.

    Raises:
        ValueError: NaN, negative or infinite values, or values of 1.7e38 and more.

    >>> encode(np.array([[[1.0, 0.5, 0.0]]]))[0, 0].tolist()
    [128, 64, 0, 129]
    """
    pixels = np.zeros((*values.shape[:2], 4), dtype=np.uint8)
    rows = max(1, _BATCH // max(values.shape[1], 1))
    for row in range(0, len(values), rows):
        part = np.asarray(values[row : row + rows], dtype=np.float32)
        low, high = part.min(initial=0.0), part.max(initial=0.0)  # NaN passes through both
        if not (low >= 0.0 and high < LARGEST):
            received = "NaN" if np.isnan(low) else f"{low if low < 0.0 else high:g}"
            raise ValueError(f"expected finite values from 0 to below {LARGEST:.3g}, received {received}")
        brightest = part.max(axis=-1)
        # 2^e > brightest * 256/255.5, so that no mantissa rounds up to 256.
        exponent = np.frexp(brightest * np.float32(256.0 / 255.5))[1]
        visible = (brightest > 0.0) & (exponent >= -127)
        exponent = np.where(visible, exponent, 0)
        mantissas = np.rint(np.ldexp(part, (8 - exponent)[..., None]))
        pixels[row : row + rows, :, :3] = np.where(visible[..., None], mantissas, 0.0)
        pixels[row : row + rows, :, 3] = np.where(visible, exponent + 128, 0)
    return pixels
