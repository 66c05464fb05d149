"""Photos with known light, the same every time: the samples on which methods are compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

from jaxtyping import Float
from torch import Tensor

from mixlight.data import display
from mixlight.data.camera_model import exposure_gain, plain_photo
from mixlight.data.crops import EVALUATION_FOV, EVALUATION_PITCH, evaluation_crops, frame_mask, take_view
from mixlight.data.panoramas import PanoramaRecord, load_panorama
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

ENVIRONMENT_HEIGHT = 128
"""Rows of the true environment maps."""

Exposure = Literal["view", "panorama"]
"""What a photo is exposed for, and its curve: `view` puts the median luminance of the view at .18 and encodes
in sRGB; `panorama` puts the median of the panorama's values at .5 of the display curve x^(1/2.4)
(`mixlight.data.display`). Either way highlights clip at 1, and the photo has 8 bits."""


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
    """Encoded canonical view, 8-bit values in [0, 1]; sRGB, unless its exposure is `panorama`."""
    environment: Float[Tensor, "env_height env_width 3"]
    """True light in the photo's exposure, centred on the photo's azimuth."""
    fov: float = EVALUATION_FOV
    """Horizontal field of view of the canonical view in radians."""

    @property
    def name(self) -> str:
        """Names the sample among all of its protocol, and its files: `kitchen_az045`."""
        return sample_name(self.scene, self.azimuth_deg)


def sample_name(scene: str, azimuth_deg: float) -> str:
    """Name of a scene's view.

    >>> sample_name("house/kitchen", 45.0)
    'house/kitchen_az045'
    """
    return f"{scene}_az{azimuth_deg:03.0f}"


def samples_of(
    record: PanoramaRecord,
    canonical: CanonicalView,
    azimuths: int = 8,
    *,
    pitch: float = EVALUATION_PITCH,
    fov: float = EVALUATION_FOV,
    exposure: Exposure = "view",
) -> Iterator[EvaluationSample]:
    """Yields the fixed views of one panorama.

    The photo is 4:3 with a FOV of 60 degrees, pitch -8 degrees, exposure 0.18 / median luminance of the view,
    sRGB, 8 bits, clipped at 1, unless told otherwise. A network with another canonical view sees that photo
    through its own: what it does not show is filled as always. The gain is not bounded here, since the scale
    of a file is arbitrary; an all-black view is left out.

    Args:
        record: where the panorama lies.
        canonical: the view through which the photo is seen.
        azimuths: views around the horizon; the first looks at the panorama's centre.
        pitch: elevation of the optical axis in radians.
        fov: horizontal field of view of the photo in radians.
        exposure: how the photo is exposed and encoded.

    Raises:
        ValueError: the file is no panorama of radiance, or there is no such exposure.
        OSError: the file cannot be read.
    """
    if exposure not in get_args(Exposure):
        raise ValueError(f"expected an exposure out of {', '.join(get_args(Exposure))}, got {exposure!r}")
    panorama = load_panorama(record.path)
    whole = equirect.resize(panorama, ENVIRONMENT_HEIGHT)
    for fixed in evaluation_crops(azimuths):
        crop = replace(fixed, fov=canonical.fov, pitch=pitch, frame_fov=fov)
        view, inside = take_view(panorama, crop, canonical), frame_mask(crop, canonical)
        if not bool((view[inside] > 0).any()):
            continue
        if exposure == "view":
            gain = exposure_gain(view, inside)
            photo = plain_photo(view, inside, gain).photo
        else:
            gain = display.gain(whole)
            photo = display.photo(view, gain)
        yield EvaluationSample(
            scene=record.scene,
            azimuth_deg=360.0 * crop.azimuth / crop.azimuths,
            pitch=crop.pitch,
            gain=gain,
            photo=photo.permute(2, 0, 1),
            environment=equirect.rotate_azimuth(whole, crop.yaw) * gain,
            fov=canonical.fov,
        )


def collect(
    records: Sequence[PanoramaRecord], canonical: CanonicalView, azimuths: int = 8
) -> list[EvaluationSample]:
    """All samples of several panoramas, in their order."""
    return [sample for record in records for sample in samples_of(record, canonical, azimuths)]
