"""The panorama: golden values, quadrature, SciPy's interpolation, brute-force overlaps, energy."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates
from scipy.stats import special_ortho_group
from torch import Tensor

from mixlight.sphere import FRAMES, calibration_card, camera, cubemap, equirect, points
from mixlight.sphere.frames import rotation
from tests.tolerances import TOLERANCE

BATCHES = [(), (2,), (1, 2)]
F64 = TOLERANCE[torch.float64]
SIZES = st.integers(1, 24)


def random_map(*shape: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    return torch.rand(*shape, dtype=dtype, generator=torch.Generator().manual_seed(seed))


def random_directions(*shape: int, seed: int = 0) -> Tensor:
    generator = torch.Generator().manual_seed(seed)
    directions = torch.randn(*shape, 3, dtype=torch.float64, generator=generator)
    return torch.nn.functional.normalize(directions, dim=-1)


def smooth_map(height: int) -> Tensor:
    x, y, z = equirect.pixel_directions(height, dtype=torch.float64).unbind(-1)
    return torch.stack((2 + x + 0.5 * y * z, 2 + y - x * x, 2 - z + x * y), -1)


def smooth_value(directions: Tensor) -> Tensor:
    x, y, z = directions.unbind(-1)
    return torch.stack((2 + x + 0.5 * y * z, 2 + y - x * x, 2 - z + x * y), -1)


# ------------------------------------------------------------------------------------- pixels and directions


@pytest.mark.parametrize(
    ("direction", "uv"),
    [
        ((0.0, 0.0, -1.0), (0.5, 0.5)),
        ((1.0, 0.0, 0.0), (0.75, 0.5)),
        ((-1.0, 0.0, 0.0), (0.25, 0.5)),
        ((0.0, 0.0, 1.0), (0.0, 0.5)),
        ((-0.0, 0.0, 1.0), (0.0, 0.5)),
        ((0.0, 1.0, 0.0), (0.5, 0.0)),
        ((0.0, -1.0, 0.0), (0.5, 1.0)),
        ((0.0, 2.0, -2.0), (0.5, 0.25)),
    ],
)
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_uv_of_the_axes(direction: tuple[float, ...], uv: tuple[float, float], dtype: torch.dtype) -> None:
    found = equirect.directions_to_uv(torch.tensor(direction, dtype=dtype))
    assert found.dtype == dtype
    torch.testing.assert_close(found, torch.tensor(uv, dtype=dtype), **TOLERANCE[dtype])


def test_uv_follow_the_formula_of_the_conventions() -> None:
    d = random_directions(1000)
    expected = torch.stack(
        (0.5 + torch.atan2(d[:, 0], -d[:, 2]) / (2 * math.pi), d[:, 1].acos() / math.pi), -1
    )
    torch.testing.assert_close(equirect.directions_to_uv(d), expected, rtol=0, atol=1e-12)


def test_pixel_directions_golden() -> None:
    half, root = 0.5, math.sqrt(0.5)
    expected = torch.tensor(
        [[-half, root, half], [-half, root, -half], [half, root, -half], [half, root, half]]
    )
    torch.testing.assert_close(equirect.pixel_directions(2)[0], expected)
    torch.testing.assert_close(equirect.pixel_directions(2)[1], expected * torch.tensor([1.0, -1.0, 1.0]))


@given(SIZES, SIZES)
def test_pixel_directions_are_unit_and_lie_at_pixel_centres(height: int, width: int) -> None:
    d = equirect.pixel_directions(height, width, dtype=torch.float64)
    torch.testing.assert_close(d.norm(dim=-1), torch.ones(height, width, dtype=torch.float64), **F64)
    uv = equirect.directions_to_uv(d)
    u, v = (torch.arange(width) + 0.5) / width, (torch.arange(height) + 0.5) / height
    expected = torch.stack((u.double().expand(height, width), v.double()[:, None].expand(height, width)), -1)
    torch.testing.assert_close(uv, expected, rtol=0, atol=1e-6)


@given(st.floats(0, 1, exclude_max=True), st.floats(1e-3, 1 - 1e-3))
def test_uv_and_directions_are_inverse(u: float, v: float) -> None:
    uv = torch.tensor([u, v], dtype=torch.float64)
    back = equirect.directions_to_uv(equirect.uv_to_directions(uv))
    turn = abs(back[0].item() - u)
    assert min(turn, 1 - turn) < 1e-12
    assert back[1].item() == pytest.approx(v, abs=1e-12)


@given(st.integers(0, 2**20), st.sampled_from([torch.float32, torch.float64]))
def test_u_is_never_one(step: int, dtype: torch.dtype) -> None:
    """Just left of the seam atan2 rounds to pi."""
    d = torch.tensor([[step * 1e-14, 0.2, 1.0], [-step * 1e-14, 0.2, 1.0]], dtype=dtype)
    u = equirect.directions_to_uv(d)[:, 0]
    assert ((u >= 0) & (u < 1)).all()


def test_polar_angle_is_precise_next_to_the_pole() -> None:
    """acos(y) knows nothing within 2e-4 of the pole in float32."""
    d = torch.tensor([1e-5, 1.0, 0.0])
    assert equirect.directions_to_uv(d)[1].item() * math.pi == pytest.approx(1e-5, rel=1e-5)


def test_a_zero_vector_has_no_direction() -> None:
    assert equirect.directions_to_uv(torch.zeros(3)).isnan().any()
    assert equirect.sample(torch.ones(2, 4, 3), torch.zeros(3)).isnan().all()


def test_tables_survive_inference_mode() -> None:
    with torch.inference_mode():
        equirect.resize(random_map(6, 12, 1), 3)
        equirect.rotate(random_map(6, 12, 1), rotation(0.1))
    panorama = random_map(6, 12, 1).requires_grad_()
    equirect.resize(panorama, 3).sum().backward()
    assert panorama.grad is not None


def test_tables_go_to_the_default_device_or_the_one_named() -> None:
    tables = (
        lambda **to: equirect.pixel_directions(2, **to),
        lambda **to: equirect.solid_angle(2, **to),
        lambda **to: points.vogel(4, **to),
        lambda **to: points.anchor_map(4, 2, **to),
        lambda **to: cubemap.pixel_directions(2, **to),
        lambda **to: cubemap.solid_angle(2, **to),
        lambda **to: camera.ray_directions(2, 2, 1.0, **to),
        lambda **to: calibration_card(8, **to),
        lambda **to: rotation(0.1, **to),
        lambda **to: FRAMES["unity"].matrix(**to),
    )
    for table in tables:
        assert table().device.type == "cpu"
        assert table(device="meta").device.type == "meta"
        with torch.device("meta"):
            assert table().device.type == "meta"


def test_functions_of_a_map_work_under_another_default_device() -> None:
    panorama = random_map(4, 8, 3)
    for call in (
        lambda: equirect.resize(panorama, 3),
        lambda: equirect.rotate(panorama, torch.eye(3, device="cpu"), 2),
        lambda: equirect.integrate(panorama),
        lambda: camera.view(panorama, 3, 4, 1.0),
        lambda: camera.resample(panorama, 1.0, 3, 4, 1.0)[0],
        lambda: camera.recentre(panorama, 0.2),
        lambda: cubemap.to_equirect(cubemap.from_equirect(panorama, 3), 4),
    ):
        expected = call()
        with torch.device("meta"):
            assert torch.equal(call(), expected)


# ------------------------------------------------------------------------------------------------ solid angle


def test_solid_angle_equals_quadrature() -> None:
    """Gauss-Legendre of the sine over each row."""
    height, width = 9, 5
    node, weight = np.polynomial.legendre.leggauss(8)
    step = math.pi / height
    angle = (np.arange(height)[:, None] + 0.5 + node / 2) * step
    rows = (np.sin(angle) * weight / 2).sum(1) * step * 2 * math.pi / width
    expected = np.repeat(rows[:, None], width, 1)
    np.testing.assert_allclose(equirect.solid_angle(height, width, dtype=torch.float64), expected, rtol=1e-12)


@given(st.integers(1, 600), st.integers(1, 40))
def test_solid_angle_sums_to_four_pi(height: int, width: int) -> None:
    total = equirect.solid_angle(height, width, dtype=torch.float64).sum().item()
    assert total == pytest.approx(4 * math.pi, rel=1e-13)


def test_solid_angle_is_exact_next_to_the_pole_of_a_large_map() -> None:
    top = equirect.row_solid_angle(8192, dtype=torch.float64)[0].item()
    # Cap of angle a: 2 pi (1 - cos a) = 4 pi sin^2(a / 2).
    assert top == pytest.approx(4 * math.pi * math.sin(math.pi / 16384) ** 2 / 16384, rel=1e-12)


@pytest.mark.parametrize("size", [(0, None), (-1, None), (4, 0)])
def test_empty_grids_are_refused(size: tuple[int, int | None]) -> None:
    for table in (equirect.pixel_directions, equirect.solid_angle, equirect.row_solid_angle):
        with pytest.raises(ValueError, match="at least 1 x 1, received"):
            table(*size)


# ----------------------------------------------------------------------------------------------------- sample


def reference_sample(panorama: Tensor, directions: Tensor) -> np.ndarray:
    """SciPy's linear interpolation of the panorama, continued over the rim and the poles by hand."""
    height, width, channels = panorama.shape
    p = panorama.numpy()
    half = width // 2
    tall = np.concatenate((np.roll(p[:1], half, 1), p, np.roll(p[-1:], half, 1)))
    full = np.concatenate((tall[:, -1:], tall, tall[:, :1]), 1)
    uv = equirect.directions_to_uv(directions).reshape(-1, 2).numpy()
    where = np.stack((uv[:, 1] * height + 0.5, uv[:, 0] * width + 0.5))
    values = [map_coordinates(full[..., c], where, order=1) for c in range(channels)]
    return np.stack(values, -1).reshape(*directions.shape[:-1], channels)


