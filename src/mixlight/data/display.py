"""The display encoding of protocol S: values as a screen would show them, on a scale of their own."""

from __future__ import annotations

from jaxtyping import Float
from torch import Tensor

GAMMA = 2.4
MEDIAN = 0.5
"""Encoded value of the median."""


def gain(panorama: Float[Tensor, "height width 3"]) -> float:
    """The linear gain that puts the median of the values above 0 at .5 of the encoded scale.

    The median is over all channels of all texels, without regard to their solid angle, and the mean of the
    two in the middle where there are two; a black panorama has gain 1.

    Convention: panorama of 1 everywhere: .5^2.4 = .1895.

    Source: Wang et al., StyleLight, 2022 (its evaluation code; percentile 50, mapped to .5, gamma 2.4).

    >>> import torch
    >>> round(gain(torch.ones(2, 4, 3)), 4)
    0.1895
    """
    values = panorama.flatten()
    values = values[values > 0].double()
    if not len(values):
        return 1.0
    middle = (len(values) - 1) // 2
    low = values.kthvalue(middle + 1).values
    high = values.kthvalue(len(values) - middle).values
    # The median of the encoded values: the curve between the two in the middle is not straight.
    median = (low ** (1 / GAMMA) + high ** (1 / GAMMA)) / 2
    return float((MEDIAN / median) ** GAMMA)


def encode(panorama: Float[Tensor, "height width 3"]) -> Float[Tensor, "height width 3"]:
    """Values to the power 1/2.4, scaled so that the median of those above 0 is .5; unclipped.

    The same for a panorama of any brightness: it is divided out.

    Raises:
        ValueError: a negative value.

    >>> import torch
    >>> panorama = torch.ones(2, 4, 3); panorama[0] = 2.0**2.4
    >>> encode(panorama)[:, 0, 0]
    tensor([0.6667, 0.3333])
    """
    if bool((panorama < 0).any()):
        raise ValueError(f"expected radiance of at least 0, got {float(panorama.min()):g}")
    return (panorama * gain(panorama)) ** (1 / GAMMA)


def photo(view: Float[Tensor, "height width 3"], gain: float) -> Float[Tensor, "height width 3"]:
    """A view as a picture on the encoded scale: clipped at 1, 8 bits.

    >>> import torch
    >>> photo(torch.full((1, 1, 3), 0.1895), 1.0)[0, 0] * 255
    tensor([128., 128., 128.])
    """
    return (((view * gain).clamp(0, 1) ** (1 / GAMMA)) * 255).round() / 255
