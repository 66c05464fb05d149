import math

import numpy as np
import pytest
import scipy.special
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import harmonics
from mixlight.sphere import equirect
from mixlight.sphere.frames import rotation
from tests.tolerances import TOLERANCE

EXACT = TOLERANCE[torch.float64]
DEGREES = range(harmonics.MAX_DEGREE + 1)
BATCHES = [(), (2,), (1, 2)]


def random_directions(count: int, seed: int = 0) -> Tensor:
    draw = torch.randn(count, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))
    return torch.nn.functional.normalize(draw, dim=-1)


def random_coefficients(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))


def turns() -> st.SearchStrategy[Tensor]:
    angle = st.floats(-math.pi, math.pi)
    return st.tuples(angle, angle, angle).map(lambda a: rotation(*torch.tensor(a, dtype=torch.float64)))


class TestBasis:
    def test_golden_polynomials(self) -> None:
        x, y, z = (directions := random_directions(50)).unbind(-1)
        one, two = 0.488603, 1.092548
        expected = [
            torch.full_like(x, 0.282095),
            one * y,
            one * z,
            one * x,
            two * x * y,
            two * y * z,
            0.315392 * (3 * z * z - 1),
            two * x * z,
            0.546274 * (x * x - y * y),
        ]
        torch.testing.assert_close(
            harmonics.basis(directions), torch.stack(expected, -1), rtol=2e-6, atol=1e-6
        )

    @pytest.mark.parametrize("degree", DEGREES)
    def test_scipy(self, degree: int) -> None:
        axes = torch.cat([torch.eye(3), -torch.eye(3)]).double()
        directions = torch.cat([random_directions(40), axes])
        x, y, z = directions.numpy().T
        polar, azimuth = np.arccos(z), np.arctan2(y, x)
        columns = []
        for band in range(degree + 1):
            for m in range(-band, band + 1):
                value = scipy.special.sph_harm_y(band, abs(m), polar, azimuth)
                sign = (-1) ** m  # SciPy has the Condon-Shortley sign, we have not
                columns.append(
                    value.real if m == 0 else sign * math.sqrt(2) * (value.real if m > 0 else value.imag)
                )
        torch.testing.assert_close(
            harmonics.basis(directions, degree),
            torch.from_numpy(np.stack(columns, -1)),
            rtol=1e-10,
            atol=1e-10,
        )

    def test_orthonormal(self) -> None:
        values = harmonics.basis(equirect.pixel_directions(128, dtype=torch.float64), 6).flatten(0, 1)
        weight = equirect.solid_angle(128, dtype=torch.float64).reshape(-1, 1)
        gram = values.T @ (values * weight)
        torch.testing.assert_close(gram, torch.eye(49, dtype=torch.float64), rtol=0, atol=4e-3)  # the grid's

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2), (0,)])
    @pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
    def test_shapes(self, shape: tuple[int, ...], dtype: torch.dtype) -> None:
        values = harmonics.basis(torch.ones(*shape, 3, dtype=dtype), 3)
        assert values.shape == (*shape, 16)
        assert values.dtype == dtype

    def test_gradient_at_the_poles(self) -> None:
        axes = torch.eye(3, dtype=torch.float64, requires_grad=True)
        assert torch.autograd.gradcheck(lambda d: harmonics.basis(d, 6), axes)

    @pytest.mark.parametrize("degree", [-1, 7])
    def test_unknown_degree(self, degree: int) -> None:
        with pytest.raises(ValueError, match=f"0 to 6, received {degree}"):
            harmonics.basis(torch.ones(3), degree)

    def test_wrong_axis(self, unchecked: None) -> None:
        with pytest.raises(ValueError, match=r"last axis of 3, received shape \(4, 2\)"):
            harmonics.basis(torch.ones(4, 2))


