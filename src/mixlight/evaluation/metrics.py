"""Errors between a picture and its truth, each named by what it divides by.

`rmse_and_si_rmse` is the formula (it lives with the light, where the training loss can reach it); the
functions here apply it to pictures under a mask, as protocol M does.
"""

from __future__ import annotations

from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.light.compare import rmse_and_si_rmse

__all__ = ["rmse", "rmse_and_si_rmse", "si_rmse"]


def rmse(
    predicted: Float[Tensor, "*batch height width channels"],
    true: Float[Tensor, "*batch height width channels"],
    mask: Bool[Tensor, "height width"],
) -> Float[Tensor, "*batch"]:
    """Root mean square error of linear pictures over the mask's pixels and all channels.

    sqrt( sum over masked pixels and channels of (p - g)² / (pixels * channels) )

    Convention: protocol M. Protocol S of the literature divides by pixels only, so its RMSE of rgb
    pictures is sqrt(3) times this one. A prediction off by 1 in every channel has RMSE 1.

    Raises:
        ValueError: If the shapes do not fit or the mask is empty.

    >>> import torch
    >>> mask = torch.tensor([[True, False]])
    >>> rmse(torch.tensor([[[2.0], [9.0]]]), torch.tensor([[[1.0], [0.0]]]), mask).item()
    1.0
    """
    return rmse_and_si_rmse(*_masked(predicted, true, mask))[0]


def si_rmse(
    predicted: Float[Tensor, "*batch height width channels"],
    true: Float[Tensor, "*batch height width channels"],
    mask: Bool[Tensor, "height width"],
) -> Float[Tensor, "*batch"]:
    """RMSE after the best single scale of the prediction, s = <p, g> / <p, p> over mask and channels.

    Convention: protocol M; one scale for all channels, so a wrong colour still counts; the error is in
    the truth's units (not divided by its brightness). A prediction that is half the truth has si-RMSE 0.

    Raises:
        ValueError: If the shapes do not fit or the mask is empty.

    >>> import torch
    >>> mask = torch.ones(1, 2, dtype=torch.bool)
    >>> si_rmse(torch.tensor([[[1.0], [2.0]]]), torch.tensor([[[2.0], [4.0]]]), mask).item()
    0.0
    """
    return rmse_and_si_rmse(*_masked(predicted, true, mask))[1]


def _masked(predicted: Tensor, true: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
    """Pixels under the mask, [..., pixels, channels]."""
    if predicted.shape != true.shape or predicted.shape[-3:-1] != mask.shape:
        raise ValueError(
            "expected pictures of one shape [..., height, width, channels] and a mask [height, width],"
            f" got {tuple(predicted.shape)}, {tuple(true.shape)} and {tuple(mask.shape)}"
        )
    return predicted[..., mask, :], true[..., mask, :]
