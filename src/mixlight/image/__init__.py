"""Pixels in and out: photos, Radiance and OpenEXR files, the sRGB curve and previews.

NumPy float32, never torch.
"""

from mixlight.image.atomic import atomic_path
from mixlight.image.color import linear_to_srgb, luminance, srgb_to_linear, xyz_to_rec709
from mixlight.image.errors import ImageFileError
from mixlight.image.ldr import Photo, PhotoError, read_photo, write_png
from mixlight.image.tonemap import preview

__all__ = [
    "ImageFileError",
    "Photo",
    "PhotoError",
    "atomic_path",
    "linear_to_srgb",
    "luminance",
    "preview",
    "read_photo",
    "srgb_to_linear",
    "write_png",
    "xyz_to_rec709",
]
