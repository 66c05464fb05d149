"""Groups are rendered about equally bright, and come back as they are."""

import dataclasses

import numpy as np
import pytest

from mixlight.data.rooms.balance import balanced, render_gains, restored
from mixlight.data.rooms.mesh import Emission
from mixlight.data.rooms.plan import Sky
from mixlight.data.rooms.scene import build
from mixlight.data.rooms.store import SKY, SUN, group_names
from tests.data.rooms.lit import fixture, lit_plan, pictures


def test_every_group_has_a_gain_that_makes_it_as_bright() -> None:
    plan = lit_plan()
    gains = render_gains(plan)
    assert list(gains) == group_names(plan)
    # A lamp of 800 lm over 20 m²: 16 lx, wanted 100 (150 for the ceiling's).
    assert gains["floor_lamp_1"] == pytest.approx(100 / 16)
    assert gains["ceiling"] == pytest.approx(150 / 16)
    assert gains[SKY] == pytest.approx(300 / 9000)
    assert gains[SUN] == pytest.approx(150 / 60000)


def test_gains_follow_the_power() -> None:
    plan = lit_plan(
        fixtures=(
            fixture("a", "ceiling"),
            fixture("b", "ceiling"),
            fixture("c", "candles", "candle", power=12.0),
        ),
        sky=Sky("night", None, 0.0, 2.0, (1.0, 1.0, 1.0), None),
    )
    gains = render_gains(plan)
    assert gains["ceiling"] == pytest.approx(150 / 32)
    assert gains["candles"] == pytest.approx(30 / 0.24)
    assert gains[SKY] == pytest.approx(150)
    assert SUN not in gains


def test_a_balanced_scene_differs_in_its_light_alone() -> None:
    plan = lit_plan()
    scene, gains = build(plan, sky_height=16), render_gains(plan)
    made = balanced(scene, gains)
    assert len(made.parts) == len(scene.parts)
    shining = 0
    for before, after in zip(scene.parts, made.parts, strict=True):
        assert after.mesh is before.mesh
        if isinstance(before.material, Emission) and isinstance(after.material, Emission):
            shining += 1
            gain = gains[before.material.group]
            np.testing.assert_allclose(after.material.radiance, np.array(before.material.radiance) * gain)
            assert after.material.reflectance == before.material.reflectance
        else:
            assert after.material == before.material
    assert shining > 3
    np.testing.assert_allclose(made.sky, scene.sky * gains[SKY], rtol=1e-6)
    assert scene.sun is not None
    assert made.sun is not None
    np.testing.assert_allclose(made.sun.irradiance, np.array(scene.sun.irradiance) * gains[SUN])
    assert dataclasses.replace(made, parts=scene.parts, sky=scene.sky, sun=scene.sun) == scene


def test_restoring_undoes_the_gains() -> None:
    plan = lit_plan()
    light, gains = pictures(plan, 8), render_gains(plan)
    brightened = {name: pixels * np.float32(gains[name]) for name, pixels in light.items()}
    for name, pixels in restored(brightened, gains).items():
        np.testing.assert_allclose(pixels, light[name], rtol=1e-6)
        assert pixels.dtype == np.float32
    untouched = restored(light, {})
    assert all(np.array_equal(untouched[name], light[name]) for name in light)
