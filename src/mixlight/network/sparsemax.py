"""Sparse layers over scores of anchors: sparsemax, and SLSparsemax, which also asks the neighbours."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn import functional

from mixlight.sphere.points import neighbours as nearest_neighbours
from mixlight.sphere.points import vogel

__all__ = ["MODES", "Mode", "SLSparsemax", "slsparsemax", "sparsemax"]

Mode = Literal["masked", "literal", "sparsemax", "none"]

MODES: tuple[Mode, ...] = get_args(Mode)
"""The modes of `slsparsemax`, the default first."""

_BLOCK = 1 << 17
"""Entries worked on at once on a CPU, few enough for its cache."""

_HEAD = 48
"""Entries of the sorted row that are looked at first."""


def sparsemax(scores: Float[Tensor, "*batch count"]) -> Float[Tensor, "*batch count"]:
    """Project scores onto the probability simplex: the nearest distribution; weak entries are exactly 0.

        p_i = max(s_i - tau, 0),  tau = (sum of the kappa largest s - 1) / kappa,
        kappa = max{k : 1 + k s_(k) > s_(1) + ... + s_(k)}  with s sorted in descending order

    Gradient: on the support of kappa entries the Jacobian is I - 1 1^T / kappa, elsewhere it is 0.

    Args:
        scores: [..., N], finite, of any scale; a common offset does not matter.

    Returns:
        [..., N] in [0, 1], sums to 1. With float16 and bfloat16 the arithmetic is float32's.

    Convention: the last axis holds the anchors. (0.6, 0.5, -0.2) gives (0.55, 0.45, 0).

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
    """Return a sparse distribution over anchors of a sphere: "local clustering, global sparsity".

    Entries enter the support in the order of their credibility instead of their score: of two equal ones,
    that which is more like its neighbours comes first. With n = s - max s,

        similarity_i = exp(-|n_i - mean of n over the neighbours of i|)
        credibility_i = n_i / similarity_i <= n_i <= 0
        kappa = max{k : 1 + k min_{i <= k} s_(i) > sum_{i <= k} s_(i)}, s in descending credibility
        tau = (sum_{i <= kappa} s_(i) - 1) / kappa

    Entries of equal credibility rank by index. The condition holds on a prefix of that order, because
    sum s_(i) - k min s_(i) never falls with k; so kappa is a count.

    `masked` (default) gives s_i - tau to the kappa first and 0 to the others; the sum is 1. `literal` is the
    paper's output, max(s_i - tau, 0) for every i: an entry that was left out comes back where s_i > tau, so
    the sum exceeds 1 and nothing is sparser than after `sparsemax`. `sparsemax` takes the score for the
    credibility. `none` returns the scores themselves, for a study without a sparse layer.

    Feed linear scores at probability scale: a distribution (after a softmax, say) comes out as it went in.

    Gradient: credibility only selects and has none. `masked`: I - 1 1^T / kappa on the support, 0 elsewhere,
    so an entry outside learns nothing through this layer: keep a loss on the scores too. `literal`, where
    p_i > 0: d p_i = d s_i - (sum of d s over the kappa first) / kappa. Where the selection changes, the
    result jumps.

    Args:
        scores: [..., N], finite.
        neighbours: [N, k] indices of each anchor's neighbours, as `sphere.points.neighbours` gives them.
        mode: `masked`, `literal`, `sparsemax` or `none`.

    Returns:
        [..., N], not negative (except `none`). With float16 and bfloat16 the arithmetic is float32's.

    Convention: the last axis holds the anchors. On a ring of four, whose neighbours are left and right,
    (1, 0.9, 0.3, 0.3) gives (0.55, 0.45, 0, 0).

    Raises:
        ValueError: unknown mode; scores not floating point or empty; neighbours not integers [N, k >= 1].

    Source: the MixLight paper, Algorithm 1; `masked` is what its text says ("retain the top kappa").

    >>> ring = torch.tensor([[3, 1], [0, 2], [1, 3], [2, 0]])
    >>> slsparsemax(torch.tensor([1.0, 0.9, 0.3, 0.3]), ring)
    tensor([0.5500, 0.4500, 0.0000, 0.0000])
    """
    _check_mode(mode)
    if neighbours.ndim != 2 or neighbours.shape[1] < 1 or neighbours.shape[:1] != scores.shape[-1:]:
        raise ValueError(
            f"expected neighbours [N, k >= 1] for scores [..., N], received {list(neighbours.shape)} "
            f"for {list(scores.shape)}"
        )
    if neighbours.dtype not in (torch.int32, torch.int64):
        raise ValueError(f"expected neighbours to be int32 or int64, received {neighbours.dtype}")
    return _sparse(scores, neighbours, mode)


