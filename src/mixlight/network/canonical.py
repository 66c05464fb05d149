"""The one view of the world that the network knows: a pinhole camera of fixed size and field of view."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.sphere import camera


@dataclass(frozen=True)
class CanonicalView:
    """Size and field of view of the network's input.

    A photo is resampled into this view around its own optical axis. A wider photo is cut to it. Where a
    narrower, flatter or portrait photo does not reach, the view is filled with the photo's mean linear
    colour, as it was in training; nothing is stretched.
    """

    height: int = 96
    """Rows."""
    width: int = 128
    """Columns."""
    fov: float = math.radians(60)
    """Horizontal field of view in radians."""

    def __post_init__(self) -> None:
        if self.height < 1 or self.width < 1:
            raise ValueError(f"expected a view of at least 1 x 1, got {self.height} x {self.width}")
        if not 0 < self.fov < math.pi:
            raise ValueError(f"expected a field of view in (0, pi) radians, got {self.fov}")

    def resample(
        self, photo: Float[Tensor, "photo_height photo_width 3"], fov_x: float
    ) -> tuple[Float[Tensor, "height width 3"], Bool[Tensor, "height width"]]:
        """Resamples a linear photo into this view, antialiased.

        Args:
            photo: linear light, any size; 1.0 is white.
            fov_x: its horizontal field of view in radians.

        Returns:
            The view, filled outside the photo with the mean of what is inside, and the mask of the pixels
            whose centre lies inside.

        Convention: twice the angle is more than twice the picture: a photo with tan(fov_x / 2) twice the
            view's loses the outer half of its columns.

        Raises:
            ValueError: a field of view outside (0, pi), or a photo so small in angle that it misses the
                centre of every pixel.

        >>> import torch
        >>> view, inside = CanonicalView(3, 4).resample(torch.ones(8, 4, 3), math.radians(60))
        >>> view.shape, bool(inside.all())
        (torch.Size([3, 4, 3]), True)
        """
        view, inside = camera.resample(photo, fov_x, self.height, self.width, self.fov)
        view = view.clamp(min=0)  # sums of positive taps may round below
        if not bool(inside.any()):
            raise ValueError(
                f"expected a photo that covers a pixel of the view of {self.height} x {self.width}, got "
                f"{math.degrees(fov_x):g} degrees over {photo.shape[1]} x {photo.shape[0]} pixels"
            )
        if not bool(inside.all()):
            view[~inside] = view[inside].mean(0)
        return view, inside
