"""The luminance from which on texels are sources, found in passes over bands of rows."""

import math
from collections.abc import Iterator

import torch
from torch import Tensor

from mixlight.sphere.equirect import row_solid_angle

REC709 = (0.2126, 0.7152, 0.0722)
"""Luminance weights of linear Rec.709 red, green and blue."""

BAND = 1 << 18
"""Texels in a band of rows: small enough for the cache, so that a pass is one read of the panorama."""

KEPT = 1 << 24
"""Up to this many texels the luminance is kept between passes; on larger maps it is worked out again."""

SAMPLE = 1 << 16
"""About this many texels tell where to look for the threshold of a large map."""

ROUNDS = (1.12, 4.0, math.inf)
"""The threshold is looked for among the texels whose rank in the sample is right to within such a factor."""


def luminance(rgb: Tensor) -> Tensor:
    """Rec.709 luminance of [..., 3].

    Not as a matrix product, whose last bit for a texel depends on how many others there are.
    """
    red, green, blue = rgb.unbind(-1)
    return (red * REC709[0]).add_(green, alpha=REC709[1]).add_(blue, alpha=REC709[2])


def level(rgb: Tensor) -> Tensor:
    """Luminance in float32: what texels are compared by."""
    return luminance(rgb.to(torch.promote_types(rgb.dtype, torch.float32))).float()


class Bands:
    """A single panorama [height, width, 3] in bands of rows, for passes that need no temporary of its size.

    Iterating gives (number of the first row, rows [n, width, 3], their luminance [n, width]), the rows in
    single precision at least, the luminance in single precision.

    >>> [(start, tuple(light.shape)) for start, _, light in Bands(torch.zeros(512, 1024, 3))]
    [(0, (256, 1024)), (256, (256, 1024))]
    """

    def __init__(self, panorama: Tensor) -> None:
        self.panorama = panorama
        self.height, self.width = panorama.shape[:2]
        self.solid_angle = row_solid_angle(
            self.height, self.width, dtype=torch.float64, device=panorama.device
        )
        self._levels: dict[int, Tensor] = {}

    def __iter__(self) -> Iterator[tuple[int, Tensor, Tensor]]:
        step = max(1, BAND // self.width)
        for start in range(0, self.height, step):
            rows = self.panorama[start : start + step]
            light = self._levels.get(start)
            if light is None:
                light = level(rows)
                if self.height * self.width <= KEPT:
                    self._levels[start] = light
            yield start, rows.to(torch.promote_types(rows.dtype, torch.float32)), light


def max_threshold(bands: Bands, fraction: float) -> float:
    """That fraction of the largest luminance, but above the lowest."""
    lowest, highest = math.inf, 0.0
    for _, _, light in bands:
        low, high = torch.aminmax(light)
        lowest, highest = min(lowest, float(low)), max(highest, float(high))
    return max(float(torch.tensor(fraction * highest, dtype=torch.float32)), _above(lowest))


def top_threshold(bands: Bands, fraction: float) -> float:
    """The highest luminance t such that texels with t or more cover the fraction, but above the lowest.

    A coarse sample says roughly where t lies; one exact pass then adds up the solid angle of all texels
    brighter than that range and lists the few within. Where the sample misled, the range is widened, in the
    end to everything.
    """
    target = fraction * 4 * math.pi * (1 - 1e-12)  # sums in another order differ in their last bits
    for spread in ROUNDS:
        low, high = _range(bands, fraction, spread)
        brighter, lowest, values, weights = _listed(bands, low, high)
        covered = brighter + weights.flip(0).cumsum(0)  # from the brightest of the listed on down
        place = int(torch.searchsorted(covered, target))
        if brighter < target and place < len(covered):
            return max(float(values[len(values) - 1 - place]), _above(lowest))
    raise AssertionError("the whole sphere covers less than a fraction of it")


def _range(bands: Bands, fraction: float, spread: float) -> tuple[float, float]:
    """Luminances between which the threshold should lie, by a sample on a coarse grid."""
    texels = bands.height * bands.width
    if spread == math.inf or texels <= 2 * SAMPLE:
        return -math.inf, math.inf
    stride = math.isqrt(texels // SAMPLE)
    grid = slice(stride // 2, None, stride)
    light = level(bands.panorama[grid, grid])
    ranked, order = light.reshape(-1).sort(descending=True)
    covered = bands.solid_angle[grid].repeat_interleave(light.shape[1])[order].cumsum(0)
    ranks = torch.tensor([fraction * spread, fraction / spread], dtype=torch.float64, device=light.device)
    low, high = torch.searchsorted(covered, ranks * covered[-1]).tolist()
    return (
        float(ranked[low]) if low < len(ranked) else -math.inf,
        _above(float(ranked[high])),  # so that a range of one value holds that value
    )


def _listed(bands: Bands, low: float, high: float) -> tuple[float, float, Tensor, Tensor]:
    """Listing of the distinct luminances from low up to high, ascending, with their solid angles.

    Before these two: the solid angle of the texels at high or above, and the lowest luminance of all.
    """
    brighter, lowest, values, weights = 0.0, math.inf, [], []
    for start, _, light in bands:
        lowest = min(lowest, float(light.min()))
        place = (light >= low).reshape(-1).nonzero()[:, 0]
        found = light.reshape(-1)[place]
        weight = bands.solid_angle[start + place // bands.width]
        within = found < high
        brighter += float(weight.sum() - weight[within].sum())
        merged, total = _merged(found[within], weight[within])
        values.append(merged)
        weights.append(total)
    return brighter, lowest, *_merged(torch.cat(values), torch.cat(weights))


def _merged(values: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
    """Distinct values, ascending, each with the sum of its weights."""
    distinct, inverse = values.unique(return_inverse=True)
    return distinct, weights.new_zeros(len(distinct)).index_add_(0, inverse, weights)


def _above(value: float) -> float:
    """The next float32."""
    return float(torch.nextafter(torch.tensor(value, dtype=torch.float32), torch.tensor(math.inf)))
