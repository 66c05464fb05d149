"""Which sky stands before the windows, how bright it is, and that its map is turned the right way."""

import dataclasses
import math
import random
from collections import Counter
from pathlib import Path

import pytest
import torch

from mixlight.data.rooms.outline import edges
from mixlight.data.rooms.plan import Sky
from mixlight.data.rooms.skies import OutdoorSky, horizontal_illuminance
from mixlight.data.rooms.sky import LUMENS_PER_UNIT, TURNS, choose_sky, sky_map
from mixlight.data.rooms.sky_analytic import analytic_map
from mixlight.image import exr
from mixlight.sphere import equirect
from tests.data.rooms.lit import lit_plan

SUNNY = OutdoorSky("meadow", Path("meadow.exr"), "day", (0.6, 0.64, 0.48), 5.0, 5200.0)
GREY = OutdoorSky("field", Path("field.exr"), "day")
STREET = OutdoorSky("street", Path("street.exr"), "night")
LOW = OutdoorSky("beach", Path("beach.exr"), "dusk", (0.0, 0.99, 0.12), 1.0, 3000.0)
SKIES = (SUNNY, GREY, STREET, LOW)


def drawn(count: int = 400, skies: tuple[OutdoorSky, ...] = SKIES) -> list[Sky]:
    return [choose_sky(lit_plan(), random.Random(seed), skies) for seed in range(count)]


def test_a_sky_is_a_function_of_the_generator() -> None:
    assert choose_sky(lit_plan(), random.Random(1), SKIES) == choose_sky(lit_plan(), random.Random(1), SKIES)


@pytest.mark.parametrize("skies", [SKIES, ()], ids=["panoramas", "analytic"])
def test_times_and_levels(skies: tuple[OutdoorSky, ...]) -> None:
    made = drawn(400, skies)
    shares = Counter(sky.time for sky in made)
    assert shares["day"] > shares["night"] > 0
    assert shares["dusk"] > 0
    for sky in made:
        low, high = {"day": (3e3, 25e3), "dusk": (30, 2e3), "night": (0.2, 15)}[sky.time]
        if sky.sun_direction is not None:  # as long as the sun is up it is not dark
            low, high = 2e3, 25e3
        assert low <= sky.illuminance <= high
        if sky.sun_direction is not None:
            assert sky.time != "night"
            assert math.hypot(*sky.sun_direction) == pytest.approx(1.0, abs=0.01)
            assert 0 < sky.sun_illuminance <= 128e3
        else:
            assert sky.sun_illuminance == 0
        step = sky.turn / (2 * math.pi) * TURNS
        assert step == pytest.approx(round(step), abs=1e-9)


def test_the_panorama_fits_the_time() -> None:
    times = {sky.name: sky.time for sky in SKIES}
    for sky in drawn():
        assert sky.file is not None
        assert times[sky.file] == sky.time


def test_without_a_fitting_panorama_the_sky_is_analytic() -> None:
    for sky in drawn(60, (STREET,)):
        assert (sky.file is None) == (sky.time != "night")


def test_some_suns_shine_in() -> None:
    """The plan's one window looks to +Y."""
    suns = [s.sun_direction for s in drawn(600, (SUNNY,)) if s.time == "day" and s.sun_direction is not None]
    before = sum(d[1] > 0.5 * math.hypot(d[0], d[1]) for d in suns) / len(suns)
    assert 0.4 < before < 0.8  # a third of all azimuths by chance, and most of four in ten more
    turned = edges(lit_plan().spaces[0].outline)[2].inward
    assert turned == (0.0, -1.0)


def spot(direction: tuple[float, float, float], height: int = 64) -> torch.Tensor:
    """A sky of half brightness with one bright spot towards a direction of the canonical frame."""
    d = equirect.pixel_directions(height)
    near = (d @ torch.nn.functional.normalize(torch.tensor(direction), dim=0)) > math.cos(math.radians(4))
    return torch.full((height, 2 * height, 3), 0.5) + 30 * near[..., None]


