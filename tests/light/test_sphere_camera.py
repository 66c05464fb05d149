"""The camera that looks at a sphere: angles, places and samples, against rays that are shot."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.sphere_samples import picture_samples, sphere_normals
from tests.render import plain_spheres
from tests.tolerances import TOLERANCE

F64 = torch.float64
EXACT = TOLERANCE[F64]


def protocol_s(width: int, height: int) -> SphereCamera:
    return SphereCamera.perspective((16, 2, 0), 85, 36, width, height)


class TestGolden:
    def test_protocol_s(self):
        """tan of the outline's angle is 1 / sqrt(260 - 1); the focal length is 85 / 36 * 960 pixels."""
        camera = protocol_s(960, 540)
        assert camera.distance == pytest.approx(math.sqrt(260))
        assert camera.radius == pytest.approx(85 / 36 * 960 / math.sqrt(259))
        assert camera.fov_x == pytest.approx(2 * math.atan(18 / 85))
        right, up, towards = camera.axes
        assert right.tolist() == pytest.approx([0, 0, -1])
        assert up.tolist() == pytest.approx([-2 / math.sqrt(260), 16 / math.sqrt(260), 0])
        assert towards.tolist() == pytest.approx([16 / math.sqrt(260), 2 / math.sqrt(260), 0])

    def test_from_afar(self):
        camera = SphereCamera.orthographic(8)
        torch.testing.assert_close(camera.axes, torch.eye(3, dtype=F64), rtol=0, atol=0)
        assert camera.fov_x is None
        angle = torch.tensor([0.0, 0.5, 1.5], dtype=F64)
        torch.testing.assert_close(camera.lean(angle), angle, rtol=0, atol=0)
        torch.testing.assert_close(camera.place(angle), angle.sin(), rtol=0, atol=0)

    def test_the_rim(self):
        """At grazing incidence the normal leans by acos(1 / D), and the ray by the rest of a right angle."""
        camera = SphereCamera.perspective((0, 0, 2), 1, 1, 8, 8)
        grazing = torch.tensor(math.pi / 2, dtype=F64)
        assert camera.lean(grazing).item() == pytest.approx(math.pi / 3)
        assert camera.sight(grazing).item() == pytest.approx(math.pi / 6)
        assert camera.place(grazing).item() == pytest.approx(1)


class TestProperties:
    @given(st.floats(1.01, 1e4), st.floats(0, 1.57))
    def test_inverses(self, distance, angle):
        camera = SphereCamera(8, 8, (0.0, 0.0, 1.0), distance, 4.0)
        incidence = torch.tensor(angle, dtype=F64)
        assert camera.incidence(camera.lean(incidence)).item() == pytest.approx(angle, abs=1e-7)
        # Near the rim the place hardly changes with the angle.
        assert camera.incidence_at(camera.place(incidence)).item() == pytest.approx(angle, abs=1e-5)

    @given(st.floats(1.05, 1e3), st.floats(0.01, 1.5))
    def test_area_is_the_derivative_of_half_the_square(self, distance, angle):
        camera = SphereCamera(8, 8, (0.0, 0.0, 1.0), distance, 4.0)
        low, middle, high = (torch.tensor(angle + d, dtype=F64) for d in (-1e-5, 0, 1e-5))
        slope = (camera.place(high) ** 2 - camera.place(low) ** 2) / 4e-5
        assert camera.area(middle).item() == pytest.approx(slope.item(), rel=1e-5, abs=1e-8)

    @pytest.mark.parametrize("camera", [protocol_s(96, 54), SphereCamera.orthographic(9)])
    def test_samples_of_a_pixel_weigh_one(self, camera):
        samples = picture_samples(camera, 3)
        totals = torch.zeros(int(samples.mask.sum()), dtype=F64).index_add_(0, samples.pixel, samples.weight)
        torch.testing.assert_close(totals, torch.ones_like(totals), **EXACT)
        views = camera.views(samples.normals)
        assert ((views * samples.normals).sum(-1) > -1e-9).all()
        torch.testing.assert_close(views.norm(dim=-1), torch.ones(len(views), dtype=F64), **EXACT)

    def test_far_away_is_orthographic(self):
        far = SphereCamera.perspective((0, 0, 1e6), 1, 2 / 1e6, 16, 16)
        assert far.radius == pytest.approx(8)
        got, expected = picture_samples(far, 2), sphere_normals(16, 2)
        torch.testing.assert_close(got.normals, expected.normals, rtol=0, atol=1e-3)
        torch.testing.assert_close(got.weight, expected.weight, rtol=0, atol=1e-4)


