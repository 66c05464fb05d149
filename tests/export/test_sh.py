"""Harmonics as engines store them: each engine's own shader, written out, must show our irradiance."""

import math
from collections.abc import Callable

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.export import sh
from mixlight.light import harmonics
from tests.tolerances import TOLERANCE

ENGINES = sorted(sh.LAYOUTS)
PI = math.pi


def random_harmonics(seed: int, *batch: int) -> Tensor:
    return torch.randn(*batch, 9, 3, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


def unity(c: Tensor, x: float, y: float, z: float) -> Tensor:
    """unity_SHAr/Br/C made of sh[channel, i] and summed as ShadeSH9 does."""
    linear = c[3] * x + c[1] * y + c[2] * z + (c[0] - c[6])
    return linear + c[4] * x * y + c[5] * y * z + 3 * c[6] * z * z + c[7] * z * x + c[8] * (x * x - y * y)


def filament(c: Tensor, x: float, y: float, z: float) -> Tensor:
    """Irradiance_SphericalHarmonics of Filament's indirect light, three bands."""
    first = c[0] + c[1] * y + c[2] * z + c[3] * x
    return (
        first + c[4] * y * x + c[5] * y * z + c[6] * (3 * z * z - 1) + c[7] * z * x + c[8] * (x * x - y * y)
    )


def three(c: Tensor, x: float, y: float, z: float) -> Tensor:
    """SphericalHarmonics3.getIrradianceAt, over pi."""
    total = c[0] * 0.886227 + 2 * 0.511664 * (c[1] * y + c[2] * z + c[3] * x)
    total = total + 2 * 0.429043 * (c[4] * x * y + c[5] * y * z + c[7] * x * z)
    return (total + c[6] * (0.743125 * z * z - 0.247708) + c[8] * 0.429043 * (x * x - y * y)) / PI


def arcore(c: Tensor, x: float, y: float, z: float) -> Tensor:
    """The factors that ARCore's sample multiplies the coefficients with, and its sum."""
    k = (0.282095, -0.325735, 0.325735, -0.325735, 0.273137, -0.273137, 0.078848, -0.273137, 0.136569)
    basis = (1, y, z, x, x * y, y * z, 3 * z * z - 1, z * x, x * x - y * y)
    return sum((f * b * row for f, b, row in zip(k, basis, c, strict=True)), torch.zeros(3))


def unreal(c: Tensor, x: float, y: float, z: float) -> Tensor:
    """TSHVector's basis function, with the diffuse transfer over pi."""
    basis = (
        0.282095, -0.488603 * y, 0.488603 * z, -0.488603 * x, 1.092548 * x * y, -1.092548 * y * z,
        0.315392 * (3 * z * z - 1), -1.092548 * x * z, 0.546274 * (x * x - y * y),
    )  # fmt: skip
    transfer = (1, *(2 / 3,) * 3, *(0.25,) * 5)
    return sum((t * b * row for t, b, row in zip(transfer, basis, c, strict=True)), torch.zeros(3))


AXES: dict[str, Callable[[float, float, float], tuple[float, float, float]]] = {
    "unity": lambda x, y, z: (x, y, -z),
    "unreal": lambda x, y, z: (-z, x, y),
}
SHADERS = {
    "unity": unity,
    "filament": filament,
    "three": three,
    "webxr": three,
    "arcore": arcore,
    "unreal": unreal,
}


@pytest.mark.parametrize("engine", SHADERS)
@given(seed=st.integers(0, 999), azimuth=st.floats(-3, 3), height=st.floats(-1, 1))
def test_the_engines_shader_shows_a_white_matte_surface_as_we_do(
    engine: str, seed: int, azimuth: float, height: float
) -> None:
    level = math.sqrt(1 - height**2)
    ours = (level * math.sin(azimuth), height, -level * math.cos(azimuth))
    light = random_harmonics(seed)
    shown = harmonics.irradiance(light, torch.tensor(ours, dtype=torch.float64)) / PI
    theirs = AXES.get(engine, lambda *n: n)(*ours)
    found = SHADERS[engine](sh.to_engine(light, engine), *theirs)
    torch.testing.assert_close(found.double(), shown, rtol=0, atol=2e-5)  # constants of six digits


def test_golden_factors() -> None:
    """Those of the table: cs and A_hat K, with Unity's z flip."""
    ones = torch.ones(9, 3, dtype=torch.float64)
    assert sh.to_engine(ones, "arcore")[:, 0].tolist() == pytest.approx([1, -1, 1, -1, 1, -1, 1, -1, 1])
    prescaled = [0.282095, *(0.325735,) * 3, *(0.273137,) * 2, 0.078848, 0.273137, 0.136569]
    assert sh.to_engine(ones, "filament")[:, 0].tolist() == pytest.approx(prescaled, abs=1e-6)
    flipped = [-v if i in (2, 5, 7) else v for i, v in enumerate(prescaled)]
    assert sh.to_engine(ones, "unity")[:, 0].tolist() == pytest.approx(flipped, abs=1e-6)
    for same in ("three", "webxr", "arkit", "mixlight"):
        torch.testing.assert_close(sh.to_engine(ones, same), ones)


def test_golden_axes_of_unreal() -> None:
    """Light from our front, -Z, is Unreal's +X: index 3, with the Condon-Shortley sign."""
    ahead = harmonics.basis(torch.tensor([0.0, 0.0, -1.0]))[:, None].expand(9, 3)
    found = sh.to_engine(ahead, "unreal")[:, 0]
    expected = torch.tensor([0.282095, 0, 0, -0.488603, 0, 0, -0.315392, 0, 0.546274])
    torch.testing.assert_close(found, expected, atol=1e-6, rtol=0)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("batch", [(), (2,), (1, 2)])
def test_back_again(engine: str, batch: tuple[int, ...]) -> None:
    light = random_harmonics(3, *batch)
    there = sh.to_engine(light, engine)
    assert there.shape == light.shape
    torch.testing.assert_close(sh.from_engine(there, engine), light, **TOLERANCE[torch.float64])


@pytest.mark.parametrize("engine", ENGINES)
def test_documents_say_what_they_are_and_come_back(engine: str) -> None:
    light = random_harmonics(5).float()
    document = sh.to_document(light, engine)
    assert set(document) == {"kind", "basis", "order", "degree", "frame", "layout", "coefficients"}
    values = torch.tensor(document["coefficients"])
    shaped = values.view(3, 9).T if engine in ("unity", "unreal", "arkit") else values.view(9, 3)
    torch.testing.assert_close(shaped, sh.to_engine(light, engine))
    torch.testing.assert_close(sh.read_document(document, engine), light, **TOLERANCE[torch.float32])
    for other in ENGINES:
        if sh.LAYOUTS[other].words != sh.LAYOUTS[engine].words:
            with pytest.raises(ValueError, match=r"harmonics\.\w+: expected"):
                sh.read_document(document, other)


@pytest.mark.parametrize("values", [[0.0] * 26, [0.0] * 26 + [math.nan], [0.0] * 26 + ["1"], None])
def test_broken_coefficients_are_named(values: object) -> None:
    document = {**sh.LAYOUTS["webxr"].words, "coefficients": values}
    with pytest.raises(ValueError, match=r"harmonics\.coefficients"):
        sh.read_document(document, "webxr")


@pytest.mark.usefixtures("unchecked")
def test_unknown_engines_and_other_degrees_are_refused() -> None:
    with pytest.raises(ValueError, match=r"expected an engine out of mixlight, three, .* received 'maya'"):
        sh.to_engine(torch.zeros(9, 3), "maya")
    with pytest.raises(ValueError, match=r"received shape \(4, 3\)"):
        sh.to_engine(torch.zeros(4, 3), "unity")
