"""The equirectangular panorama: pixel and direction, solid angle, sampling, rotation, resizing by energy.

A panorama is [..., H, W, C], W = 2H, row 0 at the top (+Y), seen from the inside, its centre at -Z:
u = 1/2 + atan2(x, -z) / 2 pi, v = acos(y) / pi,
and the centre of pixel (i, j) is at u = (j + 1/2) / W, v = (i + 1/2) / H (`docs/conventions.md`).
"""

import math
from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.sphere import _bilinear, _separable
from mixlight.sphere._tables import place

_ROW_BLOCK = 1 << 24
"""Values read at once by the reductions: bounds temporaries on 16384 x 8192 maps."""


def _grid(height: int, width: int | None) -> tuple[int, int]:
    width = 2 * height if width is None else width
    if height < 1 or width < 1:
        raise ValueError(f"expected a grid of at least 1 x 1, received height {height}, width {width}")
    return height, width


@lru_cache(maxsize=16)
def _rows(height: int) -> tuple[Tensor, Tensor]:
    """Sine and cosine of the polar angle of each row's centre, float64 on the CPU (read only)."""
    with torch.inference_mode(False):
        angle = (torch.arange(height, dtype=torch.float64, device="cpu") + 0.5) * (math.pi / height)
        return angle.sin(), angle.cos()


def pixel_directions(
    height: int,
    width: int | None = None,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, "height width 3"]:
    """Return the unit direction through the centre of each pixel.

    Args:
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [H, W, 3], x, y, z.

    Convention: +X right, +Y up, -Z forward and at the centre of the image; row 0 is the top. With H = 2 the
    pixel (0, 2) looks up, forward and right: (0.5, 0.7071, -0.5).

    Raises:
        ValueError: height or width below 1.

    >>> pixel_directions(2)[0, 2]
    tensor([ 0.5000,  0.7071, -0.5000])
    """
    height, width = _grid(height, width)
    sine, cosine = _rows(height)
    azimuth = (torch.arange(width, dtype=torch.float64, device="cpu") + 0.5) * (2 * math.pi / width) - math.pi
    result = torch.empty((height, width, 3), dtype=dtype, device="cpu")
    result[..., 0] = torch.outer(sine, azimuth.sin()).to(dtype)
    result[..., 1] = cosine.to(dtype)[:, None]
    result[..., 2] = torch.outer(sine, -azimuth.cos()).to(dtype)
    return place(result, dtype, device)


def row_solid_angle(
    height: int,
    width: int | None = None,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, " height"]:
    """Return the exact solid angle of one texel of each row: the first column of `solid_angle`.

    Args:
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [H] steradians. Weighting by it as [H, 1] costs no memory, which counts on large maps.

    Convention: row 0 is the top. With H = 2, W = 4 each texel has pi / 2.

    Raises:
        ValueError: height or width below 1.

    >>> row_solid_angle(2)
    tensor([1.5708, 1.5708])
    """
    height, width = _grid(height, width)
    # cos a - cos b as a product: exact near the poles too, where the cosines would cancel.
    rows = (4 * math.pi / width * math.sin(math.pi / (2 * height))) * _rows(height)[0]
    return place(rows, dtype, device)


def solid_angle(
    height: int,
    width: int | None = None,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, "height width"]:
    """Return the exact solid angle of each texel, in steradians.

    Omega_i = 2 pi / W (cos(i pi / H) - cos((i + 1) pi / H)); the sum over the map is 4 pi.

    Args:
        height: Number of rows H.
        width: Number of columns W; 2 H if not given.
        dtype: Type of the result (computed in float64).
        device: Device of the result.

    Returns:
        [H, W] steradians, the same along a row.

    Convention: row 0 is the top. With H = 2, W = 4 each of the eight texels has pi / 2.

    Raises:
        ValueError: height or width below 1.

    >>> round(solid_angle(128).sum().item(), 4)
    12.5664
    """
    height, width = _grid(height, width)
    return row_solid_angle(height, width, dtype=dtype, device=device)[:, None].repeat(1, width)


