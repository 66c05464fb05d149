"""Light sources as an expansion instead of lobes: what spherical harmonics make of a lamp (SHH, SGH)."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light.functions import Functions
from mixlight.network.expansion import expansion_bias, expansion_size, read_expansion
from mixlight.network.trunk import Trunk

_CAMERA = 2


@dataclass(frozen=True)
class ExpandedLight:
    """Light around a batch of photos, sources and ambient light each as coefficients of given functions.

    Convention: as `mixlight.network.heads.Prediction`.
    """

    sources: Float[Tensor, "batch functions 3"]
    """Coefficients of the sources."""
    ambient: Float[Tensor, "batch coefficients 3"]
    """Coefficients of the ambient light."""
    camera: Float[Tensor, "batch 2"]
    """Pitch (up) and roll (clockwise) in radians."""

    def to(self, device: torch.device | str) -> ExpandedLight:
        """The same light on another device."""
        return ExpandedLight(**{field.name: getattr(self, field.name).to(device) for field in fields(self)})

    def scaled(self, gain: Float[Tensor, "batch 3"]) -> ExpandedLight:
        """The same light with every channel multiplied by a gain.

        >>> light = ExpandedLight(torch.ones(1, 49, 3), torch.ones(1, 9, 3), torch.zeros(1, 2))
        >>> light.scaled(torch.tensor([[2.0, 1.0, 0.0]])).sources[0, 0]
        tensor([2., 1., 0.])
        """
        gain = gain[:, None, :]
        return ExpandedLight(self.sources * gain, self.ambient * gain, self.camera)


class ExpandedHeads(Trunk[ExpandedLight]):
    """Regresses the coefficients of sources and ambient light, and the camera's pose."""

    def __init__(
        self,
        channels: int,
        grid: tuple[int, int],
        hidden: int = 256,
        grid_channels: int = 48,
        dropout: float = 0.4,
        sources: Functions = "sh6",
        ambient: Functions = "sh2",
    ) -> None:
        """Build the layers; `sources` and `ambient` name sets of `mixlight.light.functions`."""
        self.sizes = (expansion_size(sources), expansion_size(ambient), _CAMERA)
        super().__init__(channels, grid, sum(self.sizes), hidden, grid_channels, dropout)
        self.sources, self.ambient = sources, ambient

    def start_from(
        self,
        sources: Float[Tensor, "functions 3"],
        ambient: Float[Tensor, "coefficients 3"],
        camera: Float[Tensor, " 2"],
    ) -> None:
        """Sets the output biases so that the untrained network predicts a given (mean) light."""
        with torch.no_grad():
            self.outputs.bias.copy_(
                torch.cat(
                    [expansion_bias(sources, self.sources), expansion_bias(ambient, self.ambient), camera]
                )
            )

    def forward(
        self, features: Float[Tensor, "batch channels rows columns"], mean: Float[Tensor, "batch 3"]
    ) -> ExpandedLight:
        """Regresses the light in units of `mean`, the photo's mean linear colour, which is an input too."""
        sources, ambient, camera = self.raw(features, mean).split(self.sizes, 1)
        return ExpandedLight(
            read_expansion(sources, self.sources), read_expansion(ambient, self.ambient), camera
        )
