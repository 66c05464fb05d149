"""DenseNet-121: every layer of a block reads what all layers before it wrote; 7.0 M parameters.

Names and shapes of parameters are torchvision's (`features.denseblock1.denselayer1.norm1.weight`, ...), so
that the weights published for it load. None ship with this package: no package index carries them.
"""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Mapping

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from mixlight.network.backbones.backbone import Backbone, check_picture

_GROWTH = 32
_BOTTLENECK = 4 * _GROWTH
_LAYERS = (6, 12, 24, 16)
_STEM_CHANNELS = 64
_MEAN = (0.485, 0.456, 0.406)
_DEVIATION = (0.229, 0.224, 0.225)


class DenseNet121(Backbone):
    """Feature extractor of DenseNet-121: pictures in, 1024 channels at 1/32 of their size out.

    The input is normalised by ImageNet's mean and deviation inside; the output is not negative.

    Args:
        drop_rate: In training, the probability with which a number that a layer writes is set to 0.

    Convention: NCHW, row 0 is the top. A picture of 192 x 256 gives a grid of 6 x 8.

    Raises:
        ValueError: `drop_rate` outside [0, 1); `forward` raises it for what is not [batch, 3, height, width].

    Source: Huang et al., "Densely Connected Convolutional Networks", 2017.

    >>> backbone = DenseNet121().eval()
    >>> sum(p.numel() for p in backbone.parameters()), tuple(backbone(torch.zeros(1, 3, 96, 128)).shape)
    (6953856, (1, 1024, 3, 4))
    """

    channels = 1024
    mean: Tensor
    deviation: Tensor

    def __init__(self, drop_rate: float = 0.0) -> None:
        super().__init__()
        if not 0.0 <= drop_rate < 1.0:
            raise ValueError(f"expected drop_rate in [0, 1), received {drop_rate}")
        parts: OrderedDict[str, nn.Module] = OrderedDict(
            conv0=_conv(3, _STEM_CHANNELS, kernel=7, stride=2),
            norm0=nn.BatchNorm2d(_STEM_CHANNELS),
            relu0=nn.ReLU(inplace=True),
            pool0=nn.MaxPool2d(kernel_size=3, stride=2, padding=1),
        )
        channels = _STEM_CHANNELS
        for number, layers in enumerate(_LAYERS, start=1):
            parts[f"denseblock{number}"] = _DenseBlock(channels, layers, drop_rate)
            channels += layers * _GROWTH
            if number < len(_LAYERS):
                parts[f"transition{number}"] = _transition(channels)
                channels //= 2
        parts["norm5"] = nn.BatchNorm2d(channels)
        self.features = nn.Sequential(parts)
        self.register_buffer("mean", torch.tensor(_MEAN).view(3, 1, 1), persistent=False)
        self.register_buffer("deviation", torch.tensor(_DEVIATION).view(3, 1, 1), persistent=False)
        # On a CPU these layers are faster when the channels of a pixel lie side by side.
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def forward(
        self, picture: Float[Tensor, "batch 3 height width"]
    ) -> Float[Tensor, "batch 1024 rows columns"]:
        """Return the feature map of a batch of sRGB pictures in [0, 1]."""
        check_picture(picture)
        normal = (picture.to(memory_format=torch.channels_last) - self.mean) / self.deviation
        return functional.relu(self.features(normal), inplace=True)


def from_torchvision(state: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """A published state dict of torchvision's `densenet121` as `DenseNet121` takes it.

    The classifier is left out, the names of the first release (`norm.1`, `conv.2`) become today's (`norm1`,
    `conv2`), and the counters that it lacked start at 0. Load the checkpoint with `weights_only=True`.
    """
    kept = {
        re.sub(r"(denselayer\d+\.(?:norm|relu|conv))\.(?=[12]\.)", r"\1", name): tensor
        for name, tensor in state.items()
        if not name.startswith("classifier.")
    }
    for name in list(kept):
        if name.endswith("running_mean"):
            kept.setdefault(name.replace("running_mean", "num_batches_tracked"), torch.tensor(0))
    return kept


class _DenseLayer(nn.Module):
    """Normalise, narrow by 1x1 kernels, normalise, and write `_GROWTH` new channels by 3x3 kernels."""

    def __init__(self, channels: int, drop_rate: float) -> None:
        super().__init__()
        self.norm1 = nn.BatchNorm2d(channels)
        self.conv1 = _conv(channels, _BOTTLENECK)
        self.norm2 = nn.BatchNorm2d(_BOTTLENECK)
        self.conv2 = _conv(_BOTTLENECK, _GROWTH, kernel=3)
        self.drop_rate = drop_rate

    def forward(self, x: Tensor) -> Tensor:
        narrow = self.conv1(functional.relu(self.norm1(x), inplace=True))
        new: Tensor = self.conv2(functional.relu(self.norm2(narrow), inplace=True))
        return functional.dropout(new, self.drop_rate, self.training) if self.drop_rate > 0.0 else new


class _DenseBlock(nn.Module):
    def __init__(self, channels: int, layers: int, drop_rate: float) -> None:
        super().__init__()
        for index in range(layers):
            self.add_module(f"denselayer{index + 1}", _DenseLayer(channels + index * _GROWTH, drop_rate))

    def forward(self, x: Tensor) -> Tensor:
        for layer in self.children():
            x = torch.cat((x, layer(x)), 1)
        return x


def _transition(channels: int) -> nn.Sequential:
    return nn.Sequential(
        OrderedDict(
            norm=nn.BatchNorm2d(channels),
            relu=nn.ReLU(inplace=True),
            conv=_conv(channels, channels // 2),
            pool=nn.AvgPool2d(kernel_size=2, stride=2),
        )
    )


def _conv(channels: int, out_channels: int, *, kernel: int = 1, stride: int = 1) -> nn.Conv2d:
    conv = nn.Conv2d(channels, out_channels, kernel, stride, kernel // 2, bias=False)
    nn.init.kaiming_normal_(conv.weight)
    return conv
