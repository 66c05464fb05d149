"""The Laval set by its file names: parsed, paired, split by panorama, and made into samples."""

import math
from pathlib import Path

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from mixlight.data.laval import (
    LIGHT_FOLDER,
    PHOTO_FOLDER,
    LavalPair,
    parse_name,
    read_laval,
    read_pair,
    samples_of_pairs,
    split_by_panorama,
)
from mixlight.image import exr
from mixlight.image.color import srgb_to_linear
from mixlight.light.separate import luminance
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import camera, equirect

NAME = "AG8A0001-others-40-1.62409-1.07406.exr"


@given(
    panorama=st.sampled_from(["AG8A0001", "9C4A0002-0c5b0a3a7c", "a", "room-others-x", "7", "with space"]),
    azimuth=st.integers(0, 359),
    theta=st.floats(0.01, 3.1),
    fov=st.floats(0.1, 3.0),
)
def test_names_are_taken_apart(panorama: str, azimuth: int, theta: float, fov: float) -> None:
    name = parse_name(f"{panorama}-others-{azimuth}-{theta:.5f}-{fov:.5f}.exr")
    assert (name.panorama, name.azimuth_deg) == (panorama, azimuth)
    assert (name.theta, name.fov) == (pytest.approx(theta, abs=1e-5), pytest.approx(fov, abs=1e-5))
    assert name.pitch == pytest.approx(math.pi / 2 - theta, abs=1e-5)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        (
            "room.exr",
            "expected a name of the form <panorama>-others-<azimuth>-<theta>-<fov>.exr, got 'room.exr'",
        ),
        ("AG8A0001-others-40-1.62409.exr", "of the form"),
        ("AG8A0001-others-40-1.62409-1.07406.hdr", "of the form"),
        ("AG8A0001-others-x-1.62409-1.07406.exr", "of the form"),
        ("-others-40-1.6-1.0.exr", "of the form"),
        ("AG8A0001-others-360-1.62409-1.07406.exr", "azimuth in [0, 360) degrees, got 360"),
        ("AG8A0001-others--40-1.62409-1.07406.exr", "azimuth in [0, 360) degrees, got -40"),
        ("AG8A0001-others-40-93.1-1.07406.exr", "theta in radians, in (0, pi), got 93.1"),
        ("AG8A0001-others-40-1.62409-61.5.exr", "fov in radians, in (0, pi), got 61.5"),
    ],
)
def test_other_names_are_refused_and_never_converted(name: str, says: str) -> None:
    with pytest.raises(ValueError, match="expected") as caught:
        parse_name(name)
    assert says in str(caught.value)


def store(root: Path, name: str = NAME, turned: float = 0.0) -> LavalPair:
    """A crop and its light, cut from a smooth panorama as the name says."""
    x, y, z = equirect.pixel_directions(128).unbind(-1)
    panorama = 3 * torch.stack([1 + 0.4 * x, 1 + 0.4 * y, 1 + 0.4 * z], -1)
    panorama = equirect.rotate_azimuth(panorama, turned)
    parsed = parse_name(name)
    photo = camera.view(panorama, 192, 256, parsed.fov, 0.0, parsed.pitch)
    for part, pixels in ((PHOTO_FOLDER, photo), (LIGHT_FOLDER, panorama)):
        (root / part).mkdir(exist_ok=True)
        exr.write(root / part / name, pixels.numpy(), {})
    return LavalPair(parsed, root / PHOTO_FOLDER / name, root / LIGHT_FOLDER / name)


def test_crops_are_paired_with_their_light(tmp_path: Path) -> None:
    names = [NAME, "AG8A0001-others-0-1.5-1.0.exr", "9C4A0002-others-0-1.5-1.0.exr"]
    pairs = {name: store(tmp_path, name) for name in names}
    (tmp_path / PHOTO_FOLDER / "readme.txt").touch()
    (tmp_path / PHOTO_FOLDER / "._hidden.exr").touch()
    assert read_laval(tmp_path) == [pairs[name] for name in sorted(names)]


def test_a_file_without_its_partner_is_refused_unless_allowed(tmp_path: Path) -> None:
    pair = store(tmp_path)
    lonely = tmp_path / LIGHT_FOLDER / "AG8A0000-others-0-1.5-1.0.exr"
    lonely.touch()
    with pytest.raises(
        ValueError, match=f"got 1 in one of them only .first: {lonely.name}, in {LIGHT_FOLDER}"
    ):
        read_laval(tmp_path)
    assert read_laval(tmp_path, allow_unpaired=True) == [pair]


