"""What is compared with what, and how: the protocols, as data.

A protocol never changes under its letter. Whatever would move a number (crops, exposure, map size, spheres,
masks, divisors) makes a new one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Literal, get_args

from mixlight.data.evaluation_set import EvaluationSample, Exposure, samples_of
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.cells import LIGHT_CELLS, SPHERES
from mixlight.evaluation.renderers import Scene
from mixlight.network.canonical import CanonicalView

__all__ = ["PROTOCOLS", "Letter", "Protocol", "find"]

Letter = Literal["M", "S", "L"]

Measure = Literal["rmse", "si_rmse", "geometric", "angle_deg", "normalised_rmse"]
"""What is measured on each sphere: `mixlight.evaluation.metrics`. `geometric` is sqrt(RMSE si-RMSE)."""


@dataclass(frozen=True)
class Protocol:
    """One way to compare predicted light with true light."""

    letter: Letter
    """Its name."""
    title: str
    """What it is, in a line."""
    azimuths: int
    """Views of each panorama around the horizon; the first looks at the panorama's centre."""
    pitch_deg: float
    """Elevation of the optical axis."""
    fov_deg: float
    """Horizontal field of view of the photo."""
    exposure: Exposure
    """How the photo is exposed and encoded (`mixlight.data.evaluation_set.Exposure`)."""
    photo_height: int = 192
    """Rows of the photo."""
    photo_width: int = 256
    """Columns of the photo."""
    map_height: int = 128
    """Rows of the maps that are compared; others are resized, and keep their energy."""
    encoding: Literal["linear", "display"] = "linear"
    """What lights the spheres: the maps as they are, or each encoded on its own
    (`mixlight.data.display.encode`), which divides its brightness out."""
    scene: Scene | None = None
    """Camera, materials and picture of the spheres; None: no spheres."""
    measures: tuple[Measure, ...] = ()
    """What is measured on each sphere."""
    divisor: Literal["values", "pixels"] = "values"
    """What a sum of squared errors is divided by: pixels times channels, or pixels."""
    lights: bool = False
    """Whether the maps' light sources are compared (`mixlight.evaluation.sources`)."""

    @property
    def cells(self) -> tuple[str, ...]:
        """Names of all that is measured on a sample, in the order of the tables.

        >>> PROTOCOLS["M"].cells[:4]
        ('diffuse_rmse', 'matte_rmse', 'mirror_rmse', 'diffuse_si_rmse')
        """
        spheres = tuple(f"{sphere}_{measure}" for measure in self.measures for sphere in SPHERES)
        return spheres + (LIGHT_CELLS if self.lights else ())

    @property
    def photo(self) -> CanonicalView:
        """Size and field of view of the photo."""
        return CanonicalView(self.photo_height, self.photo_width, math.radians(self.fov_deg))

    def samples(self, record: PanoramaRecord, azimuths: int | None = None) -> Iterator[EvaluationSample]:
        """Yields the protocol's photos of a panorama, each with its true light.

        Args:
            record: where the panorama lies.
            azimuths: another number of views, for what is not scored.

        Raises:
            ValueError: the file is no panorama of radiance.
            OSError: the file cannot be read.
        """
        return samples_of(
            record,
            self.photo,
            azimuths or self.azimuths,
            pitch=math.radians(self.pitch_deg),
            fov=math.radians(self.fov_deg),
            exposure=self.exposure,
        )

    def to_json(self) -> dict[str, object]:
        """All of it as plain values, for the results."""
        return asdict(self)


PROTOCOLS: dict[Letter, Protocol] = {
    protocol.letter: protocol
    for protocol in (
        Protocol(
            letter="M",
            title="linear spheres in the photo's exposure",
            azimuths=8,
            pitch_deg=-8.0,
            fov_deg=60.0,
            exposure="view",
            scene="M",
            measures=("rmse", "si_rmse", "geometric"),
        ),
        Protocol(
            letter="S",
            title="spheres under encoded maps, as StyleLight and DiffusionLight render them",
            azimuths=1,
            pitch_deg=0.0,
            # 60 degrees high at 4:3.
            fov_deg=math.degrees(2 * math.atan(math.tan(math.radians(30)) * 4 / 3)),
            exposure="panorama",
            encoding="display",
            scene="S",
            measures=("rmse", "si_rmse", "angle_deg", "normalised_rmse"),
            divisor="pixels",
        ),
        Protocol(
            letter="L",
            title="light sources: where they are and how strong",
            azimuths=8,
            pitch_deg=-8.0,
            fov_deg=60.0,
            exposure="view",
            lights=True,
        ),
    )
}


def find(letter: str) -> Protocol:
    """The protocol of that letter.

    Raises:
        ValueError: there is none.

    >>> find("S").azimuths
    1
    """
    for known in get_args(Letter):
        if letter == known:
            return PROTOCOLS[known]
    raise ValueError(f"expected a protocol out of {', '.join(PROTOCOLS)}, got {letter!r}")
