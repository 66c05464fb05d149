"""EfficientNet-Lite0: inverted residual blocks with ReLU6 and no squeeze-and-excitation, 3.4 M parameters.

The published network pads as TensorFlow's "same" does: where stride 2 meets an even size, one more zero on the right
and bottom than on the left and top. PyTorch's convolutions pad both sides alike, so the usual port copies every such
input into a larger tensor first. Here the network runs on the picture turned by 180 degrees instead, with kernels
turned likewise: the extra zero then falls on the left and top, which is exactly what symmetric padding gives for
every size, even or odd, and only the small input and output are copied. Kernels are therefore stored turned
(scripts/convert_imagenet_weights.py does it); 1x1 kernels do not notice.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from jaxtyping import Float
from torch import Tensor, nn

# (expansion, kernel, stride, channels, repeats); width and depth multipliers are 1, so the table is EfficientNet-B0's.
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


class EfficientNetLite0(nn.Module):
    """Feature extractor of EfficientNet-Lite0: an sRGB picture in, 1280 channels at 1/32 of its size out.

    Shapes: ``[batch, 3, height, width]`` -> ``[batch, 1280, ceil(height / 32), ceil(width / 32)]``.
    Range: input is sRGB-encoded in [0, 1]; its scaling to (255 x - 127) / 128 happens inside. Output is in [0, 6].

    Convention: NCHW, row 0 is the picture's top, as in the output's grid; a 96x128 picture gives a 3x4 grid.

    Args:
        drop_path: in training, the probability with which the last residual branch is left out for a sample;
            earlier branches are left out proportionally less often (stochastic depth, Huang et al. 2016).

    Raises:
        ValueError: the input is not ``[batch, 3, height, width]``, or ``drop_path`` is outside [0, 1).

    Source: Tan and Le, "EfficientNet", 2019; the Lite variant published by the same authors in 2020.

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
        blocks: list[_Block] = []
        channels = _STEM_CHANNELS
        total = sum(repeats for *_, repeats in _STAGES)
        for expansion, kernel, stride, out_channels, repeats in _STAGES:
            for repeat in range(repeats):
                blocks.append(
                    _Block(
                        channels,
                        out_channels,
                        expansion=expansion,
                        kernel=kernel,
                        stride=stride if repeat == 0 else 1,
                        drop=drop_path * len(blocks) / total,
                    )
                )
                channels = out_channels
        self.blocks = nn.Sequential(*blocks)
        self.head = _ConvNorm(channels, self.channels, kernel=1)
        self.to(memory_format=torch.channels_last)  # several times faster on a CPU than NCHW memory

    def forward(
        self, picture: Float[Tensor, "batch 3 height width"]
    ) -> Float[Tensor, "batch 1280 out_height out_width"]:
        if picture.ndim != 4 or picture.shape[1] != 3:
            raise ValueError(f"expected a picture [batch, 3, height, width], received {list(picture.shape)}")
        turned = picture.flip((-2, -1)).to(memory_format=torch.channels_last)
        features = self.head(self.blocks(self.stem(turned * (255 / 128) - 127 / 128)))
        return features.flip((-2, -1))


class _ConvNorm(nn.Module):
    """Convolution, batch normalisation and, unless linear, ReLU6."""

    def __init__(
        self, in_channels: int, out_channels: int, *, kernel: int, stride: int = 1, groups: int = 1, linear: bool = False
    ) -> None:
        super().__init__()
        self.conv = nn.Conv2d(
            in_channels, out_channels, kernel, stride, padding=kernel // 2, groups=groups, bias=False
        )
        self.norm = nn.BatchNorm2d(out_channels, eps=_NORM_EPS, momentum=_NORM_MOMENTUM)
        self.linear = linear
        nn.init.normal_(self.conv.weight, std=(2.0 * groups / (kernel * kernel * out_channels)) ** 0.5)

    def forward(self, x: Tensor) -> Tensor:
        y: Tensor = self.norm(self.conv(x))
        return y if self.linear else F.relu6(y, inplace=True)


class _Block(nn.Module):
    """Inverted residual: widen by a 1x1 convolution, filter each channel alone, narrow again without activation."""

    def __init__(
        self, in_channels: int, out_channels: int, *, expansion: int, kernel: int, stride: int, drop: float
    ) -> None:
        super().__init__()
        wide = in_channels * expansion
        self.expand = _ConvNorm(in_channels, wide, kernel=1) if expansion > 1 else nn.Identity()
        self.depthwise = _ConvNorm(wide, wide, kernel=kernel, stride=stride, groups=wide)
        self.project = _ConvNorm(wide, out_channels, kernel=1, linear=True)
        self.residual = stride == 1 and in_channels == out_channels
        self.drop = drop

    def forward(self, x: Tensor) -> Tensor:
        y: Tensor = self.project(self.depthwise(self.expand(x)))
        if not self.residual:
            return y
        if self.training and self.drop > 0.0:
            keep = 1.0 - self.drop
            y = y * torch.empty(len(y), 1, 1, 1, dtype=y.dtype, device=y.device).bernoulli_(keep).div_(keep)
        return x + y
