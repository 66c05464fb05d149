import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.image.color import REC709, luminance, rgb_to_xyz_matrix
from mixlight.image.temperature import COOLEST, NEUTRAL, WARMEST, black_body, white_point_gain


def chromaticity(rgb: np.ndarray) -> tuple[float, float]:
    x, y, z = rgb_to_xyz_matrix(REC709) @ rgb
    return x / (x + y + z), y / (x + y + z)


def planck(kelvin: float) -> tuple[float, float]:
    """Chromaticity from Planck's law and the CIE 1931 observer, in the analytic form of Wyman et al. 2013."""
    nm = np.arange(380.0, 781.0)
    spectrum = nm**-5.0 / np.expm1(1.438776877e7 / (nm * kelvin))

    def lobe(height: float, centre: float, below: float, above: float) -> np.ndarray:
        return height * np.exp(-0.5 * ((nm - centre) / np.where(nm < centre, below, above)) ** 2)

    x = lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2)
    y = lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1)
    z = lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8)
    sums = [float((spectrum * matching).sum()) for matching in (x, y, z)]
    return sums[0] / sum(sums), sums[1] / sum(sums)


def test_illuminant_a_is_a_black_body_of_2856_kelvin() -> None:
    assert chromaticity(black_body(2856.0)) == pytest.approx((0.44758, 0.40745), abs=5e-4)


@pytest.mark.parametrize("kelvin", [2000.0, 2700.0, 4000.0, 6504.0, 9000.0, 15000.0])
def test_it_is_plancks_law_seen_by_the_standard_observer(kelvin: float) -> None:
    assert chromaticity(black_body(kelvin)) == pytest.approx(planck(kelvin), abs=3e-3)


@given(st.floats(WARMEST, COOLEST))
def test_the_gain_keeps_the_luminance_of_white_and_is_light(kelvin: float) -> None:
    gain = white_point_gain(kelvin)
    assert float(luminance(gain)) == pytest.approx(1, abs=1e-12)
    assert (gain > 0).all()
    assert float(luminance(black_body(kelvin))) == pytest.approx(1, abs=5e-4)  # weights of four digits


def test_neutral_changes_nothing_and_lower_is_warmer() -> None:
    assert white_point_gain(NEUTRAL).tolist() == pytest.approx([1, 1, 1], abs=1e-12)
    ratios = [
        white_point_gain(kelvin)[0] / white_point_gain(kelvin)[2] for kelvin in (2000, 3000, 5000, 9000)
    ]
    assert ratios == sorted(ratios, reverse=True)


@pytest.mark.parametrize("kelvin", [1999.9, 15000.1, 0.0, -5.0, math.nan, math.inf])
def test_other_temperatures_are_refused(kelvin: float) -> None:
    with pytest.raises(ValueError, match="expected 2000 to 15000 kelvin"):
        white_point_gain(kelvin)