def brightest(panorama: torch.Tensor) -> torch.Tensor:
    """Direction of the brightest place in the room frame."""
    d = equirect.pixel_directions(panorama.shape[0]).reshape(-1, 3)
    weight = (panorama.sum(-1).flatten() - 3 * 0.6 * panorama.max() / 3).clamp(min=0)
    x, y, z = torch.nn.functional.normalize((d * weight[:, None]).sum(0), dim=0)
    return torch.stack([x, -z, y])


@pytest.mark.parametrize("step", [0, 5, 16, 40])
def test_map_and_sun_turn_together(tmp_path: Path, step: int) -> None:
    """The spot stands where the sun was: after any turn it is seen in the sun's direction."""
    sun = (0.5, 0.6, 0.62)
    exr.write(tmp_path / "a.exr", spot((sun[0], sun[2], -sun[1])).numpy())
    known = OutdoorSky("a", tmp_path / "a.exr", "day", sun, 2.0)
    made = next(
        s
        for seed in range(4000)
        if (s := choose_sky(lit_plan(), random.Random(seed), (known,))).time == "day"
        and round(s.turn / (2 * math.pi) * TURNS) == step
    )
    panorama = sky_map(made, (known,))
    assert made.sun_direction is not None
    towards = torch.nn.functional.normalize(torch.tensor(made.sun_direction), dim=0)
    assert float(brightest(panorama) @ towards) > math.cos(math.radians(3))
    assert horizontal_illuminance(panorama) * LUMENS_PER_UNIT == pytest.approx(made.illuminance, rel=1e-3)


def test_a_turn_is_counter_clockwise_from_above(tmp_path: Path) -> None:
    exr.write(tmp_path / "a.exr", spot((0.0, 0.3, -1.0)).numpy())  # ahead: the room's +Y
    known = OutdoorSky("a", tmp_path / "a.exr", "day")
    sky = Sky("day", "a", math.pi / 2, 1000.0, (1.0, 1.0, 1.0), None)
    assert brightest(sky_map(sky, (known,)))[0] < -0.9  # now at -X


def test_an_unknown_panorama_is_refused() -> None:
    with pytest.raises(ValueError, match="'elsewhere'"):
        sky_map(Sky("day", "elsewhere", 0.0, 1.0, (1.0, 1.0, 1.0), None), SKIES)


@pytest.mark.parametrize("time", ["day", "dusk", "night"])
@pytest.mark.parametrize("cloud", [0.0, 0.4, 1.0])
def test_analytic_skies_are_radiance(time: str, cloud: float) -> None:
    sky = Sky(time, None, 1.0, 5000.0, (0.6, 0.9, 1.5), (0.6, 0.0, 0.8), seed=3, cloud=cloud)
    panorama = analytic_map(sky, 64)
    equirect.check(panorama)
    assert torch.equal(panorama, analytic_map(sky, 64))
    assert not torch.equal(panorama, analytic_map(dataclasses.replace(sky, seed=4), 64))
    assert horizontal_illuminance(sky_map(sky, height=64)) == pytest.approx(5000 / 683, rel=1e-4)


def test_a_clear_analytic_sky_is_blue_above_and_bright_around_the_sun() -> None:
    turn = 2 * math.pi * 7 / TURNS
    sky = Sky("day", None, turn, 10000.0, (0.6, 0.9, 1.5), (0.8, 0.0, 0.6))
    panorama = sky_map(sky, height=64)
    top = panorama[:4].mean((0, 1))
    assert top[2] > 1.3 * top[0]
    towards = equirect.sample(panorama, torch.tensor([0.8, 0.6, 0.0]))
    away = equirect.sample(panorama, torch.tensor([-0.8, 0.6, 0.0]))
    assert float(towards.mean()) > 2 * float(away.mean())
