"""Each unit of light is in the map or in the lights, never in both and never in none."""

import math

import pytest
import torch
from hypothesis import given, settings

from mixlight.export.rig import Rig, light_harmonics, make_rig
from mixlight.light import harmonics
from mixlight.light.detail import Detail
from mixlight.light.lighting import Lighting
from mixlight.light.lights import Light
from mixlight.sphere import equirect
from mixlight.sphere.calibration import calibration_card
from tests.export.rigs import Recipe, lighting, recipes
from tests.tolerances import TOLERANCE


@settings(max_examples=10)
@given(recipe=recipes())
def test_nothing_is_counted_twice_and_nothing_lost(recipe: Recipe) -> None:
    light, count, residual = recipe.lighting(), recipe.count, recipe.residual
    rig = make_rig(light, lights=count, residual=residual, height=32)
    whole = equirect.integrate(light.environment(32))
    taken = [anchor for lamp in rig.lights for anchor in lamp.anchors]
    lobes = light.energy[taken].sum(0) if rig.lights_on else torch.zeros(3)
    torch.testing.assert_close(equirect.integrate(rig.environment) + lobes, whole, rtol=1e-4, atol=1e-5)
    assert rig.lights_on == (residual and len(rig.lights) > 0)
    assert rig.map_kind == ("residual" if rig.lights_on else "full")
    if count is not None:
        assert len(rig.lights) <= count
    strengths = [float(lamp.irradiance @ torch.tensor([0.2126, 0.7152, 0.0722])) for lamp in rig.lights]
    assert strengths == sorted(strengths, reverse=True)


@settings(max_examples=6)
@given(recipe=recipes())
def test_residual_and_full_light_a_surface_alike(recipe: Recipe) -> None:
    """Map and lights together, or the full map alone: the same irradiance, up to the lobes' width."""
    light, count = recipe.lighting(), recipe.count
    residual, full = (make_rig(light, lights=count, residual=choice, height=32) for choice in (True, False))
    torch.testing.assert_close(residual.sh, full.sh, rtol=1e-4, atol=1e-4)
    torch.testing.assert_close(full.ambient, full.sh)
    with_lights = residual.ambient + light_harmonics(residual.lights)
    # A light of several lobes is weaker than they are by their spread, which is less than 40 degrees.
    normals = torch.eye(3)
    error = harmonics.irradiance(with_lights - residual.sh, normals).abs().max()
    assert float(error) <= 0.25 * float(sum(lamp.irradiance.max() for lamp in residual.lights)) + 1e-4


def test_golden() -> None:
    energy = torch.zeros(128, 3)
    energy[40], energy[100] = torch.tensor([3.0, 2.0, 1.0]), 0.5
    rig = make_rig(Lighting(torch.zeros(9, 3), energy), lights=1, height=64)
    (lamp,) = rig.lights
    assert (lamp.name, lamp.anchors, lamp.irradiance.tolist()) == ("light_1", (40,), [3.0, 2.0, 1.0])
    torch.testing.assert_close(equirect.integrate(rig.environment), torch.tensor([0.5] * 3))
    assert float(rig.ambient[0, 0]) * math.sqrt(4 * math.pi) == pytest.approx(0.5, rel=1e-4)
    assert float(rig.sh[0, 0]) * math.sqrt(4 * math.pi) == pytest.approx(3.5, rel=1e-4)


def test_a_light_is_its_own_harmonics() -> None:
    """Independent reference: a small disc of the same irradiance, projected."""
    direction = torch.nn.functional.normalize(torch.tensor([0.3, 0.5, -0.7]), dim=0)
    lamp = Light("light_1", direction, torch.tensor([2.0, 1.0, 0.5]), 0.1)
    directions = equirect.pixel_directions(256)
    disc = (directions @ direction > math.cos(0.05)).float()[..., None]
    disc = disc * lamp.irradiance / equirect.integrate(disc)
    torch.testing.assert_close(light_harmonics([lamp]), harmonics.project(disc), rtol=0, atol=0.02)
    assert torch.equal(light_harmonics([]), torch.zeros(9, 3))


def test_a_map_of_ones_own_is_taken_as_it_is() -> None:
    card = calibration_card(32)
    rig = make_rig(lighting(1), environment=card, residual=False)
    torch.testing.assert_close(rig.environment, card)
    torch.testing.assert_close(rig.sh, harmonics.project(card), **TOLERANCE[torch.float32])
    residual = make_rig(lighting(1), environment=card)
    lobes = lighting(1).sources_map(32)
    torch.testing.assert_close(residual.sh, harmonics.project(card + lobes), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("residual", [True, False])
def test_the_photos_pixels_stay_when_lights_are_taken_out(residual: bool) -> None:
    photo = torch.full((24, 32, 3), 0.4)
    photo[:6, :6] = 1.0  # clipped: a lamp in the corner
    detail = Detail.of_photo(photo, math.radians(60), 32)
    light = lighting(4)
    rig = make_rig(light, height=32, residual=residual, environment=detail.environment)
    whole = detail.environment(light)
    taken = [anchor for lamp in rig.lights for anchor in lamp.anchors]
    expected = detail.environment(light.without(taken)) if residual else whole
    torch.testing.assert_close(rig.environment, expected)
    torch.testing.assert_close(rig.sh, harmonics.project(whole), rtol=1e-4, atol=1e-4)


def test_directions_turn_with_the_frame() -> None:
    lamp = Light("lamp", torch.tensor([0.0, 0.6, -0.8]), torch.ones(3), 0.14)
    rig = Rig(torch.ones(4, 8, 3), (lamp,), True, torch.zeros(9, 3), torch.zeros(9, 3), 2.0, "room")
    document = rig.document("unity")
    assert document["lights"][0]["direction"] == pytest.approx([0.0, 0.6, 0.8])
    assert rig.document("unreal")["lights"][0]["direction"] == pytest.approx([0.8, 0.0, 0.6])
    assert (document["map"], document["name"], document["exposure_gain"]) == ("residual", "room", 2.0)
    with pytest.raises(ValueError, match="received 'maya'"):
        rig.document("maya")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"environment": torch.ones(4, 12, 3)}, "2:1"),
        ({"environment": torch.ones(1, 2, 3)}, "width divisible by 4"),
        ({"environment": -torch.ones(4, 8, 3)}, "at least 0"),
        ({"environment": torch.full((4, 8, 3), math.nan)}, "nan"),
        ({"exposure_gain": 0.0}, "exposure_gain"),
    ],
)
def test_impossible_rigs_are_refused(changes: dict[str, object], message: str) -> None:
    good: dict[str, object] = {
        "environment": torch.ones(4, 8, 3), "lights": (), "residual": True,
        "ambient": torch.zeros(9, 3), "sh": torch.zeros(9, 3),
    }  # fmt: skip
    with pytest.raises(ValueError, match=message):
        Rig(**(good | changes))  # type: ignore[arg-type]


def test_impossible_wishes_are_refused() -> None:
    with pytest.raises(ValueError, match="lights: expected a number of at least 0, received -1"):
        make_rig(lighting(1), lights=-1)
    with pytest.raises(ValueError, match="height: expected an even number"):
        make_rig(lighting(1), height=15)
    with pytest.raises(ValueError, match="single"):
        make_rig(Lighting(torch.zeros(2, 9, 3), torch.zeros(2, 128, 3)))
