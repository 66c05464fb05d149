"""Cube maps in the layout that graphics cards sample (OpenGL, Vulkan, Direct3D, WebGL).

A cube is [..., 6, S, S, C], faces in the order +X -X +Y -Y +Z -Z of our axes. With s to the right and t down
the face, both in [-1, 1], a texel looks along

    +X (1, -t, -s)    -X (-1, -t, s)    +Y (s, 1, t)    -Y (s, -1, -t)    +Z (s, -t, 1)    -Z (-s, -t, -1)

so that `texture(cube, d)` returns what our panorama has in direction d. This is the convention of the
hardware: seen from inside the cube each face appears mirrored.
"""

import functools
import math

import torch
import torch.nn.functional as functional
from jaxtyping import Float, Int
from torch import Tensor

from mixlight.sphere import _bilinear, equirect
from mixlight.sphere._tables import place

FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
"""Names of the faces in their order."""

_RIGHT = ((0, 0, -1), (0, 0, 1), (1, 0, 0), (1, 0, 0), (1, 0, 0), (-1, 0, 0))
_DOWN = ((0, -1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (0, -1, 0), (0, -1, 0))
_OUT = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))


def _check_size(size: int) -> None:
    if size < 1:
        raise ValueError(f"expected faces of at least 1 x 1, received size {size}")


def _axes(dtype: torch.dtype, device: torch.device | str | None) -> tuple[Tensor, Tensor, Tensor]:
    right, down, out = (torch.tensor(rows, dtype=dtype, device=device) for rows in (_RIGHT, _DOWN, _OUT))
    return right, down, out


def _centres(size: int, border: int = 0) -> Float[Tensor, " n"]:
    """Coordinates in [-1, 1] of the texel centres along a face, and of some beyond its rim."""
    return (torch.arange(-border, size + border, dtype=torch.float64, device="cpu") + 0.5) * (2 / size) - 1


def pixel_directions(
    size: int, *, dtype: torch.dtype = torch.float32, device: torch.device | str | None = None
) -> Float[Tensor, "6 size size 3"]:
    """Return the unit direction through the centre of each texel of a cube map.

    Args:
        size: Texels along an edge S.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [6, S, S, 3].

    Convention: faces +X -X +Y -Y +Z -Z as graphics cards sample them; the top left texel of face -Z looks to
    the right, up and forward.

    Raises:
        ValueError: size below 1.

    >>> pixel_directions(1)[:, 0, 0].T
    tensor([[ 1., -1.,  0.,  0.,  0.,  0.],
            [ 0.,  0.,  1., -1.,  0.,  0.],
            [ 0.,  0.,  0.,  0.,  1., -1.]])
    """
    _check_size(size)
    return place(functional.normalize(_rays(_centres(size)), dim=-1), dtype, device)


def _rays(centres: Float[Tensor, " n"]) -> Float[Tensor, "6 n n 3"]:
    right, down, out = (axis[:, None, None, :] for axis in _axes(torch.float64, "cpu"))
    return right * centres[None, :, None] + down * centres[:, None, None] + out


def solid_angle(
    size: int, *, dtype: torch.dtype = torch.float32, device: torch.device | str | None = None
) -> Float[Tensor, "size size"]:
    """Return the exact solid angle of each texel of a face, in steradians, the same for all six faces.

    The rectangle from the face's centre to (s, t) has solid angle A(s, t) = atan2(s t, sqrt(s^2 + t^2 + 1));
    a texel is the mixed difference of A over its corners.

    Args:
        size: Texels along an edge S.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [S, S]; sums to 4 pi / 6.

    Convention: one texel a face has 2 pi / 3.

    Raises:
        ValueError: size below 1.

    >>> solid_angle(1)
    tensor([[2.0944]])
    """
    _check_size(size)
    edge = torch.arange(size + 1, dtype=torch.float64, device="cpu") * (2 / size) - 1
    s, t = edge[None, :], edge[:, None]
    area = torch.atan2(s * t, (s * s + t * t + 1).sqrt())
    return place(area.diff(dim=0).diff(dim=1), dtype, device)


def from_equirect(
    panorama: Float[Tensor, "*batch height width channels"], size: int, supersample: int = 2
) -> Float[Tensor, "*batch 6 size size channels"]:
    """Return the panorama as a cube map, antialiased as `camera.view` is.

    Args:
        panorama: [..., H, W, C], W even.
        size: Texels along an edge S.
        supersample: Rays along each side of a texel.

    Returns:
        [..., 6, S, S, C]; differentiable.

    Convention: faces +X -X +Y -Y +Z -Z as graphics cards sample them (mirrored when seen from inside).

    Raises:
        ValueError: size or supersample below 1, odd panorama width.

    >>> from_equirect(equirect.pixel_directions(64), 1)[:, 0, 0].round().T + 0.0
    tensor([[ 1., -1.,  0.,  0.,  0.,  0.],
            [ 0.,  0.,  1., -1.,  0.,  0.],
            [ 0.,  0.,  0.,  0.,  1., -1.]])
    """
    _check_size(size)
    _bilinear.check_supersample(supersample)
    panorama = equirect.prefilter(panorama, math.pi / (2 * size * supersample))
    dtype = torch.promote_types(panorama.dtype, torch.float32)
    fine = size * supersample
    centres = _centres(fine).to(panorama.device, dtype)
    right, down, out = _axes(dtype, panorama.device)

    def rays(start: int, stop: int) -> _bilinear.Planes:
        row = torch.arange(start, stop, device=panorama.device)
        face, t = row // fine, centres[row % fine]
        base = down[face] * t[:, None] + out[face]
        x, y, z = (base[:, None, axis] + right[face, None, axis] * centres for axis in range(3))
        return x, y, z

    faces = _bilinear.render(panorama, 6 * size, size, supersample, rays)
    return faces.view(*panorama.shape[:-3], 6, size, size, panorama.shape[-1])


