"""Outdoor panoramas as skies: the sun is found, measured and taken out, and nothing else changes."""

import math
from pathlib import Path

import pytest
import torch
from torch import Tensor

from mixlight.data.rooms.skies import analyse, horizontal_illuminance, read_skies
from mixlight.image import exr
from mixlight.image.temperature import black_body
from mixlight.sphere import equirect

LUMINANCE = torch.tensor([0.2126, 0.7152, 0.0722])
HEIGHT = 128


def field(level: float = 1.0) -> Tensor:
    """A plain sky over dark ground."""
    d = equirect.pixel_directions(HEIGHT)
    return torch.where(d[..., 1:2] > 0, torch.tensor([0.8, 1.0, 1.3]), torch.tensor([0.2, 0.2, 0.15])) * level


def with_sun(direction: tuple[float, float, float], ratio: float, kelvin: float = 5000.0) -> Tensor:
    """The field with a disc of 1.5 degrees that gives `ratio` times the sky's light."""
    panorama = field()
    towards = torch.nn.functional.normalize(torch.tensor(direction), dim=0)
    disc = equirect.pixel_directions(HEIGHT) @ towards > math.cos(math.radians(1.5))
    area = float((disc * equirect.solid_angle(HEIGHT)).sum())
    level = ratio * horizontal_illuminance(panorama) / area
    panorama[disc] += torch.tensor(black_body(kelvin) * level, dtype=torch.float32)
    return panorama


def test_a_uniform_sky_gives_pi() -> None:
    assert horizontal_illuminance(torch.ones(64, 128, 3)) == pytest.approx(math.pi, rel=1e-3)


@pytest.mark.parametrize("ratio", [0.2, 2.0, 9.0])
def test_the_sun_is_measured_and_goes(ratio: float) -> None:
    sky, facts = analyse(with_sun((0.5, 0.6, -0.62), ratio), "meadow")
    assert facts["time"] == "day"
    assert facts["sun_ratio"] == pytest.approx(ratio, rel=0.15)
    assert facts["sun_temperature"] == pytest.approx(5000, rel=0.05)
    # In the room frame, +Y is the panorama's centre and +Z is up.
    towards = torch.nn.functional.normalize(torch.tensor([0.5, 0.62, 0.6]), dim=0)
    assert float(torch.tensor(facts["sun_direction"]) @ towards) > math.cos(math.radians(2))
    assert horizontal_illuminance(sky) == pytest.approx(1.0, rel=1e-5)
    plain = field() / horizontal_illuminance(field())
    assert float((sky / plain).max()) < 12  # what stays is the limit, as a sun behind haze
    far = equirect.pixel_directions(HEIGHT) @ torch.tensor([-0.5, 0.6, 0.62]) > 0.5
    ratio_far = (sky / plain)[far]
    assert float(ratio_far.std()) < 1e-4


def test_energy_is_kept() -> None:
    panorama = with_sun((0.0, 0.8, -0.6), 5.0)
    sky, facts = analyse(panorama, "meadow")
    # Sun facing x sine of its height + sky = all light on open ground.
    whole = horizontal_illuminance(panorama) / horizontal_illuminance(field())
    scale = horizontal_illuminance(panorama) / (1 + facts["sun_ratio"] * facts["sun_direction"][2])
    assert scale / horizontal_illuminance(field()) * (
        1 + facts["sun_ratio"] * facts["sun_direction"][2]
    ) == pytest.approx(whole, rel=1e-3)
    torch.testing.assert_close(
        sky * scale, torch.minimum(sky * scale, panorama * 1.001), rtol=1e-3, atol=1e-4
    )


def test_an_overcast_sky_has_no_sun() -> None:
    sky, facts = analyse(field(3.0), "field")
    assert facts == {"time": "day"}
    torch.testing.assert_close(sky, field() / horizontal_illuminance(field()))


