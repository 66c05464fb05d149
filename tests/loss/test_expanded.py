"""The objective of sources in harmonics, and the losses on smooth Gaussians against explicit maps."""

import math

import pytest
import torch

from mixlight.light import functions
from mixlight.loss.common import LossWeights, expansion_loss, synthesised
from mixlight.loss.expanded import ExpandedLoss
from mixlight.sphere import equirect

HEIGHT = 16


def light(seed: int = 0) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Sources, ambient light, and their map, all above 0."""
    generator = torch.Generator().manual_seed(seed)
    sources, ambient = (0.05 * torch.randn(2, k, 3, generator=generator) for k in (49, 9))
    sources[:, 0], ambient[:, 0] = 2.0, 3.0
    maps = [functions.maps(name, HEIGHT) for name in ("sh6", "sh2")]
    flat = sum(torch.einsum("hwk,bkc->bhwc", m, c) for m, c in zip(maps, (sources, ambient), strict=True))
    return sources, ambient, torch.as_tensor(flat)


def test_the_true_light_costs_least_and_terms_are_those_that_apply() -> None:
    loss = ExpandedLoss(LossWeights(), HEIGHT)
    sources, ambient, picture = light()
    camera = torch.zeros(2, 2)
    best, terms = loss(sources, ambient, camera, sources, ambient, picture, camera)
    worse, _ = loss(1.5 * sources, 0.5 * ambient, camera, sources, ambient, picture, camera)
    assert float(best) == pytest.approx(0, abs=1e-3)
    assert float(worse) > 0.1
    assert "source_reconstruction" in terms
    assert not {"distribution", "transport", "masked_l1"} & terms.keys()


def test_no_scale_matters() -> None:
    loss = ExpandedLoss(LossWeights(), HEIGHT)
    sources, ambient, picture = light()
    other, camera = light(1), torch.zeros(2, 2)
    plain, _ = loss(other[0], other[1], camera, sources, ambient, picture, camera)
    scaled, _ = loss(4 * other[0], 4 * other[1], camera, 4 * sources, 4 * ambient, 4 * picture, camera)
    torch.testing.assert_close(scaled, plain, rtol=1e-4, atol=0)


def test_the_map_losses_on_smooth_gaussians_are_those_of_their_maps() -> None:
    generator = torch.Generator().manual_seed(0)
    error = torch.randn(9, 3, generator=generator)
    maps = functions.maps("sg9", 128)
    weight = equirect.solid_angle(128)[..., None]
    mean = ((maps @ error).square() * weight).sum() / (2 * math.pi**2 * 3)
    found = expansion_loss(error, 0 * error, "sg9", "reconstruction")
    assert float(found) == pytest.approx(float(mean), rel=1e-3)
    irradiance = functions.project(maps @ error, "sh6")
    expected = expansion_loss(irradiance, 0 * irradiance, "sh6", "rendering")
    assert float(expansion_loss(error, 0 * error, "sg9", "rendering")) == pytest.approx(
        float(expected), rel=2e-2
    )


def test_one_wide_product_is_many_small_ones() -> None:
    maps, coefficients = torch.rand(10, 4), torch.rand(3, 4, 3)
    torch.testing.assert_close(synthesised(maps, coefficients), maps @ coefficients)
