"""Colour temperature: the white of a black body, in linear Rec.709."""

import numpy as np
from jaxtyping import Float64

from mixlight.image._array import Array
from mixlight.image.color import luminance, xyz_to_rec709

__all__ = ["COOLEST", "NEUTRAL", "WARMEST", "black_body", "white_point_gain"]

NEUTRAL = 6504.0
"""Colour temperature, in kelvin, of the light that Rec.709 shows as white (D65)."""

WARMEST, COOLEST = 2000.0, 15000.0
"""Kelvin: below, black bodies leave Rec.709; above, the formula does not hold."""


def black_body(kelvin: float) -> Float64[Array, "3"]:
    """Linear Rec.709 of the luminance 1 that has the chromaticity of a black body.

    The Planckian locus in CIE 1960 uv is a ratio of two quadratics in the temperature, each::

        u = (0.860117757 + 1.54118254e-4 T + 1.28641212e-7 T^2) / (1 + 8.42420235e-4 T + 7.08145163e-7 T^2)
        v = (0.317398726 + 4.22806245e-5 T + 4.20481691e-8 T^2) / (1 - 2.89741816e-5 T + 1.61456053e-7 T^2)

    within 9e-5 of the true locus from 1000 to 15000 K.

    Convention: low is warm. At 6504 K it is near (1, 1, 1) but not quite: daylight, D65, is a little greener
    than a black body.

    Raises:
        ValueError: not from 2000 to 15000 K.

    Source: M. Krystek, An algorithm to calculate correlated colour temperature, 1985.

    >>> black_body(3000.0).round(2)
    array([1.77, 0.84, 0.27])
    """
    if not WARMEST <= kelvin <= COOLEST:
        raise ValueError(f"temperature: expected {WARMEST:g} to {COOLEST:g} kelvin, received {kelvin:g}")
    u = (0.860117757 + 1.54118254e-4 * kelvin + 1.28641212e-7 * kelvin**2) / (
        1 + 8.42420235e-4 * kelvin + 7.08145163e-7 * kelvin**2
    )
    v = (0.317398726 + 4.22806245e-5 * kelvin + 4.20481691e-8 * kelvin**2) / (
        1 - 2.89741816e-5 * kelvin + 1.61456053e-7 * kelvin**2
    )
    # x = 3u / (2u - 8v + 4), y = 2v / (2u - 8v + 4); XYZ = (x / y, 1, (1 - x - y) / y).
    return xyz_to_rec709(np.array([1.5 * u / v, 1.0, (4.0 - u - 10.0 * v) / (2.0 * v)]))


def white_point_gain(kelvin: float) -> Float64[Array, "3"]:
    """Gain of each channel that turns white light into that of a black body, as bright as before.

    The ratio of two white points, ``black_body(kelvin) / black_body(6504)``, over its own luminance.

    Convention: at 6504 K it is (1, 1, 1); white light (1, 1, 1) keeps its luminance exactly.

    Raises:
        ValueError: not from 2000 to 15000 K.

    >>> white_point_gain(3000.0).round(2), white_point_gain(6504.0)
    (array([1.71, 0.86, 0.26]), array([1., 1., 1.]))
    """
    ratio = black_body(kelvin) / black_body(NEUTRAL)
    return np.asarray(ratio / luminance(ratio))