class SLSparsemax(nn.Module):
    """`slsparsemax` on `count` Vogel anchors with their `k` nearest neighbours; it has no weights.

    The table of neighbours follows the module's device. It is not part of the state dict, since `count` and
    `k` say what it is.

    Raises:
        ValueError: unknown mode, or fewer than `k + 1` anchors.

    >>> SLSparsemax(count=128)(torch.linspace(0.0, 1.0, 128)).count_nonzero().item()
    16
    """

    neighbours: Tensor

    def __init__(self, count: int = 128, k: int = 6, mode: Mode = "masked") -> None:
        super().__init__()
        _check_mode(mode)
        self.mode = mode
        self.register_buffer("neighbours", nearest_neighbours(vogel(count), k), persistent=False)

    def forward(self, scores: Float[Tensor, "*batch count"]) -> Float[Tensor, "*batch count"]:
        """[..., count] scores to [..., count] shares."""
        return slsparsemax(scores, self.neighbours, self.mode)

    def extra_repr(self) -> str:
        """What `print(module)` shows."""
        count, k = self.neighbours.shape
        return f"count={count}, k={k}, mode={self.mode!r}"


def _check_mode(mode: str) -> None:
    if mode not in MODES:
        raise ValueError(f"expected a mode out of {', '.join(MODES)}, received {mode!r}")


def _sparse(scores: Tensor, neighbours: Tensor | None, mode: Mode) -> Tensor:
    if not scores.is_floating_point() or scores.ndim == 0 or scores.shape[-1] == 0:
        raise ValueError(
            f"expected floating-point scores [..., N >= 1], received {scores.dtype} {list(scores.shape)}"
        )
    if mode == "none":
        return scores
    wide = scores.float() if scores.dtype in (torch.float16, torch.bfloat16) else scores
    if torch.compiler.is_compiling():
        return _plain(wide, neighbours, mode).to(scores.dtype)
    result: Tensor = _Projection.apply(wide, neighbours, mode)  # type: ignore[no-untyped-call]
    return result.to(scores.dtype)


def _plain(scores: Tensor, neighbours: Tensor | None, mode: Mode) -> Tensor:
    """The definition without sort, scan and scatter, which exporters lack: an entry looks at all before it.

    It takes N^2 numbers a row. Tests hold it against `_Projection`, whose twin it is.
    """
    shifted = scores - scores.detach().amax(-1, keepdim=True)
    fixed = shifted.detach()
    rank = -fixed
    if neighbours is not None and mode != "sparsemax":
        rank = rank.log() + (fixed - fixed[..., neighbours].mean(-1)).abs()
    index = torch.arange(scores.shape[-1], device=scores.device)
    mine, other = rank[..., :, None], rank[..., None, :]
    before = (other < mine) | ((other == mine) & (index <= index[:, None]))
    member = torch.where(before, fixed[..., None, :], 0.0)  # n <= 0: what is absent is never the lowest
    support = (member.sum(-1) - before.sum(-1) * member.amin(-1) < 1).to(scores.dtype)
    tau = ((shifted * support).sum(-1, keepdim=True) - 1) / support.sum(-1, keepdim=True)
    result = (shifted - tau).relu()
    return result if mode == "literal" else result * support


