"""Photo in, light out, relative to the photo's mean colour: what the networks of all methods share."""

from __future__ import annotations

from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mixlight.network import backbones, srgb
from mixlight.network.settings import ModelSettings
from mixlight.network.trunk import Trunk

_DARKEST = 1e-3
"""Least mean of a channel that serves as a unit."""

_WEAKEST = 0.05
"""Least share of the brightest channel's mean."""


@runtime_checkable
class AnyLight(Protocol):
    """What heads regress: light that knows how to be made brighter."""

    @property
    def camera(self) -> Tensor:
        """[batch, 2]: pitch and roll in radians."""
        ...

    def scaled(self, gain: Tensor) -> Any:
        """The same light times a gain of every channel."""
        ...

    def to(self, device: torch.device | str) -> Any:
        """The same light on another device."""
        ...


Light = TypeVar("Light", bound=AnyLight)


class PhotoNet(nn.Module, Generic[Light]):
    """Backbone and heads. Light is predicted relative to the photo's mean linear colour.

    The photo tells light only up to its exposure and white balance, so the network regresses what is left
    when both are divided out, and the result is multiplied back. Exactly: `forward` is `relative` times the
    photo's mean colour. (Not exactly: the network looks at the photo as it is, so that a photo twice as
    bright gives about, not precisely, twice the light.)
    """

    backbone: backbones.Backbone
    heads: Trunk[Light]

    def __init__(self, settings: ModelSettings, backbone: backbones.Backbone, heads: Trunk[Light]) -> None:
        super().__init__()
        self.settings = settings
        self.backbone = backbone
        self.heads = heads

    def relative(self, photo: Float[Tensor, "batch 3 height width"]) -> tuple[Light, Tensor]:
        """Predicts light in units of the photo's mean colour, and returns that colour [batch, 3] beside it.

        `photo` is the sRGB-encoded canonical view in [0, 1].
        """
        mean = mean_linear_colour(photo)
        light: Light = self.heads(self.backbone(photo), mean)
        return light, mean

    def forward(self, photo: Float[Tensor, "batch 3 height width"]) -> Light:
        """Predicts light in the photo's own exposure: radiance 1 is the photo's linear white.

        `photo` is the sRGB-encoded canonical view in [0, 1].
        """
        light, mean = self.relative(photo)
        return self.exposed(light, mean)

    def exposed(self, relative: Light, mean: Float[Tensor, "batch 3"]) -> Light:
        """Light in the photos' own exposure, from what the heads said and the photos' mean colours."""
        result: Light = relative.scaled(mean)
        return result


def mean_linear_colour(photo: Float[Tensor, "batch 3 height width"]) -> Float[Tensor, "batch 3"]:
    """Mean of the sRGB-decoded photo per channel.

    Channels are kept above 1/1000 and above 5 % of the brightest, so that it can serve as a unit.

    >>> mean_linear_colour(torch.full((1, 3, 2, 2), 0.5))
    tensor([[0.2140, 0.2140, 0.2140]])
    """
    mean = srgb.decode(photo).float().mean((2, 3))
    floor = (_WEAKEST * mean.amax(1, keepdim=True)).clamp(min=_DARKEST)
    return torch.maximum(mean, floor)