@pytest.mark.parametrize(
    ("name", "height", "time"),
    [
        ("beach_sunset", 0.5, "dusk"),
        ("kiara_1_dawn", 0.5, "dusk"),
        ("meadow", 0.1, "dusk"),
        ("meadow", 0.5, "day"),
    ],
)
def test_a_low_sun_or_a_name_makes_it_dusk(name: str, height: float, time: str) -> None:
    _, facts = analyse(with_sun((0.0, height, -math.sqrt(1 - height**2)), 2.0), name)
    assert facts["time"] == time
    assert "sun_direction" in facts


def test_the_moon_is_no_sun() -> None:
    panorama = with_sun((0.0, 0.7, -0.7), 4.0)
    sky, facts = analyse(panorama, "narrow_moonlit_road")
    assert facts == {"time": "night"}
    torch.testing.assert_close(sky, panorama / horizontal_illuminance(panorama))


def test_lamps_before_a_dark_sky_are_night() -> None:
    panorama = field(0.002)
    for column in (10, 60, 120, 200):
        panorama[56, column] = 3000.0
    sky, facts = analyse(panorama, "square")
    assert facts == {"time": "night"}
    torch.testing.assert_close(sky, panorama / horizontal_illuminance(panorama))


def test_what_is_no_sky_is_refused() -> None:
    with pytest.raises(ValueError, match="cellar: expected light above the horizon"):
        analyse(torch.zeros(8, 16, 3), "cellar")
    with pytest.raises(ValueError, match="2:1"):
        analyse(torch.ones(8, 12, 3), "strip")


def table(folder: Path, rows: list[tuple[str, str, str]]) -> Path:
    lines = ["scene,file,category,split"]
    for scene, category, split in rows:
        exr.write(folder / f"{scene}.exr", with_sun((0.3, 0.6, -0.7), 3.0).numpy())
        lines.append(f"{scene},{scene}.exr,{category},{split}")
    path = folder / "table.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_only_outdoor_training_panoramas_are_skies(tmp_path: Path) -> None:
    rows = [("b", "outdoor", "train"), ("a", "outdoor", "train"), ("t", "outdoor", "test")]
    rows += [("v", "outdoor", "val"), ("i", "indoor", "train")]
    path = table(tmp_path, rows)
    skies = read_skies(path, tmp_path / "cache")
    assert [sky.name for sky in skies] == ["a", "b"]
    assert skies[0].sun_ratio == pytest.approx(3.0, rel=0.15)
    pixels, header = exr.read(skies[0].file)
    assert horizontal_illuminance(torch.from_numpy(pixels)) == pytest.approx(1.0, rel=1e-3)
    assert header["scene"] == "a"


def test_prepared_skies_are_kept_and_follow_their_file(tmp_path: Path) -> None:
    path = table(tmp_path, [("a", "outdoor", "train")])
    first = read_skies(path, tmp_path / "cache")
    before = {file: file.stat().st_mtime_ns for file in (tmp_path / "cache").iterdir()}
    assert read_skies(path, tmp_path / "cache") == first
    assert {file: file.stat().st_mtime_ns for file in (tmp_path / "cache").iterdir()} == before
    exr.write(tmp_path / "a.exr", field().numpy())
    (changed,) = read_skies(path, tmp_path / "cache")
    assert changed.sun_direction is None
    assert changed.file != first[0].file


def test_a_damaged_entry_is_made_anew(tmp_path: Path) -> None:
    path = table(tmp_path, [("a", "outdoor", "train")])
    first = read_skies(path, tmp_path / "cache")
    first[0].file.write_bytes(b"nothing")
    assert read_skies(path, tmp_path / "cache") == first
    exr.read(first[0].file)
    for numbers in (tmp_path / "cache").glob("*.json"):
        numbers.write_text("{}")
    assert read_skies(path, tmp_path / "cache") == first


def test_a_table_without_skies_is_refused(tmp_path: Path) -> None:
    path = table(tmp_path, [("t", "outdoor", "test")])
    with pytest.raises(ValueError, match="outdoor and split train"):
        read_skies(path, tmp_path / "cache")
