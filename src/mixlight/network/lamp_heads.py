"""A few lamps of free direction, size and colour in even light: Gardner et al. 2019's outputs."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from mixlight.light import lamps
from mixlight.network.trunk import LOG_LIMIT, Trunk

_CAMERA = 2
_EACH = 3 + 1 + 3
"""Outputs of one lamp: direction, size, colour."""

_SHARPEST, _SMOOTHEST = math.log(1e-3), math.log(0.5)


@dataclass(frozen=True)
class LampLight:
    """Light around a batch of photos: lamps and one constant.

    Convention: as `mixlight.network.heads.Prediction`.
    """

    direction: Float[Tensor, "batch lamps 3"]
    """Unit vectors towards the lamps."""
    sharpness: Float[Tensor, "batch lamps"]
    """Each lamp's s (`mixlight.light.lamps`)."""
    energy: Float[Tensor, "batch lamps 3"]
    """Integrated radiance of each lamp."""
    ambient: Float[Tensor, "batch 3"]
    """Radiance from everywhere else."""
    camera: Float[Tensor, "batch 2"]
    """Pitch (up) and roll (clockwise) in radians."""

    def to(self, device: torch.device | str) -> LampLight:
        """The same light on another device."""
        return LampLight(**{field.name: getattr(self, field.name).to(device) for field in fields(self)})

    def scaled(self, gain: Float[Tensor, "batch 3"]) -> LampLight:
        """The same light with every channel multiplied by a gain.

        >>> light = LampLight(*map(torch.ones, ((1, 3, 3), (1, 3), (1, 3, 3), (1, 3), (1, 2))))
        >>> light.scaled(torch.tensor([[2.0, 1.0, 0.0]])).energy[0, 0]
        tensor([2., 1., 0.])
        """
        energy, ambient = self.energy * gain[:, None, :], self.ambient * gain
        return LampLight(self.direction, self.sharpness, energy, ambient, self.camera)

    def lamps(self) -> lamps.Lamps:
        """Without the camera."""
        return lamps.Lamps(self.direction, self.sharpness, self.energy, self.ambient)


class LampHeads(Trunk[LampLight]):
    """Regresses lamps, even light, and the camera's pose; sizes and colours are exponentials."""

    def __init__(
        self,
        channels: int,
        grid: tuple[int, int],
        hidden: int = 256,
        grid_channels: int = 48,
        dropout: float = 0.4,
        count: int = lamps.COUNT,
    ) -> None:
        """Build the layers for `count` lamps."""
        super().__init__(channels, grid, _EACH * count + 3 + _CAMERA, hidden, grid_channels, dropout)
        self.count = count

    def start_from(
        self,
        direction: Float[Tensor, "lamps 3"],
        sharpness: Float[Tensor, " lamps"],
        energy: Float[Tensor, "lamps 3"],
        ambient: Float[Tensor, " 3"],
        camera: Float[Tensor, " 2"],
    ) -> None:
        """Sets the output biases so that the untrained network predicts given (mean) lamps."""
        each = torch.cat([direction, sharpness.log()[:, None], energy.clamp(min=1e-4).log()], 1)
        with torch.no_grad():
            self.outputs.bias.copy_(torch.cat([each.flatten(), ambient.clamp(min=1e-4).log(), camera]))

    def forward(
        self, features: Float[Tensor, "batch channels rows columns"], mean: Float[Tensor, "batch 3"]
    ) -> LampLight:
        """Regresses the light in units of `mean`, the photo's mean linear colour, which is an input too."""
        each, ambient, camera = self.raw(features, mean).split([_EACH * self.count, 3, _CAMERA], 1)
        direction, size, colour = each.view(-1, self.count, _EACH).split([3, 1, 3], 2)
        return LampLight(
            direction=functional.normalize(direction, dim=-1),
            sharpness=size[..., 0].clamp(_SHARPEST, _SMOOTHEST).exp(),
            energy=colour.clamp(-LOG_LIMIT, LOG_LIMIT).exp(),
            ambient=ambient.clamp(-LOG_LIMIT, LOG_LIMIT).exp(),
            camera=camera,
        )
