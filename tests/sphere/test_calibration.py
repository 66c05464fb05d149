"""Orientation, end to end, by the calibration card: views, frames, mirroring, cube faces."""

import math

import pytest
import torch
from torch import Tensor

from mixlight.sphere import (
    FRAMES,
    calibration_card,
    camera,
    convert_directions,
    convert_panorama,
    cubemap,
    equirect,
)
from mixlight.sphere.calibration import BACKGROUND, CARD_AXES, CARD_COLOURS, CARD_RADIANCE
from tests.tolerances import TOLERANCE

NAMES = sorted(CARD_COLOURS)
LOOK = {
    "-Z": (0.0, 0.0),
    "+X": (math.pi / 2, 0.0),
    "+Z": (math.pi, 0.0),
    "-X": (-math.pi / 2, 0.0),
    "+Y": (0.0, math.pi / 2),
    "-Y": (0.0, -math.pi / 2),
}
"""Yaw and pitch towards each axis."""

# u of a direction in the program's own axes, v downwards from its up axis: conventions.md, written out again.
CONSUMERS = {
    "mixlight": (lambda x, y, z: 0.5 + math.atan2(x, -z) / (2 * math.pi), 1),
    "three": (lambda x, y, z: 0.5 + math.atan2(z, x) / (2 * math.pi), 1),
    "blender": (lambda x, y, z: 0.5 - math.atan2(y, x) / (2 * math.pi), 2),
    "unity": (lambda x, y, z: 0.5 - math.atan2(z, x) / (2 * math.pi), 1),
    "mitsuba": (lambda x, y, z: math.atan2(x, -z) / (2 * math.pi) % 1, 1),
    "usd": (lambda x, y, z: 0.5 - math.atan2(x, z) / (2 * math.pi), 1),
    "filament": (lambda x, y, z: 0.5 - math.atan2(x, z) / (2 * math.pi), 1),
    "unreal": (lambda x, y, z: 0.5 + math.atan2(x, -y) / (2 * math.pi), 2),
}


def colour(name: str) -> Tensor:
    return CARD_RADIANCE * torch.tensor(CARD_COLOURS[name])


@pytest.fixture(scope="module")
def card() -> Tensor:
    return calibration_card(128)


@pytest.fixture(scope="module")
def fine_card() -> Tensor:
    return calibration_card(384)


def test_the_six_colours_differ_and_opposites_add_up_to_white() -> None:
    assert len(set(CARD_COLOURS.values())) == 6
    for axis in "XYZ":
        both = torch.tensor([CARD_COLOURS["+" + axis], CARD_COLOURS["-" + axis]]).sum(0)
        assert both.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("height", [8, 11, 128])
def test_each_axis_bears_its_colour(name: str, height: int) -> None:
    found = equirect.sample(calibration_card(height), torch.tensor(CARD_AXES[name]))
    if height == 128:
        torch.testing.assert_close(found, colour(name), **TOLERANCE[torch.float32])
    # On the smallest cards half a patch's texels are mixed with gray; the hue stays.
    assert torch.equal(found > CARD_RADIANCE / 3, colour(name) > 0)


@pytest.mark.parametrize("name", NAMES)
def test_a_view_towards_each_axis_sees_its_patch(card: Tensor, name: str) -> None:
    yaw, pitch = LOOK[name]
    picture = camera.view(card, 33, 33, math.radians(30), yaw, pitch)
    torch.testing.assert_close(picture[16, 16], colour(name), **TOLERANCE[torch.float32])
    # The plain part reaches over the upper half of the picture.
    torch.testing.assert_close(picture[6:16, 4:29].mean((0, 1)), colour(name), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_names_stand_upright_and_unmirrored(fine_card: Tensor, name: str) -> None:
    """In the view each name fills the lower part, its sign on the left (narrower ink than the letter)."""
    yaw, pitch = LOOK[name]
    patch = camera.view(fine_card, 100, 100, math.radians(40), yaw, pitch)
    plain = colour(name)
    ink = ((patch - plain).abs().sum(-1) > CARD_RADIANCE / 2).float()
    ink[:, :3] = ink[:, -3:] = ink[:3] = ink[-3:] = 0  # the rim
    assert ink[:52].sum() == 0
    left, right = ink[:, 15:46].sum().item(), ink[:, 50:85].sum().item()
    assert 0 < left < right
    # Along the sign's middle there is a horizontal bar; the letter's rows differ from it.
    bar = ink[:, 15:46].sum(1).argmax().item()
    assert 72 <= bar <= 82


def test_the_card_tells_left_from_right_and_up_from_down(card: Tensor) -> None:
    at_right = equirect.sample(equirect.mirror(card), torch.tensor([1.0, 0.0, 0.0]))
    torch.testing.assert_close(at_right, colour("-X"), **TOLERANCE[torch.float32])
    on_top = equirect.sample(card.flip(0), torch.tensor([0.0, 1.0, 0.0]))
    torch.testing.assert_close(on_top, colour("-Y"), **TOLERANCE[torch.float32])


def test_turning_right_brings_the_right_to_the_centre(card: Tensor) -> None:
    seen = equirect.rotate_azimuth(card, math.pi / 2)
    forward = torch.tensor([0.0, 0.0, -1.0])
    torch.testing.assert_close(equirect.sample(seen, forward), colour("+X"), **TOLERANCE[torch.float32])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("frame", sorted(FRAMES))
def test_every_program_finds_each_axis_where_its_formula_looks(card: Tensor, frame: str, name: str) -> None:
    theirs = convert_directions(torch.tensor(CARD_AXES[name]), "mixlight", frame).tolist()
    formula, up = CONSUMERS[frame]
    u, v = formula(*theirs) % 1, math.acos(theirs[up]) / math.pi
    converted = convert_panorama(card, "mixlight", frame)
    height, width = converted.shape[:2]
    row, column = min(int(v * height), height - 1), int(u * width) % width
    torch.testing.assert_close(converted[row, column], colour(name), **TOLERANCE[torch.float32])


@pytest.mark.parametrize("frame", sorted(FRAMES))
def test_every_program_finds_every_direction_where_its_formula_looks(frame: str) -> None:
    """Not only the axes: each pixel's own direction, through the program's axes and formula, is it."""
    height = 8
    directions = equirect.pixel_directions(height, dtype=torch.float64)
    converted = convert_panorama(directions, "mixlight", frame)
    formula, up = CONSUMERS[frame]
    for row in range(height):
        for column in range(2 * height):
            theirs = convert_directions(converted[row, column], "mixlight", frame).tolist()
            assert int(formula(*theirs) % 1 * 2 * height) == column
            assert int(math.acos(theirs[up]) / math.pi * height) == row


def test_cube_faces_bear_the_colour_of_their_axis(card: Tensor) -> None:
    cube = cubemap.from_equirect(card, 65)
    for face, name in zip(cube, cubemap.FACES, strict=True):
        torch.testing.assert_close(face[32, 32], colour(name), **TOLERANCE[torch.float32])


def test_between_the_patches_lies_gray(card: Tensor) -> None:
    between = equirect.sample(card, torch.tensor([0.75, 0.3, -0.65]))
    assert between.tolist() == pytest.approx([BACKGROUND] * 3, abs=1e-6)


def test_the_card_is_valid_radiance_in_any_dtype() -> None:
    small = calibration_card(16, dtype=torch.float64)
    equirect.check(small)
    assert small.dtype == torch.float64
    with pytest.raises(ValueError, match="at least 8 rows, received 7"):
        calibration_card(7)
