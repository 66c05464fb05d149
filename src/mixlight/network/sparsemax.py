"""Sparse layers over scores of anchors: sparsemax, and SLSparsemax, which also asks how like its neighbours each is."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
import torch
import torch.nn.functional as F
from jaxtyping import Float, Int
from torch import Tensor, nn

from mixlight.sphere.points import neighbours as nearest_neighbours
from mixlight.sphere.points import vogel

Mode = Literal["masked", "literal", "sparsemax", "none"]
MODES: tuple[str, ...] = get_args(Mode)

_BLOCK = 1 << 14
"""Entries worked on at once on a CPU: they stay in the cache, and are too few for threads to wait for each other."""


def sparsemax(scores: Float[Tensor, "*batch count"]) -> Float[Tensor, "*batch count"]:
    """Project scores onto the probability simplex: the nearest distribution, in which weak entries are exactly 0.

        p_i = max(s_i - tau, 0),  tau = (sum of the kappa largest s - 1) / kappa,
        kappa = max{k : 1 + k s_(k) > s_(1) + ... + s_(k)}  with s sorted in descending order

    Args:
        scores: [..., N], finite, of any scale; a common offset does not matter.

    Returns:
        [..., N] in [0, 1], sums to 1. With float16 and bfloat16 the arithmetic is float32's.

    Gradient: on the support S of kappa entries the Jacobian is I - 1 1^T / kappa, elsewhere it is 0.

    Convention: the last axis holds the anchors. (0.6, 0.5, -0.2) -> (0.55, 0.45, 0).

    Raises:
        ValueError: scores are not floating point, or have no last axis or an empty one.

    Source: Martins and Astudillo, "From Softmax to Sparsemax", 2016, Algorithm 1.

    >>> sparsemax(torch.tensor([0.6, 0.5, -0.2]))
    tensor([0.5500, 0.4500, 0.0000])
    """
    return _sparse(scores, None, "sparsemax")


def slsparsemax(
    scores: Float[Tensor, "*batch count"], neighbours: Int[Tensor, "count k"], mode: Mode = "masked"
) -> Float[Tensor, "*batch count"]:
    """Sparse distribution over anchors of a sphere: "local clustering, global sparsity".

    Entries enter the support in the order of their credibility instead of their score: of two equal ones, that which
    is more like its neighbours comes first. With n = s - max s,

        similarity_i = exp(-|n_i - mean of n over the neighbours of i|),   credibility_i = n_i / similarity_i <= n_i,
        kappa = max{k : 1 + k min_{i <= k} s_(i) > sum_{i <= k} s_(i)}     with s in descending credibility,
        tau = (sum_{i <= kappa} s_(i) - 1) / kappa

    Entries of equal credibility rank by index. The condition holds on a prefix of that order, because
    sum s_(i) - k min s_(i) never falls with k; so kappa is a count.

    Modes:
        ``masked`` (default): s_i - tau on the kappa first, 0 elsewhere; sums to 1.
        ``literal``: the paper's output max(s_i - tau, 0) for every i. Entries left out of the kappa first come back
            where s_i > tau, so that the sum exceeds 1 and nothing is sparser than ``sparsemax``.
        ``sparsemax``: credibility is the score; neighbours are not looked at.
        ``none``: the scores themselves, for a study without a sparse layer.

    Feed linear scores at probability scale: what already is a distribution (after a softmax, say) comes out as it is.

    Args:
        scores: [..., N], finite.
        neighbours: [N, k] indices of each anchor's neighbours, as ``sphere.points.neighbours`` gives them.

    Returns:
        [..., N], not negative (but for ``none``). With float16 and bfloat16 the arithmetic is float32's.

    Gradient: credibility only selects and has none. ``masked``: I - 1 1^T / kappa on the support, 0 elsewhere, so an
    entry outside learns nothing from this layer: keep a loss on the scores too. ``literal``: d p_i = d s_i -
    (sum of d s over the kappa first) / kappa wherever p_i > 0. Where the selection changes, the result jumps.

    Convention: the last axis holds the anchors. On a ring of four, whose neighbours are left and right, the scores
    (1, 0.9, 0.3, 0.3) give (0.55, 0.45, 0, 0).

    Raises:
        ValueError: unknown mode; scores not floating point or empty; neighbours not integers of shape [N, k >= 1].

    Source: the MixLight paper, Algorithm 1; ``masked`` is what its text says ("retain the top kappa").

    >>> ring = torch.tensor([[3, 1], [0, 2], [1, 3], [2, 0]])
    >>> slsparsemax(torch.tensor([1.0, 0.9, 0.3, 0.3]), ring)
    tensor([0.5500, 0.4500, 0.0000, 0.0000])
    """
    if mode not in MODES:
        raise ValueError(f"expected a mode out of {', '.join(MODES)}, received {mode!r}")
    if neighbours.ndim != 2 or neighbours.shape[1] < 1 or neighbours.shape[0] != scores.shape[-1:].numel():
        raise ValueError(
            f"expected neighbours [N, k] for scores [..., N] = {list(scores.shape)}, received {list(neighbours.shape)}"
        )
    if neighbours.dtype not in (torch.int32, torch.int64):
        raise ValueError(f"expected neighbours to be int32 or int64, received {neighbours.dtype}")
    return _sparse(scores, neighbours, mode)


class SLSparsemax(nn.Module):
    """``slsparsemax`` on ``count`` Vogel anchors with their ``k`` nearest neighbours; holds no weights.

    Shapes: ``[..., count]`` -> ``[..., count]``. The table of neighbours follows the module's device and is not part
    of its state dict: it follows from ``count`` and ``k``.

    Raises:
        ValueError: unknown mode, or fewer than ``k + 1`` anchors.

    >>> SLSparsemax(count=128)(torch.linspace(0.0, 1.0, 128)).count_nonzero().item()
    16
    """

    neighbours: Tensor

    def __init__(self, count: int = 128, k: int = 6, mode: Mode = "masked") -> None:
        super().__init__()
        if mode not in MODES:
            raise ValueError(f"expected a mode out of {', '.join(MODES)}, received {mode!r}")
        self.mode = mode
        self.register_buffer("neighbours", nearest_neighbours(vogel(count), k), persistent=False)

    def forward(self, scores: Float[Tensor, "*batch count"]) -> Float[Tensor, "*batch count"]:
        return slsparsemax(scores, self.neighbours, self.mode)

    def extra_repr(self) -> str:
        count, k = self.neighbours.shape
        return f"count={count}, k={k}, mode={self.mode!r}"


def _sparse(scores: Tensor, neighbours: Tensor | None, mode: Mode) -> Tensor:
    if not scores.is_floating_point() or scores.ndim == 0 or scores.shape[-1] == 0:
        raise ValueError(
            f"expected floating-point scores [..., N] with N >= 1, received {scores.dtype} {list(scores.shape)}"
        )
    if mode == "none":
        return scores
    wide = scores.float() if scores.dtype in (torch.float16, torch.bfloat16) else scores
    if torch.compiler.is_compiling():
        result = _plain(wide, neighbours, mode)
    else:
        result = _Projection.apply(wide, neighbours, mode)
    return result.to(scores.dtype)


def _plain(scores: Tensor, neighbours: Tensor | None, mode: Mode) -> Tensor:
    """The definition without sort, scan and scatter, which exporters lack: each entry looks at all before it.

    Slow for large batches (N^2 numbers a row), differentiable as it stands, and the twin that tests hold against
    ``_Projection``.
    """
    shifted = scores - scores.detach().amax(-1, keepdim=True)
    fixed = shifted.detach()
    rank = -fixed
    if neighbours is not None and mode != "sparsemax":
        rank = rank.log() + (fixed - fixed[..., neighbours].mean(-1)).abs()
    index = torch.arange(scores.shape[-1], device=scores.device)
    mine, other = rank[..., :, None], rank[..., None, :]
    before = (other < mine) | ((other == mine) & (index <= index[:, None]))
    member = torch.where(before, fixed[..., None, :], 0.0)  # n <= 0, so an absent entry never is the lowest
    support = (member.sum(-1) - before.sum(-1) * member.amin(-1) < 1).to(scores.dtype)
    tau = ((shifted * support).sum(-1, keepdim=True) - 1) / support.sum(-1, keepdim=True)
    result = (shifted - tau).relu()
    return result if mode == "literal" else result * support


class _Projection(torch.autograd.Function):
    """s -> max(s - tau, 0) on the support (``literal``: everywhere), and its transposed Jacobian."""

    @staticmethod
    def forward(ctx: Any, scores: Tensor, neighbours: Tensor | None, mode: Mode) -> Tensor:
        rows = scores.reshape(-1, scores.shape[-1])
        result = torch.empty_like(rows, memory_format=torch.contiguous_format)
        support = torch.empty_like(result, dtype=torch.bool)
        step = max(1, _BLOCK // rows.shape[-1]) if rows.device.type == "cpu" else max(1, len(rows))
        for block in range(0, len(rows), step):
            part = slice(block, block + step)
            # tau moves with a common offset, so the result does not; without it, large scores lose no digits.
            shifted = rows[part] - rows[part].amax(-1, keepdim=True)
            if mode == "sparsemax":
                tau = _threshold(_sorted(shifted, descending=True))[1]
                torch.gt(shifted, tau, out=support[part])
            else:
                assert neighbours is not None
                tau, support[part] = _select(shifted, _incredibility(shifted, neighbours))
            torch.clamp(shifted.sub_(tau), min=0, out=result[part])
        if mode == "masked":
            result *= support
        ctx.literal = mode == "literal"
        ctx.save_for_backward(support, result > 0 if ctx.literal else None)
        return result.view(scores.shape)

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, None, None]:  # type: ignore[override]
        support, positive = ctx.saved_tensors
        support = support.view(gradient.shape)
        reaching = gradient * (support if positive is None else positive.view(gradient.shape))
        shared = reaching.sum(-1, keepdim=True) / support.sum(-1, keepdim=True)
        return reaching - shared * support, None, None


def _incredibility(shifted: Tensor, neighbours: Tensor) -> Tensor:
    """A number that rises as credibility falls: log(-credibility) = log(-n) + |n - mean of neighbours|.

    The logarithm keeps the order where exp(|...|) of raw logits would overflow; the maximum, n = 0, is at -inf.
    """
    # Rows of a transposed table: ten times faster than gathering six single numbers for each entry.
    mean = F.embedding_bag(neighbours, shifted.t().contiguous(), mode="mean").t()
    return (shifted - mean).abs_().add_(shifted.neg().log_())


def _select(shifted: Tensor, rank: Tensor) -> tuple[Tensor, Tensor]:
    """tau and the support: as many of the first in ascending rank, ties by index, as the condition admits."""
    if rank.device.type != "cpu" or rank.dtype != torch.float32:
        order = torch.sort(rank, dim=-1, stable=True).indices
        kappa, tau = _threshold(shifted.gather(-1, order))
        first = torch.arange(rank.shape[-1], device=rank.device) < kappa
        return tau, torch.zeros_like(first).scatter(-1, order, first)
    # A key of the number's bits above and its index below has no ties and is sorted by value alone, for which NumPy
    # has vector instructions: six times faster than torch.sort. Flipping the lower bits of negative floats gives
    # integers in the order of the floats; adding 0 turns -0 into +0.
    bits = rank.add_(0.0).view(torch.int32)
    bits = (bits >> 31).bitwise_and_(0x7FFFFFFF).bitwise_xor_(bits)
    key = bits.to(torch.int64).bitwise_left_shift_(32).bitwise_or_(torch.arange(rank.shape[-1]))
    ordered = _sorted(key)
    kappa, tau = _threshold(shifted.gather(-1, ordered & 0xFFFFFFFF))
    return tau, key <= ordered.gather(-1, kappa - 1)


def _threshold(ordered: Tensor) -> tuple[Tensor, Tensor]:
    """kappa and tau of shifted scores in the order in which they may enter the support."""
    total = ordered.cumsum(-1)
    count = torch.arange(1, ordered.shape[-1] + 1, dtype=ordered.dtype, device=ordered.device)
    fits = total - count * ordered.cummin(-1).values < 1
    kappa = fits.sum(-1, keepdim=True).clamp_(min=1)  # at least the first; 0 could come of NaN only
    return kappa, (total.gather(-1, kappa - 1) - 1) / kappa


def _sorted(values: Tensor, descending: bool = False) -> Tensor:
    if values.device.type != "cpu":
        return torch.sort(values, dim=-1, descending=descending).values
    ordered = np.sort((-values if descending else values).numpy(), axis=-1)
    return -torch.from_numpy(ordered) if descending else torch.from_numpy(ordered)