@pytest.mark.parametrize("size", [(1, 2), (3, 6), (16, 32), (5, 14)])
def test_sample_equals_scipy(size: tuple[int, int]) -> None:
    panorama = random_map(*size, 3)
    poles = torch.tensor([[0.0, 1, 0], [0, -1, 0], [1e-9, 1, 1e-9], [-1e-9, -1, 1e-9]], dtype=torch.float64)
    seam = torch.tensor([[1e-12, 0.1, 1], [-1e-12, 0.1, 1], [0.0, -0.3, 1]], dtype=torch.float64)
    directions = torch.cat((random_directions(500), poles, seam))
    found = equirect.sample(panorama, directions)
    np.testing.assert_allclose(found.numpy(), reference_sample(panorama, directions), atol=1e-10)


def test_sample_at_the_centres_returns_the_texels() -> None:
    panorama = random_map(7, 14, 2)
    found = equirect.sample(panorama, equirect.pixel_directions(7, dtype=torch.float64))
    torch.testing.assert_close(found, panorama, rtol=0, atol=1e-12)


def test_sample_is_continuous_across_the_pole() -> None:
    panorama = random_map(4, 8, 1)
    a = torch.tensor([[1e-7, 1.0, 0.0], [-1e-7, 1.0, 0.0]], dtype=torch.float64)
    front, back = equirect.sample(panorama, a)
    torch.testing.assert_close(front, back, rtol=0, atol=1e-5)


