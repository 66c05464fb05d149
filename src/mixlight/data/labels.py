"""The true light of a panorama for every azimuth, made once and cached."""

from __future__ import annotations

import hashlib
import logging
from dataclasses import dataclass, fields
from pathlib import Path

import torch
from jaxtyping import Float
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as to_bytes
from torch import Tensor

from mixlight.image.atomic import atomic_path
from mixlight.image.cache import cache_folder
from mixlight.light import harmonics, separate
from mixlight.sphere import equirect, frames, points

_VERSION = 2  # raised whenever the meaning of the cached numbers changes
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class LabelSettings:
    """How a panorama becomes numbers."""

    separation: separate.Method = "top_fraction"
    """`top_fraction` or `max_fraction` (method: which texels are sources)."""
    fraction: float = 0.05
    """The fraction of that rule."""
    anchors: int = 128
    """Number of source directions."""
    azimuths: int = 64
    """Number of equally spaced viewing azimuths."""
    height: int = 128
    """Height of the map on which sources and ambient light are separated."""
    map_height: int = 32
    """Height of the small map for the render loss; its width has to be a multiple of `azimuths`."""

    def __post_init__(self) -> None:
        separate.check_rule(self.separation, self.fraction)
        for name in ("anchors", "azimuths", "height", "map_height"):
            if getattr(self, name) < 1:
                raise ValueError(f"expected {name} of at least 1, got {getattr(self, name)}")
        for name in ("height", "map_height"):
            rows = getattr(self, name)
            if 2 * rows % self.azimuths:
                raise ValueError(
                    f"expected {name} whose double is a multiple of azimuths = {self.azimuths}, got {rows}"
                )


@dataclass(frozen=True)
class LightLabels:
    """The light of one panorama, for `azimuths` viewing directions, as it is and mirrored left to right.

    Everything is linear in the panorama's radiance, so that a gain of the photo (one number or one
    per channel) is applied by multiplication.

    Convention: azimuth k looks 2 pi k / azimuths to the right of the panorama's centre, and its labels are
        those of `rotate_azimuth(panorama, 2 pi k / azimuths)`: with 64 azimuths, light at +X is straight
        ahead (-Z) at azimuth 16. Row 0 holds the light as it is, row 1 with left and right exchanged after
        the turn.
    """

    anchor_energy: Float[Tensor, "2 azimuths anchors 3"]
    """Integrated radiance (radiance times steradian) of the source texels nearest to each anchor."""
    ambient: Float[Tensor, "2 azimuths 9 3"]
    """Radiance SH coefficients of what remains."""
    small_map: Float[Tensor, "height width 3"]
    """The whole panorama, energy-preserving, at the render loss's size."""

    def at(
        self, azimuth: int, mirrored: bool
    ) -> tuple[Float[Tensor, "anchors 3"], Float[Tensor, "9 3"], Float[Tensor, "height width 3"]]:
        """Anchor energy, ambient coefficients and small map as seen at one azimuth, in the panorama's units.

        Raises:
            IndexError: no such azimuth.
        """
        count = self.anchor_energy.shape[1]
        small = self.small_map.roll(-azimuth * (self.small_map.shape[1] // count), 1)
        small = equirect.mirror(small) if mirrored else small
        row = int(mirrored)
        return self.anchor_energy[row, azimuth], self.ambient[row, azimuth], small


def make_labels(panorama: Float[Tensor, "height width 3"], settings: LabelSettings) -> LightLabels:
    """Separates the panorama once and reads the light off for every azimuth, plain and mirrored.

    Turning by a whole number of texels moves source texels to other anchors exactly; the ambient
    coefficients are rotated analytically.

    Raises:
        ValueError: no panorama of radiance (not 2:1, not finite, negative).

    >>> panorama = torch.zeros(16, 32, 3)
    >>> panorama[7, 24] = 10.0  # at +X, a little above the horizon
    >>> settings = LabelSettings(height=16, map_height=8, azimuths=16)
    >>> energy, ambient, small = make_labels(panorama, settings).at(4, mirrored=False)
    >>> points.vogel(128)[energy[:, 0].argmax()]  # after a quarter turn to the right it lies ahead
    tensor([ 0.0506,  0.1328, -0.9898])
    """
    height, count = settings.height, settings.azimuths
    panorama = equirect.resize(panorama, height)
    sources, ambient = separate.separate(panorama, settings.separation, settings.fraction)
    row, column = sources.sum(-1).nonzero(as_tuple=True)
    solid_angle = equirect.solid_angle(height)
    energy = (sources[row, column] * solid_angle[row, column, None]).float()
    nearest = points.anchor_map(settings.anchors, height)
    step, width = 2 * height // count, 2 * height

    anchor_energy = torch.zeros(2, count, settings.anchors, 3)
    rotated = torch.zeros(2, count, 9, 3)
    coefficients = harmonics.project(ambient, 2).float()
    for k in range(count):
        seen = (column - k * step) % width
        anchor_energy[0, k].index_add_(0, nearest[row, seen], energy)
        anchor_energy[1, k].index_add_(0, nearest[row, width - 1 - seen], energy)
        # The light turns left when the viewer turns right.
        turn = frames.rotation(-2 * torch.pi * k / count)
        rotated[0, k] = harmonics.rotate(coefficients, turn)
        rotated[1, k] = harmonics.mirror(rotated[0, k])
    return LightLabels(anchor_energy, rotated, equirect.resize(panorama, settings.map_height).float())


def cached_labels(
    path: Path,
    panorama: Float[Tensor, "height width 3"],
    settings: LabelSettings,
    cache: Path,
    variant: str = "",
) -> LightLabels:
    """Reads the labels of a panorama file from the cache, or makes them and leaves them there.

    The key holds the file's content, the size it was loaded at, what was made of it since (`variant`), every
    setting and the version of this module, so that a changed file or setting is never served old labels. A
    damaged entry is made anew. A cache that cannot be written costs time only, and a warning in the log.

    Raises:
        ValueError: as `make_labels`.
        OSError: the panorama's file may not be read.
    """
    with path.open("rb") as content:
        digest = hashlib.file_digest(content, "sha256")
    key = (_VERSION, variant, tuple(panorama.shape), [getattr(settings, f.name) for f in fields(settings)])
    digest.update(repr(key).encode())
    entry = cache / f"{path.stem}-{digest.hexdigest()[:16]}.safetensors"
    try:
        with safe_open(entry, "pt") as stored:
            return LightLabels(**{f.name: stored.get_tensor(f.name) for f in fields(LightLabels)})
    except FileNotFoundError:
        pass
    except (SafetensorError, OSError) as error:
        _LOG.warning("%s: damaged, made anew (%s)", entry, error)
    labels = make_labels(panorama, settings)
    try:
        cache.mkdir(parents=True, exist_ok=True)
        with atomic_path(entry) as temporary:
            tensors = {f.name: getattr(labels, f.name).contiguous() for f in fields(labels)}
            temporary.write_bytes(to_bytes(tensors))
    except (SafetensorError, OSError) as error:
        _LOG.warning("%s: labels are not kept (%s)", cache, error)
    return labels


def default_cache() -> Path:
    """The user's cache folder for labels."""
    return cache_folder("labels")
