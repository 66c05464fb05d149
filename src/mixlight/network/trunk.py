"""What every kind of head shares: pooling, a hidden layer, and one vector of outputs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

LOG_LIMIT = 8.0
"""Largest logarithm of an intensity, relative to the photo: a factor of 2981 either way."""

Light = TypeVar("Light")


class Trunk(nn.Module, ABC, Generic[Light]):
    """Pools a feature map and regresses numbers, which a subclass reads as light.

    A coarse grid of the features is kept beside their mean, because where in the picture it is bright
    says where the light is.
    """

    def __init__(
        self,
        channels: int,
        grid: tuple[int, int],
        outputs: int,
        hidden: int = 256,
        grid_channels: int = 48,
        dropout: float = 0.4,
    ) -> None:
        """Build the layers.

        Args:
            channels: channels of the feature map.
            grid: rows and columns of the feature grid that is kept.
            outputs: how many numbers.
            hidden: width of the hidden layer.
            grid_channels: channels of the grid.
            dropout: before and after the hidden layer.
        """
        super().__init__()
        self.grid = grid
        self.reduce = nn.Sequential(nn.Conv2d(channels, grid_channels, 1), nn.ReLU(inplace=True))
        features = channels + grid_channels * grid[0] * grid[1] + 3
        self.trunk = nn.Sequential(
            nn.Dropout(dropout), nn.Linear(features, hidden), nn.ReLU(inplace=True), nn.Dropout(dropout)
        )
        self.outputs = nn.Linear(hidden, outputs)
        nn.init.normal_(self.outputs.weight, std=0.01)
        nn.init.zeros_(self.outputs.bias)

    def hidden(
        self, features: Float[Tensor, "batch channels rows columns"], mean: Float[Tensor, "batch 3"]
    ) -> Float[Tensor, "batch hidden"]:
        """What the last layer, which is linear, takes."""
        pooled = features.mean((2, 3))
        grid = functional.adaptive_avg_pool2d(self.reduce(features), self.grid).flatten(1)
        values: Tensor = self.trunk(torch.cat([pooled, grid, mean.log()], 1))
        return values

    def raw(
        self, features: Float[Tensor, "batch channels rows columns"], mean: Float[Tensor, "batch 3"]
    ) -> Float[Tensor, "batch outputs"]:
        """The outputs of the last layer, in float32; the last two are pitch and roll in radians."""
        numbers: Tensor = self.outputs(self.hidden(features, mean))
        return numbers.float()

    @abstractmethod
    def forward(
        self, features: Float[Tensor, "batch channels rows columns"], mean: Float[Tensor, "batch 3"]
    ) -> Light:
        """Regresses the light in units of `mean`, the photo's mean linear colour (above 0)."""