def test_missing_folders_and_empty_sets_are_refused(tmp_path: Path) -> None:
    (tmp_path / PHOTO_FOLDER).mkdir()
    with pytest.raises(FileNotFoundError, match=f"found no {LIGHT_FOLDER}"):
        read_laval(tmp_path)
    (tmp_path / LIGHT_FOLDER).mkdir()
    with pytest.raises(FileNotFoundError, match="expected pairs"):
        read_laval(tmp_path)
    for part in (PHOTO_FOLDER, LIGHT_FOLDER):
        (tmp_path / part / "room.exr").touch()
    with pytest.raises(ValueError, match=f"{tmp_path}: expected a name of the form"):
        read_laval(tmp_path)


# ------------------------------------------------------------------------------------------------------ split


def pairs_of(count: int) -> list[LavalPair]:
    names = [f"P{k}-others-{azimuth}-1.6-1.0.exr" for k in range(count) for azimuth in (0, 40, 80)]
    return [LavalPair(parse_name(name), Path(name), Path(name)) for name in names]


def test_the_split_keeps_panoramas_together_and_shares_in_mind() -> None:
    pairs = pairs_of(400)
    sides = split_by_panorama(pairs, {"train": 0.8, "val": 0.05, "test": 0.15})
    rooms = {side: {pair.name.panorama for pair in members} for side, members in sides.items()}
    assert sum(map(len, sides.values())) == len(pairs)
    assert len(rooms["train"] | rooms["val"] | rooms["test"]) == sum(map(len, rooms.values())) == 400
    assert len(rooms["train"]) == pytest.approx(320, abs=30)
    assert len(rooms["test"]) == pytest.approx(60, abs=25)


def test_the_side_of_a_panorama_does_not_move_with_the_others() -> None:
    shares = {"train": 0.5, "test": 0.5}
    whole = split_by_panorama(pairs_of(40), shares)["test"]
    part = split_by_panorama(pairs_of(20), shares)["test"]
    assert part == [pair for pair in whole if int(pair.name.panorama[1:]) < 20]
    # P0's side, fixed: it must be the same on every machine and in every release.
    assert split_by_panorama(pairs_of(1), {"a": 0.25, "b": 0.25, "c": 0.5})["a"] != []


@pytest.mark.parametrize("shares", [{"a": 0.5}, {"a": 1.5, "b": -0.5}, {}])
def test_shares_that_are_none_are_refused(shares: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="sum to 1"):
        split_by_panorama([], shares)


def test_a_share_of_nothing_or_everything() -> None:
    sides = split_by_panorama(pairs_of(10), {"none": 0.0, "all": 1.0})
    assert (len(sides["none"]), len(sides["all"])) == (0, 30)


# ---------------------------------------------------------------------------------------------------- reading


def test_a_pair_is_read_in_one_scale(tmp_path: Path) -> None:
    photo, light = read_pair(store(tmp_path))
    assert photo.shape == (192, 256, 3)
    ahead = torch.nn.functional.normalize(torch.tensor([0.0, math.sin(-0.0533), -math.cos(0.0533)]), dim=0)
    torch.testing.assert_close(
        photo[95:97, 127:129].mean((0, 1)), equirect.sample(light, ahead), rtol=5e-3, atol=0
    )


def test_bad_pixels_are_refused_by_name(tmp_path: Path) -> None:
    pair = store(tmp_path)
    exr.write(pair.light, torch.ones(8, 24, 3).numpy(), {})
    with pytest.raises(ValueError, match=f"{pair.light}: expected a 2:1 panorama"):
        read_pair(pair)
    pair.photo.write_text("no picture")
    with pytest.raises(ValueError, match=str(pair.photo)):
        read_pair(pair)


def test_negative_radiance_in_a_crop_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pair = store(tmp_path)
    pixels = torch.ones(8, 8, 3).numpy()
    pixels[2, 2] = -1
    monkeypatch.setattr("mixlight.data.laval.exr.read", lambda path: (pixels, {}))
    with pytest.raises(ValueError, match="got values from -1 to 1"):
        read_pair(pair)


def test_samples_follow_protocol_m(tmp_path: Path) -> None:
    canonical = CanonicalView(48, 64)
    pair = store(tmp_path)
    (sample,) = samples_of_pairs([pair], canonical)
    assert (sample.scene, sample.azimuth_deg) == ("AG8A0001", 40.0)
    linear = torch.from_numpy(srgb_to_linear(sample.photo.permute(1, 2, 0).numpy()))
    assert float(luminance(linear).median()) == pytest.approx(0.18, rel=0.01)
    rays = camera.ray_directions(48, 64, canonical.fov, 0.0, sample.pitch)
    torch.testing.assert_close(linear, equirect.sample(sample.environment, rays), rtol=0.03, atol=2e-3)


def test_black_crops_are_left_out(tmp_path: Path) -> None:
    pair = store(tmp_path)
    exr.write(pair.photo, torch.zeros(8, 8, 3).numpy(), {})
    assert list(samples_of_pairs([pair], CanonicalView())) == []
