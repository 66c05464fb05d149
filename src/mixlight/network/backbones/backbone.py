"""What every backbone is: a picture in, a feature map out."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod

from jaxtyping import Float
from torch import Tensor, nn


class Backbone(nn.Module, ABC):
    """Turns sRGB pictures into feature maps.

    Pictures are [batch, 3, height, width], sRGB-encoded in [0, 1]; the network's own scaling of its input is
    part of the backbone. Feature maps are [batch, channels, height / 32, width / 32] with row 0 at the
    picture's top; how a size that 32 does not divide is rounded is the network's own affair.
    """

    channels: int
    """Channels of the feature map."""

    @abstractmethod
    def forward(
        self, picture: Float[Tensor, "batch 3 height width"]
    ) -> Float[Tensor, "batch channels rows columns"]:
        """Return the feature map of a batch of pictures."""

    def folded(self) -> Backbone:
        """Return a copy for inference alone, as fast as the architecture allows; this one does not change.

        The copy is in evaluation mode, none of its parameters asks for a gradient, and names and shapes in
        its state dict may differ: save the original. Feature maps agree up to rounding.
        """
        return copy.deepcopy(self).eval().requires_grad_(False)


def check_picture(picture: Tensor) -> None:
    """Raise ValueError unless the tensor is a batch of pictures, [batch, 3, height, width]."""
    if picture.ndim != 4 or picture.shape[1] != 3 or 0 in picture.shape:
        raise ValueError(f"expected pictures [batch, 3, height, width], received {list(picture.shape)}")
