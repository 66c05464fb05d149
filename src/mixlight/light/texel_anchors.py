"""Nearest anchors of single texels, for maps that are too large for a table of all of them."""

import math
from functools import lru_cache

import torch
from jaxtyping import Int
from torch import Tensor

from mixlight.sphere.equirect import pixel_directions
from mixlight.sphere.points import nearest, vogel

_ROWS = 128
"""Rows of the grid of cells; at 128 anchors three in four of its cells lie wholly with one anchor."""


class TexelAnchors:
    """The nearest Vogel anchor of texels of a height x width panorama, by their number row * width + column.

    A coarse grid of cells answers for most: where the second nearest anchor is farther from the cell's
    centre than the nearest one by more than the cell's own diameter, the whole cell belongs to the nearest.
    Only texels of the other cells are compared with every anchor, so that the answer is exact at a third of
    the work.

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
        self._cells = _cells(anchors).to(device=device)
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
        anchor = self._cells[self._row_cell[row] + self._column_cell[column]]
        open_ = (anchor < 0).nonzero()[:, 0]
        row, column = row[open_], column[open_]
        sine = self._sine[row]
        directions = torch.stack([sine * self._right[column], self._up[row], sine * self._back[column]], -1)
        anchor[open_] = nearest(self._points, directions)
        return anchor


@lru_cache(maxsize=8)
def _cells(anchors: int) -> Tensor:
    """[cells] int64: the anchor that a whole cell belongs to, or -1. Read-only."""
    with torch.inference_mode(False):
        points = vogel(anchors, dtype=torch.float32, device="cpu")
        centres = pixel_directions(_ROWS, device="cpu").reshape(-1, 3)
        if anchors == 1:
            return torch.zeros(len(centres), dtype=torch.int64)
        best = (centres @ points.T).topk(2, dim=-1)
        angle = torch.acos(best.values.clamp(-1, 1))
        # A cell spans pi / rows in both angles; no point of it is farther from its centre than half the
        # diagonal.
        diameter = math.sqrt(2) * math.pi / _ROWS
        return torch.where(angle[:, 1] - angle[:, 0] > diameter + 1e-3, best.indices[:, 0], -1)
