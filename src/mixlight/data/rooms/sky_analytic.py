"""A sky made of formulas, with clouds and a skyline, for those who have no outdoor panoramas."""

from __future__ import annotations

import math

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.rooms.plan import Sky
from mixlight.sphere import equirect

__all__ = ["analytic_map"]

_GROUND = (0.20, 0.19, 0.16)


def analytic_map(sky: Sky, height: int = 512) -> Float[Tensor, "height width 3"]:
    """An outdoor panorama without sun, not turned and on no particular scale.

    Clear sky: brighter towards the horizon and around the sun; overcast: the CIE's (1 + 2 sin h) / 3. `cloud`
    mixes them in patches. The ground reflects a fifth; a skyline of houses stands before it.
    """
    generator = np.random.default_rng(sky.seed)
    d = equirect.pixel_directions(height)
    up = d[..., 1]
    rise = up.clamp(min=0.0)
    clear = 0.35 + 0.65 * torch.exp(-3.0 * rise)
    if sky.sun_direction is not None:
        x, y, z = sky.sun_direction
        c, s = math.cos(-sky.turn), math.sin(-sky.turn)
        sun = torch.tensor([c * x - s * y, z, -(s * x + c * y)])
        angle = (d @ sun).clamp(-1, 1).acos()
        clear = clear * (1 + 6 * torch.exp(-3.0 * angle) + 1.2 * (d @ sun).square())
    white = torch.ones(3)
    zenith = torch.tensor(sky.colour)
    haze = (rise[..., None] * 2.5).clamp(max=1.0)
    blue = clear[..., None] * (zenith * haze + white * (1 - haze))
    grey = ((1 + 2 * rise) / 3)[..., None] * torch.tensor([0.97, 1.0, 1.04]) * 1.4
    cover = _patches(d, sky.cloud, generator)[..., None]
    above = blue * (1 - cover) + grey * cover
    ground = above[: height // 2].mean() * torch.tensor(_GROUND) * white
    panorama = torch.where((up > 0)[..., None], above, ground)
    return _skyline(panorama, generator, sky.time)


def _patches(d: Float[Tensor, "h w 3"], cloud: float, generator: np.random.Generator) -> Float[Tensor, "h w"]:
    """Soft noise over the sky, above 0 on about the share `cloud` of it."""
    if cloud <= 0:
        return torch.zeros(d.shape[:-1])
    if cloud >= 1:
        return torch.ones(d.shape[:-1])
    plane = d[..., [0, 2]] / (d[..., 1:2].clamp(min=0.0) + 0.15)
    noise = torch.zeros(d.shape[:-1])
    for octave in range(5):
        for _ in range(3):
            angle, phase = generator.uniform(0, 2 * math.pi, 2)
            wave = torch.tensor([math.cos(angle), math.sin(angle)], dtype=torch.float32) * 1.1 * 2.0**octave
            noise = noise + torch.sin(plane @ wave + phase) * 0.6**octave
    level = torch.quantile(noise[: d.shape[0] // 2].flatten()[::7], 1 - cloud)
    return torch.sigmoid((noise - level) * 4)


def _skyline(
    panorama: Float[Tensor, "h w 3"], generator: np.random.Generator, time: str
) -> Float[Tensor, "h w 3"]:
    height, width = panorama.shape[:2]
    picture = panorama.clone()
    light = panorama[: height // 2].mean((0, 1))
    column = 0
    while column < width:
        wide = int(width * generator.uniform(0.02, 0.09)) + 1
        rise = math.radians(generator.uniform(0, 22) if generator.random() < 0.7 else 0.0)
        colour = torch.tensor(generator.uniform(0.1, 0.5) * np.array([1.0, 0.93, 0.84]), dtype=torch.float32)
        top = int(height * (0.5 - rise / math.pi))
        bottom = int(height * 0.53)
        picture[top:bottom, column : column + wide] = light * colour * 0.6
        if time != "day":
            lit = generator.random((6, 5)) < 0.35
            for i, j in zip(*np.nonzero(lit), strict=True):
                r = top + int((i + 0.3) * (bottom - top) / 6)
                c = column + int((j + 0.3) * wide / 5)
                size = max(1, height // 128)
                if r + size < bottom and c + size < min(column + wide, width):
                    picture[r : r + size, c : c + size] = light.mean() * 3 * torch.tensor([1.0, 0.7, 0.4])
        column += wide
    return picture
