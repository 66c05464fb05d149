"""From one photo file to an estimate: the one function behind `mixlight estimate` and `mixlight.estimate`."""

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.image.ldr import Photo, read_photo
from mixlight.network.estimator import Estimate, Estimator

__all__ = ["ASSUMED_FOV", "FieldOfView", "check_fov", "estimate", "field_of_view", "linear_tensor"]

ASSUMED_FOV = math.radians(60.0)
"""Horizontal field of view of a photo that does not say its own, landscape or portrait.

A phone's main camera sees 69° along the long side and 54° along the short one, so 60° is near both.
"""

SMALLEST_FOV, LARGEST_FOV = math.radians(1.0), math.radians(170.0)


@dataclass(frozen=True)
class FieldOfView:
    """A horizontal field of view and where it comes from."""

    radians: float
    source: Literal["option", "exif", "assumed"]
    note: str | None = None
    """What it was worked out from, or why it had to be assumed."""


def check_fov(fov_x: float) -> float:
    """`fov_x` in radians, if a pinhole camera can have it: more than 1° and less than 170°.

    Raises:
        ValueError: it cannot.

    >>> check_fov(1.0)
    1.0
    """
    if not SMALLEST_FOV < fov_x < LARGEST_FOV:
        raise ValueError(f"expected a field of view between 1° and 170°, received {math.degrees(fov_x):g}°")
    return fov_x


def field_of_view(photo: Photo, fov_x: float | None = None) -> FieldOfView:
    """The horizontal field of view to use: the caller's, else the photo's EXIF, else `ASSUMED_FOV`.

    Args:
        photo: a photo that was read.
        fov_x: what the caller says, in radians, or None.

    Raises:
        ValueError: the caller's angle is not between 1° and 170°.
    """
    if fov_x is not None:
        return FieldOfView(check_fov(fov_x), "option")
    if photo.exif_fov is not None:
        return FieldOfView(photo.exif_fov, "exif", photo.exif_fov_source)
    why = photo.exif_fov_source or "the file holds no focal length"
    return FieldOfView(ASSUMED_FOV, "assumed", f"{why}; 60 degrees are assumed")


def estimate(
    photo: str | os.PathLike[str] | Photo | Float[Tensor, "height width 3"],
    *,
    fov_x: float | None = None,
    model: str | Path | Estimator = "default",
) -> Estimate:
    """The light of the place where a photo was taken.

    Convention: `estimate(...).lighting` is in the frame and exposure of `docs/conventions.md`: +X right, +Y
    up, -Z forward, the photo's azimuth in the centre of the map, radiance 1.0 = the photo's linear white. A
    photo that is uniformly one linear colour c over and over has light whose mean radiance is near c.

    Args:
        photo: a file; or a photo that was read; or linear Rec.709 [height, width, 3], 1.0 = white.
        fov_x: horizontal field of view in radians; None: from EXIF, else 60°.
        model: a shipped model's name, a weights file, or an estimator; make one with `Estimator.load` for
        many photos.

    Raises:
        ValueError: not a photo, an impossible field of view, unknown or corrupt weights.
        OSError: the file cannot be read.

    Source: Ji et al., MixLight, 2024; what differs is in `docs/method.md`.
    """
    if fov_x is not None:
        check_fov(fov_x)
    estimator = model if isinstance(model, Estimator) else Estimator.load(model)
    if isinstance(photo, Tensor):
        return estimator.estimate(photo, ASSUMED_FOV if fov_x is None else fov_x)
    read = photo if isinstance(photo, Photo) else read_photo(photo)
    return estimator.estimate(linear_tensor(read), field_of_view(read, fov_x).radians)


def linear_tensor(photo: Photo) -> Float[Tensor, "height width 3"]:
    """The photo's linear values as a tensor, without a copy where its memory allows."""
    return torch.from_numpy(np.ascontiguousarray(photo.linear))
