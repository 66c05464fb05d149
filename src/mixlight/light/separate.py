"""Separation of a panorama into sources and ambient light by luminance, weighted by solid angle.

Two rules, both with their fraction as a parameter:

- ``top_fraction``: the brightest texels that together cover a fraction of the sphere (the paper's prose).
- ``max_fraction``: the texels above a fraction of the brightest one's luminance (the lineage the paper cites:
  Gardner 2019, EMLight).

Either is a threshold on luminance, so that equal texels share their fate and a turned panorama gives the
turned mask. A texel at the panorama's lowest luminance is never a source: an even panorama is all ambient,
and so is the dark surround of a few small lamps that do not fill the fraction.
"""

import math
from collections.abc import Iterator
from typing import Literal, get_args

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.sphere.equirect import check, row_solid_angle

Method = Literal["top_fraction", "max_fraction"]

REC709 = (0.2126, 0.7152, 0.0722)
"""Luminance weights of linear Rec.709 red, green and blue."""

_BAND = 1 << 18
"""Texels in a band of rows: small enough for the cache, so that a pass is one read of the panorama."""

_KEPT = 1 << 24
"""Up to this many texels the luminance is kept between passes; on larger maps it is worked out again."""


def luminance(rgb: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch"]:
    """Luminance of linear Rec.709 colours, .2126 R + .7152 G + .0722 B.

    Convention: white (1, 1, 1) has the luminance 1.

    Raises:
        ValueError: the last axis is not 3.

    >>> luminance(torch.tensor([0.0, 1.0, 0.0]))
    tensor(0.7152)
    """
    if rgb.shape[-1] != 3:
        raise ValueError(f"rgb: expected a last axis of 3, received shape {tuple(rgb.shape)}")
    # Not as a matrix product, whose last bit for a texel depends on how many others there are.
    red, green, blue = rgb.unbind(-1)
    return (red * REC709[0]).add_(green, alpha=REC709[1]).add_(blue, alpha=REC709[2])


def threshold(
    panorama: Float[Tensor, "*batch height width 3"],
    method: Method = "top_fraction",
    fraction: float = 0.05,
) -> Float[Tensor, "*batch"]:
    """Luminance from which on a texel is a source, in single precision (at least).

    For ``top_fraction`` it is the highest luminance t such that the texels with luminance >= t cover at least
    the fraction of the sphere; found exactly by counting the values' bit patterns in two rounds, without a
    sort. For ``max_fraction`` it is that fraction of the largest luminance. Always above the lowest
    luminance.

    Args:
        panorama: radiance, 2:1, finite, >= 0.
        method: the rule.
        fraction: of the sphere's solid angle, or of the largest luminance; above 0 and below 1.

    Raises:
        ValueError: no such panorama, method or fraction.

    >>> panorama = torch.ones(8, 16, 3)
    >>> panorama[3, 4] = 50.0
    >>> threshold(panorama, "max_fraction", 0.1)
    tensor(5.0000)
    """
    check(panorama)
    check_rule(method, fraction)
    height, width = panorama.shape[-3:-1]
    flat = panorama.reshape(-1, height, width, 3)
    found = [threshold_of(Bands(one), method, fraction) for one in flat]
    return torch.tensor(found, dtype=torch.float32, device=panorama.device).reshape(panorama.shape[:-3])


def source_mask(
    panorama: Float[Tensor, "*batch height width 3"],
    method: Method = "top_fraction",
    fraction: float = 0.05,
) -> Bool[Tensor, "*batch height width"]:
    """Which texels are light sources: those with a luminance of at least `threshold`.

    Raises:
        ValueError: no such panorama, method or fraction.

    >>> panorama = torch.ones(8, 16, 3)
    >>> panorama[3, 4] = 50.0
    >>> source_mask(panorama).nonzero().tolist()
    [[3, 4]]
    """
    limits = threshold(panorama, method, fraction)
    return _level(panorama) >= limits[..., None, None]


def separate(
    panorama: Float[Tensor, "*batch height width 3"],
    method: Method = "top_fraction",
    fraction: float = 0.05,
) -> tuple[Float[Tensor, "*batch height width 3"], Float[Tensor, "*batch height width 3"]]:
    """Sources and ambient part of a panorama, each 0 where the other is not; their sum is the panorama
    exactly.

    The removed sources leave holes of 0 in the ambient part: with them SH(ambient) + SG(sources) holds the
    total energy; an inpainted ambient part would not.

    Raises:
        ValueError: no such panorama, method or fraction.

    >>> panorama = torch.ones(8, 16, 3)
    >>> panorama[3, 4] = 50.0
    >>> sources, ambient = separate(panorama)
    >>> float(sources.sum()), float(ambient.sum())
    (150.0, 381.0)
    """
    mask = source_mask(panorama, method, fraction)[..., None]
    zero = torch.zeros((), dtype=panorama.dtype, device=panorama.device)
    return torch.where(mask, panorama, zero), torch.where(mask, zero, panorama)


class Bands:
    """A single panorama [height, width, 3] in bands of rows, for passes that need no temporary of its size.

    Iterating gives (number of the first row, rows [n, width, 3], their luminance [n, width]), the rows in
    single precision at least, the luminance in single precision.

    >>> [(start, tuple(level.shape)) for start, _, level in Bands(torch.zeros(512, 1024, 3))]
    [(0, (256, 1024)), (256, (256, 1024))]
    """

    def __init__(self, panorama: Tensor) -> None:
        self.panorama = panorama
        self.height, self.width = panorama.shape[:2]
        self._levels: dict[int, Tensor] = {}

    def __iter__(self) -> Iterator[tuple[int, Tensor, Tensor]]:
        step = max(1, _BAND // self.width)
        for start in range(0, self.height, step):
            rows = self.panorama[start : start + step]
            level = self._levels.get(start)
            if level is None:
                level = _level(rows)
                if self.height * self.width <= _KEPT:
                    self._levels[start] = level
            yield start, rows.to(torch.promote_types(rows.dtype, torch.float32)), level


def threshold_of(bands: Bands, method: Method, fraction: float) -> float:
    """`threshold` of one panorama that the caller goes through in bands; nothing is checked.

    >>> threshold_of(Bands(torch.rand(8, 16, 3).clamp_max(0.5)), "max_fraction", 0.5)
    0.25
    """
    return _top_threshold(bands, fraction) if method == "top_fraction" else _max_threshold(bands, fraction)


def check_rule(method: str, fraction: float) -> None:
    """Refuse what is no rule of separation.

    Raises:
        ValueError: an unknown method, or a fraction that is not above 0 and below 1.

    >>> check_rule("top_fraction", 5)
    Traceback (most recent call last):
    ValueError: fraction: expected a number above 0 and below 1, received 5
    """
    if method not in get_args(Method):
        raise ValueError(f"separation: expected one of {', '.join(get_args(Method))}, received {method!r}")
    if not 0 < fraction < 1:
        raise ValueError(f"fraction: expected a number above 0 and below 1, received {fraction!r}")


def _max_threshold(bands: Bands, fraction: float) -> float:
    lowest, highest = math.inf, 0.0
    for _, _, level in bands:
        low, high = torch.aminmax(level)
        lowest, highest = min(lowest, float(low)), max(highest, float(high))
    found = torch.tensor(fraction * highest, dtype=torch.float32)
    # A texel at the lowest luminance is no source.
    return max(float(found), float(torch.nextafter(torch.tensor(lowest), torch.tensor(math.inf))))


def _top_threshold(bands: Bands, fraction: float) -> float:
    """Radix selection on the bit patterns.

    Floats that are not negative are ordered as their patterns are: the upper half of the pattern, and then
    the lower half of those in the bin that the fraction ends in, index a histogram of solid angle.
    """
    device = bands.panorama.device
    weight = row_solid_angle(bands.height, bands.width, dtype=torch.float64, device=device)[:, None]
    weight = weight.expand(-1, bands.width)
    upper = torch.zeros(1 << 15, dtype=torch.float64, device=device)
    for start, _, level in bands:
        bits = level.view(torch.int32) >> 16
        upper += torch.bincount(bits.reshape(-1), weight[start : start + len(level)].reshape(-1), len(upper))
    high, missing = _crossing(upper, fraction * 4 * math.pi)
    lower = torch.zeros(1 << 16, dtype=torch.float64, device=device)
    first, after = _float(high << 16), _float((high + 1) << 16)
    for start, _, level in bands:
        chosen = (level >= first) & (level < after)
        bits = level[chosen].view(torch.int32) & 0xFFFF
        lower += torch.bincount(bits, weight[start : start + len(level)][chosen], len(lower))
    low, _ = _crossing(lower, missing)
    found, lowest = high << 16 | low, int(upper.nonzero()[0]) << 16
    if high << 16 == lowest:
        lowest |= int(lower.nonzero()[0])
    return _float(found + 1 if found == lowest else found)


def _crossing(histogram: Tensor, target: float) -> tuple[int, float]:
    """The highest bin down to which, from the top, the histogram sums to the target, and what is missing
    before it.
    """
    total = histogram.flip(0).cumsum(0)
    # The sum over the sphere itself may fall short of 4 pi by a rounding error.
    place = min(int(torch.searchsorted(total, target)), int(histogram.flip(0).nonzero().max()))
    before = float(total[place - 1]) if place else 0.0
    return len(histogram) - 1 - place, target - before


def _level(rgb: Tensor) -> Tensor:
    """Luminance in float32, with the bit pattern of a positive zero for a negative one."""
    return luminance(rgb.to(torch.promote_types(rgb.dtype, torch.float32))).float().add_(0.0)


def _float(bits: int) -> float:
    """The float32 of a bit pattern; one pattern higher is the next float."""
    return float(torch.tensor(bits, dtype=torch.int32).view(torch.float32))
