"""A few lamps of free direction and size in even light: the representation of Gardner et al. 2019.

Each lamp is a spherical Gaussian whose sharpness follows from its angular size; what is left of the panorama
is one constant. The paper also gives each lamp a distance, which only data with depth can teach; ours has
none, so there is none here.
"""

import math
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn import functional

from mixlight.light import gaussians
from mixlight.light.separate import luminance
from mixlight.sphere import equirect

COUNT = 3
"""Lamps of a panorama."""

_SHARPEST, _SMOOTHEST = 1e-3, 0.5
"""Range of a lamp's s: an angular diameter of 5 to 120 degrees."""


class Lamps(NamedTuple):
    """Lamps and the light between them, in the panorama's units and our frame."""

    direction: Float[Tensor, "*batch lamps 3"]
    """Unit vectors towards the lamps, the brightest peak first."""
    sharpness: Float[Tensor, "*batch lamps"]
    """Each lamp's s: 1 - cos of the half-angle of a cone of its size."""
    energy: Float[Tensor, "*batch lamps 3"]
    """Integrated radiance; 0 for a lamp that is not there."""
    ambient: Float[Tensor, "*batch 3"]
    """Radiance from everywhere else."""


@torch.no_grad()
def find(panorama: Float[Tensor, "*batch height width 3"], lamps: int = COUNT, rim: float = 1 / 3) -> Lamps:
    """Read the lamps off a panorama, brightest peak first.

    From the brightest texel a region grows over its neighbours down to ``rim`` of its luminance; the region
    is a lamp, is taken out, and the next peak is sought. The rest is averaged. The panorama's energy is kept.
    A region larger than a quarter of the sphere is no lamp: it has no energy here, and stays in the rest.

    Args:
        panorama: radiance, 2:1, finite, >= 0.
        lamps: how many.
        rim: where a region ends, as a share of its peak.

    Raises:
        ValueError: no such panorama.

    Source: Gardner et al., "Deep Parametric Indoor Lighting Estimation", 2019, section 4.

    >>> panorama = torch.full((16, 32, 3), 0.1)
    >>> panorama[5, 5], panorama[5, 6], panorama[9, 20] = 40.0, 20.0, 10.0
    >>> found = find(panorama)
    >>> [round(e, 3) for e in found.energy[:, 0].tolist()]
    [2.037, 0.368, 0.0]
    """
    equirect.check(panorama)
    batch, (height, width) = panorama.shape[:-3], panorama.shape[-3:-1]
    rest = panorama.reshape(-1, height, width, 3).clone()
    weight = equirect.solid_angle(height).to(rest)[..., None]
    rays = equirect.pixel_directions(height).to(rest)
    found = []
    for _ in range(lamps):
        level = luminance(rest)
        peak = level.flatten(1).amax(1)
        region = _grown(level, peak, rim)[..., None]
        size = (region * weight).sum((1, 2, 3)) / (2 * math.pi)
        region = region & (size <= _SMOOTHEST)[:, None, None, None]
        light = torch.where(region, rest, 0.0) * weight
        energy = light.sum((1, 2))
        centre = (luminance(light)[..., None] * rays).sum((1, 2))
        # Equal light from all sides has no direction: straight up then.
        centre = torch.where(centre.norm(dim=-1, keepdim=True) > 1e-6 * peak[:, None], centre, rays[0, 0])
        found.append((functional.normalize(centre, dim=-1), size.clamp(_SHARPEST, _SMOOTHEST), energy))
        rest = torch.where(region, 0.0, rest)
    ambient = equirect.integrate(rest) / (4 * math.pi)
    direction, sharpness, energy = (torch.stack(part, 1) for part in zip(*found, strict=True))
    return Lamps(
        direction.reshape(*batch, lamps, 3),
        sharpness.reshape(*batch, lamps),
        energy.reshape(*batch, lamps, 3),
        ambient.reshape(*batch, 3),
    )


def environment(light: Lamps, height: int) -> Float[Tensor, "*batch height width 3"]:
    """Panorama of the lamps in their even light; differentiable in every part.

    Convention: each lamp is rescaled on this map, so that its sum over solid angle is its energy.

    Raises:
        ValueError: height below 1.

    >>> up, even = torch.tensor([[0.0, 1.0, 0.0]]), torch.full((3,), 0.5)
    >>> light = Lamps(up, torch.tensor([0.01]), torch.full((1, 3), 2.0), even)
    >>> round(float(equirect.integrate(environment(light, 32))[0]), 3)  # 2 + 4 pi / 2
    8.283
    """
    if height < 1:
        raise ValueError(f"height: expected at least 1, received {height}")
    rays = equirect.pixel_directions(height).to(light.energy).flatten(0, 1)
    weight = equirect.solid_angle(height).to(light.energy).flatten()
    # d.u - 1 from the chord, which is exact for a sharp lamp.
    chord = (light.direction[..., None, :] - rays).square().sum(-1)
    exponent = -0.5 * chord / light.sharpness[..., None]
    lobe = torch.exp(exponent - exponent.amax(-1, keepdim=True).detach())
    lobe = lobe / (lobe * weight).sum(-1, keepdim=True)
    flat = lobe.mT @ light.energy + light.ambient[..., None, :]
    return flat.reshape(*flat.shape[:-2], height, 2 * height, 3)


def cone_degrees(sharpness: float) -> float:
    """Angular diameter in degrees of the even cone that a lamp of this s stands for.

    >>> round(cone_degrees(0.0025), 2)
    8.1
    """
    return math.degrees(2 * gaussians.cone_half_angle(sharpness))


def _grown(level: Tensor, peak: Tensor, rim: float) -> Bool[Tensor, "batch height width"]:
    """The connected region of texels around the brightest one that are brighter than `rim` of it."""
    count = len(level)
    inside = (level >= rim * peak[:, None, None]) & (level > 0)
    region = torch.zeros_like(inside).flatten(1)
    region[torch.arange(count), level.flatten(1).argmax(1)] = True
    region = region.view_as(level) & inside
    size = -1
    while int(region.sum()) != size:
        size = int(region.sum())
        for _ in range(4):  # a few steps between looks
            wide = functional.pad(region.float()[:, None], (1, 1, 0, 0), mode="circular")
            wide = functional.pad(wide, (0, 0, 1, 1))
            region = (functional.max_pool2d(wide, 3, 1)[:, 0] > 0) & inside
    return region
