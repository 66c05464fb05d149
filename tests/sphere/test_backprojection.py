import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.sphere import camera, equirect
from mixlight.sphere.backprojection import lay_on_sphere
from mixlight.sphere.frames import rotation

ANGLES = st.floats(-0.6, 0.6)


def in_picture(height: int, yaw: float, pitch: float, roll: float) -> tuple[Tensor, Tensor, Tensor]:
    """Of each texel's centre: across and up in the picture's plane at unit distance, and whether ahead."""
    axes = equirect.pixel_directions(height, dtype=torch.float64) @ rotation(
        yaw, pitch, roll, dtype=torch.float64
    )
    ahead = axes[..., 2] < -1e-3
    depth = torch.where(ahead, -axes[..., 2], 1.0)
    return axes[..., 0] / depth, axes[..., 1] / depth, ahead


def test_the_picture_lies_around_the_centre_the_right_way_round() -> None:
    picture = torch.zeros(40, 40, 3)
    picture[:20, :, 0] = 1  # red above
    picture[:, 20:, 1] = 1  # green on the right
    laid, weight = lay_on_sphere(picture, math.radians(90), 32)
    assert weight[16, 32] == 1
    assert laid[12, 28].tolist() == pytest.approx([1, 0, 0])  # above, left
    assert laid[20, 36].tolist() == pytest.approx([0, 1, 0])  # below, right
    assert weight[16, 0] == 0
    # 90 degrees across: an eighth of the width to either side.
    assert weight[16].nonzero()[:, 0].tolist() == list(range(24, 40))


@pytest.mark.parametrize(
    ("pose", "axis"),
    [({"yaw": math.pi / 2}, [1.0, 0, 0]), ({"pitch": math.pi / 2}, [0, 1.0, 0]), ({}, [0, 0, -1.0])],
)
def test_yaw_and_pitch_put_the_centre_where_the_camera_looks(
    pose: dict[str, float], axis: list[float]
) -> None:
    _, weight = lay_on_sphere(torch.ones(30, 30, 1), math.radians(20), 64, **pose)
    mean = equirect.integrate(equirect.pixel_directions(64) * weight[..., None])
    assert torch.nn.functional.normalize(mean, dim=0).tolist() == pytest.approx(axis, abs=1e-5)


@given(yaw=st.floats(-3, 3), pitch=ANGLES, roll=ANGLES, fov=st.floats(0.4, 1.9))
def test_it_undoes_the_view_of_a_panorama(yaw: float, pitch: float, roll: float, fov: float) -> None:
    panorama = equirect.pixel_directions(128) * 0.5 + 0.5
    view = camera.view(panorama, 120, 160, fov, yaw, pitch, roll)
    laid, weight = lay_on_sphere(view, fov, 64, yaw=yaw, pitch=pitch, roll=roll)
    inside = weight > 0.999
    if bool(inside.any()):
        small = equirect.resize(panorama, 64)
        torch.testing.assert_close(laid[inside], small[inside], rtol=0, atol=4e-3)
    assert bool((laid[weight == 0] == 0).all())


@given(pitch=ANGLES, roll=ANGLES, columns=st.integers(8, 400))
def test_a_ramp_has_the_value_of_the_plane_at_each_texel(pitch: float, roll: float, columns: int) -> None:
    """Reference: a linear picture is linear in the plane, so a texel holds its plane coordinate."""
    fov, rows = math.radians(70), 3 * columns // 4
    reach = math.tan(fov / 2)
    across = ((torch.arange(columns, dtype=torch.float64) + 0.5) / columns * 2 - 1) * reach
    picture = across.expand(rows, columns)[..., None].contiguous()
    laid, weight = lay_on_sphere(picture, fov, 48, pitch=pitch, roll=roll)
    x, y, ahead = in_picture(48, 0.0, pitch, roll)
    margin = 2 * reach / columns + math.pi / 48
    deep = ahead & (x.abs() < reach - margin) & (y.abs() < reach * rows / columns - margin)
    assert bool((weight[deep] > 0.999).all())
    # A texel is as wide as 0.065 in the plane and more in the corners, where the plane is curved in angles.
    torch.testing.assert_close(laid[deep][:, 0], x[deep], rtol=0, atol=6e-3)


def test_a_fine_picture_is_averaged_and_not_skipped() -> None:
    """A checkerboard of single pixels, four hundred in a texel, is grey."""
    board = (torch.arange(1200)[:, None] + torch.arange(1600)) % 2
    laid, weight = lay_on_sphere(board[..., None].float(), math.radians(60), 64)
    inside = weight > 0.999
    torch.testing.assert_close(laid[inside], torch.full_like(laid[inside], 0.5), rtol=0, atol=1e-3)


def test_the_weight_is_the_covered_solid_angle() -> None:
    """Reference: a rectangle a by b at distance 1 subtends 4 asin(ab / sqrt((1 + a^2)(1 + b^2)))."""
    for fov, rows, columns in ((0.5, 30, 40), (1.2, 40, 30), (2.4, 20, 20)):
        a = math.tan(fov / 2)
        b = a * rows / columns
        true = 4 * math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b)))
        _, weight = lay_on_sphere(torch.ones(rows, columns, 1), fov, 128, pitch=0.3, roll=0.2)
        assert float(equirect.integrate(weight[..., None])) == pytest.approx(true, rel=4e-3)


def test_the_edge_is_soft_and_the_middle_whole() -> None:
    picture = torch.ones(60, 80, 2)
    hard, soft = (lay_on_sphere(picture, 1.0, 128, feather=share)[1] for share in (0.0, 0.5))
    assert bool((soft <= hard + 1e-6).all())
    assert soft[64, 128] == 1
    steps = soft[64].diff().abs()
    assert float(steps.max()) < 0.25 < float(hard[64].diff().abs().max())
    inside = soft[64, 128:]
    assert bool((inside.diff() <= 1e-6).all())  # falls all the way to the edge
    laid, weight = lay_on_sphere(picture, 1.0, 64, feather=0.3)
    torch.testing.assert_close(laid[..., 0], weight)


def test_a_view_over_a_pole_and_half_the_sphere() -> None:
    laid, weight = lay_on_sphere(torch.ones(20, 20, 3), math.radians(169), 32, pitch=1.2)
    assert weight[0].min() == 1  # the zenith is inside
    assert float(laid.max()) <= 1 + 1e-6
    assert float(equirect.integrate(weight[..., None])) < 2 * math.pi


@pytest.mark.parametrize(
    "bad",
    [
        {"fov_x": 0.0}, {"fov_x": math.pi}, {"fov_x": math.nan}, {"height": 0}, {"supersample": 0},
        {"feather": -0.1}, {"feather": 1.1}, {"feather": math.nan},
    ],
)  # fmt: skip
def test_what_is_no_camera_or_map_is_refused(bad: dict[str, float]) -> None:
    arguments = {"fov_x": 1.0, "height": 16, **bad}
    with pytest.raises(ValueError, match="expected"):
        lay_on_sphere(torch.ones(8, 8, 3), **arguments)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="at least 1 x 1"):
        lay_on_sphere(torch.ones(0, 8, 3), 1.0, 16)
