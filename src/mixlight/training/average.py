"""The running average of the weights, which is what a training run validates and keeps."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor

__all__ = ["follow"]


@torch.no_grad()
def follow(average: Mapping[str, Tensor], state: Mapping[str, Tensor], decay: float, step: int) -> None:
    """Moves an exponential moving average towards the weights, in place.

    It is bias-corrected at the start: the first steps average over what there is, with the decay
    min(`decay`, (1 + step) / (10 + step)).

    Args:
        average: what is moved; whole numbers, such as counts of batches, are copied.
        state: the weights, of the same shapes; what is not in `average` is left out.
        decay: share of the average that stays in each step, 0 to 1.
        step: how many steps were done before.
    """
    decay = min(decay, (1 + step) / (10 + step))
    for key, kept in average.items():
        value = state[key]
        if value.dtype.is_floating_point:
            kept.lerp_(value, 1 - decay)
        else:
            kept.copy_(value)
