"""Named frames of other programs, and rotations of ours.

Ours is right-handed, +X right, +Y up, -Z forward; the centre of a panorama is -Z. Every program named here
shows the same panorama unmirrored from the inside and differs only in which axis it calls what, and in which
direction it puts at the centre of the image: an exact change of axes, and an exact roll of columns.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import torch
from jaxtyping import Float
from torch import Tensor


@dataclass(frozen=True)
class Frame:
    """How one program names directions and lays out a panorama."""

    name: str
    """Key in `FRAMES`."""
    axes: tuple[tuple[int, int, int], tuple[int, int, int], tuple[int, int, int]]
    """Rows of the matrix that takes our x, y, z to the program's; a signed permutation."""
    quarter_turns: int
    """Roll of our columns to the right, in units of a quarter of the width (0 to 3)."""
    units_per_metre: float = 1.0
    """The program's length unit; directions do not feel it, positions do."""

    def matrix(
        self, *, dtype: torch.dtype = torch.float32, device: torch.device | str | None = None
    ) -> Float[Tensor, "3 3"]:
        """Return the matrix that takes our directions, as column vectors, to the program's."""
        return torch.tensor(self.axes, dtype=dtype, device=device)

    @property
    def right_handed(self) -> bool:
        """Whether x, y, z of the program are a right-handed system (determinant +1)."""
        (a, b, c), (d, e, f), (g, h, i) = self.axes
        return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) == 1


_SAME = ((1, 0, 0), (0, 1, 0), (0, 0, 1))

FRAMES: Mapping[str, Frame] = MappingProxyType(
    {
        frame.name: frame
        for frame in (
            Frame("mixlight", _SAME, 0),
            Frame("three", _SAME, 3),
            Frame("blender", ((1, 0, 0), (0, 0, -1), (0, 1, 0)), 3),
            Frame("unity", ((1, 0, 0), (0, 1, 0), (0, 0, -1)), 3),
            Frame("mitsuba", _SAME, 2),
            Frame("usd", _SAME, 2),
            Frame("filament", _SAME, 2),
            Frame("unreal", ((0, 0, -1), (1, 0, 0), (0, 1, 0)), 1, units_per_metre=100.0),
        )
    }
)
"""The named frames. "mixlight" is ours (and that of skylibs and the Laval panoramas); "usd" holds for
OpenEXR's `envmap=latlong` too. u is the fraction of the width at which the program shows a direction given in
its own axes:

| name | up, hand | u | image centre |
|---|---|---|---|
| mixlight | +Y right | 1/2 + atan2(x, -z) / 2 pi | -Z |
| three | +Y right | 1/2 + atan2(z, x) / 2 pi | +X |
| blender | +Z right | 1/2 - atan2(y, x) / 2 pi | +X |
| unity | +Y left | 1/2 - atan2(z, x) / 2 pi | +X |
| mitsuba | +Y right | atan2(x, -z) / 2 pi mod 1 | +Z |
| usd | +Y right | 1/2 - atan2(x, z) / 2 pi | +Z |
| filament | +Y right | 1/2 - atan2(x, z) / 2 pi | +Z |
| unreal | +Z left, cm | 1/2 + atan2(x, -y) / 2 pi | -Y |
"""


def _frame(name: str) -> Frame:
    if name not in FRAMES:
        raise ValueError(f"expected a frame out of {', '.join(FRAMES)}, received {name!r}")
    return FRAMES[name]


def convert_directions(
    directions: Float[Tensor, "*batch 3"], source: str, target: str
) -> Float[Tensor, "*batch 3"]:
    """Express directions given in the axes of one frame in those of another; exact (signed swaps).

    Args:
        directions: [..., 3] in the axes of `source`.
        source: A name in `FRAMES`.
        target: A name in `FRAMES`.

    Returns:
        [..., 3] in the axes of `target`; lengths stay (metres do not become centimetres).

    Convention: our forward, -Z, is Blender's +Y.

    Raises:
        ValueError: unknown frame.

    >>> convert_directions(torch.tensor([0.0, 0.0, -1.0]), "mixlight", "blender")
    tensor([0., 1., 0.])
    """
    rows, columns = _frame(target).axes, _frame(source).axes
    parts = []
    for row in rows:
        # The target's axis along each of the source's axes: one is +-1, the others are 0.
        signs = [sum(a * b for a, b in zip(row, column, strict=True)) for column in columns]
        axis = next(i for i, sign in enumerate(signs) if sign)
        parts.append(directions[..., axis] if signs[axis] > 0 else 0 - directions[..., axis])
    return torch.stack(parts, -1)