@given(st.integers(0, 1000))
def test_sample_stays_between_the_extremes(seed: int) -> None:
    panorama = random_map(4, 8, 1, seed=seed)
    values = equirect.sample(panorama, random_directions(200, seed=seed))
    assert values.min() >= panorama.min() - 1e-12
    assert values.max() <= panorama.max() + 1e-12


@pytest.mark.parametrize("batch", BATCHES)
@pytest.mark.parametrize("rays", [(), (3,), (2, 3), (0,)])
def test_sample_takes_any_batch_shared_or_not(batch: tuple[int, ...], rays: tuple[int, ...]) -> None:
    panorama = random_map(*batch, 4, 8, 3)
    shared = random_directions(*rays)
    found = equirect.sample(panorama, shared, shared=True)
    assert found.shape == (*batch, *rays, 3)
    own = random_directions(*batch, *rays, seed=3)
    mine = equirect.sample(panorama, own, shared=False)
    assert mine.shape == (*batch, *rays, 3)
    flat = panorama.reshape(-1, 4, 8, 3)
    for i, one in enumerate(flat):
        torch.testing.assert_close(found.reshape(len(flat), *rays, 3)[i], equirect.sample(one, shared))
        directions = own.reshape(len(flat), *rays, 3)[i]
        torch.testing.assert_close(mine.reshape(len(flat), *rays, 3)[i], equirect.sample(one, directions))


