import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.app import preview
from mixlight.app.preview import Marker
from mixlight.image.color import linear_to_srgb

SIZE = 64


def _spheres(level: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    centre = (np.arange(SIZE) + 0.5) * 2 / SIZE - 1
    mask = np.hypot(centre[:, None], centre) < 1
    spheres = np.full((3, SIZE, SIZE, 3), level, np.float32)
    spheres[:, ~mask] = 0
    return spheres, mask


@given(st.floats(0, 0.6))
def test_encoding_is_srgb_up_to_the_knee(value: float) -> None:
    linear = np.full((1, 3), value, np.float32)
    shown = preview.encode(linear).astype(float)
    assert np.abs(shown - 255 * np.minimum(linear_to_srgb(linear), preview.KNEE)).max() <= 0.51


def test_encoding_rises_to_white_and_never_past_it() -> None:
    ramp = np.repeat(np.geomspace(1e-4, 1e6, 400, dtype=np.float32)[:, None], 3, 1)
    shown = preview.encode(ramp).astype(int)
    assert (np.diff(shown[:, 0]) >= 0).all()
    assert shown[-1].tolist() == [255, 255, 255]
    assert shown[np.searchsorted(ramp[:, 0], 1.0), 0] < 240, (
        "light above the photo's white is told from white"
    )


def test_a_photo_is_shown_as_it_looked() -> None:
    levels = np.arange(256, dtype=np.float32)[:, None] / 255
    from mixlight.image.color import srgb_to_linear

    shown = preview.encode_photo(np.repeat(srgb_to_linear(levels), 3, 1)[:, None])
    assert (shown[:, 0, 0] == np.arange(256)).all()


def test_auto_exposure_goes_by_the_weighted_median() -> None:
    rgb = np.ones((4, 8, 3), np.float32) * np.array([0.09, 0.18, 0.36, 90.0], np.float32)[:, None, None]
    assert preview.auto_exposure(rgb, np.repeat(np.array([[0.1], [1.0], [0.1], [0.1]]), 8, 1)) == 1.0
    assert preview.auto_exposure(rgb, np.repeat(np.array([[0.1], [0.1], [2.0], [0.1]]), 8, 1)) == 0.5
    assert preview.auto_exposure(np.zeros((2, 2, 3), np.float32)) == 1.0


@given(st.integers(1, 300), st.integers(1, 300), st.integers(1, 100))
def test_shrinking_keeps_flat_pictures_and_enough_rows(height: int, width: int, rows: int) -> None:
    small = preview.shrink(np.full((height, width, 3), 0.25, np.float32), rows)
    assert small.shape[0] >= min(rows, height)
    assert small.shape[1] >= 1
    assert np.allclose(small, 0.25)


def test_shrinking_averages_blocks() -> None:
    ramp = np.arange(6 * 9 * 3, dtype=np.float32).reshape(6, 9, 3)
    small = preview.shrink(ramp, 2)
    assert np.allclose(small, ramp.reshape(2, 3, 3, 3, 3).mean((1, 3)))


@pytest.mark.parametrize("shape", [(300, 400), (400, 300), (64, 64), (100, 2000), (3000, 80), (2, 3)])
def test_any_photo_makes_a_tidy_picture(shape: tuple[int, int]) -> None:
    spheres, mask = _spheres()
    photo = np.full((*shape, 3), 0.5, np.float32)
    shown = preview.estimate_preview(
        photo, np.full((16, 32, 3), 0.2, np.float32), spheres, mask, (), caption="x" * 300 + ".jpg"
    )
    assert shown.dtype == np.uint8
    assert shown.shape[0] < 800
    assert shown.shape[1] < 1800
    # The page's margin is untouched all around.
    for edge in (shown[0], shown[-1], shown[:, 0], shown[:, -1], shown[:, 20], shown[:, -20]):
        assert (edge == preview.PAGE).all()


def test_a_fit_shows_both_maps_at_one_exposure() -> None:
    spheres, mask = _spheres()
    shown = preview.fit_preview(
        np.full((32, 64, 3), 0.1, np.float32),
        np.full((16, 32, 3), 0.2, np.float32),
        spheres,
        spheres,
        mask,
        (),
        gain=2.0,
    )
    row = shown[preview.MARGIN + preview.CAPTION_ROWS + 100]
    assert (row[100] == preview.encode(np.float32([0.2, 0.2, 0.2]))).all()
    assert (row[-100] == preview.encode(np.float32([0.4, 0.4, 0.4]))).all()


def test_spheres_are_round_antialiased_and_without_a_dark_rim() -> None:
    spheres, mask = _spheres(0.3)
    shown = preview.spheres_picture(spheres, mask, 100).astype(int)
    inside, page = int(preview.encode(np.float32([[0.3, 0.3, 0.3]]))[0, 0]), preview.PAGE[0]
    first = shown[preview.MARGIN : preview.MARGIN + 100, preview.MARGIN : preview.MARGIN + 100, 0]
    assert set(first[48:52, 5:95].reshape(-1)) == {inside}
    partly = (first > page) & (first < inside)
    assert 100 < partly.sum() < 500
    area = ((first - page) / (inside - page)).sum()
    assert area == pytest.approx(np.pi * 50**2, rel=2e-3)


@pytest.mark.parametrize(
    ("direction", "u", "v"),
    [((0, 0, -1), 0.5, 0.5), ((1, 0, 0), 0.75, 0.5), ((-1, 0, 0), 0.25, 0.5), ((0, 0.8, -0.6), 0.5, 0.2048)],
)
def test_a_marker_circles_its_direction(direction: tuple[float, float, float], u: float, v: float) -> None:
    from PIL import Image

    shown = Image.new("RGB", (preview.MAP_COLUMNS, preview.MAP_ROWS), (90, 90, 90))
    preview._mark(shown, [Marker(direction, 0.25)])
    rows, columns = np.nonzero(np.asarray(shown)[..., 0] > 150)
    assert columns.mean() + 0.5 == pytest.approx(u * preview.MAP_COLUMNS, abs=0.6)
    assert rows.mean() + 0.5 == pytest.approx(v * preview.MAP_ROWS, abs=0.6)


def test_a_marker_at_the_seam_shows_on_both_sides_and_stronger_lights_are_larger() -> None:
    from PIL import Image

    spans = []
    for share in (0.1, 0.9):
        shown = Image.new("RGB", (preview.MAP_COLUMNS, preview.MAP_ROWS), (90, 90, 90))
        preview._mark(shown, [Marker((0.0, 0.0, 1.0), share)])
        rows, columns = np.nonzero(np.asarray(shown)[..., 0] > 150)
        assert columns.min() == 0
        assert columns.max() == preview.MAP_COLUMNS - 1
        spans.append(np.ptp(rows))
    assert spans[0] < spans[1]
