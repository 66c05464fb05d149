import math

import numpy as np
import pytest
import scipy.special
import scipy.stats
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import _lobe_grid, gaussians, harmonics
from mixlight.sphere import equirect
from mixlight.sphere.points import vogel
from tests.tolerances import TOLERANCE

EXACT = TOLERANCE[torch.float64]
SHARP = 0.0025
BATCHES = [(), (2,), (1, 2)]


def random_axes(count: int, seed: int = 0) -> Tensor:
    draw = torch.randn(count, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))
    return torch.nn.functional.normalize(draw, dim=-1)


def random_energy(*shape: int) -> Tensor:
    return torch.rand(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(1))


def axes() -> st.SearchStrategy[Tensor]:
    return st.tuples(st.floats(0, 1), st.floats(0, 1)).map(
        lambda uv: equirect.uv_to_directions(torch.tensor(uv, dtype=torch.float64))[None]
    )


class TestShape:
    def test_golden(self) -> None:
        assert gaussians.normaliser(SHARP) == pytest.approx(63.6619772)
        assert math.degrees(gaussians.fwhm(SHARP)) == pytest.approx(6.747, abs=1e-3)
        assert math.degrees(2 * gaussians.cone_half_angle(SHARP)) == pytest.approx(8.105, abs=1e-3)

    def test_what_the_papers_exponent_would_cost(self) -> None:
        literal = 1 / (2 * math.pi * SHARP * (1 - math.exp(-2 * SHARP)))
        assert literal / gaussians.normaliser(SHARP) == pytest.approx(200.5, abs=0.05)

    def test_one_lobe_integrates_to_one(self) -> None:
        lobes = gaussians.lobe_maps(vogel(128), SHARP, 128, conserve=False)
        energy = equirect.integrate(lobes[..., None].double())
        torch.testing.assert_close(energy, torch.ones_like(energy), rtol=0, atol=1e-3)

    @given(axis=axes())
    def test_one_lobe_on_any_axis(self, axis: Tensor) -> None:
        lobe = gaussians.evaluate_map(axis, torch.ones(1, 1).double(), SHARP, 64)
        assert float(equirect.integrate(lobe)) == pytest.approx(1, abs=1e-12)

    def test_half_maximum_and_cone(self) -> None:
        half = gaussians.fwhm(SHARP) / 2
        up = torch.tensor([[0.0, 1.0, 0.0]], dtype=torch.float64)
        beside = torch.tensor([math.sin(half), math.cos(half), 0.0], dtype=torch.float64)
        value = gaussians.evaluate(up, torch.ones(1, 1).double(), SHARP, beside)
        assert float(value) == pytest.approx(gaussians.normaliser(SHARP) / 2)
        cone = 2 * math.pi * (1 - math.cos(gaussians.cone_half_angle(SHARP)))
        assert cone * gaussians.normaliser(SHARP) == pytest.approx(1)

    def test_von_mises_fisher(self) -> None:
        axis, points = random_axes(1), random_axes(50, seed=2)
        for sharpness in (0.02, 0.2423, 1.0):
            density = scipy.stats.vonmises_fisher(axis[0].numpy(), 1 / sharpness).pdf(points.numpy())
            found = gaussians.evaluate(axis, torch.ones(1, 1).double(), sharpness, points)[:, 0]
            torch.testing.assert_close(found, torch.from_numpy(np.asarray(density)), rtol=1e-9, atol=1e-12)

    @pytest.mark.parametrize("sharpness", [0.0, -1.0, math.nan, math.inf])
    def test_bad_sharpness(self, sharpness: float) -> None:
        with pytest.raises(ValueError, match="above 0"):
            gaussians.normaliser(sharpness)

    def test_tensor_of_sharpness(self) -> None:
        found = gaussians.normaliser(torch.tensor([0.0025, 1.0], dtype=torch.float64))
        assert isinstance(found, Tensor)
        assert found.tolist() == pytest.approx([gaussians.normaliser(0.0025), gaussians.normaliser(1.0)])
        with pytest.raises(ValueError, match=r"minimum of -1\.0"):
            gaussians.normaliser(torch.tensor([1.0, -1.0]))

    def test_no_cone_beyond_the_sphere(self) -> None:
        with pytest.raises(ValueError, match="at most 2"):
            gaussians.cone_half_angle(2.5)
        assert gaussians.fwhm(5.0) == pytest.approx(2 * math.pi)