def test_sample_reads_directions_as_batched_exactly_if_they_start_with_the_batch() -> None:
    panorama = random_map(2, 4, 8, 3)
    both = random_directions(2)
    torch.testing.assert_close(equirect.sample(panorama, both), equirect.sample(panorama, both, shared=False))
    assert equirect.sample(panorama, both).shape == (2, 3)
    assert equirect.sample(panorama, both, shared=True).shape == (2, 2, 3)
    assert equirect.sample(panorama, random_directions(5)).shape == (2, 5, 3)
    with pytest.raises(ValueError, match=r"expected directions of shape \[2, ..., 3\], received \[5, 3\]"):
        equirect.sample(panorama, random_directions(5), shared=False)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32, torch.float64])
def test_sample_follows_the_dtype_of_the_panorama(dtype: torch.dtype) -> None:
    panorama, directions = random_map(16, 32, 3), random_directions(50)
    found = equirect.sample(panorama.to(dtype), directions)
    assert found.dtype == dtype
    expected = equirect.sample(panorama, directions)
    torch.testing.assert_close(found.double(), expected, **TOLERANCE[dtype])


def test_sample_reads_strided_memory() -> None:
    panorama = random_map(3, 8, 4).permute(2, 1, 0)
    directions = random_directions(9)
    torch.testing.assert_close(
        equirect.sample(panorama, directions), equirect.sample(panorama.contiguous(), directions)
    )


def test_sample_gradients() -> None:
    panorama = random_map(2, 2, 4, 2).requires_grad_()
    directions = random_directions(2, 5).requires_grad_()
    assert torch.autograd.gradcheck(equirect.sample, (panorama, directions))
    shared = random_directions(5).requires_grad_()
    assert torch.autograd.gradcheck(equirect.sample, (panorama, shared))


def test_gradients_at_the_poles_are_finite() -> None:
    d = torch.tensor([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.1, 1.0, 0.2]], requires_grad=True)
    equirect.sample(random_map(4, 8, 3, dtype=torch.float32), d).sum().backward()
    assert d.grad is not None
    assert d.grad.isfinite().all()


def test_an_odd_width_is_refused() -> None:
    for call in (
        lambda p: equirect.sample(p, random_directions(1)),
        lambda p: equirect.rotate(p, torch.eye(3)),
    ):
        with pytest.raises(ValueError, match="even width, received 5"):
            call(random_map(3, 5, 1))


# ------------------------------------------------------------------------------------------ rotate and mirror


def test_rotate_turns_the_light_the_right_way() -> None:
    matrix = torch.from_numpy(special_ortho_group.rvs(3, random_state=4))
    directions = random_directions(200)
    turned = equirect.rotate(smooth_map(128), matrix)
    found = equirect.sample(turned, directions @ matrix.T)  # at R d
    torch.testing.assert_close(found, smooth_value(directions), rtol=0, atol=2e-3)


def test_rotate_by_the_identity_changes_nothing() -> None:
    panorama = random_map(6, 12, 3)
    torch.testing.assert_close(equirect.rotate(panorama, torch.eye(3).double()), panorama, atol=1e-12, rtol=0)


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.integers(1, 3))
def test_rotate_keeps_the_energy_of_smooth_light(yaw: float, pitch: float, supersample: int) -> None:
    panorama = smooth_map(32)
    turned = equirect.rotate(panorama, rotation(yaw, pitch, 0.3), supersample)
    torch.testing.assert_close(equirect.integrate(turned), equirect.integrate(panorama), rtol=2e-3, atol=0)