class _Projection(torch.autograd.Function):
    """s -> max(s - tau, 0) on the support (`literal`: everywhere), and its transposed Jacobian.

    The support is held as 0 and 1 in the scores' dtype: products with booleans take three times as long.
    """

    @staticmethod
    def forward(ctx: Any, scores: Tensor, neighbours: Tensor | None, mode: Mode) -> Tensor:
        rows = scores.reshape(-1, scores.shape[-1])
        result = torch.empty_like(rows, memory_format=torch.contiguous_format)
        support = torch.empty_like(result)
        step = max(1, _BLOCK // rows.shape[-1]) if rows.device.type == "cpu" else max(1, len(rows))
        for start in range(0, len(rows), step):
            block = slice(start, start + step)
            # tau moves with a common offset, so the result does not; without it, large scores lose no digits.
            shifted = rows[block] - rows[block].amax(-1, keepdim=True)
            if mode == "sparsemax" or neighbours is None:
                tau = _by_score(shifted)
                torch.gt(shifted, tau, out=support[block])
            else:
                tau = _by_credibility(shifted, _incredibility(shifted, neighbours), support[block])
            torch.clamp(shifted.sub_(tau), min=0, out=result[block])
            if mode == "masked":
                result[block].mul_(support[block])
        reached = (result > 0).to(result.dtype) if mode == "literal" else support
        ctx.save_for_backward(support, reached)
        return result.view(scores.shape)

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, None, None]:
        support, reached = (weight.view(gradient.shape) for weight in ctx.saved_tensors)
        arriving = gradient * reached
        shared = arriving.sum(-1, keepdim=True) / support.sum(-1, keepdim=True)
        return torch.addcmul(arriving, shared, support, value=-1), None, None


def _incredibility(shifted: Tensor, neighbours: Tensor) -> Tensor:
    """A number that rises as credibility falls: log(-credibility) = log(-n) + |n - mean of neighbours|.

    The logarithm keeps the order where exp(|...|) of raw logits would overflow; the maximum, n = 0,
    is at -inf.
    """
    # Whole rows of the transposed table are added: ten times faster than six numbers gathered for each entry.
    table = shifted.t().contiguous()
    mean = functional.embedding_bag(neighbours, table, mode="mean")
    return mean.sub_(table).abs_().add_(table.neg().log_()).t()


def _by_score(shifted: Tensor) -> Tensor:
    """Tau when the scores themselves give the order; the support is what lies above it."""
    if shifted.device.type == "cpu":
        return _threshold(torch.from_numpy(np.sort(shifted.neg().numpy(), axis=-1)).neg_())[1]
    return _threshold(shifted.sort(dim=-1, descending=True).values)[1]


def _by_credibility(shifted: Tensor, rank: Tensor, support: Tensor) -> Tensor:
    """Tau when entries enter in ascending rank, ties by index; writes the support."""
    if rank.device.type != "cpu" or rank.dtype != torch.float32:
        order = rank.sort(dim=-1, stable=True).indices
        kappa, tau = _threshold(shifted.gather(-1, order))
        first = torch.arange(rank.shape[-1], device=rank.device) < kappa
        support.scatter_(-1, order, first.to(support.dtype))
        return tau
    # A key of the number's bits above and its index below has no ties and is sorted by value alone, for which
    # NumPy has vector instructions: six times faster than torch.sort. Flipping the lower bits of negative
    # floats gives integers in the order of the floats; adding 0 turns -0 into +0.
    bits = (rank + 0.0).contiguous().view(torch.int32)
    bits = (bits >> 31).bitwise_and_(0x7FFFFFFF).bitwise_xor_(bits)
    key = bits.to(torch.int64).bitwise_left_shift_(32).bitwise_or_(torch.arange(rank.shape[-1]))
    ordered = torch.from_numpy(np.sort(key.numpy(), axis=-1))
    # Most supports are small: look at the first entries, and at all only where those do not settle every row.
    for head in (min(_HEAD, rank.shape[-1]), rank.shape[-1]):
        kappa, tau = _threshold(shifted.gather(-1, ordered[:, :head] & 0xFFFFFFFF))
        if int(kappa.max()) < head:
            break
    torch.le(key, ordered.gather(-1, kappa - 1), out=support)
    return tau


def _threshold(ordered: Tensor) -> tuple[Tensor, Tensor]:
    """Kappa and tau of shifted scores in the order in which they may enter the support."""
    total = ordered.cumsum(-1)
    count = torch.arange(1, ordered.shape[-1] + 1, dtype=ordered.dtype, device=ordered.device)
    fits = total - count * ordered.cummin(-1).values < 1
    kappa = fits.sum(-1, keepdim=True).clamp_(min=1)  # the maximum always fits; 0 can come of NaN only
    return kappa, (total.gather(-1, kappa - 1) - 1) / kappa
