"""The renderers of `mixlight insert`: Mitsuba and Blender themselves, trimesh as another reader of models."""

import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mixlight.render import cycles, mitsuba
from mixlight.render.composite import composite, make_layers, relative_change
from mixlight.render.insertion import InsertionScene, Region, make_scene
from mixlight.render.model import Material, Model, Part, demo_objects, load_model
from mixlight.render.scene_camera import SceneCamera, place
from mixlight.sphere import calibration, equirect

pytestmark = pytest.mark.interop

WIDTH, HEIGHT = 64, 48
CAMERA = SceneCamera(WIDTH, HEIGHT, math.radians(60), math.radians(-25), math.radians(12))
WHOLE = Region(0, 0, WIDTH, HEIGHT)
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def _blender(monkeypatch: pytest.MonkeyPatch) -> None:
    """The Blender that `make test-interop` installs, unless another one is named."""
    if "MIXLIGHT_BLENDER_PYTHON" not in os.environ:
        python = ROOT / ".interop" / "blender-5.0" / "bin" / "python"
        monkeypatch.setenv("MIXLIGHT_BLENDER_PYTHON", str(python))


def _sky(height: int = 64) -> torch.Tensor:
    """Dim, with a lamp at the upper right behind the camera and a tint to the left."""
    directions = equirect.pixel_directions(height)
    lamp = torch.nn.functional.normalize(torch.tensor([0.6, 0.7, 0.4]), dim=0)
    sky = 0.3 + 0.2 * (directions[..., :1] < 0) * torch.tensor([1.0, 0.5, 0.2])
    return sky + 12.0 * ((directions @ lamp) > 0.97)[..., None]


