"""The pinhole: golden rays, SciPy's interpolation under another derivation, dense quadrature of pixels."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates
from torch import Tensor

from mixlight.sphere import camera, equirect
from mixlight.sphere.frames import rotation
from tests.tolerances import TOLERANCE

BATCHES = [(), (2,), (1, 2)]
F64 = TOLERANCE[torch.float64]
FOV = st.floats(0.2, 2.6)
ANGLE = st.floats(-3, 3)


def random_map(*shape: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    return torch.rand(*shape, dtype=dtype, generator=torch.Generator().manual_seed(seed))


def smooth_map(height: int) -> Tensor:
    x, y, z = equirect.pixel_directions(height, dtype=torch.float64).unbind(-1)
    return torch.stack((2 + x + 0.5 * y * z, 2 + y - x * x, 2 - z + x * y), -1)


# ------------------------------------------------------------------------------------------------------- rays


def test_rays_golden() -> None:
    """fov 90 degrees, 2 x 2 pixels: the centres are at +-1/2 of the half width 1."""
    rays = camera.ray_directions(2, 2, math.pi / 2, dtype=torch.float64)
    unit = 1 / math.sqrt(1.5)
    expected = torch.tensor([[[-0.5, 0.5, -1], [0.5, 0.5, -1]], [[-0.5, -0.5, -1], [0.5, -0.5, -1]]])
    torch.testing.assert_close(rays, expected.double() * unit, **F64)


@given(st.integers(1, 9), st.integers(1, 9), FOV, ANGLE, ANGLE, ANGLE)
def test_rays_are_unit_and_turned_by_the_rotation(
    height: int, width: int, fov: float, yaw: float, pitch: float, roll: float
) -> None:
    still = camera.ray_directions(height, width, fov, dtype=torch.float64)
    turned = camera.ray_directions(height, width, fov, yaw, pitch, roll, dtype=torch.float64)
    matrix = rotation(yaw, pitch, roll, dtype=torch.float64)
    torch.testing.assert_close(turned, still @ matrix.T, **F64)
    torch.testing.assert_close(turned.norm(dim=-1), torch.ones(height, width).double(), **F64)
    # Square pixels: the same step down as across.
    plane = still / -still[..., 2:]
    step = 2 * math.tan(fov / 2) / width
    torch.testing.assert_close(
        plane[:, :, 0].diff(dim=1), torch.full((height, width - 1), step, dtype=torch.float64), **F64
    )
    torch.testing.assert_close(
        plane[:, :, 1].diff(dim=0), torch.full((height - 1, width), -step, dtype=torch.float64), **F64
    )


@given(FOV, st.integers(1, 400), st.integers(1, 400))
def test_the_field_of_view_reaches_from_edge_to_edge(fov: float, height: int, width: int) -> None:
    vertical = camera.vertical_fov(fov, height, width)
    assert math.tan(vertical / 2) / math.tan(fov / 2) == pytest.approx(height / width)
    assert camera.vertical_fov(vertical, width, height) == pytest.approx(fov)
    left, right = camera.ray_directions(1, width, fov, dtype=torch.float64)[0, [0, -1]]
    half = math.tan(fov / 2)
    assert (right[0] / -right[2]).item() == pytest.approx(half * (1 - 1 / width), abs=1e-12)
    assert (left[0] / -left[2]).item() == pytest.approx(half * (1 / width - 1), abs=1e-12)


@pytest.mark.parametrize(
    ("focal", "width", "height", "degrees"),
    [
        (36.0, 6000, 4000, 53.130),  # 36 mm wide frame at 36 mm: 2 atan(1/2)
        (24.0, 6000, 4000, 73.740),
        (24.0, 4000, 6000, 53.130),  # portrait: the 24 mm side at 24 mm
        (26.0, 4032, 3024, 67.299),  # a phone's main camera
        (26.0, 3024, 4032, 53.060),
    ],
)
def test_fov_of_equivalent_focal_lengths(focal: float, width: int, height: int, degrees: float) -> None:
    fov = camera.fov_from_focal_length_35mm(focal, width, height)
    assert math.degrees(fov) == pytest.approx(degrees, abs=2e-3)


@given(st.floats(5, 500), st.integers(1, 9000), st.integers(1, 9000))
def test_equivalent_focal_lengths_mean_the_diagonal(focal: float, width: int, height: int) -> None:
    fov = camera.fov_from_focal_length_35mm(focal, width, height)
    diagonal = math.tan(fov / 2) * math.hypot(width, height) / width
    assert 2 * focal * diagonal == pytest.approx(math.hypot(36, 24))


# ------------------------------------------------------------------------------------------------------- view


def reference_view(
    panorama: Tensor, height: int, width: int, fov: float, yaw: float, pitch: float
) -> np.ndarray:
    """One look-up a pixel in spherical angles, through SciPy; pitch and yaw by the angle formulas."""
    p = panorama.numpy()
    rows, columns, channels = p.shape
    tall = np.concatenate((np.roll(p[:1], columns // 2, 1), p, np.roll(p[-1:], columns // 2, 1)))
    full = np.concatenate((tall[:, -1:], tall, tall[:, :1]), 1)
    half = math.tan(fov / 2)
    right = ((np.arange(width) + 0.5) / width * 2 - 1) * half
    up = (1 - (np.arange(height) + 0.5) / height * 2) * half * height / width
    right, up = np.meshgrid(right, up)
    ahead = math.cos(pitch) - up * math.sin(pitch)
    above = math.sin(pitch) + up * math.cos(pitch)
    azimuth = np.arctan2(right, ahead) + yaw
    elevation = np.arctan2(above, np.hypot(right, ahead))
    u = np.mod(0.5 + azimuth / (2 * math.pi), 1)
    where = np.stack(((0.5 - elevation / math.pi) * rows + 0.5, u * columns + 0.5))
    return np.stack([map_coordinates(full[..., c], where, order=1) for c in range(channels)], -1)


@pytest.mark.parametrize(
    ("fov", "yaw", "pitch"),
    [(1.0, 0.0, 0.0), (1.2, 2.9, -0.14), (2.0, -1.5, 0.3), (1.5, 0.4, 1.4), (1.5, 0.4, -1.57)],
)
def test_view_equals_scipy(fov: float, yaw: float, pitch: float) -> None:
    panorama = random_map(32, 64, 3)
    found = camera.view(panorama, 24, 40, fov, yaw, pitch, supersample=1)
    np.testing.assert_allclose(found.numpy(), reference_view(panorama, 24, 40, fov, yaw, pitch), atol=1e-9)


def test_view_is_the_mean_of_its_subpixels() -> None:
    panorama = random_map(32, 64, 3)
    fine = camera.view(panorama, 18, 30, 1.2, 0.3, -0.2, 0.1, supersample=1)
    found = camera.view(panorama, 6, 10, 1.2, 0.3, -0.2, 0.1, supersample=3)
    torch.testing.assert_close(found, fine.view(6, 3, 10, 3, 3).mean((1, 3)), **F64)


@given(ANGLE, st.floats(-1.5, 1.5), ANGLE)
def test_view_from_a_turned_camera_is_the_view_of_turned_light(yaw: float, pitch: float, roll: float) -> None:
    panorama = smooth_map(96)
    turned = equirect.rotate(panorama, rotation(yaw, pitch, roll, dtype=torch.float64).T)
    torch.testing.assert_close(
        camera.view(panorama, 6, 8, 1.0, yaw, pitch, roll), camera.view(turned, 6, 8, 1.0), rtol=0, atol=4e-3
    )


def test_view_of_a_fine_panorama_misses_no_light() -> None:
    """One bright texel in 4096 that a bare look-up would mostly miss, wherever it lies in the picture."""
    height, width, fov = 12, 16, 1.0
    step = 2 * math.tan(fov / 2) / width
    rays = camera.ray_directions(height, width, fov)
    pixel = step**2 * -(rays[..., 2] ** 3)  # solid angle of a pixel
    for row, column in ((256, 512), (250, 520), (271, 489)):
        panorama = torch.zeros(512, 1024, 1)
        panorama[row, column] = 1.0
        energy = (camera.view(panorama, height, width, fov)[..., 0] * pixel).sum()
        assert energy.item() == pytest.approx(equirect.integrate(panorama).item(), rel=0.25)


def test_view_is_uniform_in_a_uniform_panorama() -> None:
    found = camera.view(torch.full((300, 600, 3), 0.7), 20, 30, 2.5, 0.1, 1.3, 0.4)
    torch.testing.assert_close(found, torch.full((20, 30, 3), 0.7), **TOLERANCE[torch.float32])


@pytest.mark.parametrize("batch", BATCHES)
def test_view_takes_any_batch(batch: tuple[int, ...]) -> None:
    panorama = random_map(*batch, 16, 32, 3)
    found = camera.view(panorama, 5, 7, 1.0, 0.3, 0.1, 0.2)
    assert found.shape == (*batch, 5, 7, 3)
    last = camera.view(panorama.reshape(-1, 16, 32, 3)[-1], 5, 7, 1.0, 0.3, 0.1, 0.2)
    torch.testing.assert_close(found.reshape(-1, 5, 7, 3)[-1], last)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32])
def test_view_follows_the_dtype(dtype: torch.dtype) -> None:
    panorama = random_map(16, 32, 3)
    found = camera.view(panorama.to(dtype), 5, 7, 1.0, 0.3)
    assert found.dtype == dtype
    torch.testing.assert_close(found.double(), camera.view(panorama, 5, 7, 1.0, 0.3), **TOLERANCE[dtype])


def test_view_and_recentre_gradients() -> None:
    panorama = random_map(2, 4, 1).requires_grad_()
    assert torch.autograd.gradcheck(lambda p: camera.view(p, 3, 4, 1.0, 0.3, 1.5, 0.1), (panorama,))
    assert torch.autograd.gradcheck(lambda p: camera.view(p, 1, 1, 3.0, supersample=1), (panorama,))
    assert torch.autograd.gradcheck(lambda p: camera.recentre(p, -0.4), (panorama,))


# --------------------------------------------------------------------------------------------------- resample


def reference_resample(photo: Tensor, fov: float, height: int, width: int, out_fov: float) -> np.ndarray:
    """Mean of 64 x 64 interpolated points in each pixel, for pictures that lie within the photo."""
    rows, columns, channels = photo.shape
    n = 64
    ratio = (math.tan(out_fov / 2) / width) / (math.tan(fov / 2) / columns)
    y = ((np.arange(height * n) + 0.5) / n - height / 2) * ratio + rows / 2 - 0.5
    x = ((np.arange(width * n) + 0.5) / n - width / 2) * ratio + columns / 2 - 0.5
    where = np.stack(np.meshgrid(y, x, indexing="ij"))
    fine = [map_coordinates(photo[..., c].numpy(), where, order=1, mode="nearest") for c in range(channels)]
    return np.stack([f.reshape(height, n, width, n).mean((1, 3)) for f in fine], -1)


@pytest.mark.parametrize(
    ("size", "fov", "target", "out_fov"),
    [
        ((30, 40), 1.2, (6, 8), 1.2),
        ((31, 43), 1.2, (5, 8), 1.0),
        ((12, 16), 1.2, (24, 32), 1.2),
        ((12, 16), 1.2, (20, 20), 0.7),
        ((9, 9), 0.9, (9, 9), 0.9),
        ((40, 20), 0.6, (7, 5), 0.55),
    ],
)
def test_resample_equals_dense_quadrature(
    size: tuple[int, int], fov: float, target: tuple[int, int], out_fov: float
) -> None:
    photo = random_map(*size, 2)
    found, inside = camera.resample(photo, fov, *target, out_fov)
    assert inside.all()
    np.testing.assert_allclose(found.numpy(), reference_resample(photo, fov, *target, out_fov), atol=2e-3)


def test_resample_by_a_whole_factor_is_nearly_the_block_mean() -> None:
    """Exactly so away from the rim for a linear ramp."""
    ramp = torch.arange(24.0).expand(16, 24)[..., None]
    found, _ = camera.resample(ramp, 1.0, 4, 6, 1.0)
    expected = ramp.view(4, 4, 6, 4, 1).mean((1, 3))
    torch.testing.assert_close(found[:, 1:-1], expected[:, 1:-1], **TOLERANCE[torch.float32])


def test_resample_of_the_same_camera_keeps_a_linear_ramp() -> None:
    ramp = torch.arange(8.0, dtype=torch.float64)[:, None, None].expand(8, 6, 1)
    found, inside = camera.resample(ramp, 1.0, 8, 6, 1.0)
    assert inside.all()
    torch.testing.assert_close(found[1:-1], ramp[1:-1], **F64)


@given(st.integers(1, 12), st.integers(1, 12), FOV, st.integers(1, 12), st.integers(1, 12), FOV)
def test_resample_is_a_mean_inside_and_zero_outside(
    height: int, width: int, fov: float, out_height: int, out_width: int, out_fov: float
) -> None:
    photo = 1 + random_map(height, width, 1)
    found, inside = camera.resample(photo, fov, out_height, out_width, out_fov)
    one, _ = camera.resample(torch.ones_like(photo), fov, out_height, out_width, out_fov)
    torch.testing.assert_close(one[..., 0], inside.double(), **F64)
    assert (found[~inside] == 0).all()
    if inside.any():
        assert found[inside].min() >= photo.min() - 1e-9
        assert found[inside].max() <= photo.max() + 1e-9
    # Inside is where the pixel's centre, on the plane one ahead, falls on the photo.
    plane = camera.ray_directions(out_height, out_width, out_fov, dtype=torch.float64)
    plane = plane / -plane[..., 2:]
    limit = math.tan(fov / 2)
    slack = 1e-9
    x, y = plane[..., 0].abs(), plane[..., 1].abs()
    sure_in = (x < limit - slack) & (y < limit * height / width - slack)
    sure_out = (x > limit + slack) | (y > limit * height / width + slack)
    assert inside[sure_in].all()
    assert not inside[sure_out].any()


def test_resample_agrees_with_views_of_a_panorama() -> None:
    """A photo of a smooth world, resampled to another camera, is that camera's photo."""
    panorama = smooth_map(128)
    wide = camera.view(panorama, 120, 160, 1.4, 0.5, -0.2)
    narrow = camera.view(panorama, 30, 50, 1.0, 0.5, -0.2)
    found, inside = camera.resample(wide, 1.4, 30, 50, 1.0)
    assert inside.all()
    torch.testing.assert_close(found, narrow, rtol=0, atol=1e-3)


