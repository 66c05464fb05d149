"""What the verbs share around a map: reading one, rendering spheres under it, the marks of its lights."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.app.preview import Marker
from mixlight.image import exr, radiance
from mixlight.light.lights import Light
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import camera, equirect, frames

__all__ = ["light_markers", "photo_outline", "read_map", "sphere_renderer"]

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


@lru_cache(maxsize=2)
def sphere_renderer(resolution: int) -> SphereRenderer:
    """The renderer of spheres of that many pixels; read-only, as it is kept for the next call."""
    return SphereRenderer(resolution)


def light_markers(lights: Sequence[Light]) -> list[Marker]:
    """One marker a light, sized by its share of the irradiance."""
    strengths = [float(sum(light.irradiance)) for light in lights]
    total = sum(strengths) or 1.0
    markers = []
    for light, strength in zip(lights, strengths, strict=True):
        x, y, z = (float(component) for component in light.direction)
        markers.append(Marker((x, y, z), strength / total))
    return markers


def photo_outline(
    width: int, height: int, fov_x: float, pitch: float, roll: float
) -> Float[np.ndarray, "points 3"]:
    """Directions along the edge of a photo, once around, clockwise from its upper left corner."""
    columns = 64
    rows = min(max(round(columns * height / width), 2), 256)
    rays = camera.ray_directions(rows, columns, fov_x, 0.0, pitch, roll).numpy()
    return np.concatenate([rays[0], rays[1:, -1], rays[-1, -2::-1], rays[-2::-1, 0]])
