"""From image features to light on anchors: scores, intensity, colour, ambient light and the camera's pose."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from mixlight.light.functions import Functions
from mixlight.network.expansion import expansion_bias, expansion_size, read_expansion
from mixlight.network.sparsemax import SLSparsemax
from mixlight.network.trunk import LOG_LIMIT, Trunk

ScoreMode = Literal["masked", "literal", "sparsemax", "none", "softmax"]

SCORE_MODES: tuple[str, ...] = get_args(ScoreMode)
"""How scores become a distribution: the sparse layer's modes, and softmax, which is not sparse."""

CAMERA = 2
"""Outputs for the camera's pose."""

COLOUR_LIMIT = 3.0
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
    colour: Float[Tensor, "batch *lobes 3"]
    """R: unit colour vector of the sources, one for all, or one for each anchor."""
    ambient: Float[Tensor, "batch coefficients 3"]
    """Radiance SH of the ambient light (or the coefficients of another of `mixlight.light.functions`)."""
    camera: Float[Tensor, "batch 2"]
    """Pitch (up) and roll (clockwise) in radians."""

    @property
    def anchor_energy(self) -> Float[Tensor, "batch anchors 3"]:
        """V = P E R, the integrated radiance (radiance times steradian) of each lobe."""
        if self.colour.ndim == 3:
            return (self.distribution * self.intensity[:, None])[..., None] * self.colour
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
        ambient = self.ambient * gain[:, None, :]
        if self.colour.ndim == 3:
            colour = self.colour * gain[:, None, :]
            length = colour.norm(dim=-1).clamp(min=1e-12)
            weight = self.distribution * length
            share = weight.sum(-1).clamp(min=1e-12)
            intensity = self.intensity * share
            colour, distribution = colour / length[..., None], weight / share[:, None]
            return Prediction(self.scores, distribution, intensity, colour, ambient, self.camera)
        total = self.intensity[:, None] * self.colour * gain
        intensity = total.norm(dim=-1)
        colour = total / intensity.clamp(min=1e-12)[:, None]
        return Prediction(self.scores, self.distribution, intensity, colour, ambient, self.camera)


class LightHeads(Trunk[Prediction]):
    """Regresses light sources on anchors (P, E, R), ambient light, and the camera's pose.

    All intensities are exponentials, the directional ambient terms are multiples
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
        sparse_mode: ScoreMode = "masked",
        sparse_gain: float = 1.0,
        score_scale: float = 0.05,
        ambient: Functions = "sh2",
        anchor_colours: bool = False,
    ) -> None:
        """Build the layers.

        Args:
            channels: channels of the feature map.
            grid: rows and columns of the feature grid that is kept.
            anchors: number of source directions.
            hidden: width of the regression trunk.
            grid_channels: channels of the grid.
            dropout: before and after the trunk's hidden layer.
            sparse_mode: of the layer that turns scores into a distribution, or `softmax`.
            sparse_gain: what the scores are multiplied by before that layer; above 1 it keeps fewer anchors.
            score_scale: what the scores are multiplied by, so that a weight decides at probability scale.
            ambient: the functions of the ambient light.
            anchor_colours: each anchor has a colour of its own, instead of one for all.

        Raises:
            ValueError: unknown sparse mode, or too few anchors to have neighbours.
        """
        if sparse_mode not in SCORE_MODES:
            raise ValueError(f"expected a mode out of {', '.join(SCORE_MODES)}, received {sparse_mode!r}")
        self.sizes = (
            anchors,
            1,
            3 * anchors if anchor_colours else 3,
            expansion_size(ambient),
            CAMERA,
        )
        super().__init__(channels, grid, sum(self.sizes), hidden, grid_channels, dropout)
        self.anchors = anchors
        self.score_scale = score_scale
        self.sparse_gain = sparse_gain
        self.softmax = sparse_mode == "softmax"
        self.ambient = ambient
        self.anchor_colours = anchor_colours
        self.sparse = SLSparsemax(count=anchors, mode=sparse_mode if sparse_mode != "softmax" else "none")

    def start_from(
        self,
        distribution: Float[Tensor, " anchors"],
        log_intensity: float,
        log_colour: Float[Tensor, " 3"],
        ambient: Float[Tensor, "coefficients 3"],
        camera: Float[Tensor, " 2"],
    ) -> None:
        """Sets the output biases so that the untrained network predicts a given (mean) light.

        Args:
            distribution: scores before the sparse layer.
            log_intensity: natural logarithm of E.
            log_colour: natural logarithm of R, up to a common summand.
            ambient: radiance SH, the first row above 0 (or the coefficients of the other functions).
            camera: pitch and roll in radians.
        """
        if self.softmax:
            scores = distribution.clamp(min=1e-4).log()
        else:
            scores = distribution / self.score_scale
        with torch.no_grad():
            bias = torch.cat(
                [
                    scores,
                    torch.tensor([log_intensity]),
                    log_colour.repeat(self.anchors) if self.anchor_colours else log_colour,
                    expansion_bias(ambient, self.ambient),
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
        raw = self.raw(features, mean)
        scores, intensity, colour, ambient, camera = raw.split(self.sizes, 1)
        if self.softmax:
            scores = distribution = scores.softmax(-1)
        else:
            scores = scores * self.score_scale
            # Without a sparse layer scores may be negative; light may not.
            if self.sparse.mode == "none":
                distribution = scores.clamp(min=0)
            else:
                distribution = self.sparse(self.sparse_gain * scores)
        if self.anchor_colours:
            colour = colour.view(-1, self.anchors, 3)
        return Prediction(
            scores=scores,
            distribution=distribution,
            intensity=intensity[:, 0].clamp(-LOG_LIMIT, LOG_LIMIT).exp(),
            colour=functional.normalize(colour.clamp(-COLOUR_LIMIT, COLOUR_LIMIT).exp(), dim=-1),
            ambient=read_expansion(ambient, self.ambient),
            camera=camera,
        )
