"""The sphere renderer: orientation, energy, and agreement with dense quadrature."""

import math

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mixlight.light.transport import (
    MATERIALS,
    VIEW,
    Material,
    diffuse_kernel,
    diffuse_matrix,
    ggx_kernel,
    ggx_matrix,
    sphere_matrix,
    sphere_normals,
)
from mixlight.render.rings import RingTransport
from mixlight.render.spheres import SphereRenderer, render_spheres
from mixlight.sphere import equirect
from tests.tolerances import TOLERANCE

SIZE, HEIGHT = 24, 32


@pytest.fixture(scope="module")
def renderer() -> SphereRenderer:
    return SphereRenderer(SIZE, HEIGHT)


def room(seed: int, *shape: int, height: int = HEIGHT) -> torch.Tensor:
    """Dim walls and a few small sources, hundreds of times brighter."""
    generator = torch.Generator().manual_seed(seed)
    x = torch.rand(*shape, height, 2 * height, 3, generator=generator)
    return 0.2 + 0.5 * x + 300 * (x > 0.998)


def light_from(*direction: float) -> torch.Tensor:
    """A disc of light, 12° across, in an otherwise black world."""
    towards = torch.nn.functional.normalize(torch.tensor(direction).float(), dim=-1)
    cosine = equirect.pixel_directions(HEIGHT) @ towards
    return (cosine > math.cos(math.radians(6))).float()[..., None].expand(-1, -1, 3)


def relative(got: torch.Tensor, expected: torch.Tensor) -> float:
    return ((got - expected).square().mean().sqrt() / expected.square().mean().sqrt()).item()