@pytest.mark.parametrize("batch", BATCHES)
def test_resample_takes_any_batch(batch: tuple[int, ...]) -> None:
    photo = random_map(*batch, 9, 12, 3)
    found, inside = camera.resample(photo, 1.0, 6, 6, 1.2)
    assert found.shape == (*batch, 6, 6, 3)
    assert inside.shape == (6, 6)
    last, _ = camera.resample(photo.reshape(-1, 9, 12, 3)[-1], 1.0, 6, 6, 1.2)
    torch.testing.assert_close(found.reshape(-1, 6, 6, 3)[-1], last)


def test_resample_gradients() -> None:
    photo = random_map(4, 5, 1).requires_grad_()
    assert torch.autograd.gradcheck(lambda p: camera.resample(p, 1.0, 3, 4, 1.1)[0], (photo,))


# --------------------------------------------------------------------------------------------------- recentre


def test_recentre_by_nothing_changes_nothing() -> None:
    panorama = random_map(6, 12, 3)
    torch.testing.assert_close(camera.recentre(panorama, 0.0), panorama, rtol=0, atol=1e-12)


@given(st.floats(-1.3, 1.3))
def test_recentre_looks_where_the_ray_from_the_new_place_meets_the_sphere(nadir: float) -> None:
    """The value of a panorama of directions is the meeting point p: |p| = 1 and p - (0, 0, o) is along d."""
    height = 64
    directions = equirect.pixel_directions(height, dtype=torch.float64)
    found = camera.recentre(directions, nadir)
    offset = torch.tensor([0.0, 0.0, math.sin(nadir)], dtype=torch.float64)
    along = torch.nn.functional.normalize(found - offset, dim=-1)
    torch.testing.assert_close(along, directions, rtol=0, atol=0.05 if abs(nadir) > 1 else 0.01)


