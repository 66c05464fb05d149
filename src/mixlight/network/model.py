"""The network: photo in, light out."""

from __future__ import annotations

from jaxtyping import Float
from torch import Tensor

from mixlight.network.glow import Glow
from mixlight.network.heads import LightHeads, Prediction
from mixlight.network.photo_net import PhotoNet, mean_linear_colour
from mixlight.network.settings import ANCHORED, ModelSettings

__all__ = ["MixLightNet", "ModelSettings", "mean_linear_colour"]


class MixLightNet(PhotoNet[Prediction]):
    """The method's network: sources on anchors and ambient light, with fewer sources if `glow_gain` is
    set.
    """

    heads: LightHeads

    def __init__(self, settings: ModelSettings, pretrained: bool = False) -> None:
        """Builds the network; `pretrained` loads the backbone's ImageNet weights.

        Raises:
            ValueError: unknown backbone or sparse mode, a backbone without ImageNet weights, or sources that
                are not on anchors (`mixlight.network.methods` builds those networks).
        """
        if settings.sources not in ANCHORED:
            raise ValueError(f"expected sources {' or '.join(ANCHORED)}, got {settings.sources!r}")
        backbone = settings.make_backbone(pretrained)
        heads = LightHeads(
            backbone.channels,
            (settings.grid_rows, settings.grid_columns),
            settings.anchors,
            settings.hidden,
            settings.grid_channels,
            settings.dropout,
            settings.sparse_mode,
            settings.sparse_gain,
            ambient=settings.ambient,
            anchor_colours=settings.sources == "colours",
        )
        super().__init__(settings, backbone, heads)
        self.glow = (
            Glow(
                settings.anchors,
                settings.sharpness,
                settings.glow_gain,
                settings.sparse_mode if settings.sparse_mode != "softmax" else "masked",
            )
            if settings.glow_gain
            else None
        )

    def exposed(self, relative: Prediction, mean: Float[Tensor, "batch 3"]) -> Prediction:
        """Light in the photos' own exposure, with fewer sources if `glow_gain` is set."""
        light = super().exposed(relative, mean)
        return light if self.glow is None else self.glow(light)
