"""Radiance made visible: exposure, a soft shoulder, and the sRGB curve."""

import numpy as np
from jaxtyping import Float, Float32, UInt8

from mixlight.image._array import Array
from mixlight.image.color import LUMINANCE_WEIGHTS, linear_to_srgb

__all__ = ["exposure_for", "preview", "shoulder"]


def shoulder(
    linear: Float[Array, "*shape"], knee: float = 0.6, white: float = 16.0
) -> Float[Array, "*shape"]:
    """Leaves values up to `knee` as they are and bends those above softly so that `white` becomes 1.

    Above the knee k the curve is k + (1 - k) log(1 + c t) / log(1 + c T) with t = (x - k)/(1 - k), T its
    value at white, and c such that the slope at the knee is 1: what a photo shows is shown unchanged, and
    ratios among sources stay visible as equal steps.

    Raises:
        ValueError: not 0 <= knee < 1 < white.

    >>> shoulder(np.array([0.5, 1.0, 16.0])).round(3)
    array([0.5  , 0.739, 1.   ])
    """
    if not 0.0 <= knee < 1.0 < white:
        raise ValueError(f"expected 0 <= knee < 1 < white, received knee {knee} and white {white}")
    top = (white - knee) / (1.0 - knee)
    # Slope 1 at the knee: c / log(1 + c T) = 1, solved by bisection; the left side grows with c.
    low, high = 1e-9, top
    for _ in range(100):
        c = 0.5 * (low + high)
        low, high = (c, high) if c < np.log1p(c * top) else (low, c)
    excess = np.maximum(linear - knee, 0.0) / (1.0 - knee)
    bent = knee + (1.0 - knee) * np.log1p(c * excess) / np.log1p(c * top)
    return np.where(linear > knee, np.minimum(bent, 1.0), linear).astype(linear.dtype)


def exposure_for(linear: Float[Array, "*shape 3"], target: float = 0.18) -> float:
    """The gain that brings the median luminance to `target`; 1 for a picture whose median is black.

    >>> exposure_for(np.full((2, 2, 3), 0.09))
    2.0
    """
    median = float(np.median(linear @ np.asarray(LUMINANCE_WEIGHTS, dtype=linear.dtype)))
    return target / median if median > 0.0 else 1.0


def preview(linear: Float[Array, "*shape 3"], exposure: float = 1.0) -> UInt8[Array, "*shape 3"]:
    """An 8-bit sRGB picture of linear radiance for people to look at.

    Convention: with exposure 1, radiance 0.18 becomes 118 as in an ordinary photo; radiance 1 becomes 223 and
    keeps its hue, because one factor, found from the brightest channel, scales all three; 16 and above is
    white.

    Args:
        linear: radiance; negative values are shown black.
        exposure: gain before the shoulder; `exposure_for` proposes one.

    Raises:
        ValueError: NaN or infinite values, or a gain that is not positive.

    >>> preview(np.full((1, 1, 3), 0.18)).tolist()
    [[[118, 118, 118]]]
    """
    if not 0.0 < exposure < np.inf:
        raise ValueError(f"expected a positive exposure, received {exposure}")
    if not np.isfinite(linear).all():
        raise ValueError("expected finite radiance, received NaN or infinite values")
    light: Float32[Array, "*shape 3"] = np.maximum(
        np.asarray(linear, dtype=np.float32) * np.float32(exposure), 0.0
    )
    brightest = light.max(axis=-1, keepdims=True)
    scale = shoulder(brightest) / np.maximum(brightest, np.float32(1e-20))
    return np.asarray(np.rint(linear_to_srgb(light * scale) * 255.0), dtype=np.uint8)