def convert_panorama(
    panorama: Float[Tensor, "*batch height width channels"], source: str, target: str
) -> Float[Tensor, "*batch height width channels"]:
    """Roll the columns of a panorama so that another program shows it the right way round; exact.

    Args:
        panorama: [..., H, W, C] laid out for `source`, W divisible by 4.
        source: A name in `FRAMES`.
        target: A name in `FRAMES`.

    Returns:
        [..., H, W, C] laid out for `target`.

    Convention: from "mixlight" to "three" column W/2 (-Z) goes to column W/4.

    Raises:
        ValueError: unknown frame; a width not divisible by 4.

    >>> convert_panorama(torch.arange(8.0).view(1, 8, 1), "mixlight", "three").flatten()
    tensor([2., 3., 4., 5., 6., 7., 0., 1.])
    """
    turns = _frame(target).quarter_turns - _frame(source).quarter_turns
    width = panorama.shape[-2]
    if width % 4:
        raise ValueError(f"expected a width divisible by 4 (a quarter turn is exact), received {width}")
    return panorama.roll(turns * (width // 4), -2)


Angle = float | Float[Tensor, "*#angles"]
"""Radians: a number, or a tensor for a batch of rotations."""


def rotation(
    yaw: Angle,
    pitch: Angle = 0.0,
    roll: Angle = 0.0,
    *,
    dtype: torch.dtype | None = None,
    device: torch.device | str | None = None,
) -> Float[Tensor, "*batch 3 3"]:
    """Return the camera-to-world rotation of a camera with this yaw, pitch and roll.

    R = R_y(-yaw) R_x(pitch) R_z(-roll), each the right-handed rotation about its axis: the camera is first
    rolled about its own axis, then pitched, then turned about the vertical.

    Args:
        yaw: Radians; positive turns the camera to the right.
        pitch: Radians; positive looks up.
        roll: Radians; positive turns the camera clockwise as the photographer sees it, so that the content of
            its picture turns counter-clockwise.
        dtype: Type of the result; that of the tensors given, else float32 (computed in float64).
        device: Device of the result; that of the tensors given, else the default one.

    Returns:
        [3, 3] for numbers, or [*b, 3, 3] for tensors that broadcast to [*b]; differentiable. Column 0 is the
        camera's right, column 1 its up, minus column 2 its forward direction in the world.

    Convention: +X right, +Y up, -Z forward. yaw = pi / 2 looks along +X.

    >>> rotation(0.5) @ torch.tensor([0.0, 0.0, -1.0])
    tensor([ 0.4794,  0.0000, -0.8776])
    """
    given = [angle for angle in (yaw, pitch, roll) if isinstance(angle, Tensor)]
    if dtype is None:
        dtype = torch.float32
        for i, angle in enumerate(given):
            dtype = angle.dtype if i == 0 else torch.promote_types(dtype, angle.dtype)
    if device is None and given:
        device = given[0].device
    y, p, r = (torch.as_tensor(angle, dtype=torch.float64, device=device) for angle in (yaw, pitch, roll))
    zero = torch.zeros_like(y + p + r)  # broadcasts the three
    y, p, r = y + zero, p + zero, r + zero
    sy, cy, sp, cp, sr, cr = y.sin(), y.cos(), p.sin(), p.cos(), r.sin(), r.cos()
    entries = (
        (cy * cr + sy * sp * sr, cy * sr - sy * sp * cr, -sy * cp),
        (-cp * sr, cp * cr, -sp),
        (sy * cr - cy * sp * sr, sy * sr + cy * sp * cr, cy * cp),
    )
    return torch.stack([torch.stack(row, -1) for row in entries], -2).to(dtype)
