"""Labels for all azimuths are those of the turned panorama, linear in light, complete, cached by content."""

import dataclasses
import logging
import math
from pathlib import Path

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from mixlight.data import labels as module
from mixlight.data.labels import LabelSettings, LightLabels, cached_labels, default_cache, make_labels
from mixlight.image import radiance
from mixlight.light import harmonics
from mixlight.sphere import equirect
from mixlight.sphere.calibration import CARD_AXES, CARD_COLOURS, CARD_RADIANCE, calibration_card
from tests.synthetic import room
from tests.tolerances import TOLERANCE

SETTINGS = LabelSettings(height=32, map_height=16, azimuths=32)
F32 = TOLERANCE[torch.float32]


def assert_same(
    found: tuple[torch.Tensor, ...], expected: tuple[torch.Tensor, ...], scale: float = 1.0
) -> None:
    for a, b in zip(found, expected, strict=True):
        # Sums of a few hundred texels in another order, and a rotation of coefficients: a few more digits.
        torch.testing.assert_close(a, b, rtol=2e-5, atol=2e-6 * scale)


@pytest.mark.parametrize("azimuth", [0, 1, 8, 21])
def test_labels_at_an_azimuth_are_those_of_the_turned_panorama(azimuth: int) -> None:
    panorama = room(32)
    labels = make_labels(panorama, SETTINGS)
    turned = equirect.rotate_azimuth(panorama, 2 * math.pi * azimuth / 32)
    scale = float(panorama.max())
    assert_same(labels.at(azimuth, False), make_labels(turned, SETTINGS).at(0, False), scale)
    mirrored = equirect.mirror(turned)
    assert_same(labels.at(azimuth, True), make_labels(mirrored, SETTINGS).at(0, False), scale)


def test_a_light_to_the_right_is_to_the_left_in_the_mirror() -> None:
    panorama = torch.zeros(32, 64, 3)
    panorama[12, 48] = 5.0  # +X, above the horizon
    labels = make_labels(panorama, SETTINGS)
    for mirrored, side in ((False, 1.0), (True, -1.0)):
        energy, _, _ = labels.at(0, mirrored)
        axis = module.points.vogel(128)[energy[:, 0].argmax()]
        assert float(axis @ torch.tensor([side, 0.36, 0.0])) > 0.95


@settings(max_examples=8)
@given(exponent=st.integers(-20, 12), seed=st.integers(0, 3))
def test_labels_are_linear_in_light(exponent: int, seed: int) -> None:
    gain = 2.0**exponent
    panorama, small = room(8, seed), LabelSettings(height=8, map_height=8, azimuths=16)
    plain, brighter = make_labels(panorama, small), make_labels(panorama * gain, small)
    for field in dataclasses.fields(LightLabels):
        assert torch.equal(getattr(brighter, field.name), getattr(plain, field.name) * gain)


@pytest.mark.parametrize("separation", ["top_fraction", "max_fraction"])
def test_sources_and_ambient_hold_all_light_at_every_azimuth(separation: str) -> None:
    panorama = room(64)
    labels = make_labels(panorama, dataclasses.replace(SETTINGS, separation=separation))
    total = equirect.integrate(panorama)
    found = labels.anchor_energy.sum(2) + labels.ambient[:, :, 0] * math.sqrt(4 * math.pi)
    torch.testing.assert_close(found, total.expand_as(found), rtol=2e-5, atol=0)
    torch.testing.assert_close(equirect.integrate(labels.small_map), total, rtol=2e-5, atol=0)


def test_the_calibration_card_stands_where_its_axes_are() -> None:
    card = calibration_card(32)
    labels = make_labels(card, dataclasses.replace(SETTINGS, map_height=32))
    # A quarter turn to the right brings +X ahead, -Z to the left.
    ahead = {0: "-Z", 8: "+X", 16: "+Z", 24: "-X"}
    for azimuth, name in ahead.items():
        _, _, small = labels.at(azimuth, False)
        colour = torch.tensor(CARD_COLOURS[name]) * CARD_RADIANCE
        seen = equirect.sample(small, torch.tensor([0.0, 0.0, -1.0]))
        torch.testing.assert_close(seen, colour, rtol=0, atol=0.6)
    for name in ("+Y", "-Y"):
        _, _, small = labels.at(5, True)
        seen = equirect.sample(small, torch.tensor(CARD_AXES[name]))
        torch.testing.assert_close(seen, torch.tensor(CARD_COLOURS[name]) * CARD_RADIANCE, rtol=0, atol=0.6)