class TestGolden:
    def test_white_furnace(self, renderer):
        pictures = renderer.render(torch.ones(HEIGHT, 2 * HEIGHT, 3))
        shown = pictures[:, renderer.mask]
        torch.testing.assert_close(shown[0], torch.full_like(shown[0], 0.8), rtol=2e-3, atol=0.0)
        torch.testing.assert_close(shown[2], torch.full_like(shown[2], 0.8), **TOLERANCE[torch.float32])
        assert shown[1].max() < 0.8
        assert pictures[1, SIZE // 2, SIZE // 2, 0].item() == pytest.approx(0.789, abs=1e-3)
        assert (pictures[:, ~renderer.mask] == 0).all()

    def test_a_lamp_overhead(self, renderer):
        """Irradiance of a lamp of known power: albedo v cos / pi on the diffuse sphere."""
        lamp = light_from(0, 1, 0)
        power = equirect.integrate(lamp)[0].item()
        row = 3
        normal_y = 1 - (2 * row + 1) / SIZE
        shown = renderer.render(lamp)[0, row, SIZE // 2, 0].item()
        assert shown == pytest.approx(0.8 / math.pi * power * normal_y, rel=0.02)

    def test_mask(self):
        mask = SphereRenderer(4, 8, MATERIALS[:1]).mask
        assert mask.tolist() == [
            [False, True, True, False],
            [True, True, True, True],
            [True, True, True, True],
            [False, True, True, False],
        ]


class TestOrientation:
    """An object put into the photo, lit by what stands around it."""

    @pytest.mark.parametrize(
        ("direction", "row", "column"),
        [((1, 0, 0), 0, 1), ((-1, 0, 0), 0, -1), ((0, 1, 0), -1, 0), ((0, -1, 0), 1, 0), ((0, 0, 1), 0, 0)],
    )
    def test_side_that_is_lit(self, renderer, direction, row, column):
        picture = renderer.render(light_from(*direction))[0, ..., 0]
        position = (2 * torch.arange(SIZE) + 1) / SIZE - 1
        x = (picture.sum(0) * position).sum() / picture.sum()
        y = (picture.sum(1) * position).sum() / picture.sum()
        assert (round(x.item() * 2), round(y.item() * 2)) == (column, row)

    @pytest.mark.parametrize(
        ("direction", "x", "y"), [((0, 0, 1), 0.0, 0.0), ((1, 0, 0), 0.5**0.5, 0.0), ((0, 1, 1), 0.0, 0.3827)]
    )
    def test_place_of_a_highlight(self, renderer, direction, x, y):
        """The normal half-way between light and camera; behind the photographer is in the middle."""
        for picture in renderer.render(light_from(*direction))[1:, ..., 0]:
            position = (2 * torch.arange(SIZE) + 1) / SIZE - 1
            at_x = (picture.sum(0) * position).sum() / picture.sum()
            at_y = -(picture.sum(1) * position).sum() / picture.sum()
            assert at_x.item() == pytest.approx(x, abs=0.06)
            assert at_y.item() == pytest.approx(y, abs=0.06)

    @settings(max_examples=5)
    @given(st.integers(0, 1000))
    def test_mirrored_rooms(self, renderer, seed):
        """Left and right, top and bottom change places in the map as in the picture."""
        environment = room(seed)
        picture = renderer.render(environment)
        for map_axis, picture_axis in ((1, 2), (0, 1)):
            got = renderer.render(environment.flip(map_axis)).flip(picture_axis)
            torch.testing.assert_close(got, picture, rtol=1e-3, atol=1e-3)

    def test_turned_about_the_view_axis(self, renderer):
        """A room that is rolled by 90° gives pictures rolled by 90°."""
        environment = equirect.resize(room(1, height=4), HEIGHT)  # broad patches, for the roll interpolates
        quarter = torch.tensor([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # +X goes to +Y
        rolled = renderer.render(equirect.rotate(environment, quarter, supersample=4))
        expected = renderer.render(environment).rot90(1, (1, 2))
        assert relative(rolled[0], expected[0]) < 0.01
        assert relative(rolled[1], expected[1]) < 0.03


class TestReference:
    @pytest.mark.parametrize("index", [0, 1])
    @pytest.mark.parametrize("place", [(5, 5), (3, 7), (9, 2), (0, 4)])
    def test_pixels_against_dense_quadrature(self, index, place):
        """A pixel in the middle, two farther out, one at the rim: 400 points of it, 36 of each texel."""
        resolution, height = 12, 16
        environment = room(2, 2, height=height)
        samples = sphere_normals(resolution, 20)
        pixel = samples.mask[: place[0]].sum() + samples.mask[place[0], : place[1]].sum()
        here = samples.pixel == pixel
        if index == 0:
            rows = diffuse_matrix(samples.normals[here], height, supersample=6)
        else:
            view = torch.tensor(VIEW, dtype=torch.float64)
            rows = ggx_matrix(samples.normals[here], view, height, supersample=6)
        expected = (samples.weight[here] @ rows).float() @ environment.reshape(2, -1, 3)
        got = SphereRenderer(resolution, 128, MATERIALS[index : index + 1]).render(environment)
        assert relative(got[:, 0, *place], expected) < (1e-3, 5e-3)[index]

    @pytest.mark.parametrize("direction", [(1.0, 0.2, 0.3), (-0.4, 0.8, 0.9), (0.5, -0.6, -0.4)])
    def test_a_far_lamp_against_the_kernel(self, direction):
        """One texel of a fine map is a point light: the picture is the kernel itself."""
        column, row = (equirect.directions_to_uv(torch.tensor(direction)) * torch.tensor([256, 128])).long()
        lamp = torch.zeros(128, 256, 1)
        lamp[row, column] = 1
        towards = equirect.pixel_directions(128, dtype=torch.float64)[row, column]
        power = equirect.solid_angle(128, dtype=torch.float64)[row, column]
        samples = sphere_normals(32, 8)
        view = torch.tensor(VIEW, dtype=torch.float64)
        cos_light, cos_view = samples.normals @ towards, samples.normals @ view
        got = SphereRenderer(32, 128, MATERIALS[:2]).render(lamp)[:, samples.mask, 0]
        for picture, values in zip(
            got,
            (diffuse_kernel(cos_light), ggx_kernel(cos_light, cos_view, towards @ view)),
            strict=True,
        ):
            expected = torch.zeros(len(picture), dtype=torch.float64)
            expected.index_add_(0, samples.pixel, values * samples.weight * power)
            assert relative(picture, expected) < 5e-3
            assert picture.sum().item() == pytest.approx(expected.sum().item(), rel=2e-3)

    @pytest.mark.parametrize("index", [0, 1])
    def test_pictures_against_the_matrix(self, index):
        """The plain form of the same operator; what differs is how finely it samples."""
        environment = room(12, height=16)
        matrix, mask = sphere_matrix(MATERIALS[index], SIZE, 16)
        got = SphereRenderer(SIZE, 128, MATERIALS[index : index + 1]).render(environment)[0, mask]
        expected = matrix @ environment.reshape(-1, 3)
        assert relative(got, expected) < (2e-3, 4e-2)[index]
        torch.testing.assert_close(got.mean(0), expected.mean(0), rtol=2e-3, atol=0.0)

    def test_mirror_against_looking(self):
        """A mirror's pixel is the mean of what its samples see."""
        environment = equirect.resize(room(3, height=8), HEIGHT)
        matrix, mask = sphere_matrix(MATERIALS[2], 12, HEIGHT, pixel_supersample=43)
        got = SphereRenderer(12, HEIGHT, MATERIALS[2:]).render(environment)[0, mask]
        torch.testing.assert_close(got, matrix @ environment.reshape(-1, 3), rtol=1e-3, atol=1e-3)

    def test_small_pictures_are_means_of_large_ones(self, renderer):
        environment = room(4)
        large = SphereRenderer(4 * SIZE, HEIGHT)
        fine = large.render(environment)
        weight = large.mask.float().reshape(SIZE, 4, SIZE, 4).mean((1, 3))
        mean = fine.reshape(3, SIZE, 4, SIZE, 4, 3).mean((2, 4)) / weight.clamp(min=1e-6)[..., None]
        whole = weight == 1
        coarse = renderer.render(environment)
        assert relative(mean[0][whole], coarse[0][whole]) < 2e-3
        assert relative(mean[1][whole], coarse[1][whole]) < 1e-2


class TestProperties:
    @settings(max_examples=5)
    @given(st.integers(0, 1000), st.floats(0.01, 100))
    def test_linear_and_positive(self, renderer, seed, factor):
        a, b = room(seed), room(seed + 1)
        both = renderer.render(torch.stack([a, b, factor * a + b]))
        torch.testing.assert_close(both[2], factor * both[0] + both[1], rtol=1e-3, atol=1e-4 * (1 + factor))
        assert both.min() >= 0

    @settings(max_examples=5)
    @given(st.integers(0, 1000))
    def test_a_mirror_ball_shows_the_whole_room(self, seed):
        """From afar it maps the sphere to the disc with areas kept."""
        environment = room(seed)
        fine = SphereRenderer(64, HEIGHT, MATERIALS[2:])
        got = fine.render(environment)[0, fine.mask].mean(0)
        expected = 0.8 * equirect.integrate(environment) / (4 * math.pi)
        torch.testing.assert_close(got, expected, rtol=0.06, atol=0.0)

    def test_the_rim_of_a_mirror_is_sampled_finely(self):
        """Lamps behind the sphere show in the rim alone; with few steps a pixel most of them are missed."""
        usual, coarse, exact = (
            SphereRenderer(64, 128, MATERIALS[2:], rim_step=step) for step in (None, math.inf, 0.0015)
        )
        lamps = torch.full((8, 128, 256, 3), 0.1)
        for k in range(8):
            lamps[k, 60 + k, 8 * k] = 500.0  # about +Z, which the camera at +Z cannot see directly
            lamps[k, 60 + k, 128 + 4 * k] = 500.0
        mirrors = [renderer.render(lamps)[:, 0].clamp(max=1) for renderer in (usual, coarse, exact)]
        errors = [(picture - mirrors[2]).square().mean().sqrt() for picture in mirrors[:2]]
        assert errors[0] < 0.5 * errors[1]
        assert usual.rim_step == pytest.approx(math.pi / 512)
        assert SphereRenderer(4, 32, MATERIALS[2:]).rim_step == pytest.approx(math.pi / 128)

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes(self, renderer, shape):
        environment = room(5, *shape)
        pictures = renderer.render(environment)
        assert pictures.shape == (*shape, 3, SIZE, SIZE, 3)
        one = renderer.render(environment.reshape(-1, HEIGHT, 2 * HEIGHT, 3)[-1])
        torch.testing.assert_close(pictures.reshape(-1, 3, SIZE, SIZE, 3)[-1], one, rtol=1e-4, atol=1e-4)

    @pytest.mark.parametrize("channels", [1, 4])
    def test_any_number_of_channels(self, renderer, channels):
        environment = room(6)[..., :1]
        got = renderer.render(environment.expand(-1, -1, channels))
        expected = renderer.render(environment).expand(-1, -1, -1, channels)
        torch.testing.assert_close(got, expected, rtol=1e-4, atol=1e-4)

    def test_other_sizes_are_resized_with_their_energy(self, renderer):
        environment = room(7, height=2 * HEIGHT)
        got = renderer.render(environment)
        torch.testing.assert_close(got, renderer.render(equirect.resize(environment, HEIGHT)))

    @pytest.mark.parametrize("dtype", [torch.float16, torch.float64])
    def test_dtype_follows_the_map(self, renderer, dtype):
        environment = room(8)
        got = renderer.render(environment.to(dtype))
        assert got.dtype == dtype
        torch.testing.assert_close(got.float(), renderer.render(environment), rtol=5e-3, atol=5e-3)

    def test_autocast_keeps_float32(self, renderer):
        environment = room(9)
        expected = renderer.render(environment)
        with torch.autocast("cpu", torch.bfloat16):
            torch.testing.assert_close(renderer.render(environment), expected)

    def test_gradcheck(self):
        small = SphereRenderer(2, 4)
        environment = torch.rand(4, 8, 1, dtype=torch.float64, requires_grad=True)
        assert torch.autograd.gradcheck(small, (environment,), fast_mode=True)

    def test_materials_in_any_order(self, renderer):
        swapped = SphereRenderer(SIZE, HEIGHT, (MATERIALS[2], MATERIALS[0], Material("c", "mirror", 0.4)))
        environment = room(10)
        diffuse, _, mirror = renderer.render(environment)
        got = swapped.render(environment)
        torch.testing.assert_close(got[1], diffuse, rtol=1e-4, atol=1e-4)
        torch.testing.assert_close(got[0], mirror, rtol=1e-4, atol=1e-4)
        torch.testing.assert_close(got[2], mirror / 2, rtol=1e-4, atol=1e-4)

    @pytest.mark.parametrize("resolution", [1, 2, 7])
    def test_small_and_odd_pictures(self, resolution):
        pictures, mask = render_spheres(torch.ones(8, 16, 3), resolution)
        assert mask.any()
        torch.testing.assert_close(
            pictures[0][mask], torch.full_like(pictures[0][mask], 0.8), rtol=2e-3, atol=0.0
        )


class TestBadInput:
    def test_maps(self, renderer):
        with pytest.raises(ValueError, match=r"\[..., H, 2 H, channels\], got \(32, 96, 3\)"):
            renderer.render(torch.ones(32, 96, 3))

    @pytest.mark.parametrize("sizes", [(0, 8), (8, 0)])
    def test_sizes(self, sizes):
        with pytest.raises(ValueError, match="at least"):
            SphereRenderer(*sizes)

    def test_materials_that_the_method_cannot_do(self):
        with pytest.raises(ValueError, match=r"alpha of at least 0.1, got 0.05"):
            SphereRenderer(8, 8, [Material("glossy", "ggx", 0.8, alpha=0.05)])
        with pytest.raises(ValueError, match="diffuse or ggx material"):
            RingTransport([MATERIALS[2]], sphere_normals(4), 8)
