"""Reflection kernels, the sampling of a sphere's picture, and the matrices made of both."""

import math

import numpy as np
import pytest
import scipy.integrate
import torch
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import TypeCheckError

from mixlight.light import transport
from mixlight.light.transport import MATERIALS, Material
from mixlight.sphere import equirect
from tests.tolerances import TOLERANCE

F64 = torch.float64
EXACT = TOLERANCE[F64]
VIEW = torch.tensor(transport.VIEW, dtype=F64)

unit = st.tuples(st.floats(0.05, 0.999), st.floats(0, 2 * math.pi)).map(
    lambda t: (math.sqrt(1 - t[0] ** 2) * math.cos(t[1]), math.sqrt(1 - t[0] ** 2) * math.sin(t[1]), t[0])
)
"""Directions of the hemisphere around +Z."""


def small_panorama(height: int) -> torch.Tensor:
    generator = torch.Generator().manual_seed(3)
    return torch.rand(height, 2 * height, 3, dtype=F64, generator=generator) ** 6


class TestSphereNormals:
    def test_golden(self):
        samples = transport.sphere_normals(2, rim=False)
        expected = torch.tensor([[-1, 1], [1, 1], [-1, -1], [1, -1]], dtype=F64) / 2
        torch.testing.assert_close(samples.normals[:, :2], expected, **EXACT)
        assert samples.pixel.tolist() == [0, 1, 2, 3]

    @pytest.mark.parametrize(
        ("resolution", "supersample"), [(1, 1), (1, 4), (2, 3), (7, 2), (16, 1), (33, 4)]
    )
    def test_unit_normals_that_face_the_camera_and_weights_that_sum_to_one(self, resolution, supersample):
        samples = transport.sphere_normals(resolution, supersample)
        torch.testing.assert_close(
            samples.normals.norm(dim=-1), torch.ones(len(samples.normals), dtype=F64), **EXACT
        )
        assert (samples.normals[:, 2] >= 0).all()
        assert (samples.pixel.diff() >= 0).all()
        totals = torch.zeros(int(samples.mask.sum()), dtype=F64).index_add_(0, samples.pixel, samples.weight)
        torch.testing.assert_close(totals, torch.ones_like(totals), **EXACT)

    @pytest.mark.parametrize("resolution", [12, 32])
    def test_samples_lie_in_their_pixels(self, resolution):
        samples = transport.sphere_normals(resolution, 3)
        i, j = samples.mask.nonzero(as_tuple=True)
        column = (samples.normals[:, 0] + 1) / 2 * resolution - j[samples.pixel]
        row = (1 - samples.normals[:, 1]) / 2 * resolution - i[samples.pixel]
        for place in (column, row):
            assert place.min() > -1e-9
            assert place.max() < 1 + 1e-9

    @pytest.mark.parametrize("resolution", [11, 16])
    def test_pixel_means_against_brute_force(self, resolution):
        """The mean of n_z, which has an infinite slope at the rim, over each pixel's part of the disc."""

        def means(samples):
            result = torch.zeros(int(samples.mask.sum()), dtype=F64)
            return result.index_add_(0, samples.pixel, samples.weight * samples.normals[:, 2])

        brute = means(transport.sphere_normals(resolution, 64, rim=False))
        by_angle = means(transport.sphere_normals(resolution, 4))
        by_grid = means(transport.sphere_normals(resolution, 4, rim=False))
        assert (by_angle - brute).abs().max() < 0.012
        assert (by_angle - brute).square().mean() < (by_grid - brute).square().mean() / 2

    def test_rim_is_resolved(self):
        """The last degrees before the rim hold samples, where a regular grid has none."""
        assert transport.sphere_normals(64, 2).normals[:, 2].min() < math.sin(math.radians(1))
        assert transport.sphere_normals(64, 2, rim=False).normals[:, 2].min() > math.sin(math.radians(1))

    def test_dtype(self):
        samples = transport.sphere_normals(4, dtype=torch.float32)
        assert samples.normals.dtype == samples.weight.dtype == torch.float32

    @pytest.mark.parametrize(
        "arguments",
        [{"resolution": 0}, {"resolution": 4, "supersample": 0}],
    )
    def test_bad_sizes(self, arguments):
        with pytest.raises(ValueError, match="at least 1, got"):
            transport.sphere_normals(**arguments)


