"""The canonical view: any photo of a scene, wide, narrow or portrait, shows the same world at one size."""

import math

import pytest
import torch
from torch import Tensor

from mixlight.network.canonical import CanonicalView
from mixlight.sphere import camera, equirect

VIEW = CanonicalView(48, 64)


def world() -> Tensor:
    """Smooth, and unlike itself in a mirror or upside down."""
    x, y, _ = equirect.pixel_directions(128).unbind(-1)
    return torch.stack([1 + 0.5 * x + 0.2 * y, 1 + 0.5 * y - 0.3 * x, 1 + 0.4 * (5 * x).sin() * y], -1)


def photo_of(panorama: Tensor, height: int, width: int, fov_deg: float) -> Tensor:
    return camera.view(panorama, height, width, math.radians(fov_deg), yaw=0.4, pitch=-0.14, roll=0.03)


@pytest.mark.parametrize(
    ("height", "width", "fov_deg", "share"),
    [
        (240, 320, 60.0, 1.0),  # the view itself
        (216, 384, 90.0, 1.0),  # wide: cut
        (300, 300, 100.0, 1.0),
        (240, 320, 40.0, 0.41),  # narrow: an island
        (384, 216, 40.0, 0.63),  # portrait: a column
        (160, 480, 60.0, 0.45),  # flat: a band
        (30, 40, 60.0, 1.0),  # small: enlarged
    ],
)
def test_a_photo_of_any_shape_shows_the_world_where_it_is(
    height: int, width: int, fov_deg: float, share: float
) -> None:
    panorama = world()
    view, inside = VIEW.resample(photo_of(panorama, height, width, fov_deg), math.radians(fov_deg))
    expected = photo_of(panorama, VIEW.height, VIEW.width, math.degrees(VIEW.fov))
    assert float(inside.float().mean()) == pytest.approx(share, abs=0.05)
    torch.testing.assert_close(view[inside], expected[inside], rtol=0, atol=0.02)
    if share < 1:
        fill = view[~inside]
        torch.testing.assert_close(fill, view[inside].mean(0).expand_as(fill))


def test_a_large_photo_is_antialiased() -> None:
    """A fine checkerboard becomes its mean, whichever way it falls on the pixels."""
    board = (torch.arange(603)[:, None] + torch.arange(805)).remainder(2).float()[..., None].expand(-1, -1, 3)
    view, _ = VIEW.resample(board.contiguous(), VIEW.fov)
    torch.testing.assert_close(view, torch.full_like(view, 0.5), rtol=0, atol=0.02)


def test_dtype_follows_the_photo() -> None:
    view, inside = VIEW.resample(torch.ones(48, 64, 3, dtype=torch.float64), VIEW.fov)
    assert (view.dtype, inside.dtype) == (torch.float64, torch.bool)


def test_a_photo_that_covers_no_pixel_is_refused() -> None:
    with pytest.raises(
        ValueError, match=r"covers a pixel of the view of 48 x 64, got 0\.3 degrees over 40 x 30"
    ):
        VIEW.resample(torch.ones(30, 40, 3), math.radians(0.3))
    for fov in (0.0, math.pi, math.nan):
        with pytest.raises(ValueError, match="field of view"):
            VIEW.resample(torch.ones(30, 40, 3), fov)


@pytest.mark.parametrize("wrong", [{"height": 0}, {"width": -1}, {"fov": 0.0}, {"fov": 3.2}])
def test_views_that_cannot_be_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="expected a"):
        CanonicalView(**wrong)  # type: ignore[arg-type]
