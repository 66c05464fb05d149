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

    def resample(
        self, photo: Float[Tensor, "photo_height photo_width 3"], fov_x: float
    ) -> tuple[Float[Tensor, "height width 3"], Bool[Tensor, "height width"]]:
        """Resamples a linear photo with horizontal field of view `fov_x` (radians) into this view, antialiased.

        Returns the view, filled outside the photo with the mean of what is inside, and the inside mask.
        """
        view, inside = camera.resample(photo, fov_x, self.height, self.width, self.fov)
        view = view.clamp(min=0)
        if not bool(inside.all()):
            view[~inside] = view[inside].mean(0)
        return view, inside
