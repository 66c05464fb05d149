"""The analytic ambient losses against the sums over a map that they stand for."""

import math

import pytest
import scipy.special
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light import harmonics
from mixlight.loss import ambient
from mixlight.sphere import equirect
from tests.tolerances import TOLERANCE

F64 = torch.float64
EXACT = TOLERANCE[F64]
LOSSES = [ambient.coefficient_loss, ambient.reconstruction_loss, ambient.rendering_loss]


def pair(seed: int, *shape: int) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    a, b = torch.randn(2, *shape, 9, 3, dtype=F64, generator=generator)
    return a, b


def map_mean(difference: torch.Tensor) -> torch.Tensor:
    """1/(3 W H) of the sum over texels and channels of sin(polar angle) times the squared difference."""
    height = difference.shape[-3]
    sine = torch.sin((torch.arange(height, dtype=F64) + 0.5) * math.pi / height)
    return (difference.square() * sine[:, None, None]).mean((-3, -2, -1))


class TestAgainstExplicitMaps:
    @pytest.mark.parametrize("seed", range(3))
    def test_reconstruction(self, seed):
        a, b = pair(seed)
        directions = equirect.pixel_directions(256, dtype=F64)
        maps = [harmonics.evaluate(x, directions) for x in (a, b)]
        got = ambient.reconstruction_loss(a, b)
        torch.testing.assert_close(got, map_mean(maps[0] - maps[1]), rtol=1e-4, atol=0.0)

    @pytest.mark.parametrize("seed", range(3))
    def test_rendering(self, seed):
        a, b = pair(seed)
        normals = equirect.pixel_directions(256, dtype=F64)
        maps = [harmonics.irradiance(x, normals) / math.pi for x in (a, b)]
        got = ambient.rendering_loss(a, b)
        torch.testing.assert_close(got, map_mean(maps[0] - maps[1]), rtol=1e-4, atol=0.0)

    def test_basis_of_an_independent_library(self):
        """One coefficient, its map from SciPy's spherical harmonics: real part of Y_20."""
        polar = ((torch.arange(512, dtype=F64) + 0.5) * math.pi / 512).numpy()
        # SciPy's pole is +z, where index 6 (l = 2, m = 0) has its pole too: turn the map, not the loss.
        values = torch.from_numpy(scipy.special.sph_harm_y(2, 0, polar, 0.0).real)
        expected = (values.square() * torch.sin(torch.from_numpy(polar))).mean() / 3
        a = torch.zeros(9, 3, dtype=F64)
        a[6, 0] = 1
        torch.testing.assert_close(ambient.reconstruction_loss(a, 0 * a), expected, rtol=1e-4, atol=0.0)


class TestGolden:
    def test_coefficient_weights(self):
        """1, 1/3 and 1/5 by degree."""
        eye = torch.eye(9, dtype=F64)[..., None] * torch.tensor([1.0, 0, 0], dtype=F64)
        got = ambient.coefficient_loss(eye, torch.zeros_like(eye))
        expected = torch.tensor([1] + 3 * [1 / 3] + 5 * [1 / 5], dtype=F64)
        torch.testing.assert_close(got, expected, **EXACT)

    def test_rendering_attenuates_by_degree(self):
        eye = torch.eye(9, dtype=F64)[..., None].expand(9, 9, 3)
        zero = torch.zeros_like(eye)
        got = ambient.rendering_loss(eye, zero) / ambient.reconstruction_loss(eye, zero)
        expected = torch.tensor([1] + 3 * [4 / 9] + 5 * [1 / 16], dtype=F64)
        torch.testing.assert_close(got, expected, **EXACT)

    def test_constant_maps(self):
        """Maps that differ by 1 everywhere: the mean of the sine, 2/pi."""
        a = torch.zeros(9, 3, dtype=F64)
        a[0] = math.sqrt(4 * math.pi)
        for loss in LOSSES[1:]:
            assert loss(a, 0 * a).item() == pytest.approx(2 / math.pi, rel=1e-12)


class TestProperties:
    @given(st.integers(0, 10_000), st.floats(-3, 3))
    def test_square_of_a_norm(self, seed, factor):
        a, b = pair(seed)
        for loss in LOSSES:
            assert loss(a, a).item() == 0
            torch.testing.assert_close(loss(a, b), loss(b, a), **EXACT)
            torch.testing.assert_close(loss(factor * a, factor * b), factor**2 * loss(a, b), **EXACT)

    @given(st.floats(-3, 3), st.floats(-1.5, 1.5))
    def test_map_losses_do_not_know_directions(self, yaw, pitch):
        """Turning both lights changes nothing: no direction of error is cheaper than another."""
        from mixlight.sphere import frames

        a, b = pair(1)
        turn = frames.rotation(yaw, pitch, 0.3).to(F64)
        for loss in LOSSES:
            turned = loss(harmonics.rotate(a, turn), harmonics.rotate(b, turn))
            torch.testing.assert_close(turned, loss(a, b), rtol=1e-5, atol=1e-8)

    @pytest.mark.parametrize("loss", LOSSES)
    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, loss, shape):
        a, b = pair(4, *shape)
        got = loss(a, b)
        assert got.shape == shape
        one = loss(a.reshape(-1, 9, 3)[-1], b.reshape(-1, 9, 3)[-1])
        torch.testing.assert_close(got.flatten()[-1], one, **EXACT)

    @pytest.mark.parametrize("loss", LOSSES)
    def test_gradcheck(self, loss):
        a, b = pair(5, 2)
        assert torch.autograd.gradcheck(loss, (a.requires_grad_(), b.requires_grad_()))

    @pytest.mark.parametrize("loss", LOSSES)
    @pytest.mark.parametrize("count", [1, 4, 49])
    def test_other_degrees_and_float32(self, loss, count):
        a, b = torch.ones(count, 3), torch.zeros(count, 3)
        assert loss(a, b).dtype == torch.float32
        assert loss(a, b) > 0

    @pytest.mark.parametrize("loss", LOSSES)
    def test_bad_shapes(self, loss):
        with pytest.raises(ValueError, match="square number of coefficients"):
            loss(torch.zeros(8, 3), torch.zeros(8, 3))
        with pytest.raises(ValueError, match="one shape"):
            ambient._degrees(torch.zeros(9, 3), torch.zeros(4, 3))
