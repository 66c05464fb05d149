"""Bright regions: grown from peaks, connected on the sphere, found brightest first."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from mixlight.light.regions import bright_regions, connected
from mixlight.light.separate import luminance
from mixlight.sphere import equirect
from tests.synthetic import room


def cap(height: int, direction: tuple[float, float, float], radius_deg: float, value: float) -> torch.Tensor:
    rays = equirect.pixel_directions(height)
    axis = torch.nn.functional.normalize(torch.tensor(direction, dtype=torch.float32), dim=0)
    inside = rays @ axis > math.cos(math.radians(radius_deg))
    return inside[..., None] * torch.full((3,), value)


@pytest.mark.parametrize(
    "direction", [(0, 0, -1), (0, 0, 1), (0, 1, 0), (0.1, -1, 0), (1, 0.5, 0.2)], ids=str
)
def test_a_round_lamp_is_one_region_of_its_direction_size_and_energy(
    direction: tuple[float, float, float],
) -> None:
    """Ahead, behind (across the seam), at both poles."""
    panorama = 0.01 + cap(128, direction, 8, 5.0)
    (found,) = bright_regions(panorama, limit=1)
    axis = torch.nn.functional.normalize(torch.tensor(direction, dtype=torch.float32), dim=0)
    assert math.degrees(math.acos(min(1, float(found.direction @ axis)))) < 0.4
    assert math.degrees(found.angular_radius) == pytest.approx(8, abs=0.7)  # half a texel
    torch.testing.assert_close(found.energy, torch.full((3,), 5.01 * found.solid_angle), rtol=1e-4, atol=0)


def test_regions_come_brightest_peak_first_and_do_not_overlap() -> None:
    panorama = 0.02 + cap(64, (0, 0, -1), 10, 2.0) + cap(64, (1, 1, 0), 5, 9.0) + cap(64, (-1, 0, 0), 20, 1.0)
    found = bright_regions(panorama)
    assert [round(float(panorama[r.mask].max()), 2) for r in found[:3]] == [9.02, 2.02, 1.02]
    assert int(torch.stack([r.mask for r in found]).sum(0).max()) == 1


def test_a_region_ends_where_the_luminance_falls_below_the_ratio() -> None:
    panorama = torch.full((32, 64, 3), 0.1)
    panorama[12, 20:26] = torch.tensor([9.0, 8.0, 4.0, 2.9, 9.0, 1.0])[:, None]
    first, second = bright_regions(panorama, 1 / 3, limit=2)
    assert first.mask.nonzero()[:, 1].tolist() == [20, 21, 22]
    assert second.mask.nonzero()[:, 1].tolist() == [24]  # 2.9 is below a third of 9, and touches only


def test_the_search_ends_when_little_is_left() -> None:
    lamp = cap(64, (0, 1, -1), 6, 100.0)
    assert len(bright_regions(0.001 + lamp)) == 1
    energy = float(luminance(equirect.integrate(lamp)))
    background = 0.3 * energy / (4 * math.pi)  # 23 % of the light
    assert len(bright_regions(background + lamp)) == 2
    assert len(bright_regions(torch.full((32, 64, 3), 0.7))) == 1
    assert bright_regions(torch.zeros(32, 64, 3)) == []
    assert len(bright_regions(torch.rand(32, 64, 3), 0.999, limit=4)) == 4


@given(st.integers(0, 10_000), st.floats(0.05, 0.6))
def test_connected_is_what_scipy_labels_on_a_padded_map(seed: int, density: float) -> None:
    """The map is laid out three times side by side with a full row beyond each pole, and labelled."""
    height, width = 8, 12
    mask = np.random.default_rng(seed).random((height, width)) < density
    if not mask.any():
        return
    row, column = (int(axis[seed % mask.sum()]) for axis in mask.nonzero())
    wide = np.zeros((height + 2, 3 * width), dtype=bool)
    wide[1:-1] = np.tile(mask, (1, 3))
    wide[0], wide[-1] = mask[0].any(), mask[-1].any()
    found = np.zeros_like(mask)
    found[row, column] = True
    while True:  # the copies at the rim lack a neighbour: go round until nothing is added
        labels, _ = ndimage.label(wide, np.ones((3, 3)))
        seeds = np.unique(labels[1:-1][np.tile(found, (1, 3))])
        grown = np.isin(labels[1:-1], seeds[seeds > 0]).reshape(height, 3, width).any(1)
        if (grown == found).all():
            break
        found = grown
    np.testing.assert_array_equal(connected(mask, (row, column)), found)


@given(st.integers(0, 1000))
def test_a_turned_panorama_has_the_turned_regions(seed: int) -> None:
    panorama = room(32, seed)
    turn = seed % 64
    still, turned = bright_regions(panorama), bright_regions(panorama.roll(turn, 1))
    assert len(still) == len(turned)
    for a, b in zip(still, turned, strict=True):
        assert torch.equal(a.mask.roll(turn, 1), b.mask)
        torch.testing.assert_close(a.energy, b.energy, rtol=1e-5, atol=1e-6)


@given(st.integers(0, 1000), st.floats(1e-3, 1e3))
def test_a_brighter_panorama_has_the_same_regions(seed: int, gain: float) -> None:
    panorama = room(32, seed).double()
    for a, b in zip(bright_regions(panorama), bright_regions(panorama * gain), strict=True):
        assert torch.equal(a.mask, b.mask)
        torch.testing.assert_close(a.energy * gain, b.energy)


def test_bad_input() -> None:
    with pytest.raises(ValueError, match="expected"):
        bright_regions(torch.ones(32, 32, 3))
    with pytest.raises(ValueError, match="ratio: expected"):
        bright_regions(torch.ones(32, 64, 3), 0.0)
    with pytest.raises(ValueError, match="a texel of the mask"):
        connected(np.zeros((2, 4), dtype=bool), (0, 0))
