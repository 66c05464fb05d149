"""Seven numbers of a panorama's light: known ones, what leaves them alone, a second computation, nonsense."""

import math
from dataclasses import astuple, fields, replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.data.rooms import stats
from mixlight.data.rooms.stats import (
    LABELS,
    Comparison,
    Reference,
    RoomStatistics,
    compare,
    measure,
    quantiles,
    read_reference,
    reference_document,
)
from mixlight.sphere import equirect
from tests.synthetic import room

NAMES = [field.name for field in fields(RoomStatistics)]


def near(found: RoomStatistics, expected: RoomStatistics, rel: float = 1e-4) -> None:
    assert astuple(found) == pytest.approx(astuple(expected), rel=rel, abs=1e-4)


def test_numbers_of_a_known_room() -> None:
    """Radiance 1 above the horizon and .5 below, with a lamp of 41 halfway up and a dark door; warm."""
    height = stats.HEIGHT
    panorama = torch.ones(height, 2 * height, 3)
    panorama[height // 2 :] = 0.5
    panorama[31:33, 100:102] = 41.0
    panorama[60:64, :10] = 0.5  # makes the lower value cover more than half
    found = measure(panorama * torch.tensor([1.2, 1.0, 0.6]))
    rows = equirect.row_solid_angle(height, dtype=torch.float64)
    lamp, door = 2 * float(rows[31:33].sum()), 10 * float(rows[60:64].sum())
    upper = 2 * math.pi + 40 * lamp - 0.5 * door
    light = upper + 0.5 * 2 * math.pi
    assert found.dynamic_range == pytest.approx(math.log10(41 / 0.5), abs=1e-6)
    # The brightest 5 % are the lamp and every texel of radiance 1: equal texels share their fate.
    assert found.top_share == pytest.approx((upper - 0.5 * door) / light, rel=1e-6)
    assert found.upper_share == pytest.approx(upper / light, rel=1e-6)
    assert found.red_over_blue == pytest.approx(2.0, rel=1e-6)
    assert found.ambient_contrast == pytest.approx(0.0, abs=1e-6)


def test_contrast_of_two_halves_is_half_the_logarithm_of_their_ratio() -> None:
    panorama = torch.ones(64, 128, 3)
    panorama[:, :64] = math.exp(-1.0)
    # 6 % of the sphere are brighter than all else, so that the ambient light is what is made here.
    rows = equirect.row_solid_angle(64, dtype=torch.float64).cumsum(0) * 128 / (4 * math.pi)
    caps = int(torch.searchsorted(rows, 0.03)) + 1
    panorama[:caps] = panorama[-caps:] = 9.0
    assert measure(panorama).ambient_contrast == pytest.approx(0.5, abs=1e-6)
    assert measure(panorama).source_elevation_deg == pytest.approx(0.0, abs=1e-6)


def test_contrast_does_not_follow_black_below_the_floor() -> None:
    black, blacker = room(64), room(64)
    black[50:54], blacker[50:54] = 1e-5, 0.0
    assert measure(black).ambient_contrast == pytest.approx(measure(blacker).ambient_contrast, rel=1e-6)


@pytest.mark.parametrize("elevation", [70, 20, -35])
def test_a_lamp_is_found_where_it_hangs(elevation: int) -> None:
    directions = equirect.pixel_directions(128)
    height = math.sin(math.radians(elevation))
    toward = torch.tensor([0.0, height, -math.sqrt(1 - height**2)])
    panorama = torch.full((128, 256, 3), 0.01)
    panorama[directions @ toward > math.cos(math.radians(6))] = 100.0
    found = measure(panorama)
    # The lamp covers .3 % of the sphere: the rest of the brightest 5 % has no luminance above the lowest.
    assert found.source_elevation_deg == pytest.approx(elevation, abs=0.3)
    assert found.top_share == pytest.approx(100 / (100 + 0.01 * (1 / 0.00274 - 1)), abs=0.01)
    assert 1 <= found.active_anchors <= 4


@given(
    gain=st.floats(1e-3, 1e3),
    turn=st.integers(0, 127),
    mirrored=st.booleans(),
    seed=st.integers(0, 50),
)
def test_exposure_azimuth_and_mirror_do_not_count(gain: float, turn: int, mirrored: bool, seed: int) -> None:
    panorama = room(64, seed)
    changed = panorama.roll(turn, 1) * gain
    changed = equirect.mirror(changed) if mirrored else changed
    expected, found = measure(panorama), measure(changed)
    # Anchors lie on a spiral, which a turn does not map onto itself: a lobe more or less, not many.
    assert found.active_anchors == pytest.approx(expected.active_anchors, rel=0.35, abs=3)
    near(replace(found, active_anchors=0), replace(expected, active_anchors=0))


@given(seed=st.integers(0, 50))
def test_upside_down(seed: int) -> None:
    panorama = room(64, seed)
    found, turned = measure(panorama), measure(panorama.flip(0))
    assert turned.source_elevation_deg == pytest.approx(-found.source_elevation_deg, abs=1e-6)
    assert turned.upper_share == pytest.approx(1 - found.upper_share, abs=1e-9)
    assert turned.dynamic_range == pytest.approx(found.dynamic_range, abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_against_plain_numpy(seed: int) -> None:
    """The same seven definitions with nothing of the package but the panorama's size."""
    panorama = room(128, seed)
    pixels = panorama.double().numpy()
    edges = np.cos(np.linspace(0, math.pi, 129))
    weight = np.repeat((edges[:-1] - edges[1:])[:, None] / 512, 256, 1)  # shares of the sphere
    light = pixels @ np.array([0.2126, 0.7152, 0.0722])
    order = np.argsort(light, axis=None)
    covered = np.cumsum(weight.ravel()[order])
    median = light.ravel()[order][np.searchsorted(covered, 0.5)]
    from_top = np.cumsum(weight.ravel()[order][::-1])
    limit = light.ravel()[order][::-1][np.searchsorted(from_top, 0.05)]
    top = light >= limit
    energy = light * weight
    elevation = 90 - (np.arange(128) + 0.5) * 180 / 128
    dark = np.log(light[~top])
    share = weight[~top] / weight[~top].sum()
    mean = (pixels * weight[..., None]).sum((0, 1))
    expected = {
        "dynamic_range": math.log10(light.max() / median),
        "top_share": energy[top].sum() / energy.sum(),
        "upper_share": energy[:64].sum() / energy.sum(),
        "source_elevation_deg": (energy * top).sum(1) @ elevation / energy[top].sum(),
        "red_over_blue": mean[0] / mean[2],
        "ambient_contrast": math.sqrt(share @ (dark - share @ dark) ** 2),
    }
    found = measure(panorama)
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=2e-4), name


def test_an_even_panorama() -> None:
    found = measure(torch.full((16, 32, 3), 3.0))
    near(found, RoomStatistics(0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0))


def test_other_sizes_measure_the_same_light() -> None:
    panorama = room(128)
    near(measure(equirect.resize(panorama, 256)), measure(panorama), rel=1e-3)


@pytest.mark.parametrize(
    ("panorama", "words"),
    [
        (torch.zeros(8, 16, 3), "black"),
        (torch.full((8, 16, 3), math.nan), "finite"),
        (-torch.ones(8, 16, 3), "at least 0"),
        (torch.ones(8, 24, 3), "2"),
    ],
)
def test_what_is_no_room_is_refused(panorama: Tensor, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        measure(panorama)


def test_more_than_half_black_is_refused() -> None:
    panorama = torch.zeros(32, 64, 3)
    panorama[:12] = 1.0
    with pytest.raises(ValueError, match="median 0"):
        measure(panorama)


def values(*numbers: float) -> list[RoomStatistics]:
    return [RoomStatistics(*[number] * len(NAMES)) for number in numbers]


def test_quantiles_are_numpys() -> None:
    numbers = [0.3, 7.0, 1.0, -2.0, 4.0, 4.5]
    expected = np.quantile(numbers, stats.QUANTILES)
    assert quantiles(values(*numbers))["top_share"] == pytest.approx(expected.tolist())
    assert list(quantiles(values(1.0))) == NAMES == list(LABELS)


def test_no_panoramas_no_quantiles() -> None:
    with pytest.raises(ValueError, match="at least one"):
        quantiles([])


@pytest.mark.parametrize(
    ("median", "verdict"), [(1.99, "low"), (2.0, "inside"), (3.1, "inside"), (4.0, "inside"), (4.01, "high")]
)
def test_verdict(median: float, verdict: str) -> None:
    row = Comparison("top_share", (0, 0, median, 9, 9), (0, 2.0, 3.0, 4.0, 9))
    assert row.verdict == verdict


def test_compare_puts_each_statistic_beside_its_own() -> None:
    reference = Reference("five", {str(k): one for k, one in enumerate(values(1, 2, 3, 4, 5))})
    rows = compare(values(10, 11, 12), reference)
    assert [row.name for row in rows] == NAMES
    assert {row.rooms[2] for row in rows} == {11.0}
    assert {row.reference for row in rows} == {(1.4, 2.0, 3.0, 4.0, 4.6)}
    assert {row.verdict for row in rows} == {"high"}


def test_the_reference_that_ships() -> None:
    reference = read_reference()
    assert reference.name == "25 real training interiors"
    assert {"hotel_room", "lebombo", "fireplace"} <= reference.measured.keys()
    table = quantiles(reference.measured.values())
    # The spans of design's table, which was measured on sixteen interiors, most of them among these.
    assert 2.6 < table["dynamic_range"][2] < 3.1
    assert 0.55 < table["top_share"][2] < 0.75
    assert 0.70 < table["upper_share"][2] < 0.76
    assert 15 < table["source_elevation_deg"][2] < 23
    assert 1.0 < table["red_over_blue"][2] < 1.1
    assert 0.85 < table["ambient_contrast"][2] < 1.0


def test_a_reference_comes_back_as_it_was_written() -> None:
    reference = Reference("one", {"a": RoomStatistics(2.5, 0.6, 0.7, 20.0, 1.05, 0.9, 30.0)})
    document = reference_document(reference)
    assert document["panoramas"] == {"a": [2.5, 0.6, 0.7, 20.0, 1.05, 0.9, 30.0]}
    assert document["statistics"] == NAMES
