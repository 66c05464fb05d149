"""Losses on the light sources: where (P), how strong (E) and of which colour (R).

All are squared errors except the masked one, which keeps the method's absolute value. `loss.transport`
holds the one that knows how far apart two anchors are.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor


def distribution_loss(
    predicted: Float[Tensor, "*batch anchors"], true: Float[Tensor, "*batch anchors"]
) -> Float[Tensor, "*batch"]:
    """Squared distance of two distributions over the anchors: sum of (p - g)².

    Convention: a sum, not a mean: all light on one wrong anchor costs 2, however many anchors there are.

    >>> distribution_loss(torch.tensor([1.0, 0.0, 0.0]), torch.tensor([0.0, 1.0, 0.0])).item()
    2.0
    """
    _same(predicted, true)
    return (predicted - true).square().sum(-1)


def masked_l1(
    predicted: Float[Tensor, "*batch anchors"],
    true: Float[Tensor, "*batch anchors"],
    threshold: float = 0.0,
) -> Float[Tensor, "*batch"]:
    """Light predicted where there is none: sum of |p| over the anchors whose true share is 0.

    Convention: true shares of at most `threshold` count as none. Half of the light on a wrong anchor
    costs .5, and a shift among right anchors nothing.

    >>> masked_l1(torch.tensor([0.2, 0.5, 0.3]), torch.tensor([0.6, 0.0, 0.4])).item()
    0.5
    """
    _same(predicted, true)
    return torch.where(true <= threshold, predicted.abs(), 0.0).sum(-1)


def intensity_loss(
    predicted: Float[Tensor, "*batch"], true: Float[Tensor, "*batch"], floor: float = 1e-6
) -> Float[Tensor, "*batch"]:
    """Squared error of the logarithm of the sources' intensity: ln²(max(p, floor) / max(g, floor)).

    Intensities span decades: what counts is the ratio, and too strong by a factor costs as much as
    too weak by it. Below `floor` (in the units of the input) the light counts as off; the prediction
    gets no gradient there.

    Convention: natural logarithm. Ten times too strong costs ln²(10) = 5.302.

    >>> round(intensity_loss(torch.tensor(10.0), torch.tensor(1.0)).item(), 3)
    5.302
    """
    _same(predicted, true)
    return (predicted.clamp(min=floor).log() - true.clamp(min=floor).log()).square()


def colour_loss(
    predicted: Float[Tensor, "*batch 3"], true: Float[Tensor, "*batch 3"]
) -> Float[Tensor, "*batch"]:
    """Squared distance of two colour ratios: sum of (p - g)² over the channels.

    Convention: unit vectors R = T / |T| of linear rgb, not normalised here; for unit vectors this is
    4 sin²(a/2) of the angle a between them. Pure red against pure green costs 2.

    >>> colour_loss(torch.tensor([1.0, 0.0, 0.0]), torch.tensor([0.0, 1.0, 0.0])).item()
    2.0
    """
    _same(predicted, true)
    return (predicted - true).square().sum(-1)


def concentration_loss(
    predicted: Float[Tensor, "*batch anchors"], true: Float[Tensor, "*batch anchors"]
) -> Float[Tensor, "*batch"]:
    """How much further the predicted light is spread than the true one: max(0, ln(sum g^2 / sum p^2)).

    1 / sum p^2 is the effective number of equal sources of a distribution that sums to 1. A network that
    is not sure where the lamps are would rather light the whole ceiling a little, since that is wrong nowhere
    by much; this asks it to commit to as few sources as there are.

    Convention: natural logarithm. Four equal sources where there are two cost ln 2 = .693; fewer than there
    are cost nothing.

    >>> spread, pair = torch.tensor([0.25, 0.25, 0.25, 0.25]), torch.tensor([0.5, 0.5, 0.0, 0.0])
    >>> round(concentration_loss(spread, pair).item(), 3), concentration_loss(pair, spread).item()
    (0.693, 0.0)
    """
    _same(predicted, true)
    floor = torch.finfo(predicted.dtype).tiny
    powers = [p.square().sum(-1).clamp(min=floor).log() for p in (true, predicted)]
    return (powers[0] - powers[1]).clamp(min=0)


def _same(predicted: Tensor, true: Tensor) -> None:
    if predicted.shape != true.shape:
        raise ValueError(
            f"expected prediction and truth of one shape,"
            f" got {tuple(predicted.shape)} and {tuple(true.shape)}"
        )
