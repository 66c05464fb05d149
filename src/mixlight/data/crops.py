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

_FILLED_DEG = 170.0
"""Field of view of a frame that no canonical view reaches the rim of."""

ASPECTS = (4 / 3, 3 / 2, 16 / 9, 1.0, 3 / 4, 9 / 16)
"""Width over height of the photos in training: cameras', phones' and cut ones, landscape and portrait."""

_ASPECT_SHARES = (0.6, 0.12, 0.12, 0.06, 0.06, 0.04)


@dataclass(frozen=True)
class Crop:
    """A pinhole view of a panorama, and the frame of the photo within it. Angles in radians.

    Convention: +X right, +Y up, -Z forward. Azimuth 16 of 64 looks along +X; pitch > 0 looks up; roll > 0
        turns the camera clockwise, so that the content of its picture turns counter-clockwise. `mirrored`
        exchanges left and right of the picture that yaw, pitch and roll describe: it is the picture of a
        mirrored world, whose camera has the opposite roll.
    """

    azimuth: int
    """Index of the viewing azimuth: the view turns right by 2 pi azimuth / azimuths."""
    azimuths: int
    """Number of azimuths around the horizon."""
    pitch: float = EVALUATION_PITCH
    """Elevation of the optical axis; negative looks down."""
    roll: float = 0.0
    """Clockwise turn of the camera."""
    fov: float = EVALUATION_FOV
    """Horizontal field of view that the canonical view's pixels really have: the canonical view's own, but
    for the error in what is known of a photo's field of view."""
    frame_fov: float = math.radians(90)
    """Horizontal field of view of the photo's frame, as the canonical view measures it; what lies outside is
    unseen."""
    aspect: float = 4 / 3
    """Width over height of the photo's frame."""
    mirrored: bool = False
    """Left and right exchanged after the view was taken."""

    def __post_init__(self) -> None:
        if self.azimuths < 1:
            raise ValueError(f"expected azimuths of at least 1, got {self.azimuths}")
        for name in ("fov", "frame_fov"):
            if not 0 < getattr(self, name) < math.pi:
                raise ValueError(f"expected {name} in (0, pi) radians, got {getattr(self, name)}")
        if not self.aspect > 0:
            raise ValueError(f"expected an aspect above 0, got {self.aspect}")

    @property
    def yaw(self) -> float:
        """Angle to the right in radians."""
        return 2 * math.pi * self.azimuth / self.azimuths


def evaluation_crops(azimuths: int = EVALUATION_AZIMUTHS) -> list[Crop]:
    """The fixed views of protocol M: equally spaced azimuths, pitch -8 degrees, 4:3 photos of 60 degrees.

    Raises:
        ValueError: no azimuth.

    >>> [round(math.degrees(crop.yaw)) for crop in evaluation_crops()]
    [0, 45, 90, 135, 180, 225, 270, 315]
    """
    if azimuths < 1:
        raise ValueError(f"expected azimuths of at least 1, got {azimuths}")
    return [Crop(k, azimuths, frame_fov=EVALUATION_FOV) for k in range(azimuths)]


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

    def __post_init__(self) -> None:
        for name, bounds in (("pitch_deg", (-90.0, 90.0)), ("frame_fov_deg", (0.0, 180.0))):
            low, mode, high = getattr(self, name)
            if not bounds[0] < low <= mode <= high < bounds[1]:
                raise ValueError(
                    f"expected {name} as lowest, most frequent and highest value, rising, within {bounds}, "
                    f"got {[low, mode, high]}"
                )
        for name in ("fov_error", "roll_deg"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"expected {name} of at least 0, got {getattr(self, name)}")


def random_crop(
    azimuths: int,
    settings: CropSettings,
    generator: np.random.Generator,
    canonical_fov: float = EVALUATION_FOV,
) -> Crop:
    """Draws a training view; half of them are mirrored.

    Args:
        azimuths: number of viewing azimuths, all equally likely.
        settings: how views vary.
        generator: the only source of chance.
        canonical_fov: horizontal field of view of the network's canonical view in radians.
    """
    wide = _triangular(settings.frame_fov_deg, generator) if settings.frames else _FILLED_DEG
    aspect = float(generator.choice(ASPECTS, p=_ASPECT_SHARES)) if settings.frames else 4 / 3
    if aspect < 1:  # a portrait photo has about the usual field of view along its long side
        wide = math.degrees(2 * math.atan(math.tan(math.radians(wide) / 2) * max(aspect, 3 / 4)))
    return Crop(
        azimuth=int(generator.integers(azimuths)),
        azimuths=azimuths,
        pitch=math.radians(_triangular(settings.pitch_deg, generator)),
        roll=math.radians(settings.roll_deg * generator.standard_normal()),
        fov=canonical_fov * float(np.exp(settings.fov_error * generator.standard_normal())),
        frame_fov=math.radians(wide),
        aspect=aspect,
        mirrored=bool(generator.random() < 0.5),
    )


def _triangular(bounds: tuple[float, float, float], generator: np.random.Generator) -> float:
    """NumPy refuses a triangle without width."""
    return float(generator.triangular(*bounds)) if bounds[0] < bounds[2] else bounds[0]


def frame_mask(crop: Crop, canonical: CanonicalView) -> Bool[Tensor, "height width"]:
    """Which pixels of the canonical view have their centre inside the photo's frame.

    Frame and view share the optical axis: a frame of angle f and aspect a reaches tan(f / 2) to the sides of
    it and tan(f / 2) / a up and down, at unit distance.

    >>> narrow = Crop(0, 8, frame_fov=2 * math.atan(0.5 * math.tan(math.radians(30))), aspect=2.0)
    >>> frame_mask(narrow, CanonicalView(4, 4, math.radians(60))).int()
    tensor([[0, 0, 0, 0],
            [0, 1, 1, 0],
            [0, 1, 1, 0],
            [0, 0, 0, 0]], dtype=torch.int32)
    """
    half_width = math.tan(crop.frame_fov / 2) / math.tan(canonical.fov / 2)
    half_height = half_width / crop.aspect * canonical.width / canonical.height
    x = ((torch.arange(canonical.width) + 0.5) / canonical.width * 2 - 1).abs()
    y = ((torch.arange(canonical.height) + 0.5) / canonical.height * 2 - 1).abs()
    return (x <= half_width)[None, :] & (y <= half_height)[:, None]


def take_view(
    panorama: Float[Tensor, "panorama_height panorama_width 3"], crop: Crop, canonical: CanonicalView
) -> Float[Tensor, "height width 3"]:
    """The linear radiance that the crop's camera sees, antialiased, mirrored where the crop says so.

    In the panorama's units, the whole canonical view without regard to the frame (`frame_mask`).
    """
    seen = camera.view(panorama, canonical.height, canonical.width, crop.fov, crop.yaw, crop.pitch, crop.roll)
    return seen.flip(1) if crop.mirrored else seen
