"""Layers and composites, with a renderer whose pictures are known."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from mixlight.render.composite import Layers, composite
from mixlight.render.insert import insert, touched_region
from mixlight.render.insertion import InsertionScene, Region, make_scene
from mixlight.render.model import load_model
from mixlight.render.scene_camera import SceneCamera, place
from tests.render.plain_renderer import OBJECT, SHADE, PlainRenderer


def _scene(width: int = 160, height: int = 120, v: float = 0.75) -> tuple[InsertionScene, np.ndarray]:
    camera = SceneCamera(width, height, math.radians(60), math.radians(-25))
    model = load_model("teapot")
    placement = place(camera, *model.bounds, 0.5, v, scale=0.4)
    photo = np.random.default_rng(0).uniform(0.1, 0.5, (height, width, 3)).astype(np.float32)
    return make_scene(photo, camera, model, placement, torch.ones(16, 32, 3)), photo


def test_the_shadow_darkens_the_photo_in_proportion_and_the_object_hides_it() -> None:
    scene, photo = _scene()
    layers = insert(scene, photo, PlainRenderer())
    out = composite(photo, layers)
    here = photo[layers.region.slices]
    inside = layers.coverage == 1
    assert inside.sum() > 80
    np.testing.assert_allclose(out[inside], OBJECT, rtol=1e-6)
    shaded = (layers.coverage == 0) & (np.abs(layers.shadow + (1 - SHADE) * here).max(-1) < 1e-6)
    assert shaded.sum() > 300
    np.testing.assert_allclose(out[shaded], SHADE * here[shaded], rtol=1e-5)


def test_rims_mix_object_and_shaded_photo_by_coverage() -> None:
    scene, _ = _scene()
    photo = np.full((120, 160, 3), 0.4, np.float32)
    scene = replace(scene, ground=replace(scene.ground, mean_albedo=np.full(3, 0.4)))
    layers = insert(scene, photo, PlainRenderer())
    rim = (layers.coverage > 0.2) & (layers.coverage < 0.8)
    assert rim.any()
    share = layers.coverage[rim][:, None]
    expected = share * OBJECT + (1 - share) * 0.4 * SHADE
    mixed = composite(photo, layers)[rim]
    # The top of the box may stand before ground that is not shaded.
    assert (np.abs(mixed - expected).max(-1) < 0.02).mean() > 0.9


def test_pixels_that_nothing_touches_are_the_photos_bit_for_bit() -> None:
    scene, photo = _scene()
    layers = insert(scene, photo, PlainRenderer(noise=0.05))
    out = photo.copy()
    out[layers.region.slices] = composite(photo, layers)
    touched = np.zeros(photo.shape[:2], bool)
    touched[layers.region.slices] = layers.touched
    assert 0.02 < touched.mean() < 0.6
    np.testing.assert_array_equal(out[~touched], photo[~touched])


def test_highlights_darken_no_more_than_white_paper() -> None:
    pixel = np.ones((1, 1, 3))
    scene, photo = _scene()
    photo[:] = (
        5.0  # brighter than albedo 1 can be under an irradiance of pi, and than the ground at the object
    )
    layers = insert(scene, photo, PlainRenderer())
    deepest = layers.shadow.min()
    assert deepest == pytest.approx(-(1 - SHADE) * 1.0, rel=1e-6)
    # But where all the ground is that bright, the light was estimated too dim.
    bright = replace(scene, ground=replace(scene.ground, mean_radiance=np.full(3, 4.0)))
    assert insert(bright, photo, PlainRenderer()).shadow.min() == pytest.approx(-(1 - SHADE) * 5.0, rel=1e-6)
    assert (
        composite(4 * pixel, Layers(Region(0, 0, 1, 1), 0 * pixel, pixel[..., 0] * 0, -9 * pixel)).min() == 0
    )


def test_large_photos_get_their_shadow_from_a_smaller_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, photo = _scene(320, 240)
    whole = insert(scene, photo, PlainRenderer())
    monkeypatch.setattr("mixlight.render.insert.SHADOW_PIXELS", 3000)
    renderer = PlainRenderer()
    layers = insert(scene, photo, renderer)
    assert layers.region == whole.region
    full_size = [w * h for width, w, h in renderer.calls if width == 320]
    assert len(full_size) == 1
    assert full_size[0] < 0.5 * whole.region.width * whole.region.height
    np.testing.assert_array_equal(layers.coverage, whole.coverage)
    np.testing.assert_allclose(layers.beauty, whole.beauty, atol=0.1)
    assert np.abs(layers.shadow - whole.shadow).mean() < 0.004  # but for the rim of the shadow


def test_the_region_holds_what_changes_and_little_more() -> None:
    scene, photo = _scene()
    region, outline = touched_region(scene, PlainRenderer())
    layers = insert(scene, photo, PlainRenderer())
    rows, columns = np.nonzero(layers.touched)
    assert region == layers.region
    assert 0 <= rows.min() <= 8
    assert 0 <= columns.min() <= 8
    rows, columns = np.nonzero(layers.coverage > 0)
    assert outline.left <= columns.min() + region.left
    assert outline.bottom >= rows.max() + region.top + 1


def test_an_object_outside_the_photo_is_refused() -> None:
    scene, photo = _scene()
    moved = replace(
        scene, parts=tuple(replace(p, positions=p.positions + np.array([50.0, 0, 0])) for p in scene.parts)
    )
    with pytest.raises(ValueError, match="inside the photo"):
        insert(moved, photo, PlainRenderer())


def test_the_same_seed_gives_the_same_picture() -> None:
    scene, photo = _scene()
    first, second, other = (
        insert(scene, photo, PlainRenderer(noise=0.1), seed=seed).shadow for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, other)