class TestEvaluate:
    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("points", [(), (5,), (2, 3)])
    def test_shapes(self, batch: tuple[int, ...], points: tuple[int, ...]) -> None:
        energy = torch.ones(*batch, 4, 3)
        values = gaussians.evaluate(vogel(4), energy, SHARP, torch.ones(*points, 3))
        assert values.shape == (*batch, *points, 3)
        assert values.dtype == torch.float32

    def test_single_precision_keeps_its_digits(self) -> None:
        directions = equirect.pixel_directions(64, dtype=torch.float64)
        exact = gaussians.evaluate(vogel(128).double(), random_energy(128, 3), SHARP, directions)
        single = gaussians.evaluate(vogel(128), random_energy(128, 3).float(), SHARP, directions.float())
        torch.testing.assert_close(
            single.double(), exact, rtol=2e-4, atol=1e-5
        )  # of the directions themselves

    def test_is_the_map_at_texel_centres(self) -> None:
        energy = random_energy(2, 128, 3)
        directions = equirect.pixel_directions(20, dtype=torch.float64)
        points = vogel(128, dtype=torch.float64)
        found = gaussians.evaluate_map(points, energy, SHARP, 20, conserve=False)
        torch.testing.assert_close(
            found, gaussians.evaluate(points, energy, SHARP, directions), rtol=1e-9, atol=1e-12
        )

    def test_gradcheck(self) -> None:
        inputs = (
            random_axes(3).requires_grad_(),
            random_energy(2, 3, 1).requires_grad_(),
            torch.tensor([0.3, 0.5, 0.9], dtype=torch.float64, requires_grad=True),
            random_axes(4, seed=5).requires_grad_(),
        )
        assert torch.autograd.gradcheck(gaussians.evaluate, inputs)

    def test_counts_differ(self, unchecked: None) -> None:
        with pytest.raises(ValueError, match=r"received \(4, 3\) and \(5, 3\)"):
            gaussians.evaluate(torch.ones(4, 3), torch.ones(5, 3), SHARP, torch.ones(3))


class TestMap:
    @pytest.mark.parametrize("height", [1, 2, 3, 4, 8, 16, 64, 128])
    @pytest.mark.parametrize("sharpness", [0.0005, SHARP, 0.2423, 3.0])
    def test_conserves_energy_on_any_grid(self, height: int, sharpness: float) -> None:
        energy = random_energy(2, 40, 3)
        found = gaussians.evaluate_map(random_axes(40), energy, sharpness, height)
        torch.testing.assert_close(equirect.integrate(found), energy.sum(-2), **EXACT)

    def test_single_precision_conserves(self) -> None:
        energy = random_energy(128, 3).float()
        found = gaussians.evaluate_map(vogel(128), energy, SHARP, 16)
        torch.testing.assert_close(equirect.integrate(found), energy.sum(-2), **TOLERANCE[torch.float32])

    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("conserve", [True, False])
    def test_is_the_lobes_sum(self, batch: tuple[int, ...], conserve: bool) -> None:
        points, energy = vogel(32, dtype=torch.float64), random_energy(*batch, 32, 3)
        lobes = gaussians.lobe_maps(points, SHARP, 24, conserve)
        torch.testing.assert_close(
            gaussians.evaluate_map(points, energy, SHARP, 24, conserve),
            torch.einsum("nhw,...nc->...hwc", lobes, energy),
            **EXACT,
        )

    @pytest.mark.parametrize("conserve", [True, False])
    def test_each_lobe_has_its_sharpness(self, conserve: bool) -> None:
        points, energy = vogel(3, dtype=torch.float64), random_energy(3, 3)
        energy[1] = 0  # skipped, and its sharpness with it
        sharpness = [0.002, 0.01, 0.3]
        found = gaussians.evaluate_map(points, energy, torch.tensor(sharpness).double(), 32, conserve)
        expected = sum(
            gaussians.evaluate_map(
                points[i : i + 1], energy[i : i + 1], torch.tensor(s).double(), 32, conserve
            )
            for i, s in enumerate(sharpness)
        )
        torch.testing.assert_close(found, expected, **EXACT)

    def test_bands_of_rows_change_nothing(self, monkeypatch: pytest.MonkeyPatch) -> None:
        points, energy = vogel(128, dtype=torch.float64), random_energy(128, 3)
        whole = gaussians.evaluate_map(points, energy, SHARP, 48)
        monkeypatch.setattr(_lobe_grid, "CHUNK", 5000)
        torch.testing.assert_close(gaussians.evaluate_map(points, energy, SHARP, 48), whole, **EXACT)

    def test_dark_lobes(self) -> None:
        assert gaussians.evaluate_map(vogel(8), torch.zeros(2, 8, 3), SHARP, 4).shape == (2, 4, 8, 3)
        energy = torch.zeros(8, 3)
        energy[3, 1] = 1
        lit = gaussians.evaluate_map(vogel(8), energy, SHARP, 16)
        torch.testing.assert_close(lit, gaussians.evaluate_map(vogel(8)[3:4], energy[3:4], SHARP, 16))
        assert not lit[..., 0].any()

    def test_a_dark_lobe_still_has_a_gradient(self) -> None:
        energy = torch.zeros(8, 3, requires_grad=True)
        gaussians.evaluate_map(vogel(8), energy, SHARP, 16).sum().backward()
        assert energy.grad is not None
        assert bool((energy.grad > 0).all())

    def test_gradcheck(self) -> None:
        points, energy = random_axes(3).requires_grad_(), random_energy(3, 1).requires_grad_()
        for conserve in (True, False):
            assert torch.autograd.gradcheck(
                lambda u, v, how=conserve: gaussians.evaluate_map(u, v, 0.3, 4, how), (points, energy)
            )
        sharpness = torch.tensor(0.4, dtype=torch.float64, requires_grad=True)
        assert torch.autograd.gradcheck(lambda s: gaussians.lobe_maps(points, s, 4), sharpness)

    def test_orientation(self) -> None:
        lobe = gaussians.evaluate_map(torch.tensor([[1.0, 0.0, 0.0]]), torch.ones(1, 1), SHARP, 64)[..., 0]
        row, column = divmod(int(lobe.argmax()), 128)
        assert row in (31, 32)
        assert column in (95, 96)  # +X is at three quarters of the width

    def test_no_rows(self) -> None:
        for make in (
            lambda: gaussians.evaluate_map(vogel(2), torch.ones(2, 3), SHARP, 0),
            lambda: gaussians.lobe_maps(vogel(2), SHARP, 0),
        ):
            with pytest.raises(ValueError, match="at least 1, received 0"):
                make()