class TestKernels:
    def test_diffuse_golden(self):
        cosines = torch.tensor([1.0, 0.5, 0.0, -1.0], dtype=F64)
        expected = torch.tensor([0.5 / math.pi, 0.25 / math.pi, 0, 0], dtype=F64)
        torch.testing.assert_close(transport.diffuse_kernel(cosines, 0.5), expected, **EXACT)

    @given(unit, unit, unit, st.sampled_from([0.107, 0.25, 0.6, 1.0]))
    def test_ggx_against_the_textbook_form(self, n, light, view, alpha):
        """D G2 / (4 c_l c_v) c_l with D and Smith's Lambda as published, and an explicit half vector."""
        n, light, view = (np.asarray(x) for x in (n, light, view))
        c_l, c_v = n @ light, n @ view
        got = transport.ggx_kernel(
            *(torch.tensor(float(c), dtype=F64) for c in (c_l, c_v, light @ view)), alpha, 0.8
        ).item()
        if c_l <= 0:
            assert got == 0
            return
        if c_v <= 0.01:
            return  # faces away from the camera: never in a picture
        half = (light + view) / np.linalg.norm(light + view)
        c_h = n @ half
        distribution = alpha**2 / (math.pi * (c_h**2 * (alpha**2 - 1) + 1) ** 2)

        def smith(c):
            return (-1 + math.sqrt(1 + alpha**2 * (1 / c**2 - 1))) / 2

        expected = 0.8 * distribution / (1 + smith(c_l) + smith(c_v)) / (4 * c_v)
        assert got == pytest.approx(expected, rel=1e-8)

    @given(unit, unit, unit)
    def test_ggx_is_reciprocal(self, n, light, view):
        n, light, view = (torch.tensor(x, dtype=F64) for x in (n, light, view))
        c_l, c_v = n @ light, n @ view
        if min(c_l, c_v) <= 1e-3:
            return
        there = transport.ggx_kernel(c_l, c_v, light @ view) / c_l
        back = transport.ggx_kernel(c_v, c_l, light @ view) / c_v
        torch.testing.assert_close(there, back, rtol=1e-9, atol=0.0)

    @pytest.mark.parametrize(("alpha", "cos_view"), [(0.25, 1.0), (0.25, 0.3), (0.107, 0.8)])
    def test_ggx_furnace_against_sampled_microfacets(self, alpha, cos_view):
        """Reflected share of an all-white world, by shooting rays at facets drawn from the distribution."""
        random = np.random.default_rng(5)
        count = 200_000
        u, azimuth = random.random(count), 2 * math.pi * random.random(count)
        cos_h = np.sqrt((1 - u) / (1 + (alpha**2 - 1) * u))  # D cos, inverted
        sin_h = np.sqrt(1 - cos_h**2)
        half = np.stack([sin_h * np.cos(azimuth), sin_h * np.sin(azimuth), cos_h], -1)
        view = np.array([math.sqrt(1 - cos_view**2), 0, cos_view])
        v_h = half @ view
        c_l = 2 * v_h * cos_h - cos_view

        def smith(c):
            return (-1 + np.sqrt(1 + alpha**2 * (1 / np.maximum(c, 1e-9) ** 2 - 1))) / 2

        weight = np.where(
            (c_l > 0) & (v_h > 0), np.abs(v_h) / (cos_view * cos_h) / (1 + smith(c_l) + smith(cos_view)), 0
        )
        got = transport.ggx_matrix(
            torch.tensor([0.0, 0.0, 1.0], dtype=F64), torch.tensor(view), 64, alpha=alpha, colour=1.0
        ).sum()
        assert got.item() == pytest.approx(weight.mean(), abs=4 * weight.std() / math.sqrt(count) + 5e-4)

    def test_ggx_is_finite_at_grazing_angles(self):
        cosines = torch.tensor([0.0, 1e-12, 1e-6], dtype=torch.float32)
        values = transport.ggx_kernel(cosines[:, None], cosines[None, :], torch.tensor(-1.0))
        assert torch.isfinite(values).all()
        assert (values >= 0).all()

    def test_reflect(self):
        """The mirror's centre shows what is behind the photographer, its right edge what lies ahead."""
        normals = torch.tensor([[0.0, 0, 1], [math.sqrt(0.5), 0, math.sqrt(0.5)], [1, 0, 0]], dtype=F64)
        expected = torch.tensor([[0.0, 0, 1], [1, 0, 0], [0, 0, -1]], dtype=F64)
        torch.testing.assert_close(transport.reflect(normals, VIEW), expected, **EXACT)