@pytest.mark.parametrize("batch", BATCHES)
def test_rotate_takes_any_batch(batch: tuple[int, ...]) -> None:
    panorama = random_map(*batch, 4, 8, 3)
    turned = equirect.rotate(panorama, rotation(0.4, 0.2), 2)
    assert turned.shape == panorama.shape
    one = equirect.rotate(panorama.reshape(-1, 4, 8, 3)[-1], rotation(0.4, 0.2), 2)
    torch.testing.assert_close(turned.reshape(-1, 4, 8, 3)[-1], one)


def test_rotate_in_blocks_of_rows_equals_rotate_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    panorama, matrix = random_map(12, 24, 3), rotation(0.4, 0.2, dtype=torch.float64)
    whole = equirect.rotate(panorama, matrix, 2)
    monkeypatch.setattr("mixlight.sphere._bilinear.CHUNK", 5 * 24 * 4)
    assert torch.equal(equirect.rotate(panorama, matrix, 2), whole)


def test_rotate_refuses_what_is_no_rotation() -> None:
    with pytest.raises(ValueError, match="orthonormal"):
        equirect.rotate(random_map(2, 4, 1), 2 * torch.eye(3))
    with pytest.raises(ValueError, match="orthonormal"):
        equirect.rotate(random_map(2, 4, 1), torch.full((3, 3), math.nan))
    with pytest.raises(ValueError, match="supersample of at least 1, received 0"):
        equirect.rotate(random_map(2, 4, 1), torch.eye(3), 0)


def test_rotate_gradients() -> None:
    panorama = random_map(2, 4, 1).requires_grad_()
    assert torch.autograd.gradcheck(
        lambda p: equirect.rotate(p, rotation(0.4, 0.2, dtype=torch.float64), 2), (panorama,)
    )


@pytest.mark.parametrize("eighth", range(-9, 10))
def test_rotate_azimuth_by_whole_pixels_is_an_exact_roll(eighth: int) -> None:
    panorama = random_map(4, 16, 3)
    turned = equirect.rotate_azimuth(panorama, eighth * math.pi / 4)
    assert torch.equal(turned, panorama.roll(-2 * eighth, 1))


@given(st.floats(-20, 20), st.integers(1, 5))
def test_rotate_azimuth_keeps_every_row_sum(yaw: float, height: int) -> None:
    panorama = random_map(height, 10, 2)
    turned = equirect.rotate_azimuth(panorama, yaw)
    torch.testing.assert_close(turned.sum(-2), panorama.sum(-2), rtol=1e-12, atol=0)


@given(st.floats(-4, 4))
def test_rotate_azimuth_puts_the_direction_of_yaw_at_the_centre(yaw: float) -> None:
    turned = equirect.rotate_azimuth(smooth_map(64), yaw)
    found = equirect.sample(turned, torch.tensor([[0.0, 0.0, -1.0], [0.6, 0.0, -0.8]], dtype=torch.float64))
    matrix = rotation(yaw, dtype=torch.float64)
    expected = smooth_value(
        torch.tensor([[0.0, 0.0, -1.0], [0.6, 0.0, -0.8]], dtype=torch.float64) @ matrix.T
    )
    torch.testing.assert_close(found, expected, rtol=0, atol=3e-3)


@given(st.floats(-4, 4))
def test_rotate_azimuth_is_the_rotation_of_the_light_the_other_way(yaw: float) -> None:
    panorama = smooth_map(32)
    by_matrix = equirect.rotate(panorama, rotation(-yaw, dtype=torch.float64))
    torch.testing.assert_close(equirect.rotate_azimuth(panorama, yaw), by_matrix, rtol=0, atol=1e-8)


