"""Light sources of maps, and how far predicted ones are from the true ones."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.evaluation.sources import (
    count_sources,
    find_sources,
    light_cells,
    match_angle,
    strongest_angle,
)
from mixlight.light.regions import Region
from mixlight.sphere import equirect
from tests.synthetic import room


def lamp(direction: tuple[float, float, float], radius_deg: float, value: float) -> torch.Tensor:
    rays = equirect.pixel_directions(64)
    axis = torch.nn.functional.normalize(torch.tensor(direction, dtype=torch.float32), dim=0)
    inside = rays @ axis > math.cos(math.radians(radius_deg))
    return inside[..., None] * torch.full((3,), value)


def source(*direction: float) -> Region:
    axis = torch.nn.functional.normalize(torch.tensor(direction, dtype=torch.float32), dim=0)
    return Region(torch.ones(1, 2, dtype=torch.bool), axis, torch.ones(3), 0.1)


def test_the_strongest_source_is_that_of_most_energy_not_of_the_highest_peak() -> None:
    spark, window = lamp((1, 0, 0), 4, 9.0), lamp((0, 0, 1), 20, 2.0)
    found = find_sources(0.001 + spark + window)
    assert len(found) == 2
    assert float(found[0].direction[2]) > 0.99


def test_what_covers_half_of_the_sphere_is_no_source() -> None:
    assert find_sources(torch.full((64, 128, 3), 0.5)) == []
    sky = torch.where(equirect.pixel_directions(64)[..., 1:2] > -0.05, 1.0, 0.01).expand(-1, -1, 3)
    assert find_sources(sky) == []
    assert find_sources(torch.zeros(64, 128, 3)) == []


def test_angles_of_known_lamps() -> None:
    true = 0.001 + lamp((0, 0, -1), 6, 5.0)
    for degrees in (0, 10, 90, 170):
        angle = math.radians(degrees)
        predicted = 0.001 + lamp((math.sin(angle), 0, -math.cos(angle)), 6, 2.0)
        cells = light_cells(predicted, true)
        assert cells["strongest_angle_deg"] == pytest.approx(degrees, abs=1.5)
        assert cells["blob_angle_deg"] == pytest.approx(degrees, abs=1.5)


def test_matching_golden() -> None:
    """True lamps at 0 and 90 degrees, predicted at 30 and 90: forth 30 + 0, back 30 + 0, over 4."""
    true = [source(0, 0, -1), source(1, 0, 0)]
    half = math.radians(30)
    predicted = [source(math.sin(half), 0, -math.cos(half)), source(1, 0, 0)]
    assert math.degrees(match_angle(predicted, true)) == pytest.approx(15)
    assert math.degrees(strongest_angle(predicted, true)) == pytest.approx(30)
    # One prediction meets the strongest true one alone.
    assert math.degrees(match_angle(predicted[:1], true)) == pytest.approx(30)
    # Only so many as asked for are looked at.
    assert math.degrees(match_angle(predicted, true, 1)) == pytest.approx(30)


def test_no_prediction_is_as_good_as_a_random_direction() -> None:
    generator = torch.Generator().manual_seed(0)
    directions = torch.nn.functional.normalize(torch.randn(4000, 3, generator=generator), dim=-1)
    mean = float(torch.acos(directions[:2000] @ directions[2000:].T).mean())
    assert match_angle([], [source(1, 0, 0)]) == pytest.approx(mean, abs=0.01)
    assert math.isnan(strongest_angle([source(1, 0, 0)], []))
    assert math.isnan(match_angle([source(1, 0, 0)], []))


@given(st.integers(0, 500), st.integers(0, 500))
def test_matching_is_symmetric_and_bounded(a: int, b: int) -> None:
    first, second = find_sources(room(32, a)), find_sources(room(32, b))
    there, back = match_angle(first, second), match_angle(second, first)
    assert there == pytest.approx(back)
    assert 0 <= there <= math.pi
    assert match_angle(first, first) == pytest.approx(0, abs=1e-6)


@given(st.integers(0, 500), st.floats(0.01, 100))
def test_energy_is_a_ratio_on_a_log_scale(seed: int, gain: float) -> None:
    true = room(32, seed).double()
    cells = light_cells(gain * true, true)
    assert cells["energy_log2"] == pytest.approx(math.log2(gain), abs=1e-6)
    assert cells["energy_off_log2"] == pytest.approx(abs(math.log2(gain)), abs=1e-6)
    assert cells["strongest_angle_deg"] == pytest.approx(0, abs=1e-4)
    assert cells["sources"] == cells["true_sources"] > 0


def test_a_black_prediction_has_no_energy_ratio() -> None:
    cells = light_cells(torch.zeros(64, 128, 3), 0.001 + lamp((0, 0, -1), 6, 5.0))
    assert math.isnan(cells["energy_log2"])
    assert cells["sources"] == 0
    assert cells["strongest_angle_deg"] == 90


def test_faint_regions_are_found_and_not_counted() -> None:
    """Two windows of 9 parts of the energy each, and two candles of one: the windows are 90 %."""
    lights = [((1, 0, 0), 9.0), ((-1, 0, 0), 9.0), ((0, 0, 1), 1.0), ((0, 0, -1), 1.0)]
    found = find_sources(1e-6 + sum(lamp(place, 8, value) for place, value in lights))
    assert len(found) == 2  # the candles are less than a fifth of the light, so the search ends
    assert count_sources(found) == 2
    even = [Region(r.mask, r.direction, torch.ones(3), r.solid_angle) for r in found * 10]
    assert count_sources(even) == 18
