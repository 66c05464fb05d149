"""Pictures as they are stored: decoded samples, and what the file says about their colour and orientation.

Pillow decodes 8 bits, OpenCV PNGs of 16 bits, which Pillow would cut down to 8. Their plugins are called
directly and not through `Image.open`, which would apply a cap on the size that is global to the process; the
caller has checked the size.
"""

import io
import struct
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Shaped

from mixlight.image import container, icc
from mixlight.image._array import Array
from mixlight.image.errors import one_line
from mixlight.image.exif import Exif
from mixlight.image.exif import parse as parse_exif
from mixlight.image.tiff import read_samples
from mixlight.image.tiff_structure import Directory, end_of_pixels, read_directory

if TYPE_CHECKING:
    from PIL import Image

__all__ = ["Stored", "load"]

_ORIENTATION, _PROFILE, _DNG_VERSION, _SUBFILE = 274, 34675, 50706, 254


@dataclass(frozen=True)
class Stored:
    """A decoded picture before colour and orientation."""

    samples: Shaped[Array, "rows columns *channels"]
    """uint8, uint16 or float32; [h, w] or [h, w, 1] grey, [h, w, 3] RGB; 2 or 4 channels with alpha."""
    exif: Exif = field(default_factory=Exif)
    profile: icc.Profile | None = None
    profile_data: bytes = b""
    """The bytes that `profile` was read from."""
    gamma: float | None = None
    """The exponent of a PNG whose curve is not sRGB's."""
    premultiplied: bool = False
    """Whether the colour is already multiplied by alpha."""
    notes: tuple[str, ...] = ()


def load(kind: str, data: bytes) -> Stored:
    """Decodes a JPEG, PNG, WebP or TIFF.

    Raises:
        ValueError: truncated, corrupt, or of a kind that holds no colour picture ("expected ..., received
            ...").
        Exception: whatever the decoders raise on bad data.
    """
    if kind == "TIFF":
        return _load_tiff(data)
    if kind == "PNG":
        return _load_png(data)
    if kind == "JPEG":
        container.check_jpeg(data)
    image = _open(kind, data)
    stored = _from_pillow(image)
    return _with_exif(stored, image.info.get("exif", b""))


def _load_png(data: bytes) -> Stored:
    chunks = container.png_chunks(data)
    image = _open("PNG", data)
    if chunks[b"IHDR"][8] == 16:
        stored = _with_profile(_from_opencv(data), image.info.get("icc_profile", b""))
    else:
        stored = _from_pillow(image)
    stored = _with_exif(stored, chunks.get(b"eXIf", b"") or _textual_exif(image.info))
    if b"gAMA" in chunks and b"sRGB" not in chunks and stored.profile is None:
        gamma = struct.unpack(">I", chunks[b"gAMA"])[0] / 100000.0
        if gamma > 0.0 and abs(gamma - 1.0 / 2.2) > 0.01:
            note = f"PNG gamma {gamma:g} decoded"
            return replace(stored, gamma=1.0 / gamma, notes=(*stored.notes, note))
    return stored


def _load_tiff(data: bytes) -> Stored:
    directory = read_directory(data)
    if _DNG_VERSION in directory.raw or int(directory.first(_SUBFILE, 0)) & 1 or data[8:10] == b"CR":
        raise ValueError("expected a developed picture, received a camera's raw file (develop it to TIFF)")
    if end_of_pixels(directory) > len(data):
        needed = int(end_of_pixels(directory))
        raise ValueError(f"expected pixels up to byte {needed}, received {len(data)} bytes (truncated)")
    exif = parse_exif(data)
    data = _untagged(data, directory)
    if directory.first(258, 1) <= 8:
        stored = _from_pillow(_open("TIFF", data))
    else:
        samples, premultiplied = read_samples(data, directory)
        stored = _with_profile(Stored(samples, premultiplied=premultiplied), directory.raw.get(_PROFILE, b""))
    return replace(stored, exif=exif)


def _untagged(data: bytes, directory: Directory) -> bytes:
    """The file with orientation 1: decoders turn some pictures and fail on others, so the turning is done
    here.
    """
    if directory.first(_ORIENTATION, 1) == 1:
        return data
    upright = bytearray(data)
    struct.pack_into(f"{directory.byte_order}H", upright, directory.position[_ORIENTATION], 1)
    return bytes(upright)