def test_ambient_light_turns_with_the_map() -> None:
    """The first-degree coefficients of light that comes from +X, against the map's own projection."""
    x = equirect.pixel_directions(32)[..., :1]
    labels = make_labels((1 + x).expand(-1, -1, 3).contiguous(), SETTINGS)
    for azimuth, mirrored in ((0, False), (8, False), (8, True), (3, True)):
        _, ambient, small = labels.at(azimuth, mirrored)
        whole = harmonics.project(small, 2)
        lost = labels.at(azimuth, mirrored)[0].sum(0)[0] / math.sqrt(4 * math.pi)
        assert abs(float(ambient[0, 0] + lost - whole[0, 0])) < 1e-3
        expected = whole[1:4, 0] / whole[1:4, 0].norm()
        found = ambient[1:4, 0] / ambient[1:4, 0].norm()
        assert float(found @ expected) > 0.999


def test_labels_are_float32_and_an_unknown_azimuth_is_refused() -> None:
    labels = make_labels(room(16).double(), LabelSettings(height=16, map_height=16, azimuths=32))
    assert {getattr(labels, f.name).dtype for f in dataclasses.fields(labels)} == {torch.float32}
    with pytest.raises(IndexError):
        labels.at(32, False)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"azimuths": 48}, "expected height whose double is a multiple of azimuths = 48, got 128"),
        ({"map_height": 24}, "expected map_height whose double is a multiple of azimuths = 64, got 24"),
        ({"azimuths": 0}, "expected azimuths of at least 1, got 0"),
        ({"anchors": 0}, "expected anchors of at least 1, got 0"),
        ({"fraction": 5.0}, "fraction"),
    ],
)
def test_settings_that_cannot_be_are_refused(changes: dict[str, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        LabelSettings(**changes)


# ------------------------------------------------------------------------------------------------------ cache


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "room.hdr"
    radiance.write(path, room(16).numpy())
    return path


SMALL = LabelSettings(height=16, map_height=8, azimuths=16)


def test_labels_are_made_once(stored: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    panorama, cache = room(16), tmp_path / "deep" / "cache"
    first = cached_labels(stored, panorama, SMALL, cache)
    monkeypatch.setattr(module, "make_labels", lambda *_: pytest.fail("made again"))
    again = cached_labels(stored, panorama, SMALL, cache)
    for field in dataclasses.fields(LightLabels):
        assert torch.equal(getattr(first, field.name), getattr(again, field.name))


def test_another_file_size_or_setting_has_its_own_labels(stored: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    cached_labels(stored, room(16), SMALL, cache)
    cached_labels(stored, room(16), dataclasses.replace(SMALL, fraction=0.1), cache)
    cached_labels(stored, room(32), SMALL, cache)
    radiance.write(stored, room(16, seed=1).numpy())
    cached_labels(stored, room(16, seed=1), SMALL, cache)
    assert len(list(cache.iterdir())) == 4


def test_a_damaged_entry_is_made_anew(stored: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    expected = cached_labels(stored, room(16), SMALL, tmp_path / "cache")
    (entry,) = (tmp_path / "cache").iterdir()
    entry.write_bytes(entry.read_bytes()[:100])
    with caplog.at_level(logging.WARNING):
        found = cached_labels(stored, room(16), SMALL, tmp_path / "cache")
    assert torch.equal(found.ambient, expected.ambient)
    assert "damaged, made anew" in caplog.text
    caplog.clear()
    cached_labels(stored, room(16), SMALL, tmp_path / "cache")
    assert caplog.text == ""


def test_a_cache_that_cannot_be_written_costs_a_warning(
    stored: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    with caplog.at_level(logging.WARNING):
        labels = cached_labels(stored, room(16), SMALL, tmp_path / "file" / "cache")
    assert "labels are not kept" in caplog.text
    assert torch.equal(labels.ambient, make_labels(room(16), SMALL).ambient)


def test_the_default_cache_follows_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_cache() == tmp_path / "mixlight" / "labels"
    monkeypatch.setenv("HOME", str(tmp_path))
    for unset in ("", "relative/cache"):
        monkeypatch.setenv("XDG_CACHE_HOME", unset)
        assert default_cache() == tmp_path / ".cache" / "mixlight" / "labels"