class TestHarmonics:
    @pytest.mark.parametrize("sharpness", [0.0005, SHARP, 0.2423, 2.0])
    def test_bessel(self, sharpness: float) -> None:
        orders = np.arange(13) + 0.5
        expected = scipy.special.ive(orders, 1 / sharpness) / scipy.special.ive(0.5, 1 / sharpness)
        torch.testing.assert_close(
            gaussians.band_factors(sharpness, 12), torch.from_numpy(expected), rtol=1e-9, atol=1e-14
        )

    @pytest.mark.parametrize("batch", BATCHES)
    def test_is_the_projection_of_the_map(self, batch: tuple[int, ...]) -> None:
        points, energy = random_axes(5), random_energy(*batch, 5, 3)
        expected = harmonics.project(gaussians.evaluate_map(points, energy, 0.05, 128), 6)
        found = gaussians.to_harmonics(points, energy, 0.05, 6)
        torch.testing.assert_close(found, expected, rtol=0, atol=2e-3)


class TestIrradiance:
    @pytest.mark.parametrize("sharpness", [SHARP, 0.05, 0.5])
    def test_against_the_integral(self, sharpness: float) -> None:
        points, energy, normals = random_axes(4), random_energy(4, 2), random_axes(30, seed=7)
        light = gaussians.evaluate_map(points, energy, sharpness, 192)
        directions = equirect.pixel_directions(192, dtype=torch.float64)
        weight = equirect.solid_angle(192, dtype=torch.float64)
        cosine = torch.einsum("nx,hwx->nhw", normals, directions).clamp_min(0)
        expected = torch.einsum("nhw,hwc,hw->nc", cosine, light, weight)
        found = gaussians.irradiance(points, energy, sharpness, normals)
        torch.testing.assert_close(found, expected, rtol=0, atol=2e-4)

    def test_golden(self) -> None:
        normals = torch.tensor([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], dtype=torch.float64)
        found = gaussians.irradiance(normals[:1], torch.ones(1, 1).double(), SHARP, normals)[:, 0]
        assert found.tolist() == pytest.approx([0.9975, 0.0199284, 0], abs=1e-6)

    @given(axis=axes(), normal=axes())
    def test_a_narrow_lobe_is_a_directional_light(self, axis: Tensor, normal: Tensor) -> None:
        found = gaussians.irradiance(axis, torch.ones(1, 1).double(), 1e-4, normal[0])
        expected = float((axis[0] @ normal[0]).clamp_min(0))
        assert float(found) == pytest.approx(expected, abs=5e-3)

    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("points", [(), (2, 3)])
    def test_shapes(self, batch: tuple[int, ...], points: tuple[int, ...]) -> None:
        found = gaussians.irradiance(vogel(4), torch.ones(*batch, 4, 3), SHARP, torch.ones(*points, 3))
        assert found.shape == (*batch, *points, 3)

    def test_no_lobe_no_light(self) -> None:
        found = gaussians.irradiance(torch.zeros(0, 3), torch.zeros(0, 3), SHARP, torch.ones(5, 3))
        assert found.shape == (5, 3)
        assert not found.any()

    def test_gradcheck(self) -> None:
        energy, normals = random_energy(3, 1).requires_grad_(), random_axes(4, seed=3).requires_grad_()
        assert torch.autograd.gradcheck(
            lambda v, n: gaussians.irradiance(random_axes(3), v, 0.2, n), (energy, normals)
        )
