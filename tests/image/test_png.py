from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from mixlight.image import png


@given(
    height=st.integers(1, 9),
    width=st.integers(1, 9),
    channels=st.integers(1, 4),
    deep=st.booleans(),
    seed=st.integers(0, 99),
)
def test_opencv_and_pillow_read_what_we_write(
    height: int, width: int, channels: int, deep: bool, seed: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    dtype = np.uint16 if deep else np.uint8
    samples = np.random.default_rng(seed).integers(
        0, np.iinfo(dtype).max + 1, (height, width, channels), dtype
    )
    path = tmp_path_factory.mktemp("png") / "a.png"
    png.write(path, samples)
    if not deep:
        np.testing.assert_array_equal(np.asarray(Image.open(path)).reshape(samples.shape), samples)
    if channels != 2:  # OpenCV has no grey with alpha
        read = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).reshape(samples.shape)
        order = {1: [0], 3: [2, 1, 0], 4: [2, 1, 0, 3]}[channels]
        np.testing.assert_array_equal(read[..., order], samples)


def test_many_strips(tmp_path: Path) -> None:
    samples = np.random.default_rng(0).integers(0, 256, (700, 1000, 3), np.uint8)
    png.write(tmp_path / "a.png", samples)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "a.png")), samples)


def test_profile_and_gamma_come_back(tmp_path: Path) -> None:
    samples = np.zeros((2, 2, 3), np.uint8)
    png.write(tmp_path / "a.png", samples, profile=b"some profile")
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.info["icc_profile"] == b"some profile"
    png.write(tmp_path / "b.png", samples, gamma=1.8)
    with Image.open(tmp_path / "b.png") as picture:
        assert picture.info["gamma"] == pytest.approx(1 / 1.8, abs=1e-5)


@pytest.mark.usefixtures("unchecked")
@pytest.mark.parametrize(
    "samples",
    [
        np.zeros((2, 2), np.uint8),
        np.zeros((2, 2, 5), np.uint8),
        np.zeros((2, 2, 3)),
        np.zeros((0, 2, 3), np.uint8),
    ],
)
def test_what_is_no_picture_is_refused(tmp_path: Path, samples: np.ndarray) -> None:
    with pytest.raises(ValueError, match="expected"):
        png.write(tmp_path / "a.png", samples)
    assert list(tmp_path.iterdir()) == []
