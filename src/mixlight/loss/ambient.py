"""Losses on the ambient light: coefficients, radiance map and irradiance map, without making a map.

The method states the two map losses as means over the texels of a panorama, weighted by the sine of
the polar angle. Since spherical harmonics are orthonormal under exactly that weight, each is a weighted
sum of squared coefficient errors in the limit of many texels. That is what stands here: exact, and
a few multiplications.
"""

from __future__ import annotations

import math

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light.harmonics import cosine_factor


def coefficient_loss(
    predicted: Float[Tensor, "*batch coefficients channels"],
    true: Float[Tensor, "*batch coefficients channels"],
) -> Float[Tensor, "*batch"]:
    """Squared error of the coefficients, each degree divided by its number of orders.

        L = sum over channels and l of 1/(2l + 1) * sum over m of dA_lm²

    Convention: index l² + l + m. An error of 1 in one channel of index 2 (l = 1) costs 1/3.

    Raises:
        ValueError: If the shapes differ or the number of coefficients is no square.

    >>> a = torch.zeros(9, 3)
    >>> b = a.clone()
    >>> b[2, 0] = 1.0
    >>> round(coefficient_loss(a, b).item(), 4)
    0.3333
    """
    degrees = _degrees(predicted, true)
    return _weighted(predicted, true, [1 / (2 * degree + 1) for degree in degrees])


def reconstruction_loss(
    predicted: Float[Tensor, "*batch coefficients channels"],
    true: Float[Tensor, "*batch coefficients channels"],
) -> Float[Tensor, "*batch"]:
    """Mean squared error of the radiance maps, weighted by the sine of the polar angle.

    With I = sum A_lm B_lm on an H x W panorama whose row i has polar angle t_i:

        L = 1/(3 W H) sum over texels and channels of sin(t) dI²  ->  sum of dA² / (6 pi²)

    (the sum tends to the integral over the sphere times W H / (2 pi²)). Negative radiance is not
    clamped.

    Convention: index l² + l + m; units of radiance squared. Maps that differ by 1 everywhere
    (dA_00 = sqrt(4 pi) in each of three channels) cost 2/pi = .637, the mean of the sine.

    Raises:
        ValueError: If the shapes differ or the number of coefficients is no square.

    >>> one = torch.zeros(9, 3)
    >>> one[0] = math.sqrt(4 * math.pi)
    >>> round(reconstruction_loss(one, torch.zeros(9, 3)).item(), 4)
    0.6366
    """
    degrees = _degrees(predicted, true)
    scale = 2 * math.pi**2 * predicted.shape[-1]
    return _weighted(predicted, true, [1 / scale for _ in degrees])


def rendering_loss(
    predicted: Float[Tensor, "*batch coefficients channels"],
    true: Float[Tensor, "*batch coefficients channels"],
) -> Float[Tensor, "*batch"]:
    """Mean squared error of the irradiance maps over pi, weighted by the sine of the polar angle.

    Irradiance over pi is what a white Lambertian surface of that orientation shows. With f_l = 1, 2/3,
    1/4 (the cosine kernel over pi):

        L = 1/(3 W H) sum over texels and channels of sin(t) (dE/pi)²  ->  sum of f_l² dA_lm² / (6 pi²)

    Convention: as `reconstruction_loss`; constant maps that differ by 1 cost 2/pi = .637 here too.

    Raises:
        ValueError: If the shapes differ or the number of coefficients is no square.

    >>> a = torch.zeros(9, 3)
    >>> a[2] = 1.0
    >>> round((rendering_loss(a, 0 * a) / reconstruction_loss(a, 0 * a)).item(), 4)
    0.4444
    """
    degrees = _degrees(predicted, true)
    scale = 2 * math.pi**2 * predicted.shape[-1]
    return _weighted(predicted, true, [(cosine_factor(degree) / math.pi) ** 2 / scale for degree in degrees])


def _degrees(predicted: Tensor, true: Tensor) -> list[int]:
    """The degree l of each coefficient."""
    if predicted.shape != true.shape:
        raise ValueError(
            f"expected coefficients of one shape, got {tuple(predicted.shape)} and {tuple(true.shape)}"
        )
    count = predicted.shape[-2]
    if count < 1 or math.isqrt(count) ** 2 != count:
        raise ValueError(f"expected a square number of coefficients, got shape {tuple(predicted.shape)}")
    return [math.isqrt(index) for index in range(count)]


def _weighted(predicted: Tensor, true: Tensor, weights: list[float]) -> Tensor:
    weight = torch.tensor(weights, dtype=predicted.dtype, device=predicted.device)
    return ((predicted - true).square().sum(-1) * weight).sum(-1)
