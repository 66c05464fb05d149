"""Lamps: found where they are, energy kept, wrapped around the seam, and differentiable."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.light import lamps
from mixlight.light.lamps import Lamps
from mixlight.sphere import equirect


def room(height: int = 32) -> torch.Tensor:
    return torch.full((height, 2 * height, 3), 0.1)


def test_lamps_are_found_by_their_peaks_with_their_sizes() -> None:
    panorama = room()
    panorama[8:10, 20:23] = torch.tensor([8.0, 6.0, 4.0])
    panorama[12, 50] = 5.0
    panorama[4, 5] = 2.0
    found = lamps.find(panorama)
    rays, weight = equirect.pixel_directions(32), equirect.solid_angle(32)
    assert float(found.direction[0] @ rays[9, 21]) > 0.99
    assert float(found.direction[1] @ rays[12, 50]) > 0.999
    size = float(weight[8:10, 20:23].sum()) / (2 * math.pi)
    assert float(found.sharpness[0]) == pytest.approx(size, rel=1e-5)
    colour = found.energy[0] / found.energy[0, 0]
    torch.testing.assert_close(colour, torch.tensor([1.0, 0.75, 0.5]))
    torch.testing.assert_close(found.ambient, torch.full((3,), 0.1), rtol=2e-2, atol=0)


def test_a_region_goes_down_to_a_third_and_over_the_seam() -> None:
    panorama = room()
    panorama[10, 63], panorama[10, 0], panorama[10, 1], panorama[10, 2] = 9.0, 5.0, 3.1, 2.9
    found = lamps.find(panorama, lamps=1)
    expected = float((torch.tensor([9.0, 5.0, 3.1]) * equirect.solid_angle(32)[10, 0]).sum())
    assert float(found.energy[0, 0]) == pytest.approx(expected, rel=1e-5)


def test_even_light_has_no_lamp() -> None:
    found = lamps.find(room())
    assert float(found.energy.abs().max()) == 0
    torch.testing.assert_close(found.ambient, torch.full((3,), 0.1))
    assert bool(lamps.find(torch.zeros(16, 32, 3)).direction.isfinite().all())


@given(seed=st.integers(0, 1000))
def test_energy_is_kept_and_a_turn_turns_the_lamps(seed: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    panorama = torch.rand(16, 32, 3, generator=generator) ** 6
    found = lamps.find(panorama)
    torch.testing.assert_close(
        equirect.integrate(lamps.environment(found, 16)), equirect.integrate(panorama), rtol=1e-4, atol=1e-5
    )
    turned = lamps.find(equirect.rotate_azimuth(panorama, math.pi / 2))
    torch.testing.assert_close(turned.energy, found.energy, rtol=1e-4, atol=1e-5)
    lit = found.energy.sum(-1) > 0
    # A quarter turn of the viewer to the right brings what was at +X ahead.
    x, y, z = found.direction[lit].unbind(-1)
    torch.testing.assert_close(turned.direction[lit], torch.stack([z, y, -x], -1), rtol=0, atol=1e-4)


@pytest.mark.parametrize("batch", [(), (2,), (1, 2)])
def test_batches_are_found_as_each_alone(batch: tuple[int, ...]) -> None:
    panorama = torch.rand(*batch, 16, 32, 3, generator=torch.Generator().manual_seed(1)) ** 4
    together = lamps.find(panorama)
    one = lamps.find(panorama.reshape(-1, 16, 32, 3)[-1])
    for name in Lamps._fields:
        whole = getattr(together, name)
        torch.testing.assert_close(whole.reshape(-1, *getattr(one, name).shape)[-1], getattr(one, name))


def test_the_map_has_gradients_for_every_part() -> None:
    direction = torch.nn.functional.normalize(torch.tensor([[0.3, 0.8, -0.2]], dtype=torch.float64), dim=-1)
    parts = [direction, torch.tensor([0.2]).double(), torch.rand(1, 3).double(), torch.rand(3).double()]
    for part in parts:
        part.requires_grad_()
    assert torch.autograd.gradcheck(lambda *p: lamps.environment(Lamps(*p), 4), parts)


def test_bad_input_is_refused() -> None:
    with pytest.raises(ValueError, match=r"2:1|twice"):
        lamps.find(torch.ones(8, 8, 3))
    with pytest.raises(ValueError, match="at least 1"):
        lamps.environment(lamps.find(room(8)), 0)
