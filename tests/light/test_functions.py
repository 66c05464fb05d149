"""Sets of functions: best fits, inner products against explicit sums, and what they cannot hold."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from jaxtyping import TypeCheckError

from mixlight.light import functions, harmonics
from mixlight.light.functions import Functions
from mixlight.sphere import equirect

HEIGHT = 32
NAMES: tuple[Functions, ...] = ("constant", "sh2", "sh6", "sg9")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("batch", [(), (2,), (1, 2)])
def test_an_expansion_is_found_again(name: Functions, batch: tuple[int, ...]) -> None:
    generator = torch.Generator().manual_seed(0)
    true = torch.randn(*batch, functions.count(name), 3, generator=generator)
    panorama = torch.einsum("hwk,...kc->...hwc", functions.maps(name, HEIGHT), true)
    # Harmonics are projected with exact rows, whose sums over texel centres differ a little.
    torch.testing.assert_close(
        functions.project(panorama, name), true, rtol=0, atol=5e-2 if name == "sh6" else 1e-2
    )


@given(seed=st.integers(0, 100))
def test_no_other_smooth_gaussians_are_nearer(seed: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    panorama = torch.rand(16, 32, 3, generator=generator)
    best = functions.project(panorama, "sg9")
    other = best + 0.01 * torch.randn(9, 3, generator=generator)
    maps, weight = (
        functions.maps("sg9", 16).double(),
        equirect.solid_angle(16, dtype=torch.float64)[..., None],
    )

    def error(coefficients: torch.Tensor) -> float:
        return float(((maps @ coefficients.double() - panorama.double()).square() * weight).sum())

    assert error(best) <= error(other)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("cosine", [False, True])
def test_inner_products_are_those_of_the_maps(name: Functions, cosine: bool) -> None:
    """Explicit sums over a fine map; irradiance through the harmonics of each function's own map."""
    height = 128
    maps = functions.maps(name, height).double()
    if cosine:
        coefficients = harmonics.project(maps, 6)
        factors = torch.tensor(
            [harmonics.cosine_factor(band) / math.pi for band in range(7)], dtype=torch.float64
        )
        shown = coefficients * factors[harmonics.degrees(6)][:, None]
        expected = shown.T @ shown
    else:
        weight = equirect.solid_angle(height, dtype=torch.float64)
        expected = torch.einsum("hwk,hwj,hw->kj", maps, maps, weight)
    torch.testing.assert_close(functions.products(name, cosine), expected, rtol=0, atol=1e-3)


def test_smooth_gaussians_integrate_to_one() -> None:
    for height in (8, 31, 128):
        total = equirect.integrate(functions.maps("sg9", height))
        torch.testing.assert_close(total, torch.ones(9), rtol=1e-5, atol=1e-5)


def test_a_table_is_the_callers_own() -> None:
    functions.maps("sh2", 8).zero_()
    assert float(functions.maps("sh2", 8).abs().max()) > 0


def test_bad_input_is_refused(unchecked: None) -> None:
    with pytest.raises((ValueError, TypeCheckError), match="sh3"):
        functions.count("sh3")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="twice the height"):
        functions.project(torch.ones(8, 8, 3), "sg9")
