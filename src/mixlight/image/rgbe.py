"""Radiance pixels: three mantissas that share one exponent."""

import numpy as np
from jaxtyping import Float, Float32, UInt8

from mixlight.image._array import Array

__all__ = ["DARKEST", "LARGEST", "decode", "encode"]

LARGEST = 255.5 * 2.0**119
"""Values from here on have no place in the format (8.5e37 times two: exponents end at 2^127)."""

DARKEST = 2.0**-120
"""Brightest channels below this (7.5e-37) are written as black."""

_VALUE_OF_STEP = np.where(np.arange(256) == 0, 0.0, np.ldexp(1.0, np.arange(256) - 136)).astype(np.float32)
_STORED = np.arange(256)
_VISIBLE = _STORED >= 7  # 2^-120; below it the factor would not be a float32
_STEPS_OF_EXPONENT = np.where(_VISIBLE, np.ldexp(1.0, 134 - np.maximum(_STORED, 7)), 0.0).astype(np.float32)
_BYTE_OF_EXPONENT = np.where(_VISIBLE, _STORED + 2, 0).astype(np.uint8)
_BATCH = 2**16  # pixels whose temporaries stay in the cache


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
        step = _VALUE_OF_STEP[part[..., 3]]
        for channel in range(3):
            np.multiply(part[..., channel], step, out=values[row : row + rows, :, channel])
    return values


def encode(values: Float[Array, "height width 3"]) -> UInt8[Array, "height width 4"]:
    """The nearest pixels to values, so that a channel is off by at most 1/255 of the brightest one.

    Pixels whose brightest channel is below 2^-120 become black. The result lies in memory channel by channel
    within each row, as the run-length coding takes it.

    Raises:
        ValueError: NaN, negative or infinite values, or values of 1.7e38 and more.

    >>> encode(np.array([[[1.0, 0.5, 0.0]]]))[0, 0].tolist()
    [128, 64, 0, 129]
    """
    height, width = values.shape[:2]
    planes = np.empty((height, 4, width), dtype=np.uint8)
    rows = max(1, _BATCH // max(width, 1))
    for row in range(0, height, rows):
        part = np.asarray(values[row : row + rows], dtype=np.float32)
        low, high = part.min(initial=0.0), part.max(initial=0.0)  # NaN passes through both
        if not (low >= 0.0 and high < LARGEST):
            received = "NaN" if np.isnan(low) else f"{low if low < 0.0 else high:g}"
            raise ValueError(f"expected finite values from 0 to below {LARGEST:.3g}, received {received}")
        brightest = np.maximum(np.maximum(part[..., 0], part[..., 1]), part[..., 2])
        # float32 stores 2^(b - 127) <= x < 2^(b - 126). With x = brightest * 256/255.5 no mantissa rounds up
        # to 256, and the mantissas are value * 2^(134 - b).
        exponent = (brightest * np.float32(256.0 / 255.5)).view(np.uint32) >> 23
        steps = _STEPS_OF_EXPONENT[exponent]
        for channel in range(3):
            np.add(part[..., channel] * steps, 0.5, out=planes[row : row + rows, channel], casting="unsafe")
        planes[row : row + rows, 3] = _BYTE_OF_EXPONENT[exponent]
    return planes.transpose(0, 2, 1)
