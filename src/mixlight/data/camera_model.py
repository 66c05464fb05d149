"""What a camera does to light: exposure, white balance, lens, response curve, noise, clipping, JPEG."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from PIL import Image
from torch import Tensor
from torch.nn import functional

from mixlight.image.color import linear_to_srgb, srgb_to_linear
from mixlight.light.separate import luminance

CURVES = ("srgb", "gamma", "filmic")
GAIN_RANGE = (1 / 50, 50.0)


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


PLAIN = CameraSettings(0, 0, 0, 0, 0, 0, 0, 0)


def exposure_gain(view: Float[Tensor, "height width 3"], inside: Bool[Tensor, "height width"]) -> float:
    """The linear gain that puts the median luminance of a view at 0.18 (middle gray).

    An all-black view has gain 1. The gain is linear, never computed after the response curve.

    Convention: `photo = gain * radiance`; a view of constant radiance 0.36 has gain 0.5.

    >>> exposure_gain(torch.full((4, 4, 3), 0.36), torch.ones(4, 4, dtype=torch.bool))
    0.5
    """
    median = float(luminance(view)[inside].median())
    return 0.18 / median if median > 0 else 1.0


def usable_gain(gain: float) -> bool:
    """Whether a gain lies within [1/50, 50] (method: views outside are rejected from training)."""
    return GAIN_RANGE[0] <= gain <= GAIN_RANGE[1]


@dataclass(frozen=True)
class Exposed:
    """A photo and the gain that takes scene radiance to the photo's linear scale."""

    photo: Float[Tensor, "height width 3"]
    """Display-referred sRGB-encoded values in [0, 1]."""
    gain: Float[Tensor, " 3"]
    """Per channel: the same factor takes the panorama's light to the photo's own exposure."""


def plain_photo(
    view: Float[Tensor, "height width 3"], inside: Bool[Tensor, "height width"], gain: float
) -> Exposed:
    """The evaluation camera: linear gain, clipping at 1, sRGB, 8 bits; nothing random."""
    photo = torch.from_numpy(linear_to_srgb((view * gain).clamp(0, 1).numpy()))
    photo = (photo * 255).round() / 255
    return Exposed(fill_outside(photo, inside), torch.full((3,), gain))


def fill_outside(
    photo: Float[Tensor, "height width 3"], inside: Bool[Tensor, "height width"]
) -> Float[Tensor, "height width 3"]:
    """Paints what lies outside the photo's frame with the photo's mean linear colour (sRGB-encoded)."""
    if bool(inside.all()):
        return photo
    linear = srgb_to_linear(photo[inside].numpy()).mean(0, dtype=np.float64).astype(np.float32)
    return torch.where(inside[..., None], photo, torch.from_numpy(linear_to_srgb(linear)))


def random_photo(
    view: Float[Tensor, "height width 3"],
    inside: Bool[Tensor, "height width"],
    settings: CameraSettings,
    generator: np.random.Generator,
) -> Exposed | None:
    """Takes a photo of a linear view with a random camera; None where no usable exposure exists.

    The label gain is matched at the median: with a response curve other than sRGB the linearised photo
    is no longer proportional to radiance, and the returned gain takes the view's median luminance to
    that of the sRGB-linearised photo, so that radiance stays on the scale a user would read off the photo.
    """
    base = exposure_gain(view, inside)
    if generator.random() < settings.highlight_rule:
        bright = float(luminance(view)[inside].quantile(0.99))
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


def _vignette(linear: Tensor, strength: float) -> Tensor:
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
    pixels = (photo.numpy() * 255 + 0.5).astype(np.uint8)
    if generator.random() < settings.jpeg_share:
        stream = io.BytesIO()
        Image.fromarray(pixels).save(stream, "JPEG", quality=int(generator.integers(50, 96)))
        pixels = np.asarray(Image.open(stream))
    return torch.from_numpy(pixels.astype(np.float32) / 255)
