"""Pixels in and out: photos, Radiance and OpenEXR files, the sRGB curve and previews. NumPy float32, never
torch.
"""

from mixlight.image.atomic import atomic_path
from mixlight.image.color import linear_to_srgb, luminance, srgb_to_linear, xyz_to_rec709
from mixlight.image.errors import ImageFileError

__all__ = ["ImageFileError", "atomic_path", "linear_to_srgb", "luminance", "srgb_to_linear", "xyz_to_rec709"]
