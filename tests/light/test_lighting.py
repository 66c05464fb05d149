import dataclasses
import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import gaussians, harmonics
from mixlight.light.fit import fit
from mixlight.light.lighting import Lighting
from mixlight.sphere import equirect
from mixlight.sphere.frames import rotation
from mixlight.sphere.points import vogel
from tests.tolerances import TOLERANCE

EXACT = TOLERANCE[torch.float64]
SINGLE = TOLERANCE[torch.float32]


@pytest.fixture
def lighting(generator: torch.Generator) -> Lighting:
    """Float64, with an ambient part that is positive all over and seven lobes."""
    ambient = 0.1 * torch.randn(9, 3, generator=generator).double()
    ambient[0] = 3.0
    energy = torch.zeros(128, 3, dtype=torch.float64)
    energy[::19] = torch.rand(7, 3, generator=generator).double() + 0.1
    return Lighting(ambient, energy)


class TestMaps:
    def test_golden(self) -> None:
        ambient = torch.zeros(4, 3)
        ambient[0] = math.sqrt(4 * math.pi)
        energy = torch.zeros(128, 3)
        energy[64, 1] = 2.0
        panorama = Lighting(ambient, energy).environment(64)
        assert panorama[..., 0].unique().tolist() == pytest.approx([1.0])
        assert float(equirect.integrate(panorama)[1]) == pytest.approx(4 * math.pi + 2, rel=1e-6)

    def test_environment_is_ambient_and_sources(self, lighting: Lighting) -> None:
        expected = lighting.ambient_map(32) + lighting.sources_map(32)
        assert torch.equal(lighting.environment(32), expected)
        assert torch.equal(lighting.environment(), lighting.environment(128))

    @pytest.mark.parametrize("height", [4, 33, 128])
    def test_map_holds_the_energy(self, lighting: Lighting, height: int) -> None:
        torch.testing.assert_close(
            equirect.integrate(lighting.environment(height)),
            lighting.total_energy(),
            rtol=2.0 / height**2,  # the ambient grid's
            atol=0,
        )

    def test_clamping(self) -> None:
        ambient = torch.zeros(9, 3)
        ambient[1] = 1.0
        lighting = Lighting(ambient, torch.zeros(128, 3))
        assert lighting.ambient_map(16).min() == 0
        assert lighting.ambient_map(16, clamp=False).min() < -0.4
        assert torch.equal(lighting.environment(16), lighting.ambient_map(16))

    @pytest.mark.parametrize("batch", [(2,), (1, 2)])
    def test_batches(self, batch: tuple[int, ...], lighting: Lighting) -> None:
        many = Lighting(lighting.ambient.expand(*batch, 9, 3), lighting.energy.expand(*batch, 128, 3))
        one = lighting.environment(8)
        torch.testing.assert_close(many.environment(8), one.expand(*batch, 8, 16, 3), **EXACT)
        assert many.irradiance(torch.ones(5, 3).double()).shape == (*batch, 5, 3)
        assert many.total_energy().shape == (*batch, 3)
        assert many.pruned().energy.shape == (*batch, 128, 3)
        assert many.rotated(rotation(0.5)).energy.shape == (*batch, 128, 3)
        with pytest.raises(ValueError, match="active: expected a single lighting"):
            _ = many.active


class TestActive:
    def test_threshold_is_of_the_sources_luminance(self) -> None:
        energy = torch.zeros(128, 3)
        energy[3], energy[5], energy[7] = 1.0, 2e-4, 0.5e-4
        assert Lighting(torch.zeros(9, 3), energy).active.tolist() == [3, 5]

    def test_dark(self) -> None:
        assert Lighting(torch.zeros(9, 3), torch.zeros(128, 3)).active.tolist() == []

    @pytest.mark.parametrize("share", [1e-4, 0.05, 0.2])
    def test_pruned_keeps_energy_and_irradiance(self, lighting: Lighting, share: float) -> None:
        pruned = lighting.pruned(share)
        normals = vogel(40, dtype=torch.float64)
        torch.testing.assert_close(pruned.total_energy(), lighting.total_energy(), **EXACT)
        # The ambient light's degree is 2: what is missing of a handed-over lobe is its degree 4 and beyond.
        weak = (lighting.energy - pruned.energy).sum(0)
        error = (pruned.irradiance(normals) - lighting.irradiance(normals)).abs().amax(0)
        assert bool((error <= 0.11 * weak + 1e-9).all())

    def test_pruned_is_settled(self, room: Tensor) -> None:
        once = fit(room, prune=0).pruned()
        again = once.pruned()
        assert torch.equal(once.energy, again.energy)
        assert torch.equal(once.active, (once.energy != 0).any(-1).nonzero()[:, 0])

    def test_without(self, lighting: Lighting) -> None:
        left = lighting.without([0, 19])
        assert left.active.tolist() == lighting.active.tolist()[2:]
        assert bool(lighting.energy[0].any())


