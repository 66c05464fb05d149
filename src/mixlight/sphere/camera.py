"""The pinhole camera: its rays, views of a panorama, and one photo seen through another pinhole.

Pixels are square and the optical axis pierces the centre of the picture. Pixel (i, j) of an h x w picture
looks along ((j + 1/2 - w/2) s, -(i + 1/2 - h/2) s, -1) in camera axes, s = 2 tan(fov_x / 2) / w.
"""

import math

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.sphere import _bilinear, _separable, equirect
from mixlight.sphere._tables import place
from mixlight.sphere.frames import rotation
from mixlight.sphere.grid import polar_rows

FULL_FRAME_DIAGONAL = math.hypot(36.0, 24.0)
"""Diagonal of the 36 x 24 mm frame that "35 mm equivalent" focal lengths refer to, in millimetres."""


def _picture(height: int, width: int, fov_x: float) -> float:
    """Check a picture's size and field of view; return the side of a pixel at unit distance."""
    if height < 1 or width < 1:
        raise ValueError(f"expected a picture of at least 1 x 1, received height {height}, width {width}")
    if not 0 < fov_x < math.pi:
        raise ValueError(f"expected a horizontal field of view in (0, pi) radians, received {fov_x}")
    return 2 * math.tan(fov_x / 2) / width


def ray_directions(
    height: int,
    width: int,
    fov_x: float,
    yaw: float = 0.0,
    pitch: float = 0.0,
    roll: float = 0.0,
    *,
    dtype: torch.dtype = torch.float32,
    device: torch.device | str | None = None,
) -> Float[Tensor, "height width 3"]:
    """Return the unit direction in the world through each pixel's centre.

    Args:
        height: Rows of the picture.
        width: Columns of the picture.
        fov_x: Horizontal field of view in radians, in (0, pi), from outer edge to outer edge.
        yaw: Radians, positive to the right.
        pitch: Radians, positive upwards.
        roll: Radians, positive clockwise (see `frames.rotation`).
        dtype: Type of the result.
        device: Device of the result.

    Returns:
        [height, width, 3].

    Convention: +X right, +Y up, -Z forward, row 0 on top. With yaw = pi / 2 the centre looks along +X.

    Raises:
        ValueError: fov_x outside (0, pi), empty picture.

    >>> ray_directions(1, 2, math.pi / 2)[0]
    tensor([[-0.4472,  0.0000, -0.8944],
            [ 0.4472,  0.0000, -0.8944]])
    """
    step = _picture(height, width, fov_x)
    rows, columns = _ray_terms(height, width, step, yaw, pitch, roll)
    rays = rows[:, None, :] + columns
    return place(torch.nn.functional.normalize(rays, dim=-1), dtype, device)


def _ray_terms(
    height: int, width: int, step: float, yaw: float, pitch: float, roll: float
) -> tuple[Float[Tensor, "height 3"], Float[Tensor, "width 3"]]:
    """The ray through pixel (i, j), not normalised, is rows[i] + columns[j]; float64 on the CPU."""
    matrix = rotation(yaw, pitch, roll, dtype=torch.float64, device="cpu")
    across = (torch.arange(width, dtype=torch.float64, device="cpu") + (0.5 - width / 2)) * step
    down = (torch.arange(height, dtype=torch.float64, device="cpu") + (0.5 - height / 2)) * -step
    return down[:, None] * matrix[:, 1] - matrix[:, 2], across[:, None] * matrix[:, 0]


