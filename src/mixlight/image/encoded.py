"""A photo as its file holds it, so that what is painted into it leaves all other pixels bit for bit.

`mixlight.image.ldr.read_photo` gives the linear light of a photo; this gives the samples themselves, upright,
and the way back from linear light to them.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Shaped

from mixlight.image import png
from mixlight.image._array import Array
from mixlight.image.color import linear_to_srgb, srgb_to_linear
from mixlight.image.exif import turn_upright
from mixlight.image.ldr import Photo, PhotoError
from mixlight.image.stored import Stored, load

__all__ = ["EncodedPhoto", "read_encoded"]


@dataclass(frozen=True, eq=False)
class EncodedPhoto:
    """The samples of a photo of 8 or 16 bits, upright, with what they mean."""

    samples: Shaped[Array, "height width channels"]
    stored: Stored
    """The file's profile and gamma; its samples are not turned upright."""

    def paint(
        self, light: Float[Array, "painted 3"], where: Bool[Array, "height width"]
    ) -> Shaped[Array, "height width channels"]:
        """The samples with the pixels `where` replaced by linear Rec.709 light; grey becomes RGB.

        Values outside what the encoding can hold are clipped, as a camera does. Painted pixels are opaque.

        Args:
            light: of the painted pixels, row by row.
            where: the pixels to replace.

        Returns:
            uint8 or uint16 of 3 or 4 channels, as before; all other samples are the file's own.
        """
        samples = self.samples
        count = samples.shape[2]
        if count < 3:
            samples = samples[..., [0, 0, 0] if count == 1 else [0, 0, 0, 1]]
        painted = samples.copy()
        largest = np.iinfo(samples.dtype).max
        painted[where, :3] = np.round(self.encode(light) * largest).astype(samples.dtype)
        if painted.shape[2] == 4:
            painted[where, 3] = largest
        return painted

    def encode(self, linear: Float[Array, "*shape 3"]) -> Float[Array, "*shape 3"]:
        """Linear Rec.709 light in the photo's own encoding, from 0 to 1.

        Convention: sRGB where the file says nothing else, so .2159 becomes 128 / 255.
        """
        light = np.asarray(linear, np.float64)
        profile, gamma = self.stored.profile, self.stored.gamma
        if profile is not None:
            if profile.matrix is not None:
                light = light @ np.linalg.inv(profile.matrix).T
            # A curve is known in one direction only; as it rises, a fine table can be read backwards.
            levels = np.linspace(0, 1, 2**16)
            encoded = np.empty_like(light)
            for channel in range(3):
                curve = profile.curves[channel % len(profile.curves)](levels)
                encoded[..., channel] = np.interp(light[..., channel], np.maximum.accumulate(curve), levels)
            return encoded
        clipped = light.clip(0, 1)
        return np.asarray(linear_to_srgb(clipped) if gamma is None else clipped ** (1 / gamma))

    def write_png(
        self, path: str | os.PathLike[str], samples: Shaped[Array, "height width channels"]
    ) -> None:
        """Write samples of the same encoding as a PNG that says so.

        Raises:
            OSError: the file cannot be made.
        """
        grey = self.stored.profile is not None and len(self.stored.profile.curves) == 1
        if grey:  # the profile is for grey, the picture no longer: what the curve decodes is written as sRGB
            largest = np.iinfo(samples.dtype).max
            curve = self.stored.profile.curves[0] if self.stored.profile else srgb_to_linear
            colour = linear_to_srgb(curve(samples[..., :3] / largest)) * largest
            samples = np.concatenate([np.round(colour).astype(samples.dtype), samples[..., 3:]], axis=-1)
        png.write(path, samples, profile=b"" if grey else self.stored.profile_data, gamma=self.stored.gamma)


def read_encoded(path: str | os.PathLike[str], photo: Photo) -> EncodedPhoto:
    """The samples of a photo that was read by `read_photo`.

    Raises:
        PhotoError: (a ValueError) it is a photo of linear floats, or the file changed in between.
        OSError: the file cannot be read.
    """
    if photo.source != "ldr":
        raise PhotoError(f"{photo.name}: expected a photo of 8 or 16 bits, received linear floats")
    data = Path(path).read_bytes()
    stored = load(photo.format, data)
    samples = turn_upright(stored.samples, stored.exif.orientation)
    if samples.ndim == 2:
        samples = samples[..., None]
    if (samples.shape[1], samples.shape[0]) != photo.size or samples.dtype == np.float32:
        raise PhotoError(f"{photo.name}: expected the picture that was read before, received another one")
    return EncodedPhoto(np.ascontiguousarray(samples), stored)
