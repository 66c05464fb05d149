"""Errors between a picture and its truth, each named by what it divides by.

`rmse_and_si_rmse` is the formula (it lives with the light, where the training loss can reach it); the
functions here apply it to pictures under a mask.
"""

from __future__ import annotations

import math
from typing import Literal

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.light.compare import rmse_and_si_rmse

__all__ = ["Divisor", "normalised_rmse", "rgb_angle", "rmse", "rmse_and_si_rmse", "si_rmse"]

Divisor = Literal["values", "pixels"]
"""What a sum of squared errors is divided by: pixels times channels (protocol M), or pixels (protocol S)."""

LOW, HIGH = 0.001, 0.999
"""Quantiles of a picture's values that `normalised_rmse` takes to 0 and 1."""


def rmse(
    predicted: Float[Tensor, "*batch height width channels"],
    true: Float[Tensor, "*batch height width channels"],
    mask: Bool[Tensor, "height width"],
    divisor: Divisor = "values",
) -> Float[Tensor, "*batch"]:
    """Root mean square error of pictures over the mask's pixels and all channels.

    sqrt( sum over masked pixels and channels of (p - g)² / (pixels * channels) )

    Convention: protocol M's divisor. Protocol S divides by `pixels` only, so its RMSE of rgb pictures is
    sqrt(3) times this one. A prediction off by 1 in every channel has RMSE 1, and sqrt(3) by pixels.

    Raises:
        ValueError: If the shapes do not fit or the mask is empty.

    >>> import torch
    >>> mask = torch.tensor([[True, False]])
    >>> rmse(torch.tensor([[[2.0], [9.0]]]), torch.tensor([[[1.0], [0.0]]]), mask).item()
    1.0
    """
    return rmse_and_si_rmse(*_masked(predicted, true, mask), _count(true, mask, divisor))[0]


def si_rmse(
    predicted: Float[Tensor, "*batch height width channels"],
    true: Float[Tensor, "*batch height width channels"],
    mask: Bool[Tensor, "height width"],
    divisor: Divisor = "values",
) -> Float[Tensor, "*batch"]:
    """RMSE after the best single scale of the prediction, s = <p, g> / <p, p> over mask and channels.

    Convention: one scale for all channels, so a wrong colour still counts; the error is in
    the truth's units (not divided by its brightness). A prediction that is half the truth has si-RMSE 0.

    Raises:
        ValueError: If the shapes do not fit or the mask is empty.

    >>> import torch
    >>> mask = torch.ones(1, 2, dtype=torch.bool)
    >>> si_rmse(torch.tensor([[[1.0], [2.0]]]), torch.tensor([[[2.0], [4.0]]]), mask).item()
    0.0
    """
    return rmse_and_si_rmse(*_masked(predicted, true, mask), _count(true, mask, divisor))[1]


def rgb_angle(
    predicted: Float[Tensor, "*batch height width 3"],
    true: Float[Tensor, "*batch height width 3"],
    mask: Bool[Tensor, "height width"],
) -> Float[Tensor, "*batch"]:
    """Mean angle in radians between the colours of two pictures as vectors: an error of hue and saturation.

    Convention: red against yellow of any brightness is 45 degrees. A black pixel on either side counts as an
    angle of 0, as it does in the code of StyleLight.

    Raises:
        ValueError: If the shapes do not fit or the mask is empty.

    >>> red, yellow = torch.tensor([[[2.0, 0.0, 0.0]]]), torch.tensor([[[1.0, 1.0, 0.0]]])
    >>> round(math.degrees(rgb_angle(red, yellow, torch.tensor([[True]]))), 3)
    45.0
    """
    p, g = _masked(predicted, true, mask)
    if not p.shape[-2]:
        raise ValueError("expected at least one pixel under the mask, got none")
    # By the tangent: an arc cosine loses half of the digits where the angle is small.
    sine = torch.linalg.vector_norm(torch.linalg.cross(p, g), dim=-1)
    return torch.atan2(sine, (p * g).sum(-1)).mean(-1)


def normalised_rmse(
    predicted: Float[Tensor, "*batch height width channels"],
    true: Float[Tensor, "*batch height width channels"],
    mask: Bool[Tensor, "height width"],
    frame: tuple[int, int] | None = None,
) -> Float[Tensor, "*batch"]:
    """RMSE (divided by pixels) of pictures that were each taken to a range of their own.

        x -> (x - q_low) / (q_high - q_low)

    with the quantiles .001 and .999 (linear between ranks) of all values of the whole frame, what is around
    the sphere included. A picture without range, such as a black one, becomes 0.

    Convention: a picture and its double have error 0. Where the sphere covers less than the frame, q_low of
    a picture on black is 0.

    Args:
        predicted: pictures, values of at least 0.
        true: the same of the truth.
        mask: the pixels that count.
        frame: rows and columns of the whole picture where these are cut from it; the rest of it is 0.

    Raises:
        ValueError: If the shapes do not fit, the mask is empty, or the frame is smaller than the pictures.

    >>> picture = torch.linspace(0, 1, 48).view(4, 4, 3)
    >>> normalised_rmse(2 * picture, picture, torch.ones(4, 4, dtype=torch.bool)).item()
    0.0
    """
    height, width, channels = true.shape[-3:]
    rows, columns = frame or (height, width)
    if rows < height or columns < width:
        raise ValueError(f"expected a frame of at least {height} x {width}, got {rows} x {columns}")
    around = (rows * columns - height * width) * channels
    scaled = [_ranged(picture, around) for picture in (predicted, true)]
    return rmse(scaled[0], scaled[1], mask, "pixels")


def _ranged(pictures: Tensor, around: int) -> Tensor:
    """Pictures [..., h, w, c] on the range of their quantiles; `around` values beside them are 0."""
    flat = pictures.flatten(-3).flatten(0, -2) if pictures.ndim > 3 else pictures.flatten()[None]
    low, high = (
        torch.stack([_quantile(values, around, q) for values in flat]).view(*pictures.shape[:-3], 1, 1, 1)
        for q in (LOW, HIGH)
    )
    spread = high - low
    return torch.where(spread > 0, (pictures - low) / torch.where(spread > 0, spread, 1.0), 0.0)


def _quantile(values: Tensor, zeros: int, share: float) -> Tensor:
    """Quantile of values >= 0 together with that many zeros, linear between ranks."""
    place = share * (len(values) + zeros - 1)
    rank = math.floor(place)

    def at(index: int) -> Tensor:
        return values.kthvalue(index - zeros + 1).values if index >= zeros else values.new_zeros(())

    lower = at(rank)
    return lower if place == rank else lower + (at(rank + 1) - lower) * (place - rank)


def _count(true: Tensor, mask: Tensor, divisor: Divisor) -> int:
    return int(mask.sum()) * (true.shape[-1] if divisor == "values" else 1)


def _masked(predicted: Tensor, true: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
    """Pixels under the mask, [..., pixels, channels]."""
    if predicted.shape != true.shape or predicted.shape[-3:-1] != mask.shape:
        raise ValueError(
            "expected pictures of one shape [..., height, width, channels] and a mask [height, width],"
            f" got {tuple(predicted.shape)}, {tuple(true.shape)} and {tuple(mask.shape)}"
        )
    return predicted[..., mask, :], true[..., mask, :]
