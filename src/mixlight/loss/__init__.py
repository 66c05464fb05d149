"""What training minimises: errors of ambient light, of sources, and of spheres lit by both.

`TotalLoss` (in `mixlight.loss.total`) weighs the terms; each is a plain function or module of its own.
"""

from mixlight.loss.ambient import coefficient_loss, reconstruction_loss, rendering_loss
from mixlight.loss.sources import (
    colour_loss,
    concentration_loss,
    distribution_loss,
    intensity_loss,
    masked_l1,
)
from mixlight.loss.spheres import SphereLoss
from mixlight.loss.transport import SphericalSinkhorn

__all__ = [
    "SphereLoss",
    "SphericalSinkhorn",
    "coefficient_loss",
    "colour_loss",
    "concentration_loss",
    "distribution_loss",
    "intensity_loss",
    "masked_l1",
    "reconstruction_loss",
    "rendering_loss",
]
