"""The calibration card: a panorama that tells which way is which.

Wrong rotation is the most common trouble with environment maps. Load the card instead of a real panorama:
each axis carries a bright patch in a colour of its own with its name written on it, so that one look tells a
turned, a mirrored and a flipped map apart.
"""

import math
from collections.abc import Mapping
from types import MappingProxyType

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.sphere._tables import place
from mixlight.sphere.equirect import pixel_directions, resize

CARD_COLOURS: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "+X": (1.0, 0.0, 0.0),
        "-X": (0.0, 1.0, 1.0),
        "+Y": (0.0, 1.0, 0.0),
        "-Y": (1.0, 0.0, 1.0),
        "+Z": (0.0, 0.0, 1.0),
        "-Z": (1.0, 1.0, 0.0),
    }
)
"""Colour of each axis: red, green and blue for +X, +Y and +Z, and the complement for the opposite end."""

CARD_AXES: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "+X": (1.0, 0.0, 0.0),
        "-X": (-1.0, 0.0, 0.0),
        "+Y": (0.0, 1.0, 0.0),
        "-Y": (0.0, -1.0, 0.0),
        "+Z": (0.0, 0.0, 1.0),
        "-Z": (0.0, 0.0, -1.0),
    }
)
"""Direction of each axis in our frame."""

CARD_RADIANCE = 4.0
"""Radiance of a patch in the channels of its colour: well above white, so that a map read as LDR shows."""

BACKGROUND = 0.05
"""Gray between the patches; the lines every 30 degrees are twice as bright."""

_HALF_WIDTH = math.tan(math.radians(20))
_CORNER_DEPTH = 1 / math.sqrt(1 + 2 * _HALF_WIDTH**2) - 1e-9
_GLYPHS = {
    "+": ("     ", "  #  ", "  #  ", "#####", "  #  ", "  #  ", "     "),
    "-": ("     ", "     ", "     ", "#####", "     ", "     ", "     "),
    "X": ("#   #", "#   #", " # # ", "  #  ", " # # ", "#   #", "#   #"),
    "Y": ("#   #", "#   #", " # # ", "  #  ", "  #  ", "  #  ", "  #  "),
    "Z": ("#####", "    #", "   # ", "  #  ", " #   ", "#    ", "#####"),
}
_SUPERSAMPLE = 3


def calibration_card(
    height: int, *, dtype: torch.dtype = torch.float32, device: torch.device | str | None = None
) -> Float[Tensor, "height width 3"]:
    """Return the calibration card: six bright patches, one on each axis, named and in colours of their own.

    Each patch is a square of 40 degrees whose upper part, with the axis itself, is plain and whose lower part
    bears the axis's name in black (white on blue), upright for a viewer at the centre (on +Y and -Y: for one
    who looks up or down from facing -Z). In between lies gray with lines every 30 degrees of azimuth and of
    elevation.

    Args:
        height: Rows H, at least 8; names are readable from about 128.
        dtype: Type of the result.
        device: Device of the result.

    Returns:
        [H, 2 H, 3] radiance, `CARD_RADIANCE` times `CARD_COLOURS` on the axes.

    Convention: our frame: -Z (yellow) in the centre of the image, +X (red) at three quarters of its width, -X
    (cyan) at one quarter, +Z (blue) at the seam, +Y (green) on top, -Y (magenta) at the bottom.

    Raises:
        ValueError: height below 8.

    >>> calibration_card(64)[32, 64]
    tensor([4., 4., 0.])
    """
    if height < 8:
        raise ValueError(f"expected a calibration card of at least 8 rows, received {height}")
    fine = _SUPERSAMPLE * height
    directions = pixel_directions(fine, dtype=torch.float64, device="cpu").flatten(0, 1)
    card = torch.where(_grid_lines(fine), 2 * BACKGROUND, BACKGROUND).double().flatten()[:, None].repeat(1, 3)
    for name, axis in CARD_AXES.items():
        right, up, outward = _patch_axes(axis)
        index = (directions @ outward > _CORNER_DEPTH).nonzero()[:, 0]
        near = directions[index]
        # Position on the patch: 0 ... 1 from left to right and from top to bottom.
        across, down = ((near @ side) / (near @ outward) / (2 * _HALF_WIDTH) + 0.5 for side in (right, -up))
        inside = (across >= 0) & (across < 1) & (down >= 0) & (down < 1)
        written = _label(name, across[inside], down[inside])
        colour = CARD_RADIANCE * torch.tensor(CARD_COLOURS[name], dtype=torch.float64, device="cpu")
        ink = CARD_RADIANCE if name == "+Z" else 0.0  # black on blue is hard to read
        card[index[inside]] = torch.where(written[:, None], ink, colour)
    return place(resize(card.view(fine, 2 * fine, 3), height), dtype, device)


def _grid_lines(height: int) -> Tensor:
    """Mask of the lines every 30 degrees, two fine pixels wide (rows and columns adjoin the exact angle)."""
    row = torch.arange(height, device="cpu") + 0.5
    column = torch.arange(2 * height, device="cpu") + 0.5
    step = height / 6
    on_row = (torch.remainder(row + step / 2, step) - step / 2).abs() <= 1
    on_column = (torch.remainder(column + step / 2, step) - step / 2).abs() <= 1
    return on_row[:, None] | on_column[None, :]


def _patch_axes(axis: tuple[float, float, float]) -> tuple[Tensor, Tensor, Tensor]:
    """Right, up and outward directions of the patch on an axis, as the viewer at the centre sees it."""
    outward = torch.tensor(axis, dtype=torch.float64, device="cpu")
    # Looking up from facing -Z the top of the view is behind, at +Z; looking down it is ahead, at -Z.
    up = torch.tensor([0.0, 0.0, axis[1]] if axis[1] else [0.0, 1.0, 0.0], dtype=torch.float64, device="cpu")
    return torch.linalg.cross(outward, up), up, outward


def _label(name: str, across: Tensor, down: Tensor) -> Tensor:
    """Where the two letters of a name are black: in the lower part of the patch, each 5 x 7 dots."""
    dots = torch.tensor(
        [
            [dot == "#" for dot in left + " " + right]
            for left, right in zip(_GLYPHS[name[0]], _GLYPHS[name[1]], strict=True)
        ],
        device="cpu",
    )
    rows, columns = dots.shape
    side = 0.06
    column = ((across - 0.5) / side + columns / 2).floor().long()
    row = ((down - 0.56) / side).floor().long()
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    return inside & dots[row.clamp(0, rows - 1), column.clamp(0, columns - 1)]