def test_rotate_azimuth_refuses_nan() -> None:
    with pytest.raises(ValueError, match="finite yaw, received nan"):
        equirect.rotate_azimuth(random_map(2, 4, 1), math.nan)


def test_mirror_swaps_left_and_right() -> None:
    panorama, directions = random_map(2, 8, 16, 3), random_directions(100)
    flipped = directions * torch.tensor([-1.0, 1.0, 1.0], dtype=torch.float64)
    found = equirect.sample(equirect.mirror(panorama), directions)
    torch.testing.assert_close(found, equirect.sample(panorama, flipped), **F64)
    assert torch.equal(equirect.mirror(equirect.mirror(panorama)), panorama)


# ----------------------------------------------------------------------------------------------------- resize


def reference_resize(panorama: Tensor, height: int, width: int) -> np.ndarray:
    """Every overlap of an old and a new texel, one by one."""
    p = panorama.numpy()
    rows, columns, channels = p.shape
    result = np.zeros((height, width, channels))
    for i in range(height):
        for j in range(width):
            area = 0.0
            for k in range(rows):
                top, bottom = max(i / height, k / rows), min((i + 1) / height, (k + 1) / rows)
                for m in range(columns):
                    left, right = max(j / width, m / columns), min((j + 1) / width, (m + 1) / columns)
                    if top < bottom and left < right:
                        part = (right - left) * (math.cos(math.pi * top) - math.cos(math.pi * bottom))
                        result[i, j] += part * p[k, m]
                        area += part
            result[i, j] /= area
    return result


@pytest.mark.parametrize(
    ("source", "target"),
    [
        ((6, 12), (3, 6)),
        ((5, 10), (3, 7)),
        ((3, 6), (5, 10)),
        ((4, 8), (8, 16)),
        ((1, 2), (4, 3)),
        ((7, 4), (2, 9)),
    ],
)
def test_resize_equals_the_overlaps_one_by_one(source: tuple[int, int], target: tuple[int, int]) -> None:
    panorama = random_map(*source, 2)
    np.testing.assert_allclose(
        equirect.resize(panorama, *target).numpy(), reference_resize(panorama, *target), rtol=1e-12
    )


@given(SIZES, SIZES, st.integers(1, 40), st.integers(1, 40))
def test_resize_keeps_the_energy(height: int, width: int, new_height: int, new_width: int) -> None:
    panorama = random_map(height, width, 3)
    resized = equirect.resize(panorama, new_height, new_width)
    assert resized.shape == (new_height, new_width, 3)
    torch.testing.assert_close(equirect.integrate(resized), equirect.integrate(panorama), rtol=1e-12, atol=0)
    assert resized.min() >= panorama.min() - 1e-12
    assert resized.max() <= panorama.max() + 1e-12


def test_resize_keeps_the_energy_of_a_sun_in_float32() -> None:
    panorama = torch.full((256, 512, 3), 0.1)
    panorama[100, 300] = 1e6
    for height in (64, 50, 37, 300):
        torch.testing.assert_close(
            equirect.integrate(equirect.resize(panorama, height)),
            equirect.integrate(panorama),
            **TOLERANCE[torch.float32],
        )


def test_resize_up_and_back_is_the_identity() -> None:
    panorama = random_map(5, 10, 3)
    back = equirect.resize(equirect.resize(panorama, 15), 5)
    torch.testing.assert_close(back, panorama, **F64)


def test_resize_to_the_same_size_is_a_copy() -> None:
    panorama = random_map(4, 8, 3)
    same = equirect.resize(panorama, 4)
    assert torch.equal(same, panorama)
    assert same.data_ptr() != panorama.data_ptr()


@pytest.mark.parametrize("batch", BATCHES)
def test_resize_with_and_without_a_graph_agree_for_any_batch(batch: tuple[int, ...]) -> None:
    panorama = random_map(*batch, 50, 100, 3)
    plain = equirect.resize(panorama, 40)
    graph = equirect.resize(panorama.clone().requires_grad_(), 40)
    assert plain.shape == (*batch, 40, 80, 3)
    torch.testing.assert_close(plain, graph.detach(), **F64)