class TestMirrorTaps:
    @given(st.integers(0, 10_000))
    def test_against_sampling(self, seed):
        generator = torch.Generator().manual_seed(seed)
        directions = torch.nn.functional.normalize(torch.randn(50, 3, dtype=F64, generator=generator), dim=-1)
        panorama = small_panorama(6)
        index, weight = transport.mirror_taps(directions, 6)
        got = (panorama.reshape(-1, 3)[index] * weight[..., None]).sum(-2)
        torch.testing.assert_close(got, equirect.sample(panorama, directions), rtol=1e-8, atol=1e-10)

    def test_poles_and_seam(self):
        directions = torch.tensor([[0.0, 1, 0], [0, -1, 0], [0, 0, 1], [1e-9, 1, 0]], dtype=F64)
        index, weight = transport.mirror_taps(directions, 4)
        assert index.min() >= 0
        assert index.max() < 32
        torch.testing.assert_close(weight.sum(-1), torch.ones(4, dtype=F64), **EXACT)
        assert {i // 8 for i in index[0].tolist()} == {0}
        assert {i % 8 for i in index[2].tolist()} == {0, 7}

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, shape):
        index, weight = transport.mirror_taps(VIEW.expand(*shape, 3), 4)
        assert index.shape == weight.shape == (*shape, 4)


class TestMatrices:
    def test_diffuse_entry_against_scipy(self):
        """Single texels, integrated adaptively."""
        normal = np.array([0.6, 0.0, 0.8])
        height, row = 8, 3

        def radiance(azimuth, polar):
            light = np.array(
                [math.sin(polar) * math.sin(azimuth), math.cos(polar), -math.sin(polar) * math.cos(azimuth)]
            )
            return max(light @ normal, 0) * math.sin(polar) * 0.5 / math.pi

        polar = [r * math.pi / height for r in (row, row + 1)]
        for c in (11, 14, 15):  # to the right; all that or only a part of the texel is seen
            azimuth = [(x / (2 * height) - 0.5) * 2 * math.pi for x in (c, c + 1)]
            expected, _ = scipy.integrate.dblquad(radiance, *polar, *azimuth, epsabs=1e-10)
            got = transport.diffuse_matrix(torch.tensor(normal), height, albedo=0.5, supersample=16)
            assert got.reshape(height, -1)[row, c].item() == pytest.approx(expected, rel=1e-3)

    @pytest.mark.parametrize("supersample", [1, 2, 3])
    def test_diffuse_furnace(self, supersample):
        normals = transport.sphere_normals(6, rim=False).normals
        shown = transport.diffuse_matrix(normals, 16, albedo=0.5, supersample=supersample).sum(-1)
        torch.testing.assert_close(shown, torch.full_like(shown, 0.5), rtol=3e-3, atol=0.0)

    @pytest.mark.parametrize("interpolation", ["linear", "nearest"])
    def test_mirror_furnace(self, interpolation):
        normals = transport.sphere_normals(6).normals
        shown = transport.mirror_matrix(normals, VIEW, 8, colour=0.7, interpolation=interpolation).sum(-1)
        torch.testing.assert_close(shown, torch.full_like(shown, 0.7), **EXACT)

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    @pytest.mark.parametrize("dtype", [torch.float32, F64])
    def test_leading_shapes_and_dtype(self, shape, dtype):
        normals = torch.tensor([0.6, 0.0, 0.8], dtype=dtype).expand(*shape, 3)
        view = VIEW.to(dtype)
        for matrix in (
            transport.diffuse_matrix(normals, 4),
            transport.ggx_matrix(normals, view, 4),
            transport.mirror_matrix(normals, view, 4),
        ):
            assert matrix.shape == (*shape, 32)
            assert matrix.dtype == dtype

    def test_bad_sizes(self):
        normal = torch.tensor([0.0, 0.0, 1.0])
        with pytest.raises(ValueError, match="even width"):
            transport.diffuse_matrix(normal, 4, 7)
        with pytest.raises(ValueError, match="even width"):
            transport.mirror_taps(normal, 0)
        with pytest.raises(ValueError, match="supersample"):
            transport.diffuse_matrix(normal, 4, supersample=0)
        with pytest.raises((ValueError, TypeCheckError), match="cubic"):
            transport.mirror_matrix(normal, normal, 4, interpolation="cubic")


