"""From image features to light: source scores, intensity, colour, ambient SH and the camera's pose."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from mixlight.network.sparsemax import Mode, SLSparsemax

_LOG_LIMIT = 8.0
"""Largest logarithm of an intensity, relative to the photo: a factor of 2981 either way."""

_COLOUR_LIMIT = 3.0
"""Largest logarithm of a colour channel before the colour is normalised: a factor of 20 either way."""


@dataclass(frozen=True)
class Prediction:
    """Light around a batch of photos.

    Convention: our frame, the photo's azimuth ahead (-Z), the horizon level. As the heads give it, light is
        in units of the photo's mean linear colour; `MixLightNet.forward` returns it in the photo's own
        exposure (1.0 is white).
    """

    scores: Float[Tensor, "batch anchors"]
    """Source scores before the sparse layer, at probability scale."""
    distribution: Float[Tensor, "batch anchors"]
    """P: share of each anchor in the light of the sources (sums to 1 in mode `masked`)."""
    intensity: Float[Tensor, " batch"]
    """E: Euclidean norm of the sources' integrated colour."""
    colour: Float[Tensor, "batch 3"]
    """R: unit colour vector of the sources."""
    ambient: Float[Tensor, "batch 9 3"]
    """Radiance SH of the ambient light."""
    camera: Float[Tensor, "batch 2"]
    """Pitch (up) and roll (clockwise) in radians."""

    @property
    def anchor_energy(self) -> Float[Tensor, "batch anchors 3"]:
        """V = P E R, the integrated radiance (radiance times steradian) of each lobe."""
        return self.distribution[..., None] * (self.intensity[:, None] * self.colour)[:, None, :]

    def to(self, device: torch.device | str) -> Prediction:
        """The same light on another device."""
        return Prediction(**{field.name: getattr(self, field.name).to(device) for field in fields(self)})

    def scaled(self, gain: Float[Tensor, "batch 3"]) -> Prediction:
        """The same light with every channel multiplied by a gain above 0 (light is linear).

        `anchor_energy` and `ambient` are multiplied by it; scores, distribution and camera stay.

        >>> half = torch.full((1, 2), 0.5)
        >>> one, gray = torch.ones(1), torch.full((1, 3), 3**-0.5)
        >>> light = Prediction(half, half, one, gray, torch.zeros(1, 9, 3), torch.zeros(1, 2))
        >>> light.scaled(torch.tensor([[2.0, 1.0, 0.0]])).anchor_energy[0, 0]
        tensor([0.5774, 0.2887, 0.0000])
        """
        total = self.intensity[:, None] * self.colour * gain
        intensity = total.norm(dim=-1)
        colour = total / intensity.clamp(min=1e-12)[:, None]
        ambient = self.ambient * gain[:, None, :]
        return Prediction(self.scores, self.distribution, intensity, colour, ambient, self.camera)


class LightHeads(nn.Module):
    """Pools a feature map and regresses the 159 numbers of the light, and two of the camera.

    A coarse grid of the features is kept beside their mean, because where in the picture it is bright
    says where the light is. All intensities are exponentials, the directional ambient terms are multiples
    of the mean ambient light; so no output can turn the scale of the light negative.
    """

    def __init__(
        self,
        channels: int,
        grid: tuple[int, int],
        anchors: int = 128,
        hidden: int = 256,
        grid_channels: int = 48,
        dropout: float = 0.4,
        sparse_mode: Mode = "masked",
        sparse_gain: float = 1.0,
        score_scale: float = 0.05,
    ) -> None:
        """Build the layers.

        Args:
            channels: channels of the feature map.
            grid: rows and columns of the feature grid that is kept.
            anchors: number of source directions.
            hidden: width of the regression trunk.
            grid_channels: channels of the grid.
            dropout: before and after the trunk's hidden layer.
            sparse_mode: of the layer that turns scores into a distribution.
            sparse_gain: what the scores are multiplied by before that layer; above 1 it keeps fewer anchors.
            score_scale: what the scores are multiplied by, so that a weight decides at probability scale.

        Raises:
            ValueError: unknown sparse mode, or too few anchors to have neighbours.
        """
        super().__init__()
        self.anchors = anchors
        self.grid = grid
        self.score_scale = score_scale
        self.sparse_gain = sparse_gain
        self.reduce = nn.Sequential(nn.Conv2d(channels, grid_channels, 1), nn.ReLU(inplace=True))
        features = channels + grid_channels * grid[0] * grid[1] + 3
        self.trunk = nn.Sequential(
            nn.Dropout(dropout), nn.Linear(features, hidden), nn.ReLU(inplace=True), nn.Dropout(dropout)
        )
        self.outputs = nn.Linear(hidden, anchors + 1 + 3 + 27 + 2)
        self.sparse = SLSparsemax(count=anchors, mode=sparse_mode)
        nn.init.normal_(self.outputs.weight, std=0.01)
        nn.init.zeros_(self.outputs.bias)

    def start_from(
        self,
        distribution: Float[Tensor, " anchors"],
        log_intensity: float,
        log_colour: Float[Tensor, " 3"],
        ambient: Float[Tensor, "9 3"],
        camera: Float[Tensor, " 2"],
    ) -> None:
        """Sets the output biases so that the untrained network predicts a given (mean) light.

        Args:
            distribution: scores before the sparse layer.
            log_intensity: natural logarithm of E.
            log_colour: natural logarithm of R, up to a common summand.
            ambient: radiance SH, the first row above 0.
            camera: pitch and roll in radians.
        """
        with torch.no_grad():
            bias = torch.cat(
                [
                    distribution / self.score_scale,
                    torch.tensor([log_intensity]),
                    log_colour,
                    ambient[0].clamp(min=1e-4).log(),
                    (ambient[1:] / ambient[0].clamp(min=1e-4)).flatten(),
                    camera,
                ]
            )
            self.outputs.bias.copy_(bias)

    def forward(
        self, features: Float[Tensor, "batch channels rows columns"], mean: Float[Tensor, "batch 3"]
    ) -> Prediction:
        """Regresses the light in units of `mean`, the photo's mean linear colour (above 0), which is an input
        too.
        """
        pooled = features.mean((2, 3))
        grid = functional.adaptive_avg_pool2d(self.reduce(features), self.grid).flatten(1)
        hidden = self.trunk(torch.cat([pooled, grid, mean.log()], 1))
        raw = self.outputs(hidden).float()
        scores, intensity, colour, base, shape, camera = raw.split([self.anchors, 1, 3, 3, 24, 2], 1)
        scores = scores * self.score_scale
        base = base.clamp(-_LOG_LIMIT, _LOG_LIMIT).exp()
        ambient = torch.cat([base[:, None], base[:, None] * shape.view(-1, 8, 3)], 1)
        # Without a sparse layer scores may be negative; light may not.
        if self.sparse.mode == "none":
            distribution = scores.clamp(min=0)
        else:
            distribution = self.sparse(self.sparse_gain * scores)
        return Prediction(
            scores=scores,
            distribution=distribution,
            intensity=intensity[:, 0].clamp(-_LOG_LIMIT, _LOG_LIMIT).exp(),
            colour=functional.normalize(colour.clamp(-_COLOUR_LIMIT, _COLOUR_LIMIT).exp(), dim=-1),
            ambient=ambient,
            camera=camera,
        )
