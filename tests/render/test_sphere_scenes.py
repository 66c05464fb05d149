"""Spheres seen by a camera at a finite distance, and tables that are kept on disk."""

from pathlib import Path

import numpy as np
import pytest
import torch

from mixlight.light.reflection import MATERIALS, Material
from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.surfaces import PRINCIPLED
from mixlight.render import spheres
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect
from tests.render import plain_spheres

WIDTH, FRAME_HEIGHT, HEIGHT = 480, 270, 32
CAMERA = SphereCamera.perspective((16, 2, 0), 85, 36, WIDTH, FRAME_HEIGHT)


@pytest.fixture(scope="module")
def renderer() -> SphereRenderer:
    return SphereRenderer(height=HEIGHT, materials=PRINCIPLED, camera=CAMERA, interpolation="linear")


def room(seed: int, *shape: int, height: int = HEIGHT) -> torch.Tensor:
    """Dim walls and a few sources, dozens of times brighter."""
    generator = torch.Generator().manual_seed(seed)
    x = torch.rand(*shape, height, 2 * height, 3, generator=generator)
    return 0.2 + 0.5 * x + 30 * (x > 0.998)


def bilinear(environment: torch.Tensor, height: int) -> np.ndarray:
    """A map read between its texels, as a finer map."""
    return equirect.sample(environment, equirect.pixel_directions(height)).double().numpy()


class TestProtocolS:
    @pytest.fixture(scope="class")
    @staticmethod
    def points() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        normals, views, hit = plain_spheres.points(WIDTH, FRAME_HEIGHT)
        chosen = np.random.default_rng(0).choice(len(normals), 60, replace=False)
        return normals[chosen], views[chosen], hit, chosen

    @pytest.mark.parametrize(("index", "roughness"), [(0, 0.364), (1, 0.3271)])
    def test_rough_spheres_against_the_loop(self, renderer, points, index, roughness):
        normals, views, hit, chosen = points
        environment = room(index)
        surface = plain_spheres.Surface(PRINCIPLED[index].kind == "metal", roughness)
        expected = plain_spheres.rough(bilinear(environment, 96), normals, views, surface)
        picture = renderer.render(environment)[index].double().numpy()
        got = picture[hit][chosen]
        assert (picture[~hit] == 0).all()
        assert np.sqrt(((got - expected) ** 2).mean()) < (2e-3, 1e-2)[index] * expected.mean()
        assert got.mean() == pytest.approx(expected.mean(), rel=2e-3)

    def test_mirror_against_the_loop(self, renderer, points):
        normals, views, hit, chosen = points
        environment = equirect.resize(room(3, height=8), HEIGHT)
        expected = plain_spheres.mirror(environment.double().numpy(), normals, views)
        got = renderer.render(environment)[2].double().numpy()[hit][chosen]
        # The loop looks at a pixel's centre, the renderer at all of it: they differ where a pixel shows much.
        inner = (normals * views).sum(-1) > 0.4
        assert inner.mean() > 0.5
        assert np.sqrt(((got - expected)[inner] ** 2).mean()) < 0.02 * expected[inner].mean()
        assert got[inner].mean() == pytest.approx(expected[inner].mean(), rel=3e-3)

    def test_furnace(self, renderer):
        """What Blender 5.0 shows: .8143, .8023 and .8097, the mean over the disc at 1024 samples."""
        pictures = renderer.render(torch.ones(HEIGHT, 2 * HEIGHT, 3))[:, renderer.mask]
        means = pictures.mean((1, 2)).tolist()
        assert means == pytest.approx([0.8143, 0.8023, 0.8097], rel=1e-3)

    def test_the_camera_stands_to_the_right(self, renderer):
        """Light from +X, where the camera is, lies in the middle; light from -Z on the picture's right."""
        for direction, place in (((1.0, 0.0, 0.0), 0.0), ((0.0, 0.0, -1.0), 0.5), ((0.0, 0.0, 1.0), -0.5)):
            towards = equirect.pixel_directions(HEIGHT) @ torch.tensor(direction)
            lamp = (towards > 0.97).float()[..., None].expand(-1, -1, 3)
            picture = renderer.render(lamp)[1, ..., 0]
            columns = (torch.arange(WIDTH) + 0.5 - WIDTH / 2) / CAMERA.radius
            at = (picture.sum(0) * columns).sum() / picture.sum()
            assert round(at.item() * 2) / 2 == place

    def test_gradcheck(self):
        camera = SphereCamera.perspective((3, 1, 2), 1, 1, 2, 2)
        small = SphereRenderer(height=4, materials=PRINCIPLED, camera=camera, interpolation="linear")
        environment = torch.rand(4, 8, 1, dtype=torch.float64, requires_grad=True)
        assert torch.autograd.gradcheck(small, (environment,), fast_mode=True)

    @pytest.mark.parametrize("shape", [(), (2,), (1, 2)])
    def test_leading_shapes_and_half_floats(self, renderer, shape):
        environment = room(5, *shape).half()
        pictures = renderer.render(environment)
        assert pictures.dtype == torch.float16
        assert pictures.shape == (*shape, 3, FRAME_HEIGHT, WIDTH, 3)
        exact = renderer.render(environment.float())
        torch.testing.assert_close(pictures.float(), exact, rtol=2e-3, atol=1e-3)


