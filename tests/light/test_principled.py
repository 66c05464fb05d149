"""Blender's metal and paint: energy, limits, and agreement with formulas written another way."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light.principled import (
    dielectric,
    metal_kernel,
    paint_kernel,
    schlick,
    single_bounce_albedo,
)
from mixlight.light.reflection import MATERIALS, Material, diffuse_kernel, ggx_kernel
from mixlight.light.surfaces import PRINCIPLED, kernel, mirror_reflectance
from tests.render import plain_spheres

F64 = torch.float64
DIFFUSE, MATTE, MIRROR = PRINCIPLED


def geometry(cos_view: float, height: int = 256) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """n.l and l.v of all directions of a grid, and the grid's solid angles; the normal is +Y."""
    lights, angles = plain_spheres.texels(height)
    view = np.array([math.sqrt(1 - cos_view**2), cos_view, 0.0])
    return (
        torch.from_numpy(lights[:, 1].copy()),
        torch.from_numpy(lights @ view),
        torch.from_numpy(angles.copy()),
    )


def shown(material: Material, cos_view: float) -> float:
    """Under radiance 1 from everywhere."""
    cos_light, light_dot_view, angles = geometry(cos_view)
    values = kernel(material, cos_light, torch.tensor(cos_view, dtype=F64), light_dot_view)
    return (values * angles).sum().item()


class TestGolden:
    def test_fresnel(self):
        assert dielectric(torch.tensor(1.0, dtype=F64), 1.5).item() == pytest.approx(0.04)
        assert dielectric(torch.tensor(0.0, dtype=F64), 1.5).item() == pytest.approx(1)
        # Brewster's angle: only one polarisation is reflected, sin²(2 b) ... by half.
        brewster = math.atan(1.5)
        expected = (math.sin(2 * brewster - math.pi / 2) ** 2) / 2
        assert dielectric(torch.tensor(math.cos(brewster), dtype=F64), 1.5).item() == pytest.approx(expected)
        assert schlick(torch.tensor([1.0, 0.0]), 0.8).tolist() == pytest.approx([0.8, 1])

    def test_white_furnace(self):
        """What a sphere of paint and one of metal show under radiance 1, face on."""
        assert shown(DIFFUSE, 1.0) == pytest.approx(0.8079, abs=2e-4)
        assert shown(MATTE, 1.0) == pytest.approx(0.7977, abs=1e-3)

    def test_materials_of_protocol_s(self):
        assert [m.name for m in PRINCIPLED] == ["diffuse", "matte", "mirror"]
        assert [m.reflectance for m in PRINCIPLED] == [0.8] * 3
        assert [m.is_mirror for m in PRINCIPLED] == [False, False, True]
        assert DIFFUSE.alpha == pytest.approx(0.132496)
        assert MATTE.alpha == pytest.approx(0.10699441)