class TestScale:
    def test_scaled(self, lighting: Lighting) -> None:
        tinted = lighting.scaled((1.0, 2.0, 0.5))
        factor = torch.tensor([1.0, 2.0, 0.5]).double()
        torch.testing.assert_close(tinted.environment(8), lighting.environment(8) * factor, **EXACT)
        assert tinted.exposure_gain == 1.0

    @given(gain=st.floats(0.02, 50))
    def test_exposed_and_back(self, gain: float) -> None:
        lighting = Lighting(torch.ones(9, 3).double(), torch.ones(16, 3).double())
        exposed = lighting.exposed(gain)
        assert exposed.exposure_gain == pytest.approx(gain)
        torch.testing.assert_close(exposed.energy, lighting.energy * gain, **EXACT)
        torch.testing.assert_close(exposed.absolute().ambient, lighting.ambient, **EXACT)
        assert exposed.absolute().exposure_gain == 1.0

    def test_bad_gain(self, lighting: Lighting, unchecked: None) -> None:
        with pytest.raises(ValueError, match="negative"):
            lighting.scaled(-1.0)
        with pytest.raises(ValueError, match=r"received \(2,\)"):
            lighting.scaled((1.0, 2.0))  # type: ignore[arg-type]
        with pytest.raises(ValueError, match="above 0"):
            lighting.exposed(0.0)


class TestTurn:
    def test_ambient_exactly_and_lobes_to_the_nearest_anchor(self, lighting: Lighting) -> None:
        turn = rotation(0.7, 0.2, -0.3, dtype=torch.float64)
        turned = lighting.rotated(turn)
        torch.testing.assert_close(turned.ambient, harmonics.rotate(lighting.ambient, turn), **EXACT)
        torch.testing.assert_close(turned.energy.sum(0), lighting.energy.sum(0), **EXACT)
        for index in lighting.active.tolist():
            target = (turned.axes @ turn @ lighting.axes[index]).argmax()
            torch.testing.assert_close(turned.energy[target], lighting.energy[index], **EXACT)

    def test_two_lobes_meet(self) -> None:
        lighting = Lighting(torch.zeros(9, 3), torch.ones(128, 3))
        turned = lighting.rotated(rotation(0.4, 0.9))
        torch.testing.assert_close(turned.energy.sum(0), lighting.energy.sum(0))
        assert float(turned.energy.max()) > 1

    def test_mirrored(self, lighting: Lighting) -> None:
        mirrored = lighting.mirrored()
        torch.testing.assert_close(
            mirrored.ambient_map(16), equirect.mirror(lighting.ambient_map(16)), **EXACT
        )
        torch.testing.assert_close(mirrored.energy.sum(0), lighting.energy.sum(0), **EXACT)
        before = (lighting.energy[..., None] * lighting.axes[:, None]).sum((0, 1))
        after = (mirrored.energy[..., None] * mirrored.axes[:, None]).sum((0, 1))
        flip = torch.tensor([-1.0, 1.0, 1.0]).double()
        assert float(torch.cosine_similarity(after, before * flip, 0)) > 0.98  # anchors are no mirror images

    def test_identity(self, lighting: Lighting) -> None:
        same = lighting.rotated(torch.eye(3).double())
        torch.testing.assert_close(same.energy, lighting.energy, **EXACT)
        torch.testing.assert_close(same.ambient, lighting.ambient, **EXACT)


def test_irradiance_is_the_maps(lighting: Lighting) -> None:
    normals = vogel(20, dtype=torch.float64)
    directions = equirect.pixel_directions(128, dtype=torch.float64).reshape(-1, 3)
    weight = equirect.solid_angle(128, dtype=torch.float64).reshape(-1, 1)
    expected = (normals @ directions.T).clamp_min(0) @ (lighting.environment(128).reshape(-1, 3) * weight)
    torch.testing.assert_close(lighting.irradiance(normals), expected, rtol=1e-3, atol=1e-3)


def test_other_places_and_types(lighting: Lighting) -> None:
    single = lighting.to(torch.float32)
    assert single.ambient.dtype == single.energy.dtype == single.environment(4).dtype == torch.float32
    assert lighting.to("cpu").energy.dtype == torch.float64


def test_sources_are_sharp_lobes_on_the_anchors(lighting: Lighting) -> None:
    expected = gaussians.evaluate_map(vogel(128, dtype=torch.float64), lighting.energy, 0.0025, 32)
    assert torch.equal(lighting.sources_map(32), expected)


def test_immutable(lighting: Lighting) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        lighting.sharpness = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ambient": torch.zeros(8, 3)}, r"\(degree \+ 1\)\^2"),
        ({"ambient": torch.zeros(9, 4)}, r"received \(9, 4\) and \(128, 3\)"),
        ({"energy": torch.zeros(2, 128, 3)}, r"received \(9, 3\) and \(2, 128, 3\)"),
        ({"ambient": torch.zeros(3, 9, 3), "energy": torch.zeros(2, 128, 3)}, "one leading batch"),
        ({"ambient": torch.full((9, 3), math.nan)}, "ambient: expected finite"),
        ({"energy": torch.full((128, 3), math.inf)}, "energy: expected finite"),
        ({"energy": torch.full((128, 3), -1.0)}, "energy: expected finite values of at least 0"),
        ({"sharpness": 0.0}, "sharpness: expected a number above 0"),
        ({"exposure_gain": -2.0}, "exposure_gain: expected a number above 0"),
        ({"frame": "blender"}, "frame: expected 'mixlight'"),
    ],
)
def test_nonsense(changes: dict[str, object], message: str, unchecked: None) -> None:
    whole = {"ambient": torch.zeros(9, 3), "energy": torch.zeros(128, 3), **changes}
    with pytest.raises(ValueError, match=message):
        Lighting(**whole)  # type: ignore[arg-type]