def view(
    panorama: Float[Tensor, "*batch height width channels"],
    height: int,
    width: int,
    fov_x: float,
    yaw: float = 0.0,
    pitch: float = 0.0,
    roll: float = 0.0,
    supersample: int = 2,
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Return what a pinhole camera at the panorama's centre sees, antialiased.

    Each pixel is the mean of supersample^2 bilinear look-ups. A panorama finer than these rays are apart is
    first reduced by a whole factor (`equirect.prefilter`, which keeps energy), so that none is skipped.

    Args:
        panorama: [..., H, W, C], W even.
        height: Rows of the picture.
        width: Columns of the picture.
        fov_x: Horizontal field of view in radians, in (0, pi).
        yaw: Radians, positive to the right.
        pitch: Radians, positive upwards.
        roll: Radians, positive clockwise (see `frames.rotation`).
        supersample: Rays along each side of a pixel. Of 8-bit sRGB's 255 steps, 2 was 0.2 to 0.45 off (rms)
            and 1, at a quarter of the time, 1 to 2 (three panoramas of 512 rows, 192 x 256 at 60 degrees,
            against 8).

    Returns:
        [..., height, width, C]; differentiable in the panorama.

    Convention: +X right, +Y up, -Z forward. yaw = pitch = roll = 0 looks at the centre of the panorama.

    Raises:
        ValueError: fov_x outside (0, pi), empty picture, supersample below 1, odd panorama width.

    >>> view(equirect.pixel_directions(64), 3, 3, 1.0, yaw=math.pi / 2)[1, 1, 0].item()
    0.9843
    """
    _bilinear.check_supersample(supersample)
    step = _picture(height, width, fov_x)
    panorama = equirect.prefilter(panorama, fov_x / (supersample * width))
    dtype = torch.promote_types(panorama.dtype, torch.float32)
    rows, columns = (
        terms.to(panorama.device, dtype)
        for terms in _ray_terms(
            supersample * height, supersample * width, step / supersample, yaw, pitch, roll
        )
    )

    def rays(start: int, stop: int) -> _bilinear.Planes:
        x, y, z = (rows[start:stop, None, axis] + columns[:, axis] for axis in range(3))
        return x, y, z

    return _bilinear.render(panorama, height, width, supersample, rays)


def _hat_integral(x: Tensor) -> Tensor:
    """Integral of the hat function max(0, 1 - |t|) from -1 to x."""
    x = x.clamp(-1, 1)
    return torch.where(x < 0, 0.5 * (x + 1) ** 2, 1 - 0.5 * (1 - x) ** 2)


def _pinhole_bands(count: int, out_count: int, ratio: float) -> tuple[_separable.Bands, Tensor]:
    """Box of width `ratio` (input pixels per output pixel) over the linear interpolation of the input.

    Both axes share their centre. In its outer half the last pixel is constant; an output pixel is inside when
    its centre is.
    """
    index = torch.arange(out_count, dtype=torch.float64, device="cpu")
    centre = (index + (0.5 - out_count / 2)) * ratio + count / 2
    inside = (centre >= 0) & (centre <= count)
    # Positions in units of input pixels with the centre of pixel k at k.
    low, high = centre - ratio / 2 - 0.5, centre + ratio / 2 - 0.5
    low, high = low.clamp(-0.5, count - 0.5), high.clamp(-0.5, count - 0.5)
    run = min(count, math.ceil(ratio) + 2)
    starts = low.floor().long().clamp(0, count - run)
    taps = starts[:, None] + torch.arange(run, device="cpu")
    position = taps.double()
    area = _hat_integral(high[:, None] - position) - _hat_integral(low[:, None] - position)
    # The half pixels at the rim, where no second neighbour holds the hat up.
    head = (high.clamp(max=0) - low.clamp(max=0)) - (
        _hat_integral(high.clamp(max=0)) - _hat_integral(low.clamp(max=0))
    )
    last = count - 1
    tail = (high.clamp(min=last) - low.clamp(min=last)) - (
        _hat_integral(high.clamp(min=last) - last) - _hat_integral(low.clamp(min=last) - last)
    )
    area += torch.where(taps == 0, head[:, None], 0.0)
    area += torch.where(taps == last, tail[:, None], 0.0)
    total = area.sum(1, keepdim=True)
    weights = torch.where(inside[:, None] & (total > 0), area / total.clamp(min=1e-300), 0.0)
    return _separable.Bands(starts, weights, count), inside


def resample(
    photo: Float[Tensor, "*batch height width channels"],
    fov_x: float,
    out_height: int,
    out_width: int,
    out_fov_x: float,
) -> tuple[Float[Tensor, "*batch out_height out_width channels"], Bool[Tensor, "out_height out_width"]]:
    """Return the photo as a camera on its axis with another field of view and size would take it.

    Both pictures are flat and parallel, so this is a scaling about the centre. A new pixel is the mean, over
    its own square, of the linear interpolation of the photo: antialiased when reducing, smooth when
    enlarging.

    Args:
        photo: [..., H, W, C] linear light.
        fov_x: Horizontal field of view of the photo in radians, in (0, pi).
        out_height: Rows of the result.
        out_width: Columns of the result.
        out_fov_x: Horizontal field of view of the result in radians, in (0, pi).

    Returns:
        The view [..., out_height, out_width, C], 0 outside the photo, and the mask [out_height, out_width] of
        the pixels whose centre lies inside it. A pixel cut by the rim is the mean of its covered part.

    Convention: row 0 on top. Twice the pixels over the same field of view: each pixel splits into four.

    Raises:
        ValueError: a field of view outside (0, pi), an empty picture.

    >>> wide, inside = resample(torch.ones(4, 4, 3), 1.0, 4, 8, 2 * math.atan(2 * math.tan(0.5)))
    >>> inside[0]
    tensor([False, False,  True,  True,  True,  True, False, False])
    """
    height, width = photo.shape[-3:-1]
    ratio = _picture(out_height, out_width, out_fov_x) / _picture(height, width, fov_x)
    rows, inside_rows = _pinhole_bands(height, out_height, ratio)
    columns, inside_columns = _pinhole_bands(width, out_width, ratio)
    inside = inside_rows[:, None] & inside_columns
    return _separable.apply(photo, rows, columns), inside.to(photo.device)


def vertical_fov(fov_x: float, height: int, width: int) -> float:
    """Return the vertical field of view of a picture: 2 atan(tan(fov_x / 2) height / width).

    Args:
        fov_x: Horizontal field of view in radians, in (0, pi).
        height: Rows of the picture.
        width: Columns of the picture.

    Returns:
        Radians.

    Raises:
        ValueError: fov_x outside (0, pi), empty picture.

    >>> round(math.degrees(vertical_fov(math.radians(60), 192, 256)), 3)
    46.826
    """
    return 2 * math.atan(_picture(height, width, fov_x) * height / 2)


def fov_from_focal_length_35mm(focal_length: float, width: int, height: int) -> float:
    """Return the horizontal field of view of a photo from its 35 mm equivalent focal length.

    The equivalent is the focal length at which the 36 x 24 mm frame has the same diagonal field of view (CIPA
    DCG-001), so fov_x = 2 atan(d / (2 f) w / sqrt(w^2 + h^2)), d = 43.27 mm. Portrait photos get the smaller
    angle.

    Args:
        focal_length: Equivalent focal length in millimetres (EXIF `FocalLengthIn35mmFilm`).
        width: Columns of the photo, upright and not cropped.
        height: Rows of the photo.

    Returns:
        Radians.

    Raises:
        ValueError: focal length or a side not positive.

    >>> round(math.degrees(fov_from_focal_length_35mm(24.0, 6000, 4000)), 3)
    73.74
    """
    if not 0 < focal_length < math.inf or width < 1 or height < 1:
        raise ValueError(
            "expected a positive focal length and a picture of at least 1 x 1, "
            f"received {focal_length} mm, width {width}, height {height}"
        )
    return 2 * math.atan(FULL_FRAME_DIAGONAL / (2 * focal_length) * width / math.hypot(width, height))


def recentre(
    panorama: Float[Tensor, "*batch height width channels"], nadir_angle: float
) -> Float[Tensor, "*batch height width channels"]:
    """Return the panorama as seen from a point moved along Z, as if all light came from the unit sphere.

    With o = sin(nadir_angle), direction (x, y, z) of the result looks the panorama up along
    (x t, y t, z t + o), t = -z o + sqrt(o^2 (z^2 - 1) + 1): where the ray from (0, 0, o) meets the sphere.

    Args:
        panorama: [..., H, W, C], W even.
        nadir_angle: Elevation in radians, in (-pi/2, pi/2). Negative, as for a camera looking down at the
            place to be lit, moves the point forward, to -Z.

    Returns:
        [..., H, W, C] radiance; what lies ahead grows, so the energy is not kept.

    Convention: +X right, +Y up, -Z forward. After nadir_angle = -pi/6 the direction +X shows what was at
    (0.866, 0, -0.5).

    Raises:
        ValueError: nadir_angle outside (-pi/2, pi/2), odd width.

    Source: M.-A. Gardner et al., Learning to predict indoor illumination from a single image, 2017.

    >>> moved = recentre(equirect.pixel_directions(64), -math.pi / 6)
    >>> equirect.sample(moved, torch.tensor([1.0, 0.0, 0.0]))[2].item()
    -0.500
    """
    if not -math.pi / 2 < nadir_angle < math.pi / 2:
        raise ValueError(f"expected a nadir angle in (-pi/2, pi/2) radians, received {nadir_angle}")
    height, width = panorama.shape[-3:-1]
    offset = math.sin(nadir_angle)
    # What lies behind shrinks to 1 / (1 + |o|) of its size: two rays a side miss no lamp.
    supersample = 2 if abs(offset) > 0.5 else 1
    dtype = torch.promote_types(panorama.dtype, torch.float32)
    around = equirect.pixel_directions(1, supersample * width, dtype=dtype, device=panorama.device)[0]
    sine, cosine = (table.to(panorama.device, dtype)[:, None] for table in polar_rows(supersample * height))

    def rays(start: int, stop: int) -> _bilinear.Planes:
        z = sine[start:stop] * around[:, 2]
        distance = (offset**2 * (z * z - 1) + 1).sqrt() - z * offset
        x, y = sine[start:stop] * around[:, 0] * distance, cosine[start:stop] * distance
        return x, y, z * distance + offset

    return _bilinear.render(panorama, height, width, supersample, rays)
