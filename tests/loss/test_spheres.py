"""The sphere-render loss against the plain matrices, and as a thing to train with."""

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light.compare import rmse_and_si_rmse
from mixlight.light.transport import MATERIALS, sphere_matrix
from mixlight.loss.spheres import SphereLoss
from tests.tolerances import TOLERANCE

F64 = torch.float64


@pytest.fixture(scope="module")
def loss() -> SphereLoss:
    return SphereLoss(height=8, resolution=10)


def maps(seed: int, *shape: int, height: int = 8) -> torch.Tensor:
    """High dynamic range: a few texels a thousand times brighter than the rest."""
    generator = torch.Generator().manual_seed(seed)
    x = torch.rand(*shape, height, 2 * height, 3, generator=generator)
    return x + 1000 * x**40


class TestGolden:
    def test_dimmer_everywhere(self, loss):
        one = torch.ones(8, 16, 3)
        rmse, si_rmse = loss(0.9 * one, one)
        assert rmse[0].item() == pytest.approx(0.08, abs=1e-3)
        assert rmse[2].item() == pytest.approx(0.08, abs=1e-5)
        assert si_rmse.abs().max() < 1e-5

    def test_full_size(self):
        """The size that is trained with; the matte sphere loses a little light between its facets."""
        full = SphereLoss()
        assert full.transport.shape == (4, 3 * 812 // 4, 512)
        rmse, _ = full(torch.zeros(32, 64, 3), torch.ones(32, 64, 3))
        torch.testing.assert_close(rmse, torch.tensor([0.8, 0.775, 0.8]), rtol=2e-3, atol=0.0)

    def test_a_light_moved_behind_the_sphere(self, loss):
        """Seen by the diffuse sphere a light from the viewer's side counts, one from behind hardly."""
        dark = torch.zeros(8, 16, 3)
        front, behind = dark.clone(), dark.clone()
        front[3:5, 0] = 1
        behind[3:5, 8] = 1
        assert loss(dark, front)[0][0] > 20 * loss(dark, behind)[0][0]


class TestAgainstPlainMatrices:
    @pytest.mark.parametrize("index", range(3))
    def test_errors(self, loss, index):
        matrix, _ = sphere_matrix(
            MATERIALS[index], 10, 8, pixel_supersample=16 if index == 2 else 2, interpolation="nearest"
        )
        p, g = maps(1), maps(2)
        pictures = [matrix @ x.reshape(-1, 3) for x in (p, g)]
        expected = rmse_and_si_rmse(*pictures)
        got = loss(p, g)
        for a, b in zip(got, expected, strict=True):
            torch.testing.assert_close(a[index], b, rtol=1e-4, atol=1e-5)

    @given(st.integers(0, 10_000))
    def test_encoding_keeps_inner_products(self, seed):
        loss = SphereLoss(height=8, resolution=10)  # from the cache
        matrix, _ = sphere_matrix(MATERIALS[1], 10, 8, pixel_supersample=2)
        p, g = maps(seed), maps(seed + 1)
        picture = ((matrix @ p.reshape(-1, 3)) * (matrix @ g.reshape(-1, 3))).sum()
        code = (loss.encode(p)[1] * loss.encode(g)[1]).sum()
        torch.testing.assert_close(code, picture, rtol=1e-4, atol=1e-4)


class TestProperties:
    def test_zero_for_the_truth(self, loss):
        p = maps(3, 2)
        rmse, si_rmse = loss(p, p)
        assert (rmse == 0).all()
        assert si_rmse.max() < 1e-4 * loss(0 * p, p)[0].max()

    def test_scales_with_the_light_and_ignores_exposure(self, loss):
        p, g = maps(4), maps(5)
        rmse, si_rmse = loss(p, g)
        torch.testing.assert_close(loss(3 * p, 3 * g)[0], 3 * rmse, rtol=1e-4, atol=0.0)
        torch.testing.assert_close(loss(7 * p, g)[1], si_rmse, rtol=1e-3, atol=0.0)
        assert (si_rmse <= rmse * (1 + 1e-5)).all()

    def test_mirrored_rooms_have_mirrored_spheres(self, loss):
        p, g = maps(6), maps(7)
        for axes in ([1], [0], [0, 1]):
            torch.testing.assert_close(loss(p.flip(axes), g.flip(axes)), loss(p, g), rtol=1e-4, atol=1e-6)

    def test_precomputed_basis(self, loss):
        """Rendering parameters through encoded maps, without any map."""
        generator = torch.Generator().manual_seed(1)
        basis = torch.rand(8, 16, 5, generator=generator)
        parameters = torch.rand(2, 5, 3, generator=generator)
        through_map = loss.encode((basis @ parameters[:, None]).reshape(2, 8, 16, 3))
        through_code = loss.encode(basis) @ parameters[:, None]
        torch.testing.assert_close(through_code, through_map, rtol=1e-4, atol=1e-5)
        g = maps(8, 2)
        direct = loss((basis @ parameters[:, None]).reshape(2, 8, 16, 3), g)
        for a, b in zip(loss.compare(through_code, loss.encode(g)), direct, strict=True):
            torch.testing.assert_close(a, b, rtol=1e-4, atol=1e-5)

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, loss, shape):
        p, g = maps(9, *shape), maps(10, *shape)
        for got, one in zip(
            loss(p, g), loss(p.reshape(-1, 8, 16, 3)[-1], g.reshape(-1, 8, 16, 3)[-1]), strict=True
        ):
            assert got.shape == (*shape, 3)
            torch.testing.assert_close(got.reshape(-1, 3)[-1], one, rtol=1e-5, atol=1e-6)

    def test_autocast_keeps_float32(self, loss):
        p, g = maps(11, 2), maps(12, 2)
        expected = loss(p, g)
        with torch.autocast("cpu", torch.bfloat16):
            got = loss(p, g)
        for a, b in zip(got, expected, strict=True):
            assert a.dtype == torch.float32
            torch.testing.assert_close(a, b, **TOLERANCE[torch.float32])

    def test_no_weights(self, loss):
        assert not loss.state_dict()
        assert not list(loss.parameters())

    def test_cache_is_not_shared(self):
        a, b = SphereLoss(8, 10), SphereLoss(8, 10)
        a.transport.zero_()
        assert b.transport.abs().max() > 0