class TestProject:
    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("degree", [0, 2, 6])
    def test_is_the_plain_sum(self, batch: tuple[int, ...], degree: int) -> None:
        panorama = random_coefficients(*batch, 24, 48, 3)
        values = harmonics.basis(equirect.pixel_directions(24, dtype=torch.float64), degree)
        weight = equirect.solid_angle(24, dtype=torch.float64)
        expected = torch.einsum("...hwc,hwk,hw->...kc", panorama, values, weight)
        torch.testing.assert_close(harmonics.project(panorama, degree), expected, **EXACT)

    def test_single_precision(self, room: Tensor) -> None:
        expected = harmonics.project(room.double()).float()
        torch.testing.assert_close(harmonics.project(room), expected, rtol=2e-5, atol=2e-5)

    def test_first_coefficient_is_the_energy(self, room: Tensor) -> None:
        energy = harmonics.project(room.double())[0] * math.sqrt(4 * math.pi)
        torch.testing.assert_close(energy, equirect.integrate(room.double()), **EXACT)

    @pytest.mark.parametrize("degree", DEGREES)
    def test_finds_what_was_evaluated(self, degree: int) -> None:
        coefficients = random_coefficients(harmonics.count(degree), 3)
        again = harmonics.project(harmonics.evaluate_map(coefficients, 256), degree)
        torch.testing.assert_close(again, coefficients, rtol=0, atol=3e-3)  # the grid's own error

    def test_half_precision_is_summed_in_single(self) -> None:
        panorama = torch.full((64, 128, 3), 1000.0, dtype=torch.float16)
        found = harmonics.project(panorama)[0].double()
        torch.testing.assert_close(found, torch.full((3,), 3544.9077, dtype=torch.float64), rtol=1e-5, atol=0)

    def test_orientation(self) -> None:
        panorama = torch.zeros(32, 64, 1, dtype=torch.float64)
        panorama[15:17, 47:49] = 1  # the calibration card's +X patch
        found = harmonics.project(panorama, 1)[:, 0]
        assert found.abs()[1:].argmax() == 2  # index 3 = (1, 1) is x
        assert found[3] > 0

    @pytest.mark.parametrize("shape", [(8, 8, 3), (8, 24, 3)])
    def test_not_2_to_1(self, shape: tuple[int, ...]) -> None:
        with pytest.raises(ValueError, match=f"received height 8, width {shape[1]}"):
            harmonics.project(torch.ones(shape))

    def test_gradcheck(self) -> None:
        panorama = random_coefficients(4, 8, 2).requires_grad_()
        assert torch.autograd.gradcheck(harmonics.project, panorama)

    def test_tables_made_in_inference_mode_meet_autograd(self) -> None:
        with torch.inference_mode():
            harmonics.project(torch.ones(11, 22, 3), 1)
            harmonics.rotate(torch.ones(4, 3), torch.eye(3))
        panorama = torch.ones(11, 22, 3, requires_grad=True)
        harmonics.rotate(harmonics.project(panorama, 1), torch.eye(3)).sum().backward()
        assert panorama.grad is not None


class TestEvaluate:
    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("points", [(), (5,), (2, 3)])
    def test_shapes(self, batch: tuple[int, ...], points: tuple[int, ...]) -> None:
        values = harmonics.evaluate(torch.ones(*batch, 9, 3), torch.ones(*points, 3))
        assert values.shape == (*batch, *points, 3)

    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("degree", DEGREES)
    def test_map_is_the_value_at_texel_centres(self, batch: tuple[int, ...], degree: int) -> None:
        coefficients = random_coefficients(*batch, harmonics.count(degree), 2)
        directions = equirect.pixel_directions(6, dtype=torch.float64)
        torch.testing.assert_close(
            harmonics.evaluate_map(coefficients, 6), harmonics.evaluate(coefficients, directions), **EXACT
        )

    def test_gradcheck(self) -> None:
        coefficients = random_coefficients(2, 16, 1).requires_grad_()
        directions = random_directions(3).requires_grad_()
        assert torch.autograd.gradcheck(harmonics.evaluate, (coefficients, directions))
        assert torch.autograd.gradcheck(lambda c: harmonics.evaluate_map(c, 3), coefficients)

    @pytest.mark.parametrize("size", [2, 8, 64])
    def test_no_square(self, size: int) -> None:
        with pytest.raises(ValueError, match=r"\(degree \+ 1\)\^2"):
            harmonics.evaluate(torch.ones(size, 3), torch.ones(3))

    def test_no_rows(self) -> None:
        with pytest.raises(ValueError, match="at least 1, received 0"):
            harmonics.evaluate_map(torch.ones(9, 3), 0)


