"""sRGB's transfer function on tensors: `mixlight.image.color` is NumPy and cannot be part of a graph."""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor


def encode(linear: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Linear light in [0, 1] to sRGB: 12.92 c up to 0.0031308, 1.055 c^(1/2.4) - 0.055 above.

    Convention: 18 % grey becomes 0.4614. Source: IEC 61966-2-1:1999.

    >>> round(encode(torch.tensor(0.18)).item(), 4)
    0.4614
    """
    # The clamp keeps the gradient of the branch that is not taken finite at 0.
    curve = 1.055 * linear.clamp(min=0.0031308) ** (1 / 2.4) - 0.055
    return torch.where(linear <= 0.0031308, 12.92 * linear, curve)


def decode(encoded: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Linear light of sRGB in [0, 1]: the inverse of `encode`, with its threshold at 0.04045.

    >>> round(decode(torch.tensor(0.5)).item(), 4)
    0.214
    """
    curve = ((encoded.clamp(min=0.04045) + 0.055) / 1.055) ** 2.4
    return torch.where(encoded <= 0.04045, encoded / 12.92, curve)
