import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import _level_set, harmonics, separate
from mixlight.light import fit as fit_module
from mixlight.light.fit import energy_report, fit, parameters
from mixlight.sphere import equirect
from mixlight.sphere.points import anchor_map, nearest, vogel
from tests.tolerances import TOLERANCE

EXACT = TOLERANCE[torch.float64]
SINGLE = TOLERANCE[torch.float32]
METHODS: list[separate.Method] = ["top_fraction", "max_fraction"]


class TestParameters:
    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("degree", [0, 2, 5])
    def test_the_method_word_by_word(self, method: separate.Method, degree: int, room: Tensor) -> None:
        panorama = room.double()
        sources, ambient = separate.separate(panorama, method, 0.05)
        weight = equirect.solid_angle(64, dtype=torch.float64)[..., None]
        energy = torch.zeros(128, 3, dtype=torch.float64)
        energy.index_add_(0, anchor_map(128, 64).reshape(-1), (sources * weight).reshape(-1, 3))
        total = energy.sum(0)
        share = separate.luminance(energy) / separate.luminance(total)

        found = parameters(panorama, separation=method, degree=degree)
        torch.testing.assert_close(found.anchor_energy, energy, **EXACT)
        torch.testing.assert_close(found.intensity, total.square().sum().sqrt(), **EXACT)
        torch.testing.assert_close(found.colour, total / total.square().sum().sqrt(), **EXACT)
        torch.testing.assert_close(found.distribution, share, **EXACT)
        torch.testing.assert_close(found.ambient, harmonics.project(ambient, degree), **EXACT)
        torch.testing.assert_close(found.lobe_energy(), share[:, None] * total, **EXACT)

    def test_golden(self) -> None:
        panorama = torch.zeros(64, 128, 3, dtype=torch.float64)
        panorama[20, 90] = torch.tensor([3.0, 4.0, 0.0])
        omega = float(equirect.row_solid_angle(64, dtype=torch.float64)[20])
        anchor = int(nearest(vogel(128), equirect.pixel_directions(64)[20, 90]))
        found = parameters(panorama)
        assert float(found.intensity) == pytest.approx(5 * omega)
        assert found.colour.tolist() == pytest.approx([0.6, 0.8, 0])
        assert found.distribution[anchor] == pytest.approx(1)
        assert not found.ambient.any()

    @pytest.mark.parametrize("batch", [(), (2,), (1, 2)])
    def test_batches(self, batch: tuple[int, ...], generator: torch.Generator) -> None:
        panorama = torch.rand(*batch, 16, 32, 3, generator=generator) ** 5
        found = parameters(panorama, anchors=32)
        assert [tuple(part.shape) for part in found] == [
            (*batch, 32), batch, (*batch, 3), (*batch, 32, 3), (*batch, 9, 3),
        ]  # fmt: skip
        last = parameters(panorama.reshape(-1, 16, 32, 3)[-1], anchors=32)
        for part, alone in zip(found, last, strict=True):
            assert torch.equal(part.reshape(-1, *alone.shape)[-1], alone)

    @pytest.mark.parametrize("dtype", [torch.float16, torch.float32, torch.float64])
    def test_dtypes(self, dtype: torch.dtype, room: Tensor) -> None:
        found = parameters(room.to(dtype))
        assert {part.dtype for part in found} == {torch.promote_types(dtype, torch.float32)}

    def test_no_source(self) -> None:
        found = parameters(torch.full((16, 32, 3), 0.5), anchors=64)
        assert float(found.intensity) == 0
        assert found.colour.tolist() == pytest.approx([1 / math.sqrt(3)] * 3)
        assert found.distribution.tolist() == pytest.approx([1 / 64] * 64)
        assert not found.lobe_energy().any()

    @given(gain=st.floats(1e-6, 1e6), seed=st.integers(0, 20))
    def test_exposure_scales_what_it_should(self, gain: float, seed: int) -> None:
        panorama = torch.rand(16, 32, 3, generator=torch.Generator().manual_seed(seed)).double() ** 6
        before, after = parameters(panorama, anchors=32), parameters(panorama * gain, anchors=32)
        torch.testing.assert_close(after.distribution, before.distribution, **EXACT)
        torch.testing.assert_close(after.colour, before.colour, **EXACT)
        torch.testing.assert_close(after.intensity, before.intensity * gain, **EXACT)
        torch.testing.assert_close(after.ambient / gain, before.ambient, **EXACT)

    def test_no_gradient(self, room: Tensor) -> None:
        assert not parameters(room.requires_grad_()).ambient.requires_grad

    def test_many_bands(self, room: Tensor, monkeypatch: pytest.MonkeyPatch) -> None:
        whole = parameters(room)
        monkeypatch.setattr(_level_set, "BAND", 300)
        monkeypatch.setattr(_level_set, "KEPT", 0)
        for part, expected in zip(parameters(room), whole, strict=True):
            torch.testing.assert_close(part, expected, **SINGLE)

    def test_a_sun_does_not_drown_the_ambient_light(self) -> None:
        panorama = torch.full((64, 128, 3), 0.25)
        panorama[20, 40] = 1e7
        hole = equirect.row_solid_angle(64, dtype=torch.float64)[20]
        found = parameters(panorama).ambient[0].double() * math.sqrt(4 * math.pi)
        torch.testing.assert_close(found, (0.25 * (4 * math.pi - hole)).expand(3), rtol=1e-6, atol=0)

    @pytest.mark.parametrize("degree", [-1, 7])
    def test_bad_degree(self, degree: int) -> None:
        with pytest.raises(ValueError, match="degree"):
            parameters(torch.ones(4, 8, 3), degree=degree)

    def test_bad_input(self) -> None:
        with pytest.raises(ValueError, match="at least 1 point, received 0"):
            parameters(torch.ones(4, 8, 3), anchors=0)
        with pytest.raises(ValueError, match="fraction"):
            parameters(torch.ones(4, 8, 3), fraction=1.5)
        with pytest.raises(ValueError, match="2:1"):
            parameters(torch.ones(4, 12, 3))


