"""Which views of a panorama are taken: fixed ones for evaluation, random ones for training."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.network.canonical import CanonicalView
from mixlight.sphere import camera

EVALUATION_AZIMUTHS = 8
EVALUATION_PITCH = math.radians(-8)
EVALUATION_FOV = math.radians(60)

ASPECTS = (4 / 3, 3 / 2, 16 / 9, 1.0, 3 / 4, 9 / 16)
_ASPECT_SHARES = (0.6, 0.12, 0.12, 0.06, 0.06, 0.04)


@dataclass(frozen=True)
class Crop:
    """A pinhole view of a panorama. Angles in radians."""

    azimuth: int
    """Index of the viewing azimuth: the view turns right by 2 pi azimuth / azimuths."""
    azimuths: int
    """Number of azimuths around the horizon."""
    pitch: float = EVALUATION_PITCH
    """Elevation of the optical axis; negative looks down."""
    roll: float = 0.0
    """Clockwise turn of the camera."""
    fov: float = EVALUATION_FOV
    """Horizontal field of view that the canonical view's pixels really have."""
    frame_fov: float = math.radians(90)
    """Horizontal field of view of the photo's frame; what lies outside is unseen."""
    aspect: float = 4 / 3
    """Width over height of the photo's frame."""
    mirrored: bool = False
    """Left and right exchanged after the view was taken."""

    @property
    def yaw(self) -> float:
        """Angle to the right in radians."""
        return 2 * math.pi * self.azimuth / self.azimuths


def evaluation_crops(azimuths: int = EVALUATION_AZIMUTHS) -> list[Crop]:
    """The fixed views of protocol M: equally spaced azimuths, pitch -8 degrees, FOV 60 degrees.

    >>> [round(math.degrees(crop.yaw)) for crop in evaluation_crops()]
    [0, 45, 90, 135, 180, 225, 270, 315]
    """
    return [Crop(k, azimuths) for k in range(azimuths)]


@dataclass(frozen=True)
class CropSettings:
    """How views vary in training (method: pitch and FOV are triangular with the published bounds)."""

    pitch_deg: tuple[float, float, float] = (-43.0, -8.0, 17.0)
    """Lowest, most frequent and highest elevation of the optical axis."""
    frame_fov_deg: tuple[float, float, float] = (50.0, 62.0, 80.0)
    """Smallest, most frequent and largest field of view of the photo's frame."""
    fov_error: float = 0.06
    """Standard deviation of the log error of the assumed field of view."""
    roll_deg: float = 2.0
    """Standard deviation of the camera's roll."""
    frames: bool = True
    """Whether the photo's frame varies in aspect and size; off, the canonical view is filled."""


def random_crop(azimuths: int, settings: CropSettings, generator: np.random.Generator) -> Crop:
    """Draws a training view; half of them are mirrored."""
    wide = generator.triangular(*settings.frame_fov_deg) if settings.frames else 90.0
    aspect = float(generator.choice(ASPECTS, p=_ASPECT_SHARES)) if settings.frames else 4 / 3
    if aspect < 1:  # a portrait photo has the usual field of view along its long side
        wide = math.degrees(2 * math.atan(math.tan(math.radians(wide) / 2) * max(aspect, 3 / 4)))
    return Crop(
        azimuth=int(generator.integers(azimuths)),
        azimuths=azimuths,
        pitch=math.radians(generator.triangular(*settings.pitch_deg)),
        roll=math.radians(settings.roll_deg * generator.standard_normal()),
        fov=EVALUATION_FOV * float(np.exp(settings.fov_error * generator.standard_normal())),
        frame_fov=math.radians(wide),
        aspect=aspect,
        mirrored=bool(generator.random() < 0.5),
    )


def frame_mask(crop: Crop, canonical: CanonicalView) -> Bool[Tensor, "height width"]:
    """Which pixels of the canonical view lie inside the photo's frame."""
    half_width = math.tan(crop.frame_fov / 2) / math.tan(canonical.fov / 2)
    half_height = half_width / crop.aspect * canonical.width / canonical.height
    x = ((torch.arange(canonical.width) + 0.5) / canonical.width * 2 - 1).abs()
    y = ((torch.arange(canonical.height) + 0.5) / canonical.height * 2 - 1).abs()
    return (x <= half_width)[None, :] & (y <= half_height)[:, None]


def take_view(
    panorama: Float[Tensor, "panorama_height panorama_width 3"], crop: Crop, canonical: CanonicalView
) -> Float[Tensor, "height width 3"]:
    """The linear radiance that the crop's camera sees, antialiased, mirrored where the crop says so."""
    seen = camera.view(
        panorama, canonical.height, canonical.width, crop.fov, crop.yaw, crop.pitch, crop.roll
    )
    return seen.flip(1) if crop.mirrored else seen
