"""Bright regions of a panorama: a peak and what surrounds it, found again and again."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn import functional

from mixlight.light._level_set import level
from mixlight.sphere.equirect import check, pixel_directions, solid_angle

__all__ = ["Region", "bright_regions", "connected"]

_DARKEST = 1e-30
"""A texel below is black."""


@dataclass(frozen=True, eq=False)
class Region:
    """One bright region of a panorama."""

    mask: Bool[Tensor, "height width"]
    """Its texels."""
    direction: Float[Tensor, " 3"]
    """Unit vector to its centre of luminance."""
    energy: Float[Tensor, " 3"]
    """Its integrated radiance, rgb (radiance times steradian)."""
    solid_angle: float
    """In steradian."""

    @property
    def angular_radius(self) -> float:
        """Half-angle in radians of the round cap of the same solid angle.

        >>> half = Region(torch.ones(1, 2, dtype=torch.bool), torch.zeros(3), torch.zeros(3), 2 * math.pi)
        >>> round(half.angular_radius, 4)
        1.5708
        """
        return math.acos(max(-1.0, 1 - self.solid_angle / (2 * math.pi)))


def bright_regions(
    panorama: Float[Tensor, "height width 3"],
    ratio: float = 1 / 3,
    limit: int = 15,
    *,
    least_energy: float = 0.2,
    least_area: float = 0.1,
) -> list[Region]:
    """Grow regions from the brightest texel left down to a share of its luminance, mask them, and repeat.

    A region is the part, connected to its peak, of the free texels with at least `ratio` of the peak's
    luminance. Texels that touch are connected, at corners too, across the seam, and at the poles. The search
    ends after `limit` regions, or when the free texels hold less than `least_energy` of the panorama's
    luminance, or cover less than `least_area` of the sphere.

    Args:
        panorama: radiance, 2:1, finite, >= 0.
        ratio: least luminance in a region over that of its peak, above 0 and up to 1.
        limit: number of regions at most.
        least_energy: share of the luminance that is not worth going on for.
        least_area: share of the sphere.

    Returns:
        The regions in the order in which they were found: by their peaks, brightest first. A black panorama
        has none. An even one is one region.

    Convention: +X right, +Y up, -Z at the panorama's centre. A single lit texel of 128x256 straight ahead is
        a region of one texel with a direction of about -Z.

    Raises:
        ValueError: not a panorama of radiance, or a ratio outside (0, 1].

    Source: Gardner et al., Deep Parametric Indoor Lighting Estimation, 2019, section 4 (ratio 1/3); the
        stopping rules are those of Somanath and Kurz, HDR Environment Map Estimation for Real-Time Augmented
        Reality, 2021.

    >>> panorama = torch.zeros(32, 64, 3)
    >>> panorama[10:12, 62:] = 9.0
    >>> panorama[10:12, :2] = 4.0
    >>> panorama[20, 30] = 1.0
    >>> [int(region.mask.sum()) for region in bright_regions(panorama, least_energy=0)]
    [8, 1]
    """
    check(panorama)
    if not 0 < ratio <= 1:
        raise ValueError(f"ratio: expected a number above 0 and up to 1, received {ratio}")
    bright = level(panorama).double().cpu().numpy()
    texel = solid_angle(panorama.shape[0], dtype=torch.float64).numpy()
    power = bright * texel
    area, left = 4 * math.pi, float(power.sum())
    fewest, weakest = least_area * area, least_energy * left
    free = bright.copy()  # -1 where a region was found
    regions: list[Region] = []
    while len(regions) < limit and area >= fewest and left >= weakest:
        peak = int(free.argmax())
        if free.flat[peak] <= 0:
            break
        mask = connected(free >= max(ratio * free.flat[peak], _DARKEST), divmod(peak, bright.shape[1]))
        free[mask] = -1
        found = _region(panorama, mask, power[mask], texel[mask])
        area, left = area - found.solid_angle, left - float(power[mask].sum())
        regions.append(found)
    return regions


def connected(
    mask: Bool[np.ndarray, "height width"], seed: tuple[int, int]
) -> Bool[np.ndarray, "height width"]:
    """The part of a mask on the sphere that is connected to one of its texels.

    Neighbours are the eight around a texel; columns wrap, and the texels of the first row all touch at the
    pole, as do those of the last.

    Raises:
        ValueError: the seed is not in the mask.

    >>> connected(np.array([[True, False, True, False], [False, True, False, False]]), (1, 1)).astype(int)
    array([[1, 0, 1, 0],
           [0, 1, 0, 0]])
    """
    if not mask[seed]:
        raise ValueError(f"seed: expected a texel of the mask, received {seed}")
    # Row by row the mask is runs of texels: a run that is touched is taken whole, so that a step crosses
    # the width at once and the number of steps is about that of the rows.
    starts = mask.copy()
    starts[:, 1:] &= ~mask[:, :-1]
    run = starts.ravel().cumsum().reshape(mask.shape)
    found = np.zeros_like(mask)
    found[seed] = True
    while True:
        touched = np.zeros(int(run[-1, -1]) + 1, dtype=bool)
        touched[run[found]] = True
        whole = touched[run] & mask
        wide = whole | np.roll(whole, 1, 1) | np.roll(whole, -1, 1)
        near = wide.copy()
        near[1:] |= wide[:-1]
        near[:-1] |= wide[1:]
        for pole in (0, -1):
            near[pole] |= bool(whole[pole].any())
        near &= mask
        if int(near.sum()) == int(found.sum()):
            return found
        found = near


def _region(panorama: Tensor, mask: np.ndarray, power: np.ndarray, texel: np.ndarray) -> Region:
    """A region from its texels' luminance times solid angle, and their solid angle, in the mask's order."""
    chosen = torch.from_numpy(mask)
    rays = pixel_directions(panorama.shape[0])[chosen].double()
    centre = (rays * torch.from_numpy(power)[:, None]).sum(0)
    radiance = panorama[chosen.to(panorama.device)].double().cpu()
    energy = (radiance * torch.from_numpy(texel)[:, None]).sum(0)
    return Region(
        chosen, functional.normalize(centre, dim=0).to(panorama), energy.to(panorama), float(texel.sum())
    )
