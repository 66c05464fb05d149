"""Nearest anchors of single texels, for maps that are too large for a table of all of them."""

import math
from functools import lru_cache

import torch
from jaxtyping import Int
from torch import Tensor

from mixlight.sphere.equirect import pixel_directions
from mixlight.sphere.points import vogel

_ROWS = 128
"""Rows of the grid of cells."""


class TexelAnchors:
    """The nearest Vogel anchor of texels of a height x width panorama, by their number row * width + column.

    A coarse grid of cells holds the few anchors that can be nearest anywhere in a cell: those that are
    farther from its centre than the nearest one by no more than the cell's own diameter. For three cells in
    four that is a single one, and for the others the choice is among three or four and not among all. Exact.

    Convention: row 0 is +Y, the image centre is -Z; ties go to the lower index, as in
        `mixlight.sphere.points.nearest`.

    >>> TexelAnchors(128, 2048, 4096)(torch.tensor([0, 2047 * 4096]))
    tensor([  0, 127])
    """

    def __init__(
        self, anchors: int, height: int, width: int, device: torch.device | str | None = None
    ) -> None:
        self._width = width
        self._points = vogel(anchors, dtype=torch.float64, device=device)
        self._candidates = _candidates(anchors).to(device=device)
        centre = torch.arange(max(height, width), dtype=torch.float64, device=device) + 0.5
        polar = centre[:height] * (math.pi / height)
        azimuth = (centre[:width] / width - 0.5) * (2 * math.pi)
        self._sine, self._up = torch.sin(polar), torch.cos(polar)
        self._right, self._back = torch.sin(azimuth), -torch.cos(azimuth)
        self._row_cell = (centre[:height] * _ROWS / height).long() * (2 * _ROWS)
        self._column_cell = (centre[:width] * (2 * _ROWS) / width).long()

    def __call__(self, texels: Int[Tensor, " n"]) -> Int[Tensor, " n"]:
        """Indices of the anchors."""
        row = texels // self._width
        column = texels - row * self._width
        cell = self._row_cell[row] + self._column_cell[column]
        anchor = self._candidates[cell, 0]
        if self._candidates.shape[1] == 1:
            return anchor
        open_ = (self._candidates[cell, 1] != anchor).nonzero()[:, 0]
        row, column, few = row[open_], column[open_], self._candidates[cell[open_]]
        sine = self._sine[row]
        direction = torch.stack([sine * self._right[column], self._up[row], sine * self._back[column]], -1)
        cosine = (self._points[few] @ direction[:, :, None])[..., 0]
        anchor[open_] = few.gather(1, cosine.argmax(-1, keepdim=True))[:, 0]
        return anchor


@lru_cache(maxsize=8)
def _candidates(anchors: int) -> Tensor:
    """[cells, most]: anchors that may be nearest in each, ascending, filled with the lowest. Read-only."""
    with torch.inference_mode(False):
        points = vogel(anchors, dtype=torch.float32, device="cpu")
        centres = pixel_directions(_ROWS, device="cpu").reshape(-1, 3)
        # A cell spans pi / rows in both angles; no point of it is farther from its centre than half the
        # diagonal. The margin covers single precision.
        diameter = math.sqrt(2) * math.pi / _ROWS + 1e-3
        cosine = centres @ points.T
        most = min(8, anchors)
        while True:
            best = cosine.topk(most, dim=-1)
            angle = torch.acos(best.values.clamp(-1, 1))
            possible = angle <= angle[:, :1] + diameter
            if most == anchors or not bool(possible[:, -1].any()):
                break
            most = min(2 * most, anchors)
        index = torch.where(possible, best.indices, anchors).sort(-1).values[:, : int(possible.sum(1).max())]
        return torch.where(index == anchors, index[:, :1], index)