class TestInterpolation:
    def test_linear_is_a_finer_constant(self):
        """A map read between its texels is, to a map of many times the size, nearly constant in each."""
        environment = room(7, height=16)
        linear = SphereRenderer(16, 16, MATERIALS[:2], interpolation="linear").render(environment)
        fine = torch.from_numpy(bilinear(environment, 128)).float()
        expected = SphereRenderer(16, 128, MATERIALS[:2]).render(fine)
        constant = SphereRenderer(16, 16, MATERIALS[:2]).render(environment)
        error, other = ((x - expected).square().mean((1, 2, 3)).sqrt() for x in (linear, constant))
        assert (error < 0.01 * expected.mean((1, 2, 3))).all()
        assert error[1] < 0.5 * other[1]


class TestCache:
    PLAIN = (MATERIALS[0], PRINCIPLED[2], MATERIALS[2])

    def make(self, folder: Path, **changes: object) -> SphereRenderer:
        camera = SphereCamera.perspective((3, 1, 2), 1, 1, 6, 4)
        options = {"height": 64, "materials": self.PLAIN, "camera": camera} | changes
        return SphereRenderer(**options, cache=folder)  # type: ignore[arg-type]

    def test_the_same_tables(self, tmp_path, monkeypatch):
        environment = room(1)
        built = self.make(tmp_path / "a" / "b").render(environment)
        (file,) = (tmp_path / "a" / "b").iterdir()
        monkeypatch.setattr(SphereRenderer, "_build", None)  # nothing is built any more
        kept = self.make(file.parent)
        torch.testing.assert_close(kept.render(environment), built, rtol=0, atol=0)
        assert not kept.state_dict()

    def test_mirrors_alone(self, tmp_path):
        environment = room(1)
        built, kept = (self.make(tmp_path, materials=PRINCIPLED[2:]).render(environment) for _ in range(2))
        torch.testing.assert_close(kept, built, rtol=0, atol=0)

    @pytest.mark.parametrize(
        "changes",
        [
            {"height": 32},
            {"interpolation": "linear"},
            {"rim_step": 0.01},
            {"materials": PLAIN[:2]},
            {"materials": (Material("diffuse", "diffuse", 0.5), *PLAIN[1:])},
            {"camera": SphereCamera.perspective((3, 1, 2.1), 1, 1, 6, 4)},
        ],
    )
    def test_other_tables_have_other_names(self, tmp_path, changes):
        self.make(tmp_path)
        self.make(tmp_path, **changes)
        assert len(list(tmp_path.iterdir())) == 2

    def test_other_code_makes_other_names(self, tmp_path, monkeypatch):
        self.make(tmp_path)
        monkeypatch.setattr(spheres, "_code_digest", lambda: b"another version")
        self.make(tmp_path)
        assert len(list(tmp_path.iterdir())) == 2

    def test_a_broken_file_is_made_anew(self, tmp_path):
        built = self.make(tmp_path).render(room(1))
        (file,) = tmp_path.iterdir()
        whole = file.read_bytes()
        file.write_bytes(whole[: len(whole) // 2])
        again = self.make(tmp_path).render(room(1))
        torch.testing.assert_close(again, built, rtol=0, atol=0)
        assert file.read_bytes() == whole

    def test_a_folder_that_cannot_be_written_is_no_error(self, tmp_path):
        (tmp_path / "file").write_text("not a folder")
        self.make(tmp_path / "file" / "cache")
