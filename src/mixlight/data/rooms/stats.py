"""What the light of panoramas is like in seven numbers, and how a set of rooms compares with real interiors.

Each number is blind to exposure, so that a rendered room may be held against any photograph of a place.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from importlib import resources
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import separate
from mixlight.light.fit import fit
from mixlight.sphere import equirect

__all__ = [
    "LABELS",
    "QUANTILES",
    "Comparison",
    "Reference",
    "RoomStatistics",
    "compare",
    "measure",
    "quantiles",
    "read_reference",
]

HEIGHT = 128
"""Rows at which panoramas are measured: the height at which labels are made, so that size does not count."""

TOP = 0.05
"""The share of the sphere that holds the sources."""

QUANTILES = (0.1, 0.25, 0.5, 0.75, 0.9)
"""The quantiles by which a set is described."""

_FLOOR = 1e-3
"""Ambient luminance below this share of the median counts as this: no two files have the same black."""

_REFERENCE = "real_interiors.json"


@dataclass(frozen=True)
class RoomStatistics:
    """The light of one panorama, measured on 128 rows; all means are weighted by solid angle."""

    dynamic_range: float
    """log10 of the largest luminance over the median one."""
    top_share: float
    """Share of the luminous energy that comes from the brightest 5 % of the sphere."""
    upper_share: float
    """Share of the luminous energy that comes from above the horizon."""
    source_elevation_deg: float
    """Mean elevation of the brightest 5 %, weighted by energy, in degrees above the horizon."""
    red_over_blue: float
    """Red over blue of the mean radiance."""
    ambient_contrast: float
    """Standard deviation of the natural logarithm of the luminance of the other 95 %."""
    active_anchors: float
    """Anchors of the fitted light that are lit (`mixlight.light.fit.fit`), of 128."""


LABELS: Mapping[str, str] = {
    "dynamic_range": "log10 (max / median)",
    "top_share": "energy in the brightest 5 %",
    "upper_share": "energy from the upper hemisphere",
    "source_elevation_deg": "elevation of the brightest 5 % (°)",
    "red_over_blue": "R / B of the mean",
    "ambient_contrast": "std of log ambient",
    "active_anchors": "active anchors of the fit",
}
"""What each field of `RoomStatistics` is called in tables and plots, in their order."""


def measure(panorama: Float[Tensor, "height width 3"]) -> RoomStatistics:
    """Measures one panorama.

    Args:
        panorama: linear radiance, 2:1, finite, >= 0, of any height and exposure, horizon level.

    Convention: the upper hemisphere is the upper half of the rows; an even panorama has a dynamic range of 0,
        an upper share of .5 and an ambient contrast of 0.

    Raises:
        ValueError: no such panorama, or one in which half of the sphere is black: its median says nothing.

    >>> panorama = torch.ones(64, 128, 3)
    >>> panorama[10, 20] = 500.0
    >>> found = measure(panorama)
    >>> round(found.dynamic_range, 3), round(found.source_elevation_deg), found.active_anchors
    (2.699, 60, 1.0)
    """
    equirect.check(panorama)
    small = equirect.resize(panorama, HEIGHT).double()
    light = separate.luminance(small)
    weight = equirect.solid_angle(HEIGHT, dtype=torch.float64).expand_as(light)
    median = _weighted_median(light, weight)
    if not median > 0:
        raise ValueError("expected a panorama of which more than half is not black, got one with median 0")
    energy = light * weight
    top = separate.source_mask(small, "top_fraction", TOP)
    elevation = math.pi / 2 - (torch.arange(HEIGHT, dtype=torch.float64) + 0.5) * (math.pi / HEIGHT)
    source = (energy * top).sum(1)
    # An even panorama has no sources: then their mean elevation is that of all light.
    source = source if float(source.sum()) > 0 else energy.sum(1)
    rest = light[~top].clamp(min=_FLOOR * median).log()
    share = weight[~top] / weight[~top].sum()
    mean = equirect.integrate(small)
    return RoomStatistics(
        dynamic_range=math.log10(float(light.max()) / median),
        top_share=float((energy * top).sum() / energy.sum()),
        upper_share=float(energy[: HEIGHT // 2].sum() / energy.sum()),
        source_elevation_deg=math.degrees(float(source @ elevation / source.sum())),
        red_over_blue=float(mean[0] / mean[2]),
        ambient_contrast=float((share * (rest - (share * rest).sum()).square()).sum().sqrt()),
        active_anchors=float(len(fit(small.float(), fraction=TOP).active)),
    )


def quantiles(measured: Iterable[RoomStatistics]) -> dict[str, tuple[float, ...]]:
    """The five `QUANTILES` of every statistic over a set, by the field's name (linear between ranks).

    Raises:
        ValueError: an empty set.

    >>> one = measure(torch.ones(8, 16, 3))
    >>> quantiles([one, one])["upper_share"]
    (0.5, 0.5, 0.5, 0.5, 0.5)
    """
    found = list(measured)
    if not found:
        raise ValueError("expected at least one measured panorama, got none")
    levels = torch.tensor(QUANTILES, dtype=torch.float64)
    table = {}
    for name in LABELS:
        values = torch.tensor([getattr(one, name) for one in found], dtype=torch.float64)
        table[name] = tuple(float(value) for value in values.quantile(levels))
    return table


@dataclass(frozen=True)
class Reference:
    """A measured set that others are held against."""

    name: str
    """What it is, in a few words."""
    measured: Mapping[str, RoomStatistics]
    """By the panorama's name."""


