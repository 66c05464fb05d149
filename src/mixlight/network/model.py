"""The network: photo in, light out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mixlight.network import backbones, srgb
from mixlight.network.canonical import CanonicalView
from mixlight.network.glow import Glow
from mixlight.network.heads import LightHeads, Prediction
from mixlight.network.sparsemax import MODES, Mode

_DARKEST = 1e-3
"""Least mean of a channel that serves as a unit."""

_WEAKEST = 0.05
"""Least share of the brightest channel's mean."""

_LATER = ("glow_gain",)
"""Settings that cards of version 0.1 do not have."""


@dataclass(frozen=True)
class ModelSettings:
    """Everything that is needed to build the network again."""

    backbone: str = "efficientnet_lite0"
    """Name in the registry of `mixlight.network.backbones`."""
    height: int = 96
    """Rows of the canonical view."""
    width: int = 128
    """Columns of the canonical view."""
    fov_deg: float = 60.0
    """Horizontal field of view of the canonical view."""
    anchors: int = 128
    """Number of source directions."""
    sharpness: float = 0.0025
    """Angular size s of the lobes."""
    hidden: int = 256
    """Width of the regression trunk."""
    grid_channels: int = 48
    """Channels of the feature grid that is kept beside the pooled features."""
    grid_rows: int = 3
    """Rows of that grid."""
    grid_columns: int = 4
    """Columns of that grid."""
    dropout: float = 0.4
    """Dropout before and after the hidden layer."""
    drop_path: float = 0.0
    """Largest share of residual branches that are left out in training (EfficientNet-Lite0 only)."""
    sparse_mode: Mode = "masked"
    """Sparse layer: `masked`, `literal`, `sparsemax` or `none`."""
    sparse_gain: float = 1.0
    """Factor on the scores before the sparse layer. Scores learn the expected P, which is spread wherever the
    network is not sure; at 1 the layer leaves such a distribution as it is, above 1 it keeps the
    likeliest."""
    glow_gain: float = 0.0
    """Factor on the scores that decides which anchors stay sources in the result: those that the sparse layer
    keeps at this gain. The light of the others joins the ambient light (`mixlight.network.glow`). 0 leaves
    the light as it is predicted. Training does not see it."""

    def __post_init__(self) -> None:
        if self.backbone not in backbones.names():
            raise ValueError(
                f"expected a backbone out of {', '.join(backbones.names())}, got {self.backbone!r}"
            )
        if self.sparse_mode not in MODES:
            raise ValueError(f"expected a sparse_mode out of {', '.join(MODES)}, got {self.sparse_mode!r}")
        for name in ("height", "width", "anchors", "hidden", "grid_channels", "grid_rows", "grid_columns"):
            if getattr(self, name) < 1:
                raise ValueError(f"expected {name} of at least 1, got {getattr(self, name)}")
        if not self.sparse_gain > 0:
            raise ValueError(f"expected a sparse_gain above 0, got {self.sparse_gain}")
        if not self.glow_gain >= 0:
            raise ValueError(f"expected a glow_gain of at least 0, got {self.glow_gain}")
        if not 0 < self.fov_deg < 180:
            raise ValueError(f"expected fov_deg in (0, 180), got {self.fov_deg}")
        if not self.sharpness > 0:
            raise ValueError(f"expected a sharpness above 0, got {self.sharpness}")
        if not 0 <= self.dropout < 1:
            raise ValueError(f"expected dropout in [0, 1), got {self.dropout}")

    @property
    def canonical(self) -> CanonicalView:
        """The view of the world that the network takes."""
        return CanonicalView(self.height, self.width, math.radians(self.fov_deg))

    def to_card(self) -> dict[str, object]:
        """As plain values, for the card of the weights."""
        return asdict(self)

    @classmethod
    def from_card(cls, values: Mapping[str, Any]) -> ModelSettings:
        """The settings that `to_card` wrote; what older cards did not know has its default.

        Raises:
            ValueError: an unknown or missing name, or a value of another type or outside its range.

        >>> ModelSettings.from_card(ModelSettings(height=192).to_card()).height
        192
        """
        known = {f.name: type(f.default) for f in fields(cls)}
        values = {name: getattr(cls, name) for name in _LATER} | dict(values)
        wrong = sorted(known.keys() ^ values.keys())
        if wrong:
            raise ValueError(
                f"expected the settings {', '.join(known)}, missing or unknown: {', '.join(wrong)}"
            )
        for name, kind in known.items():
            given = values[name]
            fits = isinstance(given, kind) or (kind is float and isinstance(given, int))
            if not fits or isinstance(given, bool):
                raise ValueError(f"expected {kind.__name__} for {name}, got {given!r}")
        return cls(**values)


class MixLightNet(nn.Module):
    """Backbone and heads. Light is predicted relative to the photo's mean linear colour.

    The photo tells light only up to its exposure and white balance, so the network regresses what is left
    when both are divided out, and the result is multiplied back. Exactly: `forward` is `relative` times the
    photo's mean colour, with fewer sources if `glow_gain` is set. (Not exactly: the network looks at the
    photo as it is, so that a photo twice as bright gives about, not precisely, twice the light.)
    """

    backbone: backbones.Backbone
    heads: LightHeads

    def __init__(self, settings: ModelSettings, pretrained: bool = False) -> None:
        """Builds the network; `pretrained` loads the backbone's ImageNet weights.

        Raises:
            ValueError: unknown backbone or sparse mode, or a backbone without ImageNet weights.
        """
        super().__init__()
        self.settings = settings
        options = {"drop_path": settings.drop_path} if settings.drop_path else {}
        self.backbone = backbones.create(settings.backbone, pretrained=pretrained, **options)
        self.heads = LightHeads(
            self.backbone.channels,
            (settings.grid_rows, settings.grid_columns),
            settings.anchors,
            settings.hidden,
            settings.grid_channels,
            settings.dropout,
            settings.sparse_mode,
            settings.sparse_gain,
        )
        self.glow = (
            Glow(settings.anchors, settings.sharpness, settings.glow_gain, settings.sparse_mode)
            if settings.glow_gain
            else None
        )

    def relative(self, photo: Float[Tensor, "batch 3 height width"]) -> tuple[Prediction, Tensor]:
        """Predicts light in units of the photo's mean colour, and returns that colour [batch, 3] beside it.

        `photo` is the sRGB-encoded canonical view in [0, 1].
        """
        mean = mean_linear_colour(photo)
        return self.heads(self.backbone(photo), mean), mean

    def forward(self, photo: Float[Tensor, "batch 3 height width"]) -> Prediction:
        """Predicts light in the photo's own exposure: radiance 1 is the photo's linear white.

        `photo` is the sRGB-encoded canonical view in [0, 1].
        """
        prediction, mean = self.relative(photo)
        light = prediction.scaled(mean)
        return light if self.glow is None else self.glow(light)


def mean_linear_colour(photo: Float[Tensor, "batch 3 height width"]) -> Float[Tensor, "batch 3"]:
    """Mean of the sRGB-decoded photo per channel.

    Channels are kept above 1/1000 and above 5 % of the brightest, so that it can serve as a unit.

    >>> mean_linear_colour(torch.full((1, 3, 2, 2), 0.5))
    tensor([[0.2140, 0.2140, 0.2140]])
    """
    mean = srgb.decode(photo).float().mean((2, 3))
    floor = (_WEAKEST * mean.amax(1, keepdim=True)).clamp(min=_DARKEST)
    return torch.maximum(mean, floor)
