"""What the verbs share around a map: reading one, its spheres, the marks of its lights."""

from collections.abc import Sequence
from pathlib import Path

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.app.preview import SPHERE, Marker
from mixlight.image import exr, radiance
from mixlight.light.lights import Light
from mixlight.render.spheres import render_spheres
from mixlight.sphere import equirect, frames

__all__ = ["light_markers", "preview_spheres", "read_map"]

_EXR_MAGIC, _RADIANCE_MAGIC = b"\x76\x2f\x31\x01", b"#?"


def read_map(path: str | Path, *, max_pixels: int) -> tuple[Float[Tensor, "height width 3"], bool]:
    """Read an HDR panorama, Radiance or OpenEXR by its first bytes; also says whether we wrote the file.

    A map of ours whose header says that it was rolled for another program is turned back into our frame; any
    other file is taken to be in our frame already.

    Raises:
        ValueError: not such a file, too large, not 2:1, NaN, infinite or negative radiance; the message names
            the file.
        OSError: the file cannot be read.
    """
    with open(path, "rb") as file:
        magic = file.read(4)
    header: dict[str, str]
    if magic == _EXR_MAGIC:
        pixels, attributes = exr.read(path, max_pixels=max_pixels)
        header = {key: str(value) for key, value in attributes.items()}
    elif magic[:2] == _RADIANCE_MAGIC:
        pixels, lines = radiance.read(path, max_pixels=max_pixels)
        header = {key.lower(): value for key, value in lines.items()}
    else:
        received = "an empty file" if not magic else f"a file that starts with {magic!r}"
        raise ValueError(
            f"{path}: expected a Radiance (.hdr) or OpenEXR (.exr) panorama, received {received}"
        )
    panorama = torch.from_numpy(pixels)
    equirect.check(panorama, str(path))
    ours = header.get("software", "").startswith("mixlight")
    frame = header.get("frame", "mixlight") if ours else "mixlight"
    if frame == "mixlight":
        return panorama, ours
    try:
        return frames.convert_panorama(panorama, frame, "mixlight"), ours
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def light_markers(lights: Sequence[Light]) -> list[Marker]:
    """One marker a light, sized by its share of the irradiance."""
    strengths = [float(sum(light.irradiance)) for light in lights]
    total = sum(strengths) or 1.0
    markers = []
    for light, strength in zip(lights, strengths, strict=True):
        x, y, z = (float(component) for component in light.direction)
        markers.append(Marker((x, y, z), strength / total))
    return markers


def preview_spheres(
    environment: Float[Tensor, "height width 3"],
) -> tuple[Float[Tensor, "3 size size 3"], Bool[Tensor, "size size"]]:
    """The three spheres of a preview, at the size at which it shows them."""
    return render_spheres(environment, resolution=SPHERE)
