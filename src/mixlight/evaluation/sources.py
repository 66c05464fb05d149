"""The light sources of a map, found the same way in the truth and in any prediction (protocol L)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light.regions import Region, bright_regions
from mixlight.light.separate import luminance
from mixlight.sphere import equirect

__all__ = [
    "RATIO",
    "TOP",
    "UNINFORMED",
    "count_sources",
    "find_sources",
    "light_cells",
    "match_angle",
    "strongest_angle",
]

RATIO = 0.3
"""A source reaches down to this share of its peak's luminance."""

TOP = 5
"""The strongest sources that are matched."""

UNINFORMED = math.pi / 2
"""What a map without any source scores as an angle: the mean angle between random directions."""

COUNTED = 0.9
"""Share of the sources' energy that the counted ones hold together."""

_AMBIENT_SHARE = 0.5
"""A region larger than this share of the sphere is ambient light, no source."""


def find_sources(environment: Float[Tensor, "height width 3"]) -> list[Region]:
    """The sources of a map, strongest first: bright regions that are no half of the sphere.

    Regions are grown as `mixlight.light.regions.bright_regions` does, down to .3 of each peak, 15 at most,
    until less than a fifth of the light or a tenth of the sphere is left. Strength is energy: luminance times
    solid angle.

    Raises:
        ValueError: not a panorama of radiance.

    Source: after Somanath and Kurz, HDR Environment Map Estimation for Real-Time Augmented Reality, 2021.
        Theirs weighs luminance with the sine of the polar angle before peaks are looked for, is blind across
        the seam, and takes the first five in raster order; ours takes luminance as it is, and the five
        strongest.

    >>> environment = torch.full((32, 64, 3), 0.01); environment[8, 20] = 50.0
    >>> [int(source.mask.sum()) for source in find_sources(environment)]
    [1]
    """
    regions = bright_regions(environment, RATIO)
    kept = [region for region in regions if region.solid_angle <= _AMBIENT_SHARE * 4 * math.pi]
    return sorted(kept, key=lambda region: -float(luminance(region.energy)))


def strongest_angle(predicted: Sequence[Region], true: Sequence[Region]) -> float:
    """Angle in radians between the strongest sources of two maps.

    Convention: pi / 2 where the prediction has no source, NaN where the truth has none.

    >>> strongest_angle([], [Region(torch.ones(1, 2).bool(), torch.ones(3), torch.ones(3), 0.1)])
    1.5707963267948966
    """
    if not true:
        return math.nan
    return _angle(predicted[0], true[0]) if predicted else UNINFORMED


def match_angle(predicted: Sequence[Region], true: Sequence[Region], top: int = TOP) -> float:
    """Mean angle in radians from each of the strongest sources to the nearest of the other map's, both ways.

    k = min(top, number of true sources, number of predicted ones); the k strongest of either map look for
    their nearest among the k strongest of the other, and the 2 k angles are averaged.

    Convention: as `strongest_angle`. Two true sources 90 degrees apart, one of them predicted: k = 1, and the
        angle is 0 if it is the stronger one.

    >>> match_angle([], [])
    nan
    """
    if not true:
        return math.nan
    k = min(top, len(true), len(predicted))
    if not k:
        return UNINFORMED
    angles = torch.tensor([[_angle(p, t) for t in true[:k]] for p in predicted[:k]])
    return float((angles.amin(0).sum() + angles.amin(1).sum()) / (2 * k))


def count_sources(sources: Sequence[Region]) -> int:
    """How many of the strongest sources hold nine tenths of the energy of all.

    A search that goes on to ever weaker regions finds as many as it may; what a scene is lit by are few.

    Args:
        sources: strongest first, as `find_sources` gives them.

    >>> mask, ahead = torch.ones(1, 2).bool(), torch.tensor([0.0, 0.0, -1.0])
    >>> lamp, candle = (Region(mask, ahead, torch.full((3,), energy), 0.1) for energy in (9.0, 0.1))
    >>> count_sources([lamp, candle, candle]), count_sources([candle] * 3), count_sources([])
    (1, 3, 0)
    """
    energies = [float(luminance(source.energy)) for source in sources]
    wanted, held = COUNTED * sum(energies), 0.0
    for number, energy in enumerate(energies, 1):
        held += energy
        if held >= wanted * (1 - 1e-9):
            return number
    return 0


def light_cells(
    predicted: Float[Tensor, "height width 3"],
    true: Float[Tensor, "height width 3"],
    true_sources: Sequence[Region] | None = None,
) -> dict[str, float]:
    """All that protocol L measures on two maps, but for `active_anchors`, which no map knows.

    `energy_log2` is the binary logarithm of the ratio of the maps' luminance energies (predicted over true),
    `energy_off_log2` its absolute value; NaN where a map is black.

    Args:
        predicted: the predicted map.
        true: the true one.
        true_sources: its sources, where they are known already.

    >>> true = torch.full((32, 64, 3), 0.01); true[8, 20] = 50.0
    >>> cells = light_cells(2 * true.roll(16, 1), true)
    >>> round(cells["strongest_angle_deg"], 1), round(cells["energy_log2"], 3), cells["sources"]
    (63.2, 1.0, 1.0)
    """
    found, theirs = find_sources(predicted), find_sources(true) if true_sources is None else true_sources
    energies = [float(luminance(equirect.integrate(light.double()))) for light in (predicted, true)]
    ratio = math.log2(energies[0] / energies[1]) if min(energies) > 0 else math.nan
    return {
        "strongest_angle_deg": math.degrees(strongest_angle(found, theirs)),
        "blob_angle_deg": math.degrees(match_angle(found, theirs)),
        "energy_log2": ratio,
        "energy_off_log2": abs(ratio),
        "sources": float(count_sources(found)),
        "true_sources": float(count_sources(theirs)),
    }


def _angle(a: Region, b: Region) -> float:
    """Between two directions; exact for small angles too."""
    u, v = a.direction.double(), b.direction.double()
    return math.atan2(float(torch.linalg.vector_norm(torch.linalg.cross(u, v))), float(u @ v))
