"""From one photo file to an estimate: the one function behind `mixlight estimate` and `mixlight.estimate`."""

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.image.ldr import Photo, read_photo
from mixlight.network.estimator import Estimate, Estimator

__all__ = ["ASSUMED_FOV", "FieldOfView", "check_fov", "estimate", "field_of_view"]

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
    """What a reader of the result should know; None where the angle is certain."""


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


def field_of_view(exif_fov: float | None, fov_x: float | None = None, how: str | None = None) -> FieldOfView:
    """The horizontal field of view to use: the caller's, else the photo's EXIF, else `ASSUMED_FOV`.

    Args:
        exif_fov: what EXIF says, in radians, or None. An impossible value is not believed.
        fov_x: what the caller says, in radians, or None.
        how: what EXIF's angle was worked out from.

    Raises:
        ValueError: the caller's angle is not between 1° and 170°.

    >>> field_of_view(None).source, field_of_view(0.9).source, field_of_view(0.9, 1.2).radians
    ('assumed', 'exif', 1.2)
    """
    if fov_x is not None:
        return FieldOfView(check_fov(fov_x), "option")
    if exif_fov is None:
        note = "no field of view was given and the file holds no focal length: 60 degrees are assumed"
        return FieldOfView(ASSUMED_FOV, "assumed", note)
    if not SMALLEST_FOV < exif_fov < LARGEST_FOV:
        told = f"{math.degrees(exif_fov):.4g} degrees"
        note = f"the file's EXIF says {told}, which no photo has: 60 degrees are assumed"
        return FieldOfView(ASSUMED_FOV, "assumed", note)
    return FieldOfView(exif_fov, "exif", how)


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
        return estimator.estimate(photo, field_of_view(None, fov_x).radians)
    read = photo if isinstance(photo, Photo) else read_photo(photo)
    return estimator.estimate(torch.from_numpy(read.linear), field_of_view(read.exif_fov, fov_x).radians)
