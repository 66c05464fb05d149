import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from mixlight.light import _level_set, separate
from mixlight.sphere import equirect

BATCHES = [(), (2,), (1, 2)]
METHODS: list[separate.Method] = ["top_fraction", "max_fraction"]


def coverage(mask: Tensor) -> float:
    weight = equirect.solid_angle(mask.shape[-2], dtype=torch.float64)
    return float((mask * weight).sum() / (4 * math.pi))


def by_sorting(panorama: Tensor, fraction: float) -> Tensor:
    """The definition of ``top_fraction``, word by word."""
    level = separate.luminance(panorama).float().reshape(-1)
    weight = equirect.solid_angle(panorama.shape[0], dtype=torch.float64).reshape(-1)
    order = level.argsort(descending=True)
    covered = weight[order].cumsum(0)
    first = int((covered >= fraction * 4 * math.pi * (1 - 1e-12)).nonzero()[0])
    chosen = (level >= level[order[first]]) & (level > level.min())
    return chosen.reshape(panorama.shape[:2])


def panoramas() -> st.SearchStrategy[Tensor]:
    """Random panoramas of up to 30 decades, some of them with many equal texels."""

    def make(drawn: tuple[int, float, int, int]) -> Tensor:
        seed, decades, levels, height = drawn
        draw = torch.rand(height, 2 * height, 3, generator=torch.Generator().manual_seed(seed))
        if levels:
            draw = (draw * levels).round() / levels
        return 10 ** (decades * (draw - 0.5))

    return st.tuples(st.integers(0, 99), st.floats(0, 30), st.integers(0, 4), st.integers(1, 16)).map(make)


class TestLuminance:
    def test_golden(self) -> None:
        rgb = torch.tensor([[1.0, 1, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]])
        torch.testing.assert_close(separate.luminance(rgb), torch.tensor([1.0, 0.2126, 0.7152, 0.0722, 0.0]))

    def test_not_rgb(self) -> None:
        with pytest.raises((ValueError, TypeError)):
            separate.luminance(torch.ones(4))

    def test_not_rgb_message(self, unchecked: None) -> None:
        with pytest.raises(ValueError, match=r"last axis of 3, received shape \(4,\)"):
            separate.luminance(torch.ones(4))