class TestIrradiance:
    def test_golden_kernel(self) -> None:
        expected = [math.pi, 2 * math.pi / 3, math.pi / 4, 0, -math.pi / 24, 0, math.pi / 64]
        torch.testing.assert_close(
            harmonics.cosine_kernel(6), torch.tensor(expected, dtype=torch.float64), **EXACT
        )

    def test_against_the_integral(self) -> None:
        coefficients, normals = random_coefficients(16, 3), random_directions(7)
        directions = equirect.pixel_directions(200, dtype=torch.float64)
        weight = equirect.solid_angle(200, dtype=torch.float64)
        cosine = torch.einsum("nx,hwx->nhw", normals, directions).clamp_min(0)
        radiance = harmonics.evaluate(coefficients, directions)
        expected = torch.einsum("nhw,hwc,hw->nc", cosine, radiance, weight)
        torch.testing.assert_close(harmonics.irradiance(coefficients, normals), expected, rtol=0, atol=2e-3)

    def test_the_first_nine_are_the_published_formula(self) -> None:
        # Ramamoorthi and Hanrahan 2001, eq. 13, with c1 ... c5 and their L indices.
        light, (x, y, z) = random_coefficients(9, 1)[:, 0], random_directions(1)[0]
        c1, c2, c3, c4, c5 = 0.429043, 0.511664, 0.743125, 0.886227, 0.247708
        expected = (
            c1 * light[8] * (x * x - y * y)
            + c3 * light[6] * z * z
            + c4 * light[0]
            - c5 * light[6]
            + 2 * c1 * (light[4] * x * y + light[7] * x * z + light[5] * y * z)
            + 2 * c2 * (light[3] * x + light[1] * y + light[2] * z)
        )
        found = harmonics.irradiance(light[:, None], torch.stack([x, y, z]))[0]
        torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-5)  # constants of six digits


class TestRotate:
    @given(turn=turns(), degree=st.sampled_from(DEGREES), seed=st.integers(0, 9))
    def test_moves_the_light(self, turn: Tensor, degree: int, seed: int) -> None:
        coefficients = random_coefficients(2, harmonics.count(degree), 3, seed=seed)
        directions = random_directions(20, seed)
        turned = harmonics.evaluate(harmonics.rotate(coefficients, turn), directions @ turn.T)
        torch.testing.assert_close(turned, harmonics.evaluate(coefficients, directions), **EXACT)

    @given(first=turns(), second=turns())
    def test_composes_and_keeps_each_degrees_power(self, first: Tensor, second: Tensor) -> None:
        coefficients = random_coefficients(49, 1)
        once = harmonics.rotate(coefficients, second @ first)
        twice = harmonics.rotate(harmonics.rotate(coefficients, first), second)
        torch.testing.assert_close(once, twice, **EXACT)
        for band in range(7):
            mine = harmonics.degrees(6) == band
            torch.testing.assert_close(once[mine].norm(), coefficients[mine].norm(), **EXACT)

    def test_agrees_with_the_panorama_turned(self) -> None:
        turn = rotation(0.7, 0.3, -0.4, dtype=torch.float64)
        panorama = harmonics.evaluate_map(random_coefficients(9, 3), 128)
        turned = harmonics.project(equirect.rotate(panorama, turn))
        torch.testing.assert_close(
            turned, harmonics.rotate(harmonics.project(panorama), turn), rtol=0, atol=4e-3
        )

    def test_a_mirror_is_an_improper_rotation(self) -> None:
        coefficients = random_coefficients(49, 3)
        flip = torch.diag(torch.tensor([-1.0, 1.0, 1.0], dtype=torch.float64))
        torch.testing.assert_close(
            harmonics.rotate(coefficients, flip), harmonics.mirror(coefficients), **EXACT
        )

    def test_batches_broadcast(self) -> None:
        matrices = torch.stack([rotation(0.1), rotation(0.2), rotation(0.3)]).double()
        coefficients = random_coefficients(5, 1, 9, 3)
        turned = harmonics.rotate(coefficients, matrices)
        assert turned.shape == (5, 3, 9, 3)
        torch.testing.assert_close(turned[4, 2], harmonics.rotate(coefficients[4, 0], matrices[2]), **EXACT)

    def test_gradcheck(self) -> None:
        coefficients = random_coefficients(9, 2).requires_grad_()
        turn = rotation(0.3, dtype=torch.float64)
        assert torch.autograd.gradcheck(lambda c: harmonics.rotate(c, turn), coefficients)

    def test_single_precision_stays(self) -> None:
        assert harmonics.rotate(torch.ones(9, 3), rotation(0.5)).dtype == torch.float32

    @pytest.mark.parametrize("matrix", [torch.ones(3, 3), 2 * torch.eye(3), torch.full((3, 3), math.nan)])
    def test_no_rotation(self, matrix: Tensor) -> None:
        with pytest.raises(ValueError, match="orthogonal"):
            harmonics.rotate(torch.ones(9, 3), matrix)


def test_mirror_is_the_mirrored_panorama() -> None:
    panorama = random_coefficients(2, 16, 32, 3)
    torch.testing.assert_close(
        harmonics.mirror(harmonics.project(panorama, 6)),
        harmonics.project(equirect.mirror(panorama), 6),
        **EXACT,
    )