def _scene(name: str = "teapot", material: Material | None = None, v: float = 0.7) -> InsertionScene:
    model = load_model(name)
    if material is not None:
        model = Model(name, tuple(replace(part, material=material) for part in model.parts))
    placement = place(CAMERA, *model.bounds, 0.5, v)
    photo = np.full((HEIGHT, WIDTH, 3), 0.25)
    photo[:, : WIDTH // 2] = [0.1, 0.2, 0.3]
    return make_scene(photo, CAMERA, model, placement, _sky())


RENDERERS = {"mitsuba": mitsuba.render, "blender": cycles.render}


@pytest.mark.parametrize("name", RENDERERS)
def test_free_ground_looks_like_the_photo(name: str) -> None:
    """Orientation of camera and ground, its texture, and the irradiance: all wrong ones show here."""
    scene = _scene()
    found = RENDERERS[name](scene, WHOLE, samples=36).ground[0]
    near = slice(30, 44), slice(20, 44)  # the part of the photo that the ground carries
    left, right = found[30:44, 22:30].mean((0, 1)), found[30:44, 35:43].mean((0, 1))
    np.testing.assert_allclose(left, [0.1, 0.2, 0.3], rtol=0.03)
    np.testing.assert_allclose(right, 0.25, rtol=0.03)
    assert (found[near] > 0).all()


@pytest.mark.parametrize("name", RENDERERS)
def test_the_object_covers_the_pixels_that_it_projects_to(name: str) -> None:
    scene = _scene()
    region = Region(8, 6, 60, 46)
    coverage = RENDERERS[name](scene, region, samples=32).coverage
    points = np.concatenate([CAMERA.project(part.positions)[0] for part in scene.parts])
    low, high = points.min(0) - [region.left, region.top], points.max(0) - [region.left, region.top]
    rows, columns = np.nonzero(coverage > 0.02)
    assert [columns.min(), rows.min()] == pytest.approx(low, abs=1.0)
    assert [columns.max() + 1, rows.max() + 1] == pytest.approx(high, abs=1.0)
    assert 0.02 < ((coverage > 0.1) & (coverage < 0.9)).sum() / (coverage > 0).sum() < 0.5  # soft rims


@pytest.mark.parametrize("name", RENDERERS)
def test_a_mirror_shows_the_calibration_card_from_the_right_sides(name: str) -> None:
    """In a ball before a level camera: its middle shows what is behind, its right what is right."""
    camera = SceneCamera(33, 33, math.radians(20))
    steps = np.linspace(0, math.pi, 41)
    polar, around = np.meshgrid(steps, 2 * steps, indexing="ij")
    points = np.stack([np.sin(polar) * np.sin(around), np.cos(polar), np.sin(polar) * np.cos(around)], -1)
    index = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate(
        [np.stack([a, b, c], -1)[1:].reshape(-1, 3), np.stack([a, c, d], -1)[1:].reshape(-1, 3)]
    )
    mirror = Material((1.0, 1.0, 1.0), 1.0, 0.0)
    ball = Part(
        points.reshape(-1, 3) - np.array([0.0, 0.0, 12.0]), points.reshape(-1, 3), triangles, None, mirror
    )
    scene = _scene()
    scene = replace(
        scene,
        camera=camera,
        parts=(ball,),
        environment=calibration.calibration_card(64),
        ground=replace(scene.ground, centre=np.array([0.0, -500.0, 0.0]), half_side=0.01),
    )
    found = RENDERERS[name](scene, Region(0, 0, 33, 33), samples=16).scene[0]
    card = scene.environment
    radius = camera.focal / 12
    for offset, direction in (
        ((0.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.7071, 0.0), (1.0, 0.0, 0.0)),
        ((-0.7071, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, -0.7071), (0.0, 1.0, 0.0)),
        ((0.0, 0.7071), (0.0, -1.0, 0.0)),
    ):
        expected = equirect.sample(card, torch.tensor(direction)).numpy()
        pixel = found[round(16 + offset[1] * radius), round(16 + offset[0] * radius)]
        np.testing.assert_allclose(pixel, expected, atol=0.15 * expected.max(), err_msg=str(offset))


def test_mitsuba_and_blender_agree() -> None:
    """A matte ball, a satin one and a mirror."""
    scene = _scene("spheres")
    region = Region(14, 22, 56, 46)
    photo = np.full((HEIGHT, WIDTH, 3), 0.25)
    made = {}
    for name, render in RENDERERS.items():
        renders = render(scene, region, samples=25, runs=5)
        layers = make_layers(scene, renders, region, region, relative_change(scene, renders, region), photo)
        made[name] = layers, composite(photo, layers)
    (m, m_picture), (b, b_picture) = made["mitsuba"], made["blender"]
    np.testing.assert_allclose(m.coverage, b.coverage, atol=0.15)
    # Measured: .5 % of the object, 7 % of the shadow, into which caustics of the mirror throw noise.
    assert m.beauty.sum() == pytest.approx(b.beauty.sum(), rel=0.03)
    assert m.shadow.sum() == pytest.approx(b.shadow.sum(), rel=0.12)
    dull = np.minimum(m_picture, 1) - np.minimum(b_picture, 1)  # as the photo shows them
    assert np.sqrt((dull**2).mean()) < 0.02


def test_ground_far_from_the_object_is_free_of_noise() -> None:
    scene = _scene("spheres", v=0.6)
    renders = mitsuba.render(scene, WHOLE, samples=4, runs=2)
    change = renders.scene - renders.ground
    assert (change[:, -3:, :6] == 0).mean() > 0.5
    np.testing.assert_array_equal(change[:, 0], 0)  # above the horizon


def test_textures_lie_the_right_way_round() -> None:
    """An upright board with four colours, and roughness and metal from a texture."""
    corners = np.array([[-1, -0.6, -4], [1, -0.6, -4], [1, 1.4, -4], [-1, 1.4, -4]], float)
    uv = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], float)  # glTF: v = 0 is the top of the picture
    colours = np.array([[[0.8, 0.05, 0.05], [0.05, 0.8, 0.05]], [[0.05, 0.05, 0.8], [0.8, 0.8, 0.05]]])
    texture = np.kron(colours, np.ones((8, 8, 1)))
    surface = np.stack([np.zeros((2, 2)), np.ones((2, 2))], -1)
    material = Material((1.0, 1.0, 1.0), 1.0, 1.0, texture, surface)
    board = Part(corners, np.tile([0.0, 0, 1], (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]), uv, material)
    level = SceneCamera(32, 32, math.radians(40))
    scene = replace(_scene(), parts=(board,), camera=level, environment=torch.ones(16, 32, 3))
    for name, render in RENDERERS.items():
        found = render(scene, Region(0, 0, 32, 32), samples=16).scene[0]
        x, y = (level.project(np.array([[-0.5, 0.9, -4.0], [0.5, -0.1, -4.0]]))[0]).astype(int).T
        for row, i in ((y[0], 0), (y[1], 1)):
            for column, j in ((x[0], 0), (x[1], 1)):
                pixel = found[row, column]
                bright = colours[i, j] > 0.5
                assert pixel[bright].min() > 2 * pixel[~bright].max(), (name, i, j, pixel)


@pytest.mark.parametrize("name", demo_objects())
def test_trimesh_reads_the_same_geometry(name: str) -> None:
    import trimesh

    ours = load_model(name)
    path = Path(mitsuba.__file__).parent.parent / "assets" / "objects" / f"{name}.glb"
    theirs = trimesh.load_scene(path)
    np.testing.assert_allclose(np.stack(ours.bounds), theirs.bounds, atol=1e-6)
    area = 0.0
    for part in ours.parts:
        corners = part.positions[part.triangles]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area += float(np.linalg.norm(cross, axis=1).sum() / 2)
    assert area == pytest.approx(theirs.area, rel=1e-5)
