"""Photos with known light, the same every time: the samples on which methods are compared (protocol M)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from jaxtyping import Float
from torch import Tensor

from mixlight.data.camera_model import exposure_gain, plain_photo
from mixlight.data.crops import evaluation_crops, frame_mask, take_view
from mixlight.data.panoramas import PanoramaRecord, load_panorama
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

ENVIRONMENT_HEIGHT = 128
"""Rows of the true environment maps of protocol M."""


@dataclass(frozen=True)
class EvaluationSample:
    """One photo of a panorama, and the panorama as that photo's camera exposed and faced it."""

    scene: str
    """Name of the panorama."""
    azimuth_deg: float
    """Degrees to the right of the panorama's centre."""
    pitch: float
    """Elevation of the optical axis in radians."""
    gain: float
    """Linear gain from scene radiance to the photo's exposure."""
    photo: Float[Tensor, "3 height width"]
    """sRGB-encoded canonical view, 8-bit values in [0, 1]."""
    environment: Float[Tensor, "env_height env_width 3"]
    """True light in the photo's exposure, centred on the photo's azimuth."""


def samples_of(
    record: PanoramaRecord, canonical: CanonicalView, azimuths: int = 8
) -> Iterator[EvaluationSample]:
    """Yields the fixed views of one panorama.

    The photo is 4:3 with a FOV of 60 degrees, pitch -8 degrees, exposure 0.18 / median luminance of the view,
    sRGB, 8 bits, clipped at 1. A network with another canonical view sees that photo through its own: what it
    does not show is filled as always. The gain is not bounded here, since the scale of a file is arbitrary;
    an all-black view is left out.

    Raises:
        ValueError: the file is no panorama of radiance.
        OSError: the file cannot be read.
    """
    panorama = load_panorama(record.path)
    whole = equirect.resize(panorama, ENVIRONMENT_HEIGHT)
    for fixed in evaluation_crops(azimuths):
        crop = replace(fixed, fov=canonical.fov)
        view, inside = take_view(panorama, crop, canonical), frame_mask(crop, canonical)
        if not bool((view[inside] > 0).any()):
            continue
        gain = exposure_gain(view, inside)
        exposed = plain_photo(view, inside, gain)
        yield EvaluationSample(
            scene=record.scene,
            azimuth_deg=360.0 * crop.azimuth / crop.azimuths,
            pitch=crop.pitch,
            gain=gain,
            photo=exposed.photo.permute(2, 0, 1),
            environment=equirect.rotate_azimuth(whole, crop.yaw) * gain,
        )


def collect(
    records: Sequence[PanoramaRecord], canonical: CanonicalView, azimuths: int = 8
) -> list[EvaluationSample]:
    """All samples of several panoramas, in their order."""
    return [sample for record in records for sample in samples_of(record, canonical, azimuths)]