class TestMask:
    @given(panorama=panoramas(), fraction=st.floats(0.001, 0.999))
    def test_top_fraction_by_sorting(self, panorama: Tensor, fraction: float) -> None:
        found = separate.source_mask(panorama, "top_fraction", fraction)
        assert torch.equal(found, by_sorting(panorama, fraction))

    @pytest.mark.parametrize("sample", [1, 16, 100])
    @given(panorama=panoramas(), fraction=st.floats(0.001, 0.999))
    def test_a_poor_sample_only_costs_time(self, sample: int, panorama: Tensor, fraction: float) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(_level_set, "SAMPLE", sample)
            found = separate.source_mask(panorama, "top_fraction", fraction)
        assert torch.equal(found, by_sorting(panorama, fraction))

    def test_a_sample_that_sees_nothing(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(_level_set, "SAMPLE", 32)
        panorama = torch.ones(16, 32, 3)
        panorama[::2] = torch.rand(8, 32, 3) + 5  # between the sample's rows
        assert torch.equal(separate.source_mask(panorama, fraction=0.2), by_sorting(panorama, 0.2))

    @given(panorama=panoramas(), fraction=st.floats(0.001, 0.999))
    def test_max_fraction_by_its_definition(self, panorama: Tensor, fraction: float) -> None:
        level = separate.luminance(panorama).double()
        found = separate.source_mask(panorama, "max_fraction", fraction)
        clear = (level / (fraction * level.max()) - 1).abs() > 1e-6  # the rest is rounding
        expected = (level >= fraction * level.max()) & (level > level.min())
        assert torch.equal(found & clear, expected & clear)

    @pytest.mark.parametrize("fraction", [0.01, 0.05, 0.3])
    def test_covers_the_fraction_of_solid_angle(self, fraction: float, generator: torch.Generator) -> None:
        panorama = torch.rand(64, 128, 3, generator=generator)
        one_texel = 1 / (64 * 128) * math.pi / 2
        found = coverage(separate.source_mask(panorama, "top_fraction", fraction))
        assert fraction <= found <= fraction + one_texel

    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("value", [0.0, 0.7])
    def test_an_even_panorama_has_no_source(self, method: separate.Method, value: float) -> None:
        assert not separate.source_mask(torch.full((16, 32, 3), value), method).any()

    def test_a_dark_surround_does_not_fill_the_fraction(self) -> None:
        panorama = torch.full((32, 64, 3), 0.01)
        panorama[10, 10], panorama[20, 40] = 1.0, 0.02
        assert separate.source_mask(panorama).nonzero().tolist() == [[10, 10], [20, 40]]

    def test_equal_texels_share_their_fate(self) -> None:
        panorama = torch.full((32, 64, 3), 0.1)
        panorama[8:16, 8:40] = 1.0  # a clipped window that alone covers more than the fraction
        found = separate.source_mask(panorama, "top_fraction", 0.05)
        assert torch.equal(found, panorama[..., 0] == 1)

    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("shift", [1, 17])
    def test_turns_with_the_panorama(self, method: separate.Method, shift: int, room: Tensor) -> None:
        turned = separate.source_mask(room.roll(shift, 1), method)
        assert torch.equal(turned, separate.source_mask(room, method).roll(shift, 1))

    @pytest.mark.parametrize("method", METHODS)
    @given(exponent=st.integers(-20, 20))
    def test_exposure_changes_nothing(self, method: separate.Method, exponent: int) -> None:
        draw = torch.rand(16, 32, 3, generator=torch.Generator().manual_seed(3))
        expected = separate.source_mask(draw, method)
        assert torch.equal(separate.source_mask(draw * 2.0**exponent, method), expected)

    @pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16, torch.float32, torch.float64])
    @pytest.mark.parametrize("method", METHODS)
    def test_dtypes(self, dtype: torch.dtype, method: separate.Method, room: Tensor) -> None:
        panorama = room.to(dtype)
        expected = separate.source_mask(panorama.float(), method)
        assert torch.equal(separate.source_mask(panorama, method), expected)

    def test_negative_zero_is_zero(self) -> None:
        panorama = torch.full((8, 16, 3), -0.0)
        panorama[3, 3] = 1.0
        assert separate.source_mask(panorama).sum() == 1

    @pytest.mark.parametrize("method", METHODS)
    def test_many_bands(self, method: separate.Method, room: Tensor, monkeypatch: pytest.MonkeyPatch) -> None:
        expected = separate.source_mask(room, method)
        monkeypatch.setattr(_level_set, "BAND", 300)
        assert torch.equal(separate.source_mask(room, method), expected)
        monkeypatch.setattr(_level_set, "KEPT", 0)
        assert torch.equal(separate.source_mask(room, method), expected)


class TestSeparate:
    @pytest.mark.parametrize("batch", BATCHES)
    @pytest.mark.parametrize("method", METHODS)
    def test_sums_to_the_panorama_exactly(
        self, batch: tuple[int, ...], method: separate.Method, generator: torch.Generator
    ) -> None:
        panorama = torch.rand(*batch, 16, 32, 3, generator=generator) ** 4
        sources, ambient = separate.separate(panorama, method, 0.1)
        assert torch.equal(sources + ambient, panorama)
        assert not (sources * ambient).any()
        for one, part in zip(panorama.reshape(-1, 16, 32, 3), sources.reshape(-1, 16, 32, 3), strict=True):
            assert torch.equal(separate.separate(one, method, 0.1)[0], part)

    @pytest.mark.parametrize("fraction", [0.0, 1.0, -1.0, 5.0, math.nan])
    def test_bad_fraction(self, fraction: float) -> None:
        with pytest.raises(ValueError, match="fraction: expected a number above 0 and below 1"):
            separate.separate(torch.ones(4, 8, 3), "top_fraction", fraction)

    def test_bad_method(self, unchecked: None) -> None:
        with pytest.raises(ValueError, match="top_fraction, max_fraction, received 'otsu'"):
            separate.separate(torch.ones(4, 8, 3), "otsu")  # type: ignore[arg-type]

    @pytest.mark.parametrize("value", [math.nan, math.inf, -1.0])
    def test_bad_panorama(self, value: float) -> None:
        panorama = torch.ones(4, 8, 3)
        panorama[1, 2, 0] = value
        with pytest.raises(ValueError, match="row 1, column 2"):
            separate.separate(panorama)
        with pytest.raises(ValueError, match="2:1"):
            separate.separate(torch.ones(4, 12, 3))
