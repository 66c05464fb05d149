"""Separable resampling: weighted means of runs of rows, then of runs of columns.

Every resampling of the project that keeps the axes (resize of a panorama, pinhole to pinhole) is two banded
matrices. A `Bands` stores such a matrix as its runs, so that a 16384 x 8192 map needs no full-size temporary.
"""

from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor

DENSE_LIMIT = 1 << 13
"""Entries of a row matrix up to which one dense product beats the loop over runs (measured)."""

DENSE_COLUMNS = 1 << 19
"""Entries of a column matrix up to which one dense product beats the loop over taps (measured)."""


@dataclass(frozen=True)
class Bands:
    """A matrix [outputs, inputs] whose row i is non-zero only from column starts[i] on, for one run."""

    starts: Int[Tensor, " outputs"]
    """First input of each run; starts + run <= inputs."""
    weights: Float[Tensor, "outputs run"]
    """The runs, float64."""
    inputs: int
    """Number of inputs (columns of the matrix)."""

    def dense(self) -> Float[Tensor, "outputs inputs"]:
        """The whole matrix, float64."""
        outputs, run = self.weights.shape
        matrix = torch.zeros(outputs, self.inputs, dtype=torch.float64)
        return matrix.scatter_(1, self.starts[:, None] + torch.arange(run), self.weights)


def overlap(output_edges: Float[Tensor, " out_edges"], input_edges: Float[Tensor, " in_edges"]) -> Bands:
    """Mean over each output cell of a function that is constant on each input cell.

    Both lists of edges ascend in one measure (for instance -cos of the polar angle, whose differences are
    solid angles) and span the same interval. Weight_ik = |cell_i and cell_k| / |cell_i|; each row sums to 1.
    """
    inputs = len(input_edges) - 1
    low, high = output_edges[:-1, None], output_edges[1:, None]
    first = torch.searchsorted(input_edges, low[:, 0].contiguous(), right=True) - 1
    last = torch.searchsorted(input_edges, high[:, 0].contiguous()) - 1
    run = min(int((last - first).max()) + 1, inputs)
    starts = first.clamp(0, inputs - run)
    cells = starts[:, None] + torch.arange(run)
    covered = torch.minimum(input_edges[cells + 1], high) - torch.maximum(input_edges[cells], low)
    covered = covered.clamp(min=0)
    return Bands(starts, covered / covered.sum(1, keepdim=True), inputs)


def apply(
    values: Float[Tensor, "*batch height width channels"], rows: Bands, columns: Bands
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Return rows @ values @ columns^T for every channel; differentiable.

    Maps that need no gradient and are too big for a dense product go run by run through the rows (each a
    matrix-vector product on memory as it lies), so that only the already reduced map is touched twice.
    """
    batch, (height, width, channels) = values.shape[:-3], values.shape[-3:]
    out_height, out_width = len(rows.starts), len(columns.starts)
    precise = torch.float32 if values.dtype in (torch.float16, torch.bfloat16) else values.dtype
    flat = values.reshape(-1, height, width * channels)
    graph = values.requires_grad and torch.is_grad_enabled()
    if graph or out_height * height <= DENSE_LIMIT:
        reduced = rows.dense().to(values.device, precise) @ flat.to(precise)
    else:
        reduced = flat.new_empty((len(flat), out_height, width * channels), dtype=precise)
        weights, run = rows.weights.to(values.device, precise), rows.weights.shape[1]
        for source, target in zip(flat, reduced, strict=True):
            for i, start in enumerate(rows.starts.tolist()):
                torch.mv(source[start : start + run].to(precise).T, weights[i], out=target[i])
    reduced = reduced.view(-1, out_height, width, channels)
    if graph or out_width * width <= DENSE_COLUMNS:
        matrix = columns.dense().to(values.device, precise)
        result = (reduced.transpose(-1, -2) @ matrix.T).transpose(-1, -2).contiguous()
    else:
        starts, taps = columns.starts.to(values.device), columns.weights.to(values.device, precise)
        result = reduced.new_zeros((len(reduced), out_height, out_width, channels))
        for tap in range(taps.shape[1]):
            result.addcmul_(reduced.index_select(2, starts + tap), taps[:, tap, None])
    return result.view(*batch, out_height, out_width, channels).to(values.dtype)