def directions_to_uv(directions: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 2"]:
    """Return where on the panorama a direction lies, as fractions of its width and height.

    u = 1/2 + atan2(x, -z) / 2 pi, v = acos(y / |d|) / pi; computed so that it is exact at the poles.

    Args:
        directions: [..., 3], of any length but zero (a zero vector has no direction and gives NaN).

    Returns:
        [..., 2], u in [0, 1) rightwards, v in [0, 1] downwards. u = 1/2 on the poles, where it is free.

    Convention: pixel (i, j) has its centre at u = (j + 1/2) / W, v = (i + 1/2) / H. +X is at (0.75, 0.5).

    >>> directions_to_uv(torch.tensor([1.0, 0.0, 0.0]))
    tensor([0.7500, 0.5000])
    """
    wide = directions.to(torch.promote_types(directions.dtype, torch.float32))
    azimuth, angle = _bilinear.polar(*_planes(wide))
    u = (azimuth / (2 * math.pi) + 0.5).clamp(min=0)
    return torch.stack((torch.where(u >= 1, u - 1, u), angle / math.pi), -1)


def uv_to_directions(uv: Float[Tensor, "*batch 2"]) -> Float[Tensor, "*batch 3"]:
    """Return the unit direction at a place of the panorama; the inverse of `directions_to_uv`.

    d = (sin(pi v) sin(phi), cos(pi v), -sin(pi v) cos(phi)), phi = 2 pi (u - 1/2).

    Args:
        uv: [..., 2], u as a fraction of the width (any number, it wraps), v of the height (0 top, 1 bottom).

    Returns:
        [..., 3] unit vectors.

    Convention: the centre of the image (0.5, 0.5) is -Z.

    >>> uv_to_directions(torch.tensor([0.75, 0.25]))
    tensor([7.0711e-01, 7.0711e-01, 3.0909e-08])
    """
    azimuth, angle = (uv[..., 0] - 0.5) * (2 * math.pi), uv[..., 1] * math.pi
    sine = angle.sin()
    return torch.stack((sine * azimuth.sin(), angle.cos(), -sine * azimuth.cos()), -1)


def _planes(directions: Tensor) -> _bilinear.Planes:
    x, y, z = directions.unbind(-1)
    return x.contiguous(), y.contiguous(), z.contiguous()


def sample(
    panorama: Float[Tensor, "*maps height width channels"],
    directions: Float[Tensor, "*directions 3"],
    *,
    shared: bool | None = None,
) -> Float[Tensor, "*samples channels"]:
    """Look the panorama up along directions: bilinear between texel centres, seamless everywhere.

    Columns wrap; the row above row 0 is row 0 shifted by W/2 (what lies across the pole), likewise
    at the bottom.

    Args:
        panorama: [*b, H, W, C], W even.
        directions: [*b, *n, 3], one set of directions for each map, or [*n, 3], one set for all maps;
            any length but zero (a zero vector gives NaN).
        shared: True: one set for all maps. False: `directions` starts with the maps' shape *b. None: False
            exactly if it does so; say it yourself where *n could equal *b by chance.

    Returns:
        [*b, *n, C] in the panorama's dtype. Differentiable in both arguments.

    Convention: +X right, +Y up, -Z forward (centre of the image).

    Raises:
        ValueError: odd width; `shared=False` and shapes that do not fit.

    >>> panorama = pixel_directions(64)
    >>> sample(panorama, torch.tensor([1.0, 0.0, 0.0]))[0].item()
    0.9994
    """
    maps, (height, width, channels) = panorama.shape[:-3], panorama.shape[-3:]
    _bilinear.require_even(width)
    fits = directions.shape[: len(maps)] == maps and directions.ndim > len(maps)
    if shared is None:
        shared = not fits
    elif not shared and not fits:
        raise ValueError(
            f"expected directions of shape [{', '.join(map(str, maps))}, ..., 3], "
            f"received {list(directions.shape)}"
        )
    wide = directions.to(torch.promote_types(directions.dtype, torch.float32))
    if shared or not maps:
        texels = panorama.reshape(-1, height * width, channels)
        index, weight = _bilinear.taps(*_planes(wide), height, width)
        index, weight = index.view(-1, 4), weight.view(-1, 4)
        parts = [_bilinear.gather(texel, index, weight) for texel in texels]
        result = torch.stack(parts) if parts else panorama.new_empty(0, len(index), channels)
        return result.view(*maps, *directions.shape[:-1], channels)
    count = math.prod(maps)
    index, weight = _bilinear.taps(*_planes(wide.reshape(count, -1, 3)), height, width)
    # One gather from all maps laid end to end; 32-bit indices hold them unless they are enormous.
    flat = index.long() if panorama.numel() > 2**31 else index
    flat = flat + torch.arange(count, device=index.device, dtype=flat.dtype)[:, None, None] * (height * width)
    values = _bilinear.gather(panorama.reshape(-1, channels), flat.view(-1, 4), weight.view(-1, 4))
    return values.view(*directions.shape[:-1], channels)


def rotate(
    panorama: Float[Tensor, "*batch height width channels"],
    rotation: Float[Tensor, "3 3"],
    supersample: int = 1,
) -> Float[Tensor, "*batch height width channels"]:
    """Turn the light: what came from direction d comes from rotation @ d.

    Bilinear, the mean of supersample^2 rays a pixel. Radiance is kept, so energy is kept up to the sampling
    error (use `rotate_azimuth` for turns about +Y, which keep it exactly).

    Args:
        panorama: [..., H, W, C], W even.
        rotation: [3, 3] orthonormal, acts on column vectors of our frame (see `frames.rotation`).
        supersample: Rays along each side of a pixel.

    Returns:
        [..., H, W, C], result(rotation @ d) = panorama(d).

    Convention: `rotation(yaw=pi/2)` turns the light at the centre (-Z) to the right (+X).

    Raises:
        ValueError: odd width; supersample below 1; a matrix that is not orthonormal.

    >>> from mixlight.sphere.frames import rotation
    >>> turned = rotate(pixel_directions(64), rotation(math.pi / 2))
    >>> (sample(turned, torch.tensor([1.0, 0.0, 0.0])) * 100).round()
    tensor([   0.,    0., -100.])
    """
    height, width = panorama.shape[-3:-1]
    _bilinear.check_supersample(supersample)
    exact = rotation.detach().double()
    error = (exact @ exact.T - torch.eye(3, dtype=torch.float64, device=exact.device)).abs().max().item()
    if not error <= 1e-3:
        raise ValueError(f"expected an orthonormal matrix, received one whose R R^T is off by {error:.3g}")
    dtype = torch.promote_types(panorama.dtype, torch.float32)
    matrix = rotation.to(panorama.device, dtype)
    # The look-up for direction e is along d = rotation^T e = e @ rotation.
    fine = pixel_directions(1, supersample * width, dtype=dtype, device=panorama.device)[0]
    across = fine[:, :1] * matrix[0] + fine[:, 2:] * matrix[2]
    sine, cosine = (table.to(panorama.device, dtype)[:, None] for table in _rows(supersample * height))

    def rays(start: int, stop: int) -> _bilinear.Planes:
        s, c = sine[start:stop], cosine[start:stop]
        x, y, z = (torch.addcmul(c * matrix[1, axis], s, across[:, axis]) for axis in range(3))
        return x, y, z

    return _bilinear.render(panorama, height, width, supersample, rays)


def rotate_azimuth(
    panorama: Float[Tensor, "*batch height width channels"], yaw: float
) -> Float[Tensor, "*batch height width channels"]:
    """Return the panorama as a viewer sees it who has turned right by yaw about +Y.

    A turn by a whole number of pixels rolls the columns and is exact; any other mixes neighbouring columns
    linearly. Either way each row keeps its sum, so the energy is kept.

    Args:
        panorama: [..., H, W, C].
        yaw: Angle in radians, positive to the right.

    Returns:
        [..., H, W, C]; the centre of the result is the direction of yaw. The inverse turns by -yaw.

    Convention: after yaw = pi / 2 the centre of the image shows what was at +X.

    Raises:
        ValueError: yaw is not finite.

    >>> rotate_azimuth(torch.arange(4.0).view(1, 4, 1), math.pi / 2).flatten()
    tensor([1., 2., 3., 0.])
    """
    if not math.isfinite(yaw):
        raise ValueError(f"expected a finite yaw, received {yaw}")
    width = panorama.shape[-2]
    shift = yaw / (2 * math.pi) * width
    whole = math.floor(shift + 0.5)
    if abs(shift - whole) < 1e-9:
        return panorama.roll(-whole, -2)
    whole = math.floor(shift)
    return torch.lerp(panorama.roll(-whole, -2), panorama.roll(-whole - 1, -2), shift - whole)


def mirror(
    panorama: Float[Tensor, "*batch height width channels"],
) -> Float[Tensor, "*batch height width channels"]:
    """Swap left and right: the value at (x, y, z) goes to (-x, y, z).

    Args:
        panorama: [..., H, W, C].

    Returns:
        [..., H, W, C], the columns in reverse order.

    Convention: what was at +X is at -X.

    >>> mirror(torch.arange(4.0).view(1, 4, 1)).flatten()
    tensor([3., 2., 1., 0.])
    """
    return panorama.flip(-2)


@lru_cache(maxsize=64)
def _row_bands(height: int, out_height: int) -> _separable.Bands:
    with torch.inference_mode(False):
        # -cos of the polar angle: its differences are solid angles.
        edges = [
            -(torch.arange(count + 1, dtype=torch.float64, device="cpu") * (math.pi / count)).cos()
            for count in (out_height, height)
        ]
        return _separable.overlap(edges[0], edges[1])


@lru_cache(maxsize=64)
def _column_bands(width: int, out_width: int) -> _separable.Bands:
    with torch.inference_mode(False):
        edges = [
            torch.arange(count + 1, dtype=torch.float64, device="cpu") / count for count in (out_width, width)
        ]
        return _separable.overlap(edges[0], edges[1])


def resize(
    panorama: Float[Tensor, "*batch height width channels"], height: int, width: int | None = None
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Resize with the energy kept: each new texel is the solid-angle-weighted mean of what it covers.

    The overlap of two texels is the product of an interval of -cos(polar angle) and one of azimuth, so the
    mean is separable. Works up (blocky, on purpose: nothing is invented) and down, for any pair of sizes.

    Args:
        panorama: [..., H, W, C].
        height: Rows of the result.
        width: Columns of the result; 2 height if not given.

    Returns:
        [..., height, width, C] with the same `integrate`, to rounding.

    Convention: two rows over a hemisphere with 0 above and 1 below, reduced to one row, give 0.5.

    Raises:
        ValueError: height or width below 1.

    >>> resize(torch.tensor([[[0.0]], [[0.0]], [[0.0]], [[1.0]]]), 2, 1).flatten()
    tensor([0.0000, 0.2929])
    """
    height, width = _grid(height, width)
    if panorama.shape[-3:-1] == (height, width):
        return panorama.clone()
    rows = _row_bands(panorama.shape[-3], height)
    return _separable.apply(panorama, rows, _column_bands(panorama.shape[-2], width))


def prefilter(
    panorama: Float[Tensor, "*batch height width channels"], spacing: float
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Reduce a panorama whose texels are finer than the rays that will sample it, so that none is skipped.

    Args:
        panorama: [..., H, W, C].
        spacing: Angle between neighbouring rays in radians.

    Returns:
        `resize` of the panorama by the largest whole factor that leaves its texels no wider than `spacing`,
        up to a row; the panorama itself where that factor is 1.

    Convention: H = 512 and a spacing of pi / 128 give 128 rows.

    >>> prefilter(torch.ones(512, 1024, 1), math.pi / 128).shape
    torch.Size([128, 256, 1])
    """
    height = panorama.shape[-3]
    factor = int(spacing * height / math.pi + 1e-9)
    return panorama if factor < 2 else resize(panorama, max(2, height // factor))


def integrate(panorama: Float[Tensor, "*batch height width channels"]) -> Float[Tensor, "*batch channels"]:
    """Integrate over the sphere: the sum of radiance times solid angle.

    Args:
        panorama: [..., H, W, C] radiance.

    Returns:
        [..., C] radiance times steradians, summed in at least float32 within blocks of rows and in float64
        between them.

    Convention: a panorama of ones gives 4 pi.

    >>> integrate(torch.ones(4, 8, 3))
    tensor([12.5664, 12.5664, 12.5664])
    """
    height, width, channels = panorama.shape[-3:]
    precise = torch.promote_types(panorama.dtype, torch.float32)
    weights = row_solid_angle(height, width, dtype=precise, device=panorama.device)
    rows = max(1, min(64, _ROW_BLOCK // max(1, width * channels)))
    if panorama.requires_grad and torch.is_grad_enabled():
        rows = height  # the gradient of each block would be a map of its own
    total = torch.zeros((*panorama.shape[:-3], channels), dtype=torch.float64, device=panorama.device)
    for start in range(0, height, rows):
        block = panorama[..., start : start + rows, :, :].flatten(-2).to(precise)
        row = weights[start : start + rows] @ block
        total = total + row.view(*row.shape[:-1], width, channels).sum(-2).double()
    return total.to(panorama.dtype)


def check(panorama: Float[Tensor, "*batch height width channels"], name: str = "panorama") -> None:
    """Refuse what is no panorama of radiance: one that is not 2:1, or has NaN, infinite or negative values.

    Args:
        panorama: [..., H, W, C].
        name: What to call it in the message, for instance the file.

    Raises:
        ValueError: with what was expected and what was received where.

    >>> check(torch.zeros(4, 12, 3), "room.hdr")
    Traceback (most recent call last):
    ValueError: room.hdr: expected a 2:1 panorama, received 12 x 4 (width x height)
    """
    if panorama.ndim < 3:
        raise ValueError(
            f"{name}: expected [..., height, width, channels], received shape {list(panorama.shape)}"
        )
    height, width, channels = panorama.shape[-3:]
    if width != 2 * height or height < 1:
        raise ValueError(f"{name}: expected a 2:1 panorama, received {width} x {height} (width x height)")
    if panorama.numel() == 0:
        raise ValueError(f"{name}: expected a panorama with values, received shape {list(panorama.shape)}")
    low, high = (bound.item() for bound in panorama.detach().aminmax())  # NaN goes through both
    if low >= 0 and high < math.inf:
        return
    rows = max(1, _ROW_BLOCK // (width * channels))
    flat = panorama.detach().reshape(-1, width, channels)
    for start in range(0, len(flat), rows):
        part = flat[start : start + rows]
        wrong = ~((part >= 0) & (part < math.inf))
        if bool(wrong.any()):
            place = wrong.nonzero()[0]
            value = part[tuple(place)].item()
            row = (start + int(place[0])) % height
            raise ValueError(
                f"{name}: expected finite radiance of at least 0, "
                f"received {value:g} at row {row}, column {int(place[1])}"
            )
