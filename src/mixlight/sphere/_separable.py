"""Separable resampling: weighted means of runs of rows, then of runs of columns.

Every resampling of the project that keeps the axes (resize of a panorama, pinhole to pinhole) is two banded
matrices. A `Bands` stores such a matrix as its runs, so that a 16384 x 8192 map needs no full-size temporary.
"""

from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor

BLOCK = 16
"""Outputs of one dense product of `_multiply` (measured: 8 to 32 are alike)."""


@dataclass(frozen=True)
class Bands:
    """A matrix [outputs, inputs] whose row i is non-zero only from column starts[i] on, for one run."""

    starts: Int[Tensor, " outputs"]
    """First input of each run, ascending; starts + run <= inputs."""
    weights: Float[Tensor, "outputs run"]
    """The runs, float64."""
    inputs: int
    """Number of inputs (columns of the matrix)."""

    def dense(self) -> Float[Tensor, "outputs inputs"]:
        """The whole matrix, float64."""
        outputs, run = self.weights.shape
        matrix = torch.zeros(outputs, self.inputs, dtype=torch.float64, device="cpu")
        return matrix.scatter_(1, self.starts[:, None] + torch.arange(run, device="cpu"), self.weights)


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
    cells = starts[:, None] + torch.arange(run, device="cpu")
    covered = torch.minimum(input_edges[cells + 1], high) - torch.maximum(input_edges[cells], low)
    covered = covered.clamp(min=0)
    return Bands(starts, covered / covered.sum(1, keepdim=True), inputs)


def apply(
    values: Float[Tensor, "*batch height width channels"], rows: Bands, columns: Bands
) -> Float[Tensor, "*batch out_height out_width channels"]:
    """Return rows @ values @ columns^T for every channel; differentiable."""
    batch, (height, width, channels) = values.shape[:-3], values.shape[-3:]
    out_height, out_width = len(rows.starts), len(columns.starts)
    flat = values.reshape(-1, height, width * channels)
    reduced = torch.stack([_multiply(rows, plane) for plane in flat]) if len(flat) else flat
    planes = reduced.reshape(-1, width, channels).transpose(1, 2).reshape(-1, width)
    result = _multiply(columns, planes.T).T.reshape(-1, channels, out_width).transpose(1, 2)
    return result.reshape(*batch, out_height, out_width, channels).to(values.dtype)


def _multiply(bands: Bands, values: Float[Tensor, "inputs n"]) -> Float[Tensor, "outputs n"]:
    """Return bands @ values in at least float32, by blocks of outputs: each is a small dense product.

    The work is inputs * BLOCK * n instead of inputs * outputs * n. Where a gradient is wanted it is one
    block, for each block would send back a gradient as large as all values.
    """
    precise = torch.promote_types(values.dtype, torch.float32)
    if values.requires_grad and torch.is_grad_enabled():
        return bands.dense().to(values.device, precise) @ values.to(precise)
    outputs, run = bands.weights.shape
    result = values.new_empty((outputs, values.shape[1]), dtype=precise)
    for start in range(0, outputs, BLOCK):
        starts, weights = bands.starts[start : start + BLOCK], bands.weights[start : start + BLOCK]
        first = int(starts[0])
        block = Bands(starts - first, weights, int(starts[-1]) + run - first)
        window = values[first : first + block.inputs].to(precise)
        torch.mm(block.dense().to(values.device, precise), window, out=result[start : start + BLOCK])
    return result