class TestGradient:
    def test_gradcheck(self):
        loss = SphereLoss(height=2, resolution=2).double()
        p = maps(13, 2, height=2).double().requires_grad_()
        g = maps(14, 2, height=2).double()
        assert torch.autograd.gradcheck(lambda x: loss(x, g), (p,))

    @pytest.mark.parametrize("case", ["equal", "black prediction", "both black"])
    def test_finite_where_the_error_has_a_kink(self, loss, case):
        g = torch.zeros(8, 16, 3) if case == "both black" else maps(15)
        p = (g.clone() if case == "equal" else torch.zeros(8, 16, 3)).requires_grad_()
        rmse, si_rmse = loss(p, g)
        (rmse.sum() + si_rmse.sum()).backward()
        assert torch.isfinite(rmse).all()
        assert torch.isfinite(si_rmse).all()
        assert torch.isfinite(p.grad).all()

    def test_descent_finds_the_light(self, loss):
        """A hundred steps on the texels' logarithm reduce the error of all spheres."""
        g = maps(16).clamp(max=20)
        log_p = torch.zeros(8, 16, 3, requires_grad=True)
        optimiser = torch.optim.Adam([log_p], lr=0.1)
        before = loss(log_p.exp(), g)[0].detach()
        for _ in range(100):
            optimiser.zero_grad()
            loss(log_p.exp(), g)[0].sum().backward()
            optimiser.step()
        assert (loss(log_p.exp(), g)[0] < 0.3 * before).all()


class TestBadInput:
    @pytest.mark.parametrize("sizes", [(7, 8), (8, 7), (0, 8), (8, 0)])
    def test_sizes(self, sizes):
        with pytest.raises(ValueError, match="even sizes"):
            SphereLoss(*sizes)

    def test_map_of_another_size(self, loss):
        with pytest.raises(ValueError, match=r"\[..., 8, 16, channels\], got \(16, 32, 3\)"):
            loss(torch.ones(16, 32, 3), torch.ones(16, 32, 3))