class TestReference:
    def test_normals_and_views_against_rays(self):
        camera = protocol_s(96, 54)
        normals, views, hit = plain_spheres.points(96, 54)
        samples = picture_samples(camera, rim=False)
        assert (samples.mask.numpy() == hit).all()
        np.testing.assert_allclose(samples.normals.numpy(), normals, atol=1e-10)
        np.testing.assert_allclose(camera.views(samples.normals).numpy(), views, atol=1e-10)

    def test_samples_lie_in_their_pixels(self):
        """Each sample, projected as a pinhole camera projects points."""
        camera = protocol_s(96, 54)
        samples = picture_samples(camera, 3)
        position = torch.tensor([16.0, 2.0, 0.0], dtype=F64)
        x, y, z = ((samples.normals - position) @ camera.axes.T).unbind(-1)
        column, row = 48 - x / z * 85 / 36 * 96, 27 + y / z * 85 / 36 * 96
        i, j = samples.mask.nonzero(as_tuple=True)
        for place, first in ((column, j), (row, i)):
            inside = place - first[samples.pixel]
            assert inside.min() > -1e-9
            assert inside.max() < 1 + 1e-9

    def test_rim_step(self):
        """Neighbours in a rim pixel are no farther apart than asked; inner pixels stay as they are."""
        camera = SphereCamera.orthographic(16)
        fine, coarse = (picture_samples(camera, 2, rim_step=step) for step in (0.005, math.inf))
        for samples in (fine, coarse):
            totals = torch.zeros(int(samples.mask.sum()), dtype=F64)
            totals.index_add_(0, samples.pixel, samples.weight)
            torch.testing.assert_close(totals, torch.ones_like(totals), **EXACT)
        widest = 0.0
        for pixel in fine.pixel.unique():
            here = fine.pixel == pixel
            count = int(here.sum())
            if count == int((coarse.pixel == pixel).sum()) and count < 40:
                continue
            angles = torch.acos(fine.normals[here, 2]).sort().values
            widest = max(widest, float(angles.diff().max()))
        assert 0.001 < widest < 0.0051
        assert len(coarse.normals) < len(fine.normals)

    def test_cropped_and_scaled(self):
        """The pixels of the cut picture are those of the whole; a scaled one has the same mean normal."""
        whole = protocol_s(96, 54)
        cut = whole.cropped()
        assert (cut.width, cut.height) == (30, 30)
        inner = picture_samples(cut, rim=False)
        torch.testing.assert_close(inner.normals, picture_samples(whole, rim=False).normals, **EXACT)
        assert whole.scaled(2) == protocol_s(192, 108)
        odd = SphereCamera(9, 7, (0.0, 0.0, 1.0), math.inf, 2.2).cropped()
        assert (odd.width, odd.height) == (5, 5)


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "match"),
        [
            ((0, 8, (0.0, 0.0, 1.0), 2.0, 4.0), "at least one pixel"),
            ((8, 8, (0.0, 0.0, 1.0), 2.0, math.nan), "outline"),
            ((8, 8, (0.0, 0.0, 1.0), 1.0, 4.0), r"outside the sphere of radius 1, got 1.0"),
            ((8, 8, (0.0, 0.0, 2.0), 2.0, 4.0), "unit vector"),
            ((8, 8, (0.0, 1.0, 0.0), 2.0, 4.0), "not vertical"),
        ],
    )
    def test_cameras(self, arguments, match):
        with pytest.raises(ValueError, match=match):
            SphereCamera(*arguments)

    def test_perspective(self):
        with pytest.raises(ValueError, match="outside the sphere"):
            SphereCamera.perspective((0, 0, 0.5), 85, 36, 8, 8)
        with pytest.raises(ValueError, match="focal length"):
            SphereCamera.perspective((0, 0, 2), 0, 36, 8, 8)

    def test_scaled(self):
        with pytest.raises(ValueError, match="keeps 960 x 540 pixels whole"):
            protocol_s(960, 540).scaled(0.31)

    def test_sampling(self):
        with pytest.raises(ValueError, match="rim_step above 0, got 0"):
            picture_samples(SphereCamera.orthographic(4), rim_step=0)
        with pytest.raises(ValueError, match="supersample of at least 1, got 0"):
            picture_samples(SphereCamera.orthographic(4), 0)