class TestSphereMatrix:
    @pytest.mark.parametrize("material", MATERIALS, ids=lambda m: m.name)
    @pytest.mark.parametrize("resolution", [1, 5, 6])
    def test_mirrored_quarters_equal_the_whole(self, material, resolution):
        samples = transport.sphere_normals(resolution, 2)
        if material.kind == "diffuse":
            rows = transport.diffuse_matrix(samples.normals, 6, None, material.reflectance)
        elif material.kind == "ggx":
            rows = transport.ggx_matrix(samples.normals, VIEW, 6, None, material.alpha, material.reflectance)
        else:
            rows = transport.mirror_matrix(samples.normals, VIEW, 6, None, material.reflectance)
        expected = torch.zeros(int(samples.mask.sum()), 72, dtype=F64)
        expected.index_add_(0, samples.pixel, rows * samples.weight[:, None])
        got, mask = transport.sphere_matrix(material, resolution, 6, pixel_supersample=2, dtype=F64)
        assert torch.equal(mask, samples.mask)
        torch.testing.assert_close(got, expected, rtol=1e-8, atol=1e-10)

    @pytest.mark.parametrize(
        ("direction", "edge"),
        [((1, 0, 0), (4, 7)), ((0, 1, 0), (0, 4)), ((-1, 0, 0), (4, 0)), ((0, -1, 0), (7, 4))],
    )
    def test_a_light_brightens_its_own_side(self, direction, edge):
        directions = equirect.pixel_directions(16, dtype=F64)
        panorama = ((directions @ torch.tensor(direction, dtype=F64)) > 0.95).double()
        for material in MATERIALS[:2]:
            matrix, mask = transport.sphere_matrix(material, 8, 16, pixel_supersample=2, dtype=F64)
            picture = torch.zeros(8, 8, dtype=F64)
            picture[mask] = matrix @ panorama.flatten()
            opposite = tuple(7 - i for i in edge)
            assert picture[edge] > 5 * picture[opposite]

    def test_mirror_picture_keeps_the_mean(self):
        """Seen from afar, a mirror ball maps the sphere to the disc with areas kept."""
        samples = transport.sphere_normals(24, 24)
        panorama = small_panorama(8)
        rows = transport.mirror_matrix(samples.normals, VIEW, 8, colour=1.0, interpolation="nearest")
        pixels = torch.zeros(int(samples.mask.sum()), 3, dtype=F64)
        pixels.index_add_(0, samples.pixel, (rows @ panorama.reshape(-1, 3)) * samples.weight[:, None])
        # Pixels at the rim count by the part of them that lies on the disc, known to within the samples.
        position = (2 * torch.arange(24 * 32) + 1) / (24 * 32) - 1
        inside = (torch.hypot(position, position[:, None]) < 1).double()
        cover = inside.reshape(24, 32, 24, 32).mean((1, 3))[samples.mask][:, None]
        got = (pixels * cover).sum(0) / cover.sum()
        expected = equirect.integrate(panorama) / (4 * math.pi)
        torch.testing.assert_close(got, expected, rtol=0.02, atol=0.0)

    def test_rougher_metal_is_blurrier(self):
        directions = equirect.pixel_directions(16, dtype=F64)
        panorama = (directions[..., 2] > 0.95).double().flatten()
        peaks = []
        for alpha in (0.15, 0.3, 0.6):
            matrix, _ = transport.sphere_matrix(Material("m", "ggx", 1.0, alpha), 8, 16, dtype=F64)
            peaks.append((matrix @ panorama).max().item())
        assert peaks == sorted(peaks, reverse=True)