def read_reference() -> Reference:
    """The real training interiors that ship with the package: 25 measured panoramas (train split, indoor).

    >>> len(read_reference().measured)
    25
    """
    text = resources.files(__package__).joinpath(_REFERENCE).read_text(encoding="utf-8")
    document = json.loads(text)
    names = [field.name for field in fields(RoomStatistics)]
    if document["statistics"] != names:
        raise ValueError(f"{_REFERENCE}: expected the statistics {names}, got {document['statistics']}")
    return Reference(
        document["name"],
        {scene: RoomStatistics(*values) for scene, values in document["panoramas"].items()},
    )


def reference_document(reference: Reference) -> dict[str, Any]:
    """What `read_reference` reads, ready for JSON; values to five digits."""
    names = [field.name for field in fields(RoomStatistics)]
    return {
        "format": "mixlight/room-statistics-reference",
        "version": 1,
        "name": reference.name,
        "statistics": names,
        "panoramas": {
            scene: [float(f"{getattr(found, name):.5g}") for name in names]
            for scene, found in reference.measured.items()
        },
    }


@dataclass(frozen=True)
class Comparison:
    """One statistic of a set beside the reference's."""

    name: str
    """Field of `RoomStatistics`."""
    rooms: tuple[float, ...]
    """Its `QUANTILES` over the set."""
    reference: tuple[float, ...]
    """Those of the reference."""

    @property
    def verdict(self) -> str:
        """`inside`, if the set's median lies between the reference's quartiles; else `low` or `high`."""
        median, lower, upper = self.rooms[2], self.reference[1], self.reference[3]
        return "low" if median < lower else "high" if median > upper else "inside"


def compare(rooms: Sequence[RoomStatistics], reference: Reference) -> list[Comparison]:
    """Holds a set against a reference, statistic by statistic, in the order of `LABELS`.

    Raises:
        ValueError: either set is empty.

    >>> reference = read_reference()
    >>> {row.verdict for row in compare(list(reference.measured.values()), reference)}
    {'inside'}
    """
    ours, theirs = quantiles(rooms), quantiles(reference.measured.values())
    return [Comparison(name, ours[name], theirs[name]) for name in LABELS]


def _weighted_median(values: Tensor, weights: Tensor) -> float:
    """The lowest value such that those up to it have half of the weight."""
    ordered, order = values.flatten().sort()
    covered = weights.flatten()[order].cumsum(0)
    return float(ordered[int(torch.searchsorted(covered, covered[-1] / 2))])
