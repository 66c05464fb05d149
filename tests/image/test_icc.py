"""ICC profiles: against LittleCMS, every kind of curve, and profiles that are broken or of another kind."""

import io

import numpy as np
import pytest
from PIL import Image, ImageCms

from mixlight.image import icc
from mixlight.image.color import srgb_to_linear
from tests.image.build import (
    ADOBE_COLORANTS,
    P3_COLORANTS,
    SRGB_COLORANTS,
    SRGB_CURVE,
    gamma_curve,
    icc_bytes,
    parametric_curve,
    table_curve,
)

X = np.linspace(0.0, 1.0, 101)


def decode(profile: icc.Profile, encoded: np.ndarray) -> np.ndarray:
    linear = np.stack([profile.curves[c % len(profile.curves)](encoded[..., c]) for c in range(3)], axis=-1)
    return linear if profile.matrix is None else linear @ profile.matrix.T


@pytest.mark.parametrize(
    ("colorants", "curve"),
    [
        (P3_COLORANTS, SRGB_CURVE),
        (ADOBE_COLORANTS, gamma_curve(2.19921875)),
        (ADOBE_COLORANTS, table_curve(X**1.8)),
        (SRGB_COLORANTS, gamma_curve(1.0)),
    ],
)
def test_littlecms_decodes_the_same(colorants: np.ndarray, curve: bytes) -> None:
    data = icc_bytes(colorants, [curve] * 3)
    # Colours inside both gamuts, because LittleCMS clips to sRGB.
    samples = np.random.default_rng(0).integers(90, 160, (40, 40, 3), dtype=np.uint8)
    source, target = ImageCms.ImageCmsProfile(io.BytesIO(data)), ImageCms.createProfile("sRGB")
    theirs = ImageCms.profileToProfile(Image.fromarray(samples), source, target)
    profile = icc.parse(data)
    assert profile is not None
    ours = decode(profile, samples / 255.0)
    assert ours.min() > 0.0
    assert ours.max() < 1.0
    # One step of 8 bits in the middle of the range is 0.004 to 0.007 of linear light.
    np.testing.assert_allclose(ours, srgb_to_linear(np.asarray(theirs) / 255.0), atol=0.008)
    assert abs(float((ours - srgb_to_linear(np.asarray(theirs) / 255.0)).mean())) < 1e-3


def test_srgb_profiles_mean_plain_srgb() -> None:
    for data in (
        icc_bytes(SRGB_COLORANTS, [SRGB_CURVE] * 3),
        icc_bytes(SRGB_COLORANTS, [table_curve(srgb_to_linear(np.linspace(0.0, 1.0, 1024)))] * 3),
        ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes(),
    ):
        profile = icc.parse(data)
        assert profile is not None
        assert profile.matrix is None
        assert all(curve is srgb_to_linear for curve in profile.curves)


def test_white_is_white_and_p3_red_is_brighter_than_red() -> None:
    profile = icc.parse(icc_bytes(P3_COLORANTS, [SRGB_CURVE] * 3, name="Display P3"))
    assert profile is not None
    assert profile.name == "Display P3"
    np.testing.assert_allclose(decode(profile, np.ones((1, 3)))[0], 1.0, atol=1e-12)
    np.testing.assert_allclose(
        decode(profile, np.array([[1.0, 0.0, 0.0]]))[0], [1.2249, -0.0421, -0.0196], atol=1e-3
    )


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        (b"curv" + bytes(8), X),
        (gamma_curve(1.5), X**1.5),
        (table_curve(np.array([0.0, 0.1, 1.0])), np.where(X < 0.5, 0.2 * X, 0.1 + 1.8 * (X - 0.5))),
        (parametric_curve(0, 3.0), X**3),
        (parametric_curve(1, 2.0, 1.5, -0.5), np.maximum(1.5 * X - 0.5, 0.0) ** 2),
        (parametric_curve(2, 2.0, 1.0, -0.25, 0.125), np.maximum(X - 0.25, 0.0) ** 2 + 0.125),
        (parametric_curve(3, 2.0, 0.5, 0.5, 0.25, 0.5), np.where(X >= 0.5, (0.5 * X + 0.5) ** 2, 0.25 * X)),
        (
            parametric_curve(4, 2.0, 0.5, 0.25, 0.25, 0.5, 0.125, 0.0625),
            np.where(X >= 0.5, (0.5 * X + 0.25) ** 2 + 0.125, 0.25 * X + 0.0625),
        ),
    ],
)
def test_every_kind_of_curve(curve: bytes, expected: np.ndarray) -> None:
    profile = icc.parse(icc_bytes(P3_COLORANTS, [SRGB_CURVE, curve, SRGB_CURVE]))
    assert profile is not None
    np.testing.assert_allclose(profile.curves[1](X), expected, atol=2e-5)


def test_a_grey_profile_has_one_curve() -> None:
    profile = icc.parse(icc_bytes(np.eye(3), [gamma_curve(1.8)], space=b"GRAY"))
    assert profile is not None
    assert len(profile.curves) == 1
    np.testing.assert_allclose(profile.curves[0](X), X**1.8, atol=1e-2)


def test_other_kinds_are_left_to_a_colour_engine() -> None:
    assert icc.parse(icc_bytes(P3_COLORANTS, [SRGB_CURVE] * 3, space=b"CMYK")) is None
    assert icc.parse(icc_bytes(P3_COLORANTS, [SRGB_CURVE] * 3, extra=(b"A2B0",))) is None


def test_broken_profiles_are_errors() -> None:
    data = icc_bytes(P3_COLORANTS, [SRGB_CURVE] * 3)
    for length in range(0, len(data), 7):
        with pytest.raises(ValueError, match=r"expected an? .*ICC profile, received"):
            icc.parse(data[:length])
    singular = icc_bytes(np.zeros((3, 3)), [SRGB_CURVE] * 3)
    with pytest.raises(ValueError, match="ICC profile"):
        icc.parse(singular)
    with pytest.raises(ValueError, match="curve of type b'what'"):
        icc.parse(icc_bytes(P3_COLORANTS, [b"what" + bytes(20)] * 3))