def test_resize_gradients() -> None:
    panorama = random_map(2, 3, 4, 1).requires_grad_()
    assert torch.autograd.gradcheck(lambda p: equirect.resize(p, 2, 5), (panorama,))
    assert torch.autograd.gradgradcheck(lambda p: equirect.resize(p, 2, 5), (panorama,))
    assert torch.autograd.gradcheck(equirect.integrate, (panorama,))


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32])
def test_resize_and_integrate_follow_the_dtype(dtype: torch.dtype) -> None:
    panorama = random_map(40, 80, 3)
    small = equirect.resize(panorama.to(dtype), 20)
    assert small.dtype == dtype
    torch.testing.assert_close(small.double(), equirect.resize(panorama, 20), **TOLERANCE[dtype])
    total = equirect.integrate(panorama.to(dtype))
    assert total.dtype == dtype
    torch.testing.assert_close(total.double(), equirect.integrate(panorama), **TOLERANCE[dtype])


def test_resize_refuses_an_empty_size() -> None:
    with pytest.raises(ValueError, match="at least 1 x 1, received height 0"):
        equirect.resize(random_map(4, 8, 3), 0)


def test_prefilter_leaves_no_texel_between_rays() -> None:
    panorama = random_map(64, 128, 1)
    assert equirect.prefilter(panorama, math.pi / 64) is panorama
    assert equirect.prefilter(panorama, 1.9 * math.pi / 64) is panorama
    assert torch.equal(equirect.prefilter(panorama, 3.5 * math.pi / 64), equirect.resize(panorama, 21))


# ---------------------------------------------------------------------------------------- integrate and check


def test_integrate_golden() -> None:
    assert equirect.integrate(torch.ones(16, 32, 1)).item() == pytest.approx(4 * math.pi)
    x, y, _ = equirect.pixel_directions(256, dtype=torch.float64).unbind(-1)
    moments = equirect.integrate(torch.stack((x, y, x * x, y * y, x * y), -1))
    third = 4 * math.pi / 3
    np.testing.assert_allclose(moments.numpy(), [0, 0, third, third, 0], atol=2e-4)


@pytest.mark.parametrize("batch", BATCHES)
def test_integrate_equals_the_plain_sum(batch: tuple[int, ...]) -> None:
    panorama = random_map(*batch, 150, 300, 2)
    expected = (panorama * equirect.solid_angle(150, dtype=torch.float64)[..., None]).sum((-3, -2))
    torch.testing.assert_close(equirect.integrate(panorama), expected, **F64)


def test_check_accepts_radiance() -> None:
    equirect.check(torch.zeros(1, 2, 3))
    equirect.check(torch.rand(2, 4, 8, 1, dtype=torch.float16))


@pytest.mark.parametrize(
    ("value", "text"), [(math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf"), (-0.25, "-0.25")]
)
@pytest.mark.parametrize("place", [(0, 0, 0), (3, 7, 2), (2, 5, 1)])
def test_check_names_the_first_bad_texel(value: float, text: str, place: tuple[int, int, int]) -> None:
    panorama = torch.rand(2, 4, 8, 3)
    panorama[(1, *place)] = value
    where = f"room.hdr: .*at least 0, received {text} at row {place[0]}, column {place[1]}$"
    with pytest.raises(ValueError, match=where):
        equirect.check(panorama, "room.hdr")


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((4, 12, 3), r"2:1 panorama, received 12 x 4 \(width x height\)"),
        ((8, 4, 3), "received 4 x 8"),
        ((0, 0, 3), "received 0 x 0"),
        ((4, 8), r"expected \[..., height, width, channels\], received shape \[4, 8\]"),
        ((4, 8, 0), "with values"),
    ],
)
def test_check_refuses_other_shapes(shape: tuple[int, ...], message: str) -> None:
    # The plain function: with shape checks on, beartype would refuse two axes first.
    check = getattr(equirect.check, "__wrapped__", equirect.check)
    with pytest.raises(ValueError, match=message):
        check(torch.zeros(shape), "panorama")