def test_recentre_forward_brings_what_is_ahead_nearer() -> None:
    panorama = torch.zeros(64, 128, 1)
    panorama[28:36, 60:68] = 1.0
    ahead, away = camera.recentre(panorama, -0.5), camera.recentre(panorama, 0.5)
    assert equirect.integrate(ahead) > 2 * equirect.integrate(panorama) > 4 * equirect.integrate(away)


@pytest.mark.parametrize("nadir", [-0.3, -0.5, -1.1])
@pytest.mark.parametrize("place", [(32, 0), (30, 3), (36, 125)])
def test_recentre_keeps_small_lamps_behind(nadir: float, place: tuple[int, int]) -> None:
    """Seen from farther away by 1 + |o| a lamp has 1 / (1 + |o|)^2 of its solid angle, and of its energy."""
    panorama = torch.zeros(64, 128, 1, dtype=torch.float64)
    panorama[place] = 1.0
    expected = equirect.integrate(panorama).item() / (1 - math.sin(nadir)) ** 2
    assert equirect.integrate(camera.recentre(panorama, nadir)).item() == pytest.approx(expected, rel=0.3)


# -------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize("fov", [0.0, -1.0, math.pi, 4.0, math.nan])
def test_impossible_fields_of_view_are_refused(fov: float) -> None:
    match = r"field of view in \(0, pi\) radians, received"
    with pytest.raises(ValueError, match=match):
        camera.ray_directions(2, 2, fov)
    with pytest.raises(ValueError, match=match):
        camera.view(torch.zeros(2, 4, 3), 2, 2, fov)
    with pytest.raises(ValueError, match=match):
        camera.resample(torch.zeros(2, 4, 3), fov, 2, 2, 1.0)
    with pytest.raises(ValueError, match=match):
        camera.resample(torch.zeros(2, 4, 3), 1.0, 2, 2, fov)
    with pytest.raises(ValueError, match=match):
        camera.vertical_fov(fov, 2, 2)


def test_other_bad_input_is_refused() -> None:
    panorama = torch.zeros(2, 4, 3)
    with pytest.raises(ValueError, match="picture of at least 1 x 1, received height 0, width 3"):
        camera.view(panorama, 0, 3, 1.0)
    with pytest.raises(ValueError, match="supersample of at least 1, received 0"):
        camera.view(panorama, 2, 3, 1.0, supersample=0)
    with pytest.raises(ValueError, match="even width, received 5"):
        camera.view(torch.zeros(3, 5, 3), 2, 3, 1.0)
    with pytest.raises(ValueError, match="even width, received 5"):
        camera.recentre(torch.zeros(3, 5, 3), 0.1)
    with pytest.raises(ValueError, match=r"nadir angle in \(-pi/2, pi/2\) radians, received 2"):
        camera.recentre(panorama, 2.0)
    for focal, width in ((0.0, 4), (math.nan, 4), (math.inf, 4), (24.0, 0)):
        with pytest.raises(ValueError, match="positive focal length"):
            camera.fov_from_focal_length_35mm(focal, width, 3)