def to_equirect(
    cube: Float[Tensor, "*batch 6 size size channels"], height: int
) -> Float[Tensor, "*batch height width channels"]:
    """Return the cube map as a panorama, interpolated seamlessly over the edges and corners of the cube.

    Bilinear on each face, whose rim is continued by the neighbouring faces; then reduced by `equirect.resize`
    from a map at least as fine as the cube, so that no texel is skipped.

    Args:
        cube: [..., 6, S, S, C].
        height: Rows H of the panorama.

    Returns:
        [..., H, 2 H, C]; differentiable.

    Convention: faces +X -X +Y -Y +Z -Z as graphics cards sample them (mirrored when seen from inside).

    Raises:
        ValueError: shape that is no cube, height below 1.

    >>> to_equirect(torch.arange(6.0).view(6, 1, 1, 1), 2)[..., 0]
    tensor([[2.2702, 2.5404, 2.2702, 2.0000],
            [2.7298, 3.0000, 2.7298, 2.4596]])
    """
    if cube.ndim < 4 or cube.shape[-4] != 6 or cube.shape[-3] != cube.shape[-2]:
        raise ValueError(f"expected a cube map [..., 6, S, S, C], received shape {list(cube.shape)}")
    if height < 1:
        raise ValueError(f"expected a height of at least 1, received {height}")
    size, channels = cube.shape[-2:]
    factor = max(1, math.ceil(2 * size / height))
    fine = factor * height
    padded = _pad(cube).reshape(-1, 6 * (size + 2) ** 2, channels)
    dtype = torch.promote_types(cube.dtype, torch.float32)
    directions = equirect.pixel_directions(fine, dtype=dtype, device=cube.device)
    index, weight = _taps(directions, size)
    index, weight = index.view(-1, 4), weight.view(-1, 4)
    maps = torch.stack([_bilinear.gather(texels, index, weight) for texels in padded])
    return equirect.resize(maps.view(*cube.shape[:-4], fine, 2 * fine, channels), height)


def _taps(directions: Float[Tensor, "*n 3"], size: int) -> tuple[Int[Tensor, "*n 4"], Float[Tensor, "*n 4"]]:
    """Indices into the padded faces, laid end to end, of four texels around a direction, and weights."""
    right, down, out = _axes(directions.dtype, directions.device)
    axis = directions.abs().argmax(-1)
    face = 2 * axis + (directions.gather(-1, axis[..., None])[..., 0] < 0)
    depth = (directions * out[face]).sum(-1)
    # Position among padded texels, whose first one is the neighbour's: centre k of the face is k + 1.
    column = ((directions * right[face]).sum(-1) / depth + 1) * (size / 2) + 0.5
    row = ((directions * down[face]).sum(-1) / depth + 1) * (size / 2) + 0.5
    left, top = column.floor().clamp(0, size), row.floor().clamp(0, size)
    along, below = column - left, row - top
    stride = size + 2
    start = ((face * stride + top.long()) * stride + left.long()).int()
    index = torch.stack((start, start + 1, start + stride, start + stride + 1), -1)
    both = along * below
    return index, torch.stack((1 - along - below + both, along - both, below - both, both), -1)


def _pad(cube: Float[Tensor, "*batch 6 size size channels"]) -> Tensor:
    """Continue each face by the one texel around it that the neighbouring faces hold."""
    size, channels = cube.shape[-2:]
    flat = cube.reshape(*cube.shape[:-4], 6 * size * size, channels)
    padded = flat[..., _border_index(size).to(cube.device), :]
    # Three texels meet at a corner of the cube: the missing fourth is their mean.
    for i, near_i in ((0, 1), (-1, -2)):
        for j, near_j in ((0, 1), (-1, -2)):
            corner = padded[..., near_i, near_j, :] + padded[..., i, near_j, :] + padded[..., near_i, j, :]
            padded[..., i, j, :] = corner / 3
    return padded


@functools.lru_cache(maxsize=8)
def _border_index(size: int) -> Int[Tensor, "6 padded padded"]:
    """Texel of the cube, faces laid end to end, that lies nearest to each texel of the padded faces."""
    with torch.inference_mode(False):
        rays = _rays(_centres(size, border=1))
        right, down, out = _axes(torch.float64, "cpu")
        axis = rays.abs().argmax(-1)
        face = 2 * axis + (rays.gather(-1, axis[..., None])[..., 0] < 0)
        depth = (rays * out[face]).sum(-1)
        column, row = (
            (((rays * side[face]).sum(-1) / depth + 1) * (size / 2)).floor().long().clamp(0, size - 1)
            for side in (right, down)
        )
        return (face * size + row) * size + column