class TestProperties:
    @given(st.floats(0.2, 1), st.floats(0.2, 0.8))  # what the grid of directions resolves
    def test_white_metal_shows_all_light(self, cos_view, alpha):
        """What is lost to further bounces is put back: reflectance 1 gives 1 from every side."""
        cos_light, light_dot_view, angles = geometry(cos_view, 160)
        view = torch.tensor(cos_view, dtype=F64)
        total = (metal_kernel(cos_light, view, light_dot_view, alpha, 1.0) * angles).sum().item()
        assert total == pytest.approx(1, abs=3e-3)

    @given(st.floats(0.2, 1), st.floats(0.2, 0.8))  # what the grid of directions resolves
    def test_white_paint_shows_all_light(self, cos_view, alpha):
        """The coat takes from the ground what it reflects itself."""
        cos_light, light_dot_view, angles = geometry(cos_view, 160)
        view = torch.tensor(cos_view, dtype=F64)
        total = (paint_kernel(cos_light, view, light_dot_view, alpha, 1.0, 1.5) * angles).sum().item()
        assert total == pytest.approx(1, abs=3e-3)

    @given(st.floats(0, 1), st.floats(0, 1), st.floats(-1, 1))
    def test_finite_and_not_negative(self, cos_light, cos_view, light_dot_view):
        for material in (DIFFUSE, MATTE):
            value = kernel(material, *(torch.tensor(x) for x in (cos_light, cos_view, light_dot_view)))
            assert value.isfinite()
            assert value >= 0

    def test_light_from_below_gives_nothing(self):
        below, view = torch.tensor([-0.5, -1e-6]), torch.tensor(0.7)
        for material in (DIFFUSE, MATTE):
            assert (kernel(material, below, view, torch.tensor([0.2, 0.5])) == 0).all()

    def test_index_one_is_no_coat(self):
        """A coat of air: nothing but the ground."""
        cos_light = torch.tensor([0.2, 0.9], dtype=F64)
        got = paint_kernel(
            cos_light, torch.tensor(0.6, dtype=F64), torch.tensor(0.3, dtype=F64), 0.2, 0.5, 1.0
        )
        torch.testing.assert_close(got, diffuse_kernel(cos_light, 0.5))


class TestReference:
    @pytest.mark.parametrize("alpha", [0.107, 0.1325, 0.5])
    @pytest.mark.parametrize("cos_view", [0.1, 0.4, 0.8, 1.0])
    def test_single_bounce_against_the_hemisphere(self, alpha, cos_view):
        """The integral over light directions of the kernel itself."""
        cos_light, light_dot_view, angles = geometry(cos_view)
        view = torch.tensor(cos_view, dtype=F64)
        single = ggx_kernel(cos_light, view, light_dot_view, alpha, 1.0) * angles
        assert single_bounce_albedo(view, alpha).item() == pytest.approx(single.sum().item(), abs=1e-3)
        half = ((1 + light_dot_view) / 2).sqrt()
        coat = (single * dielectric(half, 1.5)).sum().item()
        assert single_bounce_albedo(view, alpha, 1.5).item() == pytest.approx(coat, abs=1e-3)

    @pytest.mark.parametrize(("material", "roughness"), [(DIFFUSE, 0.364), (MATTE, 0.3271)])
    @pytest.mark.parametrize("cos_view", [0.15, 0.5, 0.95])
    def test_kernel_against_the_plain_one(self, material, roughness, cos_view):
        plain = plain_spheres.Surface(material.kind == "metal", roughness)
        lights, _ = plain_spheres.texels(16)
        normal, view = np.array([0.0, 1.0, 0.0]), np.array([math.sqrt(1 - cos_view**2), cos_view, 0.0])
        expected = plain.kernel(lights, view, normal)
        got = kernel(
            material,
            torch.from_numpy(lights @ normal),
            torch.tensor(cos_view, dtype=F64),
            torch.from_numpy(lights @ view),
        )
        np.testing.assert_allclose(got.numpy(), expected, rtol=2e-3, atol=2e-4)


class TestSurfaces:
    def test_the_plain_materials(self):
        angles = torch.tensor(0.5), torch.tensor(0.9), torch.tensor(0.2)
        assert kernel(MATERIALS[0], *angles) == diffuse_kernel(angles[0])
        assert kernel(MATERIALS[1], *angles) == ggx_kernel(*angles)
        assert mirror_reflectance(MATERIALS[2], torch.tensor([0.1, 1.0])).tolist() == pytest.approx(
            [0.8, 0.8]
        )
        assert mirror_reflectance(MIRROR, torch.tensor([0.0, 1.0])).tolist() == pytest.approx([1, 0.8])

    def test_mirrors_and_others_are_told_apart(self):
        one = torch.tensor(1.0)
        with pytest.raises(ValueError, match="expected a diffuse or rough material"):
            kernel(MIRROR, one, one, one)
        with pytest.raises(ValueError, match="expected a mirror"):
            mirror_reflectance(MATTE, one)
