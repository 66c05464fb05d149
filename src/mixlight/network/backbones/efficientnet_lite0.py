"""EfficientNet-Lite0: inverted residual blocks with ReLU6 and no squeeze-and-excitation, 3.4 M parameters.

The published network pads as TensorFlow's "same" does: where stride 2 meets an even size, there is one more
zero on the right and bottom than on the left and top. PyTorch's convolutions pad both sides alike, so ports
usually copy every such input into a larger tensor first. Here the network runs on the picture turned by 180
degrees, with kernels turned likewise: the extra zero then falls on the left and top, and that is exactly what
symmetric padding gives, for even sizes and odd ones. Only the picture and the feature map are copied. Kernels
are therefore stored turned (scripts/convert_imagenet_weights.py turns them); kernels of one pixel do not
notice.
"""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from mixlight.network.backbones.backbone import Backbone, check_picture

# Expansion, kernel, stride, channels, repeats: EfficientNet-B0's, as both multipliers are 1.
_STAGES = (
    (1, 3, 1, 16, 1),
    (6, 3, 2, 24, 2),
    (6, 5, 2, 40, 2),
    (6, 3, 2, 80, 3),
    (6, 5, 1, 112, 3),
    (6, 5, 2, 192, 4),
    (6, 3, 1, 320, 1),
)
_STEM_CHANNELS = 32
_NORM_EPS = 1e-3
_NORM_MOMENTUM = 0.01


class EfficientNetLite0(Backbone):
    """Feature extractor of EfficientNet-Lite0: pictures in, 1280 channels at 1/32 of their size out.

    The input is scaled to (255 x - 127) / 128 inside; the output lies in [0, 6].

    Args:
        drop_path: In training, the probability with which the last residual branch is left out for a sample;
            earlier ones are left out proportionally less often (stochastic depth, Huang et al. 2016).

    Convention: NCHW, row 0 is the top. A picture of 96 x 128 gives a grid of 3 x 4.

    Raises:
        ValueError: `drop_path` outside [0, 1); `forward` raises it for what is not [batch, 3, height, width].

    Source: Tan and Le, "EfficientNet", 2019; the Lite variant is its authors' release of 2020.

    >>> backbone = EfficientNetLite0()
    >>> sum(p.numel() for p in backbone.parameters()), tuple(backbone(torch.zeros(2, 3, 96, 128)).shape)
    (3371008, (2, 1280, 3, 4))
    """

    channels = 1280

    def __init__(self, drop_path: float = 0.0) -> None:
        super().__init__()
        if not 0.0 <= drop_path < 1.0:
            raise ValueError(f"expected drop_path in [0, 1), received {drop_path}")
        self.stem = _ConvNorm(3, _STEM_CHANNELS, kernel=3, stride=2)
        total = sum(repeats for *_, repeats in _STAGES)
        blocks: list[nn.Module] = []
        channels = _STEM_CHANNELS
        for expansion, kernel, stride, wider, repeats in _STAGES:
            for repeat in range(repeats):
                drop = drop_path * len(blocks) / total
                step = stride if repeat == 0 else 1
                blocks.append(
                    _Block(channels, wider, expansion=expansion, kernel=kernel, stride=step, drop=drop)
                )
                channels = wider
        self.blocks = nn.Sequential(*blocks)
        self.head = _ConvNorm(channels, self.channels)
        # On a CPU these layers are several times faster when the channels of a pixel lie side by side.
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def forward(
        self, picture: Float[Tensor, "batch 3 height width"]
    ) -> Float[Tensor, "batch 1280 rows columns"]:
        """Return the feature map of a batch of sRGB pictures in [0, 1]."""
        check_picture(picture)
        turned = picture.flip((-2, -1)).to(memory_format=torch.channels_last)
        features: Tensor = self.head(self.blocks(self.stem(turned * (255 / 128) - 127 / 128)))
        return features.flip((-2, -1))

    def folded(self) -> Backbone:
        """Return a copy for inference alone, in which normalisation has become part of the kernels.

        Batches take about two thirds of the time. The copy is in evaluation mode, none of its parameters asks
        for a gradient, and its state dict has other names: save the original.

        >>> backbone, picture = EfficientNetLite0().eval(), torch.full((1, 3, 64, 64), 0.5)
        >>> torch.allclose(backbone.folded()(picture), backbone(picture), atol=1e-4)
        True
        """
        copied = super().folded()
        for module in copied.modules():
            if isinstance(module, _ConvNorm):
                module.fold()
        return copied


class _ConvNorm(nn.Module):
    """Convolution, batch normalisation and, unless linear, ReLU6."""

    def __init__(
        self,
        channels: int,
        out_channels: int,
        *,
        kernel: int = 1,
        stride: int = 1,
        groups: int = 1,
        linear: bool = False,
    ) -> None:
        super().__init__()
        padding = kernel // 2
        self.conv = nn.Conv2d(channels, out_channels, kernel, stride, padding, groups=groups, bias=False)
        self.norm: nn.Module = nn.BatchNorm2d(out_channels, eps=_NORM_EPS, momentum=_NORM_MOMENTUM)
        self.linear = linear
        fan_out = kernel * kernel * out_channels // groups
        nn.init.normal_(self.conv.weight, std=(2 / fan_out) ** 0.5)

    def forward(self, x: Tensor) -> Tensor:
        y: Tensor = self.norm(self.conv(x))
        return y if self.linear else functional.relu6(y, inplace=True)

    def fold(self) -> None:
        """Make the normalisation by its running statistics part of the convolution."""
        if isinstance(self.norm, nn.BatchNorm2d):
            self.conv = fuse_conv_bn_eval(self.conv, self.norm)
            self.norm = nn.Identity()


class _Block(nn.Module):
    """Inverted residual: widen by 1x1 kernels, filter every channel alone, narrow again."""

    def __init__(
        self, channels: int, out_channels: int, *, expansion: int, kernel: int, stride: int, drop: float
    ) -> None:
        super().__init__()
        wide = channels * expansion
        self.expand = _ConvNorm(channels, wide) if expansion > 1 else nn.Identity()
        self.depthwise = _ConvNorm(wide, wide, kernel=kernel, stride=stride, groups=wide)
        self.project = _ConvNorm(wide, out_channels, linear=True)
        self.residual = stride == 1 and channels == out_channels
        self.drop = drop

    def forward(self, x: Tensor) -> Tensor:
        y: Tensor = self.project(self.depthwise(self.expand(x)))
        if not self.residual:
            return y
        if self.training and self.drop > 0.0:
            keep = 1.0 - self.drop
            y = y * y.new_empty(len(y), 1, 1, 1).bernoulli_(keep).div_(keep)
        return x + y
