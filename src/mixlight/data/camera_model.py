"""What a camera does to light: exposure, white balance, lens, response curve, noise, clipping, JPEG."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass, fields

import numpy as np
import torch
from jaxtyping import Bool, Float
from PIL import Image
from torch import Tensor
from torch.nn import functional

from mixlight.image.color import linear_to_srgb, srgb_to_linear
from mixlight.light.separate import luminance

CURVES = ("srgb", "gamma", "filmic")
"""Response curves: sRGB's own, a power of 1/2 to 1/2.5, and a shoulder with contrast."""

GAIN_RANGE = (1 / 50, 50.0)
"""Gains outside are rejected from training (method, section 6)."""

MIDDLE_GRAY = 0.18
"""Linear value at which an exposure puts the median luminance."""


@dataclass(frozen=True)
class CameraSettings:
    """How strongly each part of the camera varies in training; `PLAIN` is the evaluation camera."""

    exposure_ev: float = 0.5
    """Standard deviation of the exposure error in stops."""
    highlight_rule: float = 0.25
    """Share of photos exposed for their 99th percentile instead of their median."""
    white_balance: float = 0.06
    """Standard deviation of the log channel gains."""
    curve_share: float = 0.5
    """Share of photos with another response curve than sRGB."""
    vignetting: float = 0.3
    """Largest loss of light in the corner."""
    noise: float = 0.01
    """Largest standard deviation of sensor noise at linear white."""
    blur: float = 0.8
    """Largest standard deviation of the blur in pixels; negative draws sharpen."""
    jpeg_share: float = 0.5
    """Share of photos that pass through JPEG (quality 50 to 95)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not value >= 0:
                raise ValueError(f"expected {field.name} of at least 0, got {value}")
        for name in ("highlight_rule", "curve_share", "vignetting", "jpeg_share"):
            if getattr(self, name) > 1:
                raise ValueError(f"expected {name} of at most 1, got {getattr(self, name)}")


PLAIN = CameraSettings(0, 0, 0, 0, 0, 0, 0, 0)
"""No variation: `random_photo` with it is `plain_photo` at the median exposure."""


def exposure_gain(view: Float[Tensor, "height width 3"], inside: Bool[Tensor, "height width"]) -> float:
    """The linear gain that puts the median luminance of a view at 0.18 (middle gray).

    The median is taken over the pixels inside the photo's frame (the lower one of two in the middle). A view
    whose median is 0, black by more than half, tells no exposure and has gain 1. The gain is linear, never
    computed after the response curve.

    Convention: `photo = gain * radiance`; a view of constant radiance 0.36 has gain 0.5.

    Raises:
        ValueError: no pixel is inside.

    >>> exposure_gain(torch.full((4, 4, 3), 0.36), torch.ones(4, 4, dtype=torch.bool))
    0.5
    """
    median = float(_inside(luminance(view), inside).median())
    return MIDDLE_GRAY / median if median > 0 else 1.0


def usable_gain(gain: float) -> bool:
    """Whether a gain lies within [1/50, 50] (method: views outside are rejected from training).

    >>> usable_gain(50.0), usable_gain(51.0)
    (True, False)
    """
    return GAIN_RANGE[0] <= gain <= GAIN_RANGE[1]


@dataclass(frozen=True)
class Exposed:
    """A photo and the gain that takes scene radiance to the photo's linear scale.

    Convention: what is neither clipped nor changed by lens, noise or curve has `srgb_to_linear(photo) = gain
        * radiance`, channel by channel.
    """

    photo: Float[Tensor, "height width 3"]
    """Display-referred sRGB-encoded values in [0, 1]."""
    gain: Float[Tensor, " 3"]
    """Per channel: the same factor takes the panorama's light to the photo's own exposure."""


def plain_photo(
    view: Float[Tensor, "height width 3"], inside: Bool[Tensor, "height width"], gain: float
) -> Exposed:
    """The evaluation camera: linear gain, clipping at 1, sRGB, 8 bits; nothing random.

    >>> half = torch.full((2, 2, 3), 0.5)
    >>> plain_photo(half, torch.ones(2, 2, dtype=torch.bool), 1.0).photo[0, 0] * 255
    tensor([188., 188., 188.])
    """
    photo = torch.from_numpy(linear_to_srgb((view * gain).clamp(0, 1).numpy()))
    photo = (photo * 255).round() / 255
    return Exposed(fill_outside(photo, inside), torch.full((3,), gain))


def fill_outside(
    photo: Float[Tensor, "height width 3"], inside: Bool[Tensor, "height width"]
) -> Float[Tensor, "height width 3"]:
    """Paints what lies outside the photo's frame with the photo's mean linear colour (sRGB-encoded).

    `CanonicalView.resample` does the same to a user's photo.

    Raises:
        ValueError: no pixel is inside.
    """
    if bool(inside.all()):
        return photo
    linear = srgb_to_linear(_inside(photo, inside).numpy()).mean(0, dtype=np.float64).astype(np.float32)
    return torch.where(inside[..., None], photo, torch.from_numpy(linear_to_srgb(linear)))


def random_photo(
    view: Float[Tensor, "height width 3"],
    inside: Bool[Tensor, "height width"],
    settings: CameraSettings,
    generator: np.random.Generator,
) -> Exposed | None:
    """Takes a photo of a linear view with a random camera; None where the exposure drawn is not usable.

    Light passes exposure and white balance (linear gains), vignetting, blur, sensor noise, response curve
    with clipping, and 8 bits or JPEG, in this order. `generator` is the only source of chance. Outside the
    frame the photo holds its own mean colour.

    The label gain is matched at the median: with a response curve other than sRGB the linearised photo
    is no longer proportional to radiance, and the returned gain takes the view's median luminance to
    that of the sRGB-linearised photo, so that radiance stays on the scale a user would read off the photo.
    White balance is part of the gain, since it is part of what the photo calls white.

    Raises:
        ValueError: no pixel is inside.
    """
    base = exposure_gain(view, inside)
    if generator.random() < settings.highlight_rule:
        bright = float(_inside(luminance(view), inside).quantile(0.99))
        base = generator.uniform(0.6, 1.2) / bright if bright > 0 else 1.0
    gain = base * 2 ** (settings.exposure_ev * generator.standard_normal())
    if not usable_gain(gain):
        return None
    balance = np.exp(settings.white_balance * generator.standard_normal(3))
    balance /= balance @ (0.2126, 0.7152, 0.0722)
    channel_gain = torch.from_numpy((gain * balance).astype(np.float32))
    linear = _vignette(view * channel_gain, settings.vignetting * generator.random())
    linear = _blur(linear, settings.blur * generator.uniform(-0.6, 1.0))
    linear = _sensor(linear, settings.noise * generator.random() ** 2, generator)
    photo, curved = _respond(linear, settings, generator)
    if curved:
        before = float(luminance(linear)[inside].median())
        after = float(luminance(torch.from_numpy(srgb_to_linear(photo.numpy())))[inside].median())
        if before > 0 and after > 0:
            channel_gain = channel_gain * (after / before)
    photo = _compress(photo, settings, generator)
    return Exposed(fill_outside(photo, inside), channel_gain)


def _inside(values: Tensor, inside: Tensor) -> Tensor:
    if not bool(inside.any()):
        raise ValueError(f"expected a frame with a pixel inside the view of {tuple(inside.shape)}, got none")
    return values[inside]


def _vignette(linear: Tensor, strength: float) -> Tensor:
    """Falls off with the square of the distance from the centre, by `strength` in the corners."""
    if strength <= 0:
        return linear
    height, width = linear.shape[:2]
    y = (torch.arange(height) + 0.5) / height * 2 - 1
    x = (torch.arange(width) + 0.5) / width * 2 - 1
    radius = (y[:, None] ** 2 + x**2) / 2
    return linear * (1 - strength * radius)[..., None]


def _blur(linear: Tensor, sigma: float) -> Tensor:
    """Gaussian blur; a negative sigma sharpens by the same amount (unsharp mask)."""
    if abs(sigma) < 0.2:
        return linear
    reach = math.ceil(2.5 * abs(sigma))
    taps = torch.exp(-(torch.arange(-reach, reach + 1) ** 2) / (2 * sigma**2))
    taps = (taps / taps.sum()).to(linear)
    image = linear.clamp(max=16).permute(2, 0, 1)[:, None]
    image = functional.pad(image, (reach, reach, reach, reach), mode="replicate")
    image = functional.conv2d(functional.conv2d(image, taps.view(1, 1, -1, 1)), taps.view(1, 1, 1, -1))
    soft = image[:, 0].permute(1, 2, 0)
    return soft if sigma > 0 else (linear + 0.7 * (linear.clamp(max=16) - soft)).clamp(min=0)


def _sensor(linear: Tensor, noise: float, generator: np.random.Generator) -> Tensor:
    """Shot noise (grows with the root of the signal) over a floor of read noise."""
    if noise <= 0:
        return linear
    unit = torch.from_numpy(generator.standard_normal(linear.shape, dtype=np.float32))
    return (linear + noise * unit * (linear.clamp(0, 1) + 0.02).sqrt()).clamp(min=0)


def _respond(linear: Tensor, settings: CameraSettings, generator: np.random.Generator) -> tuple[Tensor, bool]:
    """Response curve: linear light to display values; tells whether it was another than sRGB's."""
    curve = str(generator.choice(CURVES[1:])) if generator.random() < settings.curve_share else "srgb"
    if curve == "srgb":
        return torch.from_numpy(linear_to_srgb(linear.clamp(0, 1).numpy())), False
    if curve == "gamma":
        return linear.clamp(0, 1) ** (1 / generator.uniform(2.0, 2.5)), True
    # Filmic: a shoulder x (1 + x / w^2) / (1 + x) (Reinhard et al. 2002, eq. 4) mixed into the straight line.
    white, share = generator.uniform(2, 6), generator.uniform(0.3, 1)
    shoulder = linear * (1 + linear / white**2) / (1 + linear)
    mixed = ((1 - share) * linear + share * shoulder * 1.2).clamp(0, 1)
    contrast = generator.uniform(1.0, 1.25)
    encoded = torch.from_numpy(linear_to_srgb(mixed.numpy()))
    return (0.46 * (encoded / 0.46) ** contrast).clamp(0, 1), True


def _compress(photo: Tensor, settings: CameraSettings, generator: np.random.Generator) -> Tensor:
    """Eight bits, by way of JPEG for some."""
    pixels = (photo.numpy() * 255 + 0.5).astype(np.uint8)
    if generator.random() < settings.jpeg_share:
        stream = io.BytesIO()
        Image.fromarray(pixels).save(stream, "JPEG", quality=int(generator.integers(50, 96)))
        pixels = np.asarray(Image.open(stream))
    return torch.from_numpy(pixels.astype(np.float32) / 255)
