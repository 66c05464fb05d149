import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light.lighting import Lighting
from mixlight.render.insertion import ALBEDO, ground_irradiance, make_ground, make_scene
from mixlight.render.model import load_model
from mixlight.render.scene_camera import SceneCamera, place

CAMERA = SceneCamera(64, 48, math.radians(60), math.radians(-20))


def test_golden_irradiance() -> None:
    sky = torch.zeros(16, 32, 3)
    sky[:8] = torch.tensor([1.0, 2.0, 3.0])
    torch.testing.assert_close(ground_irradiance(sky), torch.tensor([1.0, 2.0, 3.0]) * math.pi)
    torch.testing.assert_close(ground_irradiance(sky.flip(0)), torch.zeros(3))
    # A horizon in the middle of a row, and a zenith that is one texel high.
    assert ground_irradiance(torch.ones(5, 10, 3))[0] == pytest.approx(math.pi, rel=1e-6)


@given(st.integers(0, 10**6))
def test_irradiance_is_the_lightings_own(seed: int) -> None:
    """Reference: the closed form of harmonics and lobes, which knows no map."""
    generator = torch.Generator().manual_seed(seed)
    ambient = torch.randn(9, 3, generator=generator) * 0.05
    ambient[0] = 2.0
    energy = torch.zeros(128, 3)
    energy[torch.randint(0, 60, (4,), generator=generator)] = 0.7
    lighting = Lighting(ambient, energy)
    expected = lighting.irradiance(torch.tensor([0.0, 1.0, 0.0]))
    # Lobes near the horizon lose their half below it on the map and in the closed form alike.
    torch.testing.assert_close(ground_irradiance(lighting.environment(128)), expected, rtol=4e-3, atol=1e-3)


def test_the_ground_is_what_makes_the_photo() -> None:
    """Albedo times irradiance over pi is the photo again, wherever it may be."""
    photo = np.full((48, 64, 3), 0.2)
    photo[:, 32:] = 0.4
    irradiance = np.array([2.0, 2.5, 3.0])
    point = CAMERA.ground_point(0.5, 0.7)
    ground = make_ground(photo, CAMERA, point, 0.3, irradiance)
    shown = ground.albedo * irradiance / math.pi
    rows, columns = shown.shape[:2]
    np.testing.assert_allclose(shown[rows // 2, columns // 2 - 8], 0.2, rtol=1e-6)  # left of the point
    np.testing.assert_allclose(shown[rows // 2, columns // 2 + 8], 0.4, rtol=1e-6)
    np.testing.assert_allclose(ground.mean_albedo * irradiance / math.pi, 0.3, rtol=0.15)
    # Where the photo cannot be trusted lies the mean.
    np.testing.assert_allclose(ground.albedo[0, 0], ground.mean_albedo)


def test_rows_of_the_ground_go_from_far_to_near() -> None:
    photo = np.full((48, 64, 3), 0.2)
    point = CAMERA.ground_point(0.5, 0.7)
    photo[34:] = 0.4  # the lower part of the picture, nearer than the point
    albedo = make_ground(photo, CAMERA, point, 0.2, np.full(3, math.pi)).albedo
    middle = len(albedo) // 2
    assert albedo[middle - 25, middle, 0] == pytest.approx(0.2)
    assert albedo[middle + 25, middle, 0] == pytest.approx(0.4)


def test_albedo_stays_physical() -> None:
    point = CAMERA.ground_point(0.5, 0.7)
    for value, expected in ((0.0, ALBEDO[0]), (5.0, ALBEDO[1])):
        ground = make_ground(np.full((48, 64, 3), value), CAMERA, point, 0.3, np.full(3, math.pi))
        np.testing.assert_allclose(ground.albedo, expected)


def test_light_from_below_alone_is_refused() -> None:
    with pytest.raises(ValueError, match="light that reaches the ground"):
        make_ground(np.ones((48, 64, 3)), CAMERA, np.array([0.0, -1.0, -2.0]), 0.3, np.zeros(3))


def test_a_scene_holds_the_object_in_the_world() -> None:
    model = load_model("teapot")
    placement = place(CAMERA, *model.bounds, 0.4, 0.7)
    photo = np.full((48, 64, 3), 0.3)
    scene = make_scene(photo, CAMERA, model, placement, torch.ones(16, 32, 3))
    low = np.min([part.positions.min(0) for part in scene.parts], axis=0)
    assert low[1] == pytest.approx(-1.0)
    np.testing.assert_allclose(scene.irradiance, math.pi, rtol=1e-6)
    np.testing.assert_allclose(scene.ground.mean_albedo, 0.3, rtol=1e-6)


@pytest.mark.parametrize("shape", [(48, 60, 3), (40, 64, 3)])
def test_photos_of_another_size_are_refused(shape: tuple[int, int, int]) -> None:
    model = load_model("teapot")
    placement = place(CAMERA, *model.bounds, 0.4, 0.7)
    with pytest.raises(ValueError, match="expected a photo of 64 x 48"):
        make_scene(np.ones(shape), CAMERA, model, placement, torch.ones(16, 32, 3))


def test_no_panorama_is_refused() -> None:
    model = load_model("teapot")
    placement = place(CAMERA, *model.bounds, 0.4, 0.7)
    with pytest.raises(ValueError, match="2:1"):
        make_scene(np.ones((48, 64, 3)), CAMERA, model, placement, torch.ones(16, 48, 3))