class TestFit:
    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("per_anchor_colour", [True, False])
    @pytest.mark.parametrize("degree", [0, 2, 6])
    def test_holds_the_energy(
        self, method: separate.Method, per_anchor_colour: bool, degree: int, room: Tensor
    ) -> None:
        lighting = fit(room, separation=method, per_anchor_colour=per_anchor_colour, degree=degree)
        torch.testing.assert_close(lighting.total_energy(), equirect.integrate(room), **SINGLE)
        assert lighting.degree == degree

    @given(
        seed=st.integers(0, 99),
        power=st.floats(0, 20),
        fraction=st.floats(0.001, 0.9),
        method=st.sampled_from(METHODS),
    )
    def test_holds_any_energy(
        self, seed: int, power: float, fraction: float, method: separate.Method
    ) -> None:
        panorama = torch.rand(8, 16, 3, generator=torch.Generator().manual_seed(seed)) ** power
        lighting = fit(panorama, separation=method, fraction=fraction)
        torch.testing.assert_close(lighting.total_energy(), equirect.integrate(panorama), rtol=1e-5, atol=0)

    def test_the_map_shows_the_lamp_where_it_was(self) -> None:
        panorama = torch.full((64, 128, 3), 0.1)
        panorama[16:18, 100:102] = 200.0
        truth = equirect.pixel_directions(64)[17, 101]
        shown = fit(panorama).environment(64)[..., 1]
        found = equirect.pixel_directions(64).reshape(-1, 3)[shown.reshape(-1).argmax()]
        assert float(truth @ found) > math.cos(math.radians(12))  # an anchor's cell, and a texel

    @pytest.mark.parametrize("batch", [(2,), (1, 2)])
    def test_batches(self, batch: tuple[int, ...], generator: torch.Generator) -> None:
        panorama = torch.rand(*batch, 16, 32, 3, generator=generator) ** 5
        lighting = fit(panorama)
        assert lighting.environment(8).shape == (*batch, 8, 16, 3)
        alone = fit(panorama.reshape(-1, 16, 32, 3)[-1])
        assert torch.equal(lighting.energy.reshape(-1, 128, 3)[-1], alone.energy)
        torch.testing.assert_close(lighting.ambient.reshape(-1, 9, 3)[-1], alone.ambient, **SINGLE)

    def test_prunes_and_hands_over(self, room: Tensor) -> None:
        room[40, 6] *= 1e5  # a sun, beside which the surround's speckles are nothing
        lighting, whole = fit(room), fit(room, prune=0)
        lit = (lighting.energy != 0).any(-1).nonzero()[:, 0]
        assert torch.equal(lit, lighting.active)
        assert torch.equal(lighting.energy[lit], whole.energy[lit])
        assert len(lit) < int((whole.energy != 0).any(-1).sum())

    def test_all_black(self) -> None:
        lighting = fit(torch.zeros(8, 16, 3))
        assert not lighting.environment(8).any()

    def test_finer_map_same_light(self, room: Tensor) -> None:
        fine = room.repeat_interleave(4, 0).repeat_interleave(4, 1)
        torch.testing.assert_close(
            fit(fine, separation="max_fraction").ambient,
            fit(room, separation="max_fraction").ambient,
            rtol=0,
            atol=1e-2,  # texel centres against texels of four times the side
        )


class TestEnergyReport:
    def test_counts_what_clamping_adds(self, room: Tensor) -> None:
        panorama = room.clone()
        panorama[32:] *= 0.001  # a black floor under a bright ceiling: negative lobes
        lighting = fit(panorama, separation="max_fraction")
        report = energy_report(panorama, lighting)
        assert abs(float(report["error"])) < 1e-6  # type: ignore[arg-type]
        assert 0 < float(report["clamped_sphere"]) < 1  # type: ignore[arg-type]
        shown = equirect.integrate(lighting.environment(128).double())
        torch.testing.assert_close(
            torch.tensor(report["map"], dtype=torch.float64), shown, rtol=1e-4, atol=0
        )  # the map's grid
        before = equirect.integrate(panorama.double())
        added = float(separate.luminance(shown - before) / separate.luminance(before))
        assert report["clamping"] == pytest.approx(added, rel=1e-2)
        parts = torch.tensor([report["sources"], report["ambient"]]).sum(0)
        torch.testing.assert_close(parts, torch.tensor(report["out"]), **SINGLE)

    def test_black(self) -> None:
        black = torch.zeros(8, 16, 3)
        with pytest.raises(ValueError, match="black all over"):
            energy_report(black, fit(black))


def test_the_default_is_the_papers() -> None:
    assert fit_module.ANCHORS == 128
    assert fit(torch.ones(8, 16, 3)).sharpness == 0.0025
