"""A network that exports in seconds: one layer of a backbone behind the real heads and sparse layer."""

from typing import Any

import torch
from torch import Tensor, nn

from mixlight.network.backbones import Backbone
from mixlight.network.estimator import Estimator
from mixlight.network.heads import LightHeads
from mixlight.network.model import MixLightNet, ModelSettings


class SmallBackbone(Backbone):
    channels = 6

    def __init__(self) -> None:
        super().__init__()
        self.conv = nn.Conv2d(3, self.channels, 8, stride=8)

    def forward(self, picture: Tensor) -> Tensor:
        features: Tensor = self.conv(picture).relu()
        return features


def small_estimator(mode: Any = "masked", gain: float = 1.0, glow: float = 0.0, **card: Any) -> Estimator:
    """An untrained estimator of 24 x 32 pixels whose scores spread over the anchors."""
    settings = ModelSettings(
        height=24, width=32, sparse_mode=mode, sparse_gain=gain, glow_gain=glow, hidden=16
    )
    torch.manual_seed(3)
    model = MixLightNet(settings)
    model.backbone = SmallBackbone()
    model.heads = LightHeads(6, (3, 4), sparse_mode=mode, sparse_gain=gain, hidden=16)
    nn.init.normal_(model.heads.outputs.weight, std=2.0)
    return Estimator(model, {"name": "small"} | card)
