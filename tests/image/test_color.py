"""Colour: published values, inverses, and an independent implementation of the sRGB curve."""

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from mixlight.image.color import (
    LUMINANCE_WEIGHTS,
    REC709,
    convert_to_rec709,
    is_rec709,
    linear_to_srgb,
    luminance,
    rgb_to_rec709_matrix,
    rgb_to_xyz_matrix,
    srgb_to_linear,
    xyz_to_rec709,
)

P3 = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.3290)
SHAPES = [(), (2,), (1, 2)]


def test_the_curve_at_known_points() -> None:
    encoded = np.array([0.0, 0.04045, 0.5, 1.0])
    np.testing.assert_allclose(srgb_to_linear(encoded), [0.0, 0.0031308, 0.21404114, 1.0], rtol=1e-5)
    np.testing.assert_allclose(linear_to_srgb(np.array([0.0, 0.18, 1.0])), [0.0, 0.46135613, 1.0], rtol=1e-7)


@given(arrays.arrays(np.float64, 20, elements=st.floats(-1.0, 4.0)))
def test_the_curves_are_inverse(values: np.ndarray) -> None:
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(values)), values, rtol=1e-6, atol=1e-6)


def test_the_curve_is_monotonic_and_nearly_continuous() -> None:
    x = np.linspace(-0.1, 1.2, 100001)
    for curve in (srgb_to_linear, linear_to_srgb):
        steps = np.diff(curve(x))
        assert (steps > 0.0).all()
        assert steps.max() < 2e-4


def test_openimageio_has_the_same_curve() -> None:
    values = np.linspace(0.0, 1.0, 3000, dtype=np.float32).reshape(1, 1000, 3)
    buffer = oiio.ImageBuf(oiio.ImageSpec(1000, 1, 3, "float"))
    buffer.set_pixels(oiio.ROI(), values)
    theirs = oiio.ImageBufAlgo.colorconvert(buffer, "sRGB", "linear").get_pixels(oiio.FLOAT)
    np.testing.assert_allclose(srgb_to_linear(values), theirs, atol=2e-4)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_shapes_and_dtypes_are_kept(shape: tuple[int, ...], dtype: type) -> None:
    values = np.full((*shape, 3), 0.5, dtype)
    for function in (srgb_to_linear, linear_to_srgb, xyz_to_rec709):
        result = function(values)
        assert (result.shape, result.dtype) == (values.shape, dtype)
    assert luminance(values).shape == shape
    assert convert_to_rec709(values, P3).shape == values.shape


def test_integers_are_not_divided() -> None:
    np.testing.assert_array_equal(srgb_to_linear(np.array([0, 1])), [0.0, 1.0])
    assert srgb_to_linear(np.array([0, 1])).dtype == np.float64


def test_the_matrix_of_rec709_is_the_published_one() -> None:
    # IEC 61966-2-1, annex: four decimals.
    published = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    np.testing.assert_allclose(rgb_to_xyz_matrix(REC709), published, atol=6e-5)
    np.testing.assert_allclose(rgb_to_xyz_matrix(REC709)[1], LUMINANCE_WEIGHTS, atol=5e-5)


def test_xyz_is_the_inverse_and_white_is_white() -> None:
    rgb = np.random.default_rng(0).random((5, 3))
    np.testing.assert_allclose(xyz_to_rec709(rgb @ rgb_to_xyz_matrix(REC709).T), rgb, atol=1e-12)
    np.testing.assert_allclose(rgb_to_rec709_matrix(REC709), np.eye(3), atol=1e-12)


def test_bradford_from_d50_is_the_published_adaptation() -> None:
    # B. Lindbloom's table: D50 to D65, whose D65 is rounded otherwise (Z 1.08883 for 1.08906).
    published = [
        [0.9555766, -0.0230393, 0.0631636],
        [-0.0282895, 1.0099416, 0.0210077],
        [0.0122982, -0.0204830, 1.3299098],
    ]
    d50 = (*REC709[:6], 0.34567, 0.35850)
    adaptation = rgb_to_xyz_matrix(REC709) @ rgb_to_rec709_matrix(d50) @ np.linalg.inv(rgb_to_xyz_matrix(d50))
    np.testing.assert_allclose(adaptation, published, atol=4e-4)


@given(st.tuples(st.floats(0.2, 0.45), st.floats(0.2, 0.45)))
def test_any_white_stays_white(white: tuple[float, float]) -> None:
    matrix = rgb_to_rec709_matrix((*REC709[:6], *white))
    np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-9)


def test_what_leaves_rec709_is_clipped_and_what_was_wrong_stays() -> None:
    rgb = np.array([[1.0, 0.0, 0.0], [-0.5, 0.2, 0.2]])
    converted = convert_to_rec709(rgb, P3)
    assert converted[0].tolist()[1:] == [0.0, 0.0]
    assert converted[1, 0] < 0.0
    assert np.isnan(convert_to_rec709(np.array([[np.nan, 0.0, np.inf]]), P3)).any()


@pytest.mark.parametrize(
    ("chromaticities", "known"),
    [(REC709, True), ((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3128, 0.329), True), (P3, False), ((), False)],
)
def test_rec709_is_recognised(chromaticities: tuple[float, ...], known: bool) -> None:
    assert is_rec709(chromaticities) is known


@pytest.mark.parametrize(
    "chromaticities",
    [(0.1,) * 8, (0.64, 0.0, 0.3, 0.6, 0.15, 0.06, 0.3, 0.3), (0.3,) * 7, (*REC709[:7], np.nan)],
)
def test_chromaticities_that_span_nothing_are_refused(chromaticities: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match=r"chromaticities: expected .* received"):
        rgb_to_xyz_matrix(chromaticities)