def _open(kind: str, data: bytes) -> "Image.Image":
    """The picture's header, in Pillow."""
    file = io.BytesIO(data)
    if kind == "JPEG":
        from PIL.JpegImagePlugin import jpeg_factory

        return jpeg_factory(file)
    if kind == "PNG":
        from PIL.PngImagePlugin import PngImageFile

        return PngImageFile(file)
    if kind == "WebP":
        from PIL.WebPImagePlugin import WebPImageFile

        return WebPImageFile(file)
    from PIL.TiffImagePlugin import TiffImageFile

    return TiffImageFile(file)


def _from_pillow(image: "Image.Image") -> Stored:
    image.load()
    profile = image.info.get("icc_profile", b"")
    frames = getattr(image, "n_frames", 1)
    notes = (f"the first of {frames} pictures in the file",) if frames > 1 else ()
    if image.mode not in ("L", "RGB", "RGBA", "CMYK") or image.has_transparency_data:
        if image.mode not in ("1", "L", "P", "PA", "LA", "La", "RGB", "RGBA", "RGBa", "RGBX", "YCbCr"):
            raise ValueError(f"expected grey, RGB or CMYK, received a picture of mode {image.mode}")
        image = image.convert("RGBA" if image.has_transparency_data else "L" if image.mode == "1" else "RGB")
    tabular = image.mode == "CMYK"
    if profile and not tabular:
        try:
            tabular = icc.parse(profile) is None
        except ValueError:
            tabular = False  # reported below
    if profile and tabular:
        image, note = _through_colour_engine(image, profile)
        notes, profile = (*notes, note), b""
    if image.mode == "CMYK":
        image = image.convert("RGB")
    return _with_profile(Stored(np.asarray(image), notes=notes), profile)


def _through_colour_engine(image: "Image.Image", profile: bytes) -> tuple["Image.Image", str]:
    from PIL import ImageCms

    mode = "RGBA" if image.mode == "RGBA" else "RGB"
    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        converted = ImageCms.profileToProfile(image, source, ImageCms.createProfile("sRGB"), outputMode=mode)
        assert converted is not None
        name = one_line(ImageCms.getProfileDescription(source), 60)
    except (ImageCms.PyCMSError, OSError) as error:
        return image, f"ICC profile not usable ({one_line(error, 60)}), sRGB assumed"
    return converted, f"ICC profile {name} converted"


def _from_opencv(data: bytes) -> Stored:
    import cv2

    samples = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if samples is None:
        raise ValueError("expected pixels that can be decoded, received corrupt ones")
    samples = np.asarray(samples)
    if samples.ndim == 3:
        order = {3: [2, 1, 0], 4: [2, 1, 0, 3]}.get(samples.shape[2])
        if order is None:
            raise ValueError(f"expected 1, 3 or 4 channels, received {samples.shape[2]}")
        samples = samples[..., order]
    return Stored(samples)


def _with_profile(stored: Stored, profile: bytes) -> Stored:
    if not profile:
        return stored
    try:
        parsed = icc.parse(profile)
    except ValueError as error:
        return replace(stored, notes=(*stored.notes, f"ICC profile not usable ({error}), sRGB assumed"))
    if parsed is None:
        return replace(
            stored, notes=(*stored.notes, "ICC profile of tables not applied to 16 bits, sRGB assumed")
        )
    if len(parsed.curves) == 3 and (stored.samples.ndim == 2 or stored.samples.shape[2] < 3):
        return replace(stored, notes=(*stored.notes, "ICC profile for RGB not applied to grey, sRGB assumed"))
    note = f"ICC profile {one_line(parsed.name, 60)} decoded"
    return replace(stored, profile=parsed, profile_data=profile, notes=(*stored.notes, note))


def _with_exif(stored: Stored, data: bytes) -> Stored:
    if not data:
        return stored
    try:
        return replace(stored, exif=parse_exif(data))
    except ValueError as error:
        return replace(stored, notes=(*stored.notes, f"EXIF data not usable: {error}"))


def _textual_exif(info: dict[str | tuple[int, int], object]) -> bytes:
    """EXIF data as ImageMagick used to write them into PNG: hexadecimal digits below three lines."""
    lines = str(info.get("Raw profile type exif", "")).split("\n")[3:]
    try:
        return bytes.fromhex("".join(lines))
    except ValueError:
        return b""
