"""What a protocol measures on maps."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

from mixlight.evaluation.protocols import PROTOCOLS, find
from mixlight.evaluation.renderers import Renderer, matrix
from mixlight.evaluation.scoring import score
from mixlight.light.compare import rmse_and_si_rmse
from mixlight.render.spheres import SphereRenderer
from tests.synthetic import room


@pytest.fixture(scope="module")
def linear() -> Renderer:
    return matrix("M")


class Flat:
    """Shows the map itself in every sphere: numbers can be worked out by hand."""

    def __init__(self) -> None:
        self.about: dict[str, object] = {"kind": "flat"}
        self.frame = (8, 10)
        self.mask = torch.ones(4, 8, dtype=torch.bool)

    def render(self, maps: Tensor) -> Tensor:
        return maps[:, None].expand(-1, 3, -1, -1, -1)


SMALL_S = replace(PROTOCOLS["S"], map_height=4)


def test_protocol_m_is_linear_spheres_over_pixels_and_channels(linear: Renderer) -> None:
    """Against the renderer of protocol M as it is used elsewhere, and the formula."""
    true, predicted = room(128, 1), room(128, 2)
    (cells,) = score(PROTOCOLS["M"], [predicted], true, linear)
    spheres = SphereRenderer(resolution=64)
    pictures = spheres.render(torch.stack([predicted, true]))[:, :, spheres.mask]
    rmse, si_rmse = rmse_and_si_rmse(pictures[0], pictures[1])
    for i, sphere in enumerate(("diffuse", "matte", "mirror")):
        assert cells[f"{sphere}_rmse"] == pytest.approx(float(rmse[i]), rel=1e-5)
        assert cells[f"{sphere}_si_rmse"] == pytest.approx(float(si_rmse[i]), rel=1e-5)
        assert cells[f"{sphere}_geometric"] == pytest.approx(math.sqrt(rmse[i] * si_rmse[i]), rel=1e-5)
    assert tuple(cells) == PROTOCOLS["M"].cells


def test_the_truth_has_no_error_and_its_double_no_scale_invariant_one(linear: Renderer) -> None:
    true = room(128, 3)
    same, double = score(PROTOCOLS["M"], [true, 2 * true], true, linear)
    assert max(same.values()) < 1e-5
    assert double["matte_si_rmse"] < 1e-4 < double["matte_rmse"]


def test_maps_of_another_size_are_compared_at_the_protocols(linear: Renderer) -> None:
    """An even map is the same at any size."""
    even = torch.full((32, 64, 3), 0.3)
    (cells,) = score(PROTOCOLS["M"], [even], torch.full((256, 512, 3), 0.3), linear)
    assert max(cells.values()) < 1e-5


def test_protocol_s_divides_brightness_out_and_divides_by_pixels() -> None:
    """A map of halves; the channels of the prediction differ by a factor of 2 in every second column.

    The truth is .5 encoded everywhere. The prediction is 1 in half of its values and 2^(1/2.4) times that in
    the others; its median of values lies between the two.
    """
    true = torch.full((4, 8, 3), 3.0)
    predicted = torch.full((4, 8, 3), 1.0)
    predicted[:, ::2] = 2.0
    (cells,) = score(SMALL_S, [predicted], true, Flat())
    high = 2 ** (1 / 2.4)
    scale = 0.5 / ((1 + high) / 2)
    errors = np.array([scale - 0.5, scale * high - 0.5])
    assert cells["matte_rmse"] == pytest.approx(math.sqrt(3 * (errors**2).mean()), rel=1e-5)
    ratio = 0.5 * (scale + scale * high) / (scale**2 + (scale * high) ** 2)
    residual = np.array([ratio * scale - 0.5, ratio * scale * high - 0.5])
    assert cells["matte_si_rmse"] == pytest.approx(math.sqrt(3 * (residual**2).mean()), rel=1e-5)
    assert cells["matte_angle_deg"] == pytest.approx(0, abs=1e-3)
    assert tuple(cells) == PROTOCOLS["S"].cells


def test_protocol_s_does_not_see_brightness() -> None:
    true = room(4, 5)
    one, bright = score(SMALL_S, [room(4, 6), 100 * room(4, 6)], true, Flat())
    for cell, value in one.items():
        assert bright[cell] == pytest.approx(value, rel=1e-4, abs=1e-6)


def test_protocol_s_sees_colour() -> None:
    true = torch.full((4, 8, 3), 1.0)
    red = true * torch.tensor([2.0, 1.0, 1.0])
    (cells,) = score(SMALL_S, [red], true, Flat())
    a = np.array([2 ** (1 / 2.4), 1, 1])
    expected = math.degrees(math.acos(a.sum() / np.linalg.norm(a) / math.sqrt(3)))
    assert cells["diffuse_angle_deg"] == pytest.approx(expected, rel=1e-4)


def test_a_renderer_is_asked_for() -> None:
    with pytest.raises(ValueError, match="expected a renderer for the spheres of protocol M"):
        score(PROTOCOLS["M"], [room(32)], room(32))


@pytest.mark.parametrize("letter", ["M", "S", "L"])
def test_bad_maps_are_refused(letter: str, linear: Renderer) -> None:
    bad = torch.full((32, 64, 3), math.nan)
    with pytest.raises(ValueError, match="expected"):
        score(find(letter), [bad], room(32), linear)
    with pytest.raises(ValueError, match="expected"):
        score(find(letter), [torch.ones(32, 32, 3)], room(32), linear)


def test_protocol_l_needs_no_renderer() -> None:
    (cells,) = score(PROTOCOLS["L"], [2 * room(64)], room(64))
    assert cells["energy_log2"] == pytest.approx(1, abs=1e-5)
    assert {*cells, "active_anchors"} == set(PROTOCOLS["L"].cells)


def test_there_is_no_other_protocol() -> None:
    with pytest.raises(ValueError, match="expected a protocol out of M, S, L, got 'X'"):
        find("X")


def test_predictions_of_several_sizes_are_scored_together() -> None:
    """An even light is the same at any size."""
    found = score(PROTOCOLS["L"], [torch.full((h, 2 * h, 3), 0.5) for h in (32, 64, 128)], room(64))
    assert found[1:] == [pytest.approx(found[0], rel=1e-5)] * 2
