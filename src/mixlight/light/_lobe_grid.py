"""Lobes at the texel centres of a panorama, in bands of rows, each band without the lobes far from it."""

import math
from collections.abc import Iterator

import torch
from torch import Tensor
from torch.nn import functional

from mixlight.sphere.equirect import row_solid_angle

CHUNK = 1 << 22
"""Largest number of entries of a temporary table."""

NEGLIGIBLE = 40.0
"""A lobe is 0 where it would be below exp(-40) = 4e-18 of its peak, under float64's resolution."""


def falloff(exponent: Tensor) -> Tensor:
    """exp(exponent), and exactly 0 below exp(-40); the argument is used up.

    Not exp alone: on a CPU it takes forty times as long for results that underflow, as most of a lobe's do.

    >>> falloff(torch.tensor([0.0, -1.0, -50.0]))
    tensor([1.0000, 0.3679, 0.0000])
    """
    least = math.exp(-NEGLIGIBLE) * (1 + 1e-5)
    if exponent.requires_grad:
        return functional.threshold(exponent.clamp_min(-NEGLIGIBLE).exp(), least, 0.0)
    return functional.threshold(exponent.clamp_min_(-NEGLIGIBLE).exp_(), least, 0.0, inplace=True)


class LobeGrid:
    """Lobes [n] on the texels of a map of some height, each scaled to 1 at its brightest texel.

    A lobe's exponent at texel (i, j) is row[n, i] + slope[n, i] * column[n, j]: 0 on the axis, negative off
    it. With the polar angle t from +Y and the azimuth a it is the haversine formula ::

        (d.u - 1) / s = -2 / s (sin^2((t - t_u) / 2) + sin t sin t_u sin^2((a - a_u) / 2))

    which does not cancel near the axis as the cosine does, and costs one product a texel.

    `peak` [n] is the largest exponent over the texels: near 0 on a fine map, far below on one that is coarser
    than the lobe, which without scaling would be all zeros in single precision.
    """

    def __init__(self, axes: Tensor, sharpness: Tensor, height: int, dtype: torch.dtype) -> None:
        x, y, z = axes.double().unbind(-1)
        polar_axis, azimuth_axis = torch.atan2(torch.hypot(x, z), y), torch.atan2(x, -z)
        centre = torch.arange(2 * height, dtype=torch.float64, device=axes.device) + 0.5
        polar, azimuth = centre[:height] * (math.pi / height), (centre / height - 1) * math.pi
        factor = -2 / sharpness.double().to(axes.device).expand(len(axes))[:, None]
        row = factor * torch.sin((polar - polar_axis[:, None]) / 2).square()
        slope = factor * torch.sin(polar) * torch.sin(polar_axis)[:, None]
        column = torch.sin((azimuth - azimuth_axis[:, None]) / 2).square()
        brightest = row + slope * column.amin(-1, keepdim=True)
        self.peak = brightest.amax(-1)
        self._brightest = (brightest - self.peak[:, None]).detach()
        self._row, self._slope, self._column = (
            part.to(dtype) for part in (row - self.peak[:, None], slope, column)
        )
        self._weight = row_solid_angle(height, dtype=torch.float64, device=axes.device)
        self._count, self._height = len(axes), height
        self._only: Tensor | None = None

    def table(self) -> Tensor:
        """All lobes on all rows [n, height, width]."""
        return self._lobes(slice(None), 0, self._height)

    def bands(self) -> Iterator[tuple[slice, Tensor | slice, Tensor]]:
        """Band after band: its rows, the lobes that reach it, and these on it [near, rows, width]."""
        step = max(1, CHUNK // (self._count * 2 * self._height))
        if step >= self._height:  # a single band is kept for the next pass
            if self._only is None:
                self._only = self.table()
            yield slice(0, self._height), slice(None), self._only
            return
        for start in range(0, self._height, step):
            stop = min(start + step, self._height)
            near = (self._brightest[:, start:stop].amax(-1) > -NEGLIGIBLE).nonzero()[:, 0]
            yield slice(start, stop), near, self._lobes(near, start, stop)

    def integral(self) -> Tensor:
        """[n] in float64: each lobe's sum of value times solid angle over the map."""
        total = self.peak.new_zeros(self._count)
        everyone = torch.arange(self._count, device=total.device)
        for rows, near, table in self.bands():
            total = total.index_add(0, everyone[near], table.sum(-1).double() @ self._weight[rows])
        return total

    def _lobes(self, chosen: Tensor | slice, start: int, stop: int) -> Tensor:
        along = self._slope[chosen, start:stop, None] * self._column[chosen, None]
        return falloff(along + self._row[chosen, start:stop, None])
