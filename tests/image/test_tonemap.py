"""Previews: what a photo shows stays as it is, what is brighter stays visible."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.image.color import linear_to_srgb
from mixlight.image.tonemap import exposure_for, preview, shoulder


def test_golden_values() -> None:
    greys = preview(np.array([0.0, 0.18, 0.5, 1.0, 4.0, 16.0, 1e6]).repeat(3).reshape(-1, 3))[:, 0]
    assert greys.tolist() == [0, 118, 188, 223, 242, 255, 255]


def test_below_the_knee_a_preview_is_plain_srgb() -> None:
    values = np.random.default_rng(0).random((9, 9, 3)).astype(np.float32) * 0.6
    np.testing.assert_array_equal(preview(values), np.rint(linear_to_srgb(values) * 255.0))


@given(st.floats(0.0, 0.9), st.floats(1.1, 200.0))
def test_the_shoulder_rises_smoothly_to_white(knee: float, white: float) -> None:
    x = np.linspace(0.0, white * 1.2, 5001)
    y = shoulder(x, knee, white)
    slope = np.diff(y) / np.diff(x)
    assert (slope >= -1e-12).all()
    assert (slope <= 1.0 + 1e-6).all()
    np.testing.assert_allclose(y[x <= knee], x[x <= knee])
    np.testing.assert_allclose(shoulder(np.array([white, 2.0 * white]), knee, white), 1.0)


def test_hue_is_kept_in_bright_colours() -> None:
    from mixlight.image.color import srgb_to_linear

    bright = srgb_to_linear(preview(np.array([8.0, 4.0, 2.0])) / 255.0)
    np.testing.assert_allclose(bright / bright[0], [1.0, 0.5, 0.25], atol=0.01)


@pytest.mark.parametrize("shape", [(3,), (2, 3), (1, 2, 3)])
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_any_leading_shape(shape: tuple[int, ...], dtype: type) -> None:
    result = preview(np.full(shape, 0.25, dtype), exposure=0.72)
    assert (result.shape, result.dtype) == (shape, np.uint8)
    assert (result == 118).all()


def test_exposure_brings_the_median_to_middle_grey() -> None:
    values = np.random.default_rng(1).random((20, 20, 3)) * 0.01
    gain = exposure_for(values)
    np.testing.assert_allclose(exposure_for(values * gain), 1.0)
    assert exposure_for(np.zeros((4, 4, 3))) == 1.0


def test_negative_is_black_and_senseless_is_refused() -> None:
    assert preview(np.array([-1.0, -1.0, -1.0])).tolist() == [0, 0, 0]
    with pytest.raises(ValueError, match="expected finite radiance"):
        preview(np.array([np.nan, 0.0, 0.0]))
    with pytest.raises(ValueError, match=r"expected a positive exposure, received 0\.0"):
        preview(np.zeros(3), exposure=0.0)
    with pytest.raises(ValueError, match="expected 0 <= knee < 1 < white"):
        shoulder(np.zeros(3), white=0.5)
