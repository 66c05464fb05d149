"""Everything that is needed to build a network again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, get_args

from mixlight.network import backbones
from mixlight.network.canonical import CanonicalView
from mixlight.network.heads import SCORE_MODES, ScoreMode

Ambient = Literal["sh2", "constant", "sg9"]
Sources = Literal["anchors", "colours", "sh6", "lamps"]

ANCHORED = ("anchors", "colours")
"""Kinds of sources that are Gaussians on fixed anchors."""

_LATER = ("glow_gain", "ambient", "sources")
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
    ambient: Ambient = "sh2"
    """Functions of the ambient light: `sh2` (the method), `constant` or `sg9`
    (`mixlight.light.functions`)."""
    sources: Sources = "anchors"
    """Light sources: `anchors` in one colour (the method), `colours` (each anchor its own), `sh6` (harmonics
    of degree 6), or `lamps` (3 of free direction and size, in constant ambient light)."""
    sparse_mode: ScoreMode = "masked"
    """Sparse layer: `masked`, `literal`, `sparsemax` or `none`; or `softmax` in its place."""
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
        for name, known in (
            ("sparse_mode", SCORE_MODES),
            ("ambient", get_args(Ambient)),
            ("sources", get_args(Sources)),
        ):
            if getattr(self, name) not in known:
                raise ValueError(
                    f"expected a value of {name} out of {', '.join(known)}, got {getattr(self, name)!r}"
                )
        if self.sources == "lamps" and self.ambient != "constant":
            raise ValueError(f"expected constant ambient light around lamps, got {self.ambient!r}")
        if self.glow_gain > 0 and (self.ambient != "sh2" or self.sources not in ANCHORED):
            raise ValueError(
                "expected ambient sh2 and sources on anchors for a glow_gain above 0, "
                f"got {self.ambient} and {self.sources}"
            )
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

    def make_backbone(self, pretrained: bool = False) -> backbones.Backbone:
        """The backbone, with its ImageNet weights if `pretrained`.

        Raises:
            ValueError: a backbone without ImageNet weights.
        """
        options = {"drop_path": self.drop_path} if self.drop_path else {}
        return backbones.create(self.backbone, pretrained=pretrained, **options)

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
