"""How far two lit pictures are apart: RMSE, and RMSE after the best single scale."""

from __future__ import annotations

import math

import torch
from jaxtyping import Float
from torch import Tensor


def rmse_and_si_rmse(
    predicted: Float[Tensor, "*batch pixels channels"],
    true: Float[Tensor, "*batch pixels channels"],
    count: int | None = None,
) -> tuple[Float[Tensor, "*batch"], Float[Tensor, "*batch"]]:
    """RMSE and scale-invariant RMSE of pictures, over pixels and channels.

        RMSE    = sqrt( sum (p - g)² / count )
        si-RMSE = sqrt( sum (s p - g)² / count ),   s = <p, g> / <p, p>

    with one scale s for all pixels and channels of a picture; s = 0 where the prediction is black.

    Convention: protocol M of the evaluation: linear radiance, the divisor is the number of the
    sphere's pixels times the number of channels. p = (1, 1), g = (1, 3) in one channel: RMSE
    sqrt(2), s = 2, si-RMSE 1.

    Args:
        predicted: Pixels under the mask, any order.
        true: The same of the truth; broadcasts against `predicted`.
        count: Divisor; pixels times channels if not given. (A loss that works on an orthonormal
            transform of the pixels has fewer rows than the picture has pixels.)

    Returns:
        RMSE and si-RMSE, in the units of the input. Differentiable everywhere, with gradient 0
        where they are 0.

    Raises:
        ValueError: If the trailing shapes differ, or there is no pixel.

    >>> p, g = torch.tensor([[1.0], [1.0]]), torch.tensor([[1.0], [3.0]])
    >>> [round(x.item(), 4) for x in rmse_and_si_rmse(p, g)]
    [1.4142, 1.0]
    """
    if predicted.shape[-2:] != true.shape[-2:]:
        raise ValueError(
            f"expected pictures of one size, got {tuple(predicted.shape)} and {tuple(true.shape)}"
        )
    count = predicted.shape[-2] * predicted.shape[-1] if count is None else count
    if count < 1:
        raise ValueError(f"expected at least one pixel, got {tuple(predicted.shape)}")
    product = (predicted * true).sum((-2, -1))
    power = predicted.square().sum((-2, -1))
    lit = power > 0
    scale = torch.where(lit, product / torch.where(lit, power, 1.0), 0.0)
    # Norms of the residuals themselves, not <g, g> - <p, g>²/<p, p>: that loses all digits of a good fit.
    # Their gradient at 0 is 0, where that of a square root would be infinite.
    error = torch.linalg.vector_norm(predicted - true, dim=(-2, -1))
    scaled = torch.linalg.vector_norm(scale[..., None, None] * predicted - true, dim=(-2, -1))
    return error / math.sqrt(count), scaled / math.sqrt(count)
