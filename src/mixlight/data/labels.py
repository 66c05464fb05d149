"""The true light of a panorama for every azimuth, made once and cached."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, fields
from pathlib import Path

import torch
from jaxtyping import Float
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor

from mixlight.image.atomic import atomic_path
from mixlight.light import harmonics, separate
from mixlight.sphere import equirect, frames, points

_VERSION = 2  # raised whenever the meaning of the cached numbers changes


@dataclass(frozen=True)
class LabelSettings:
    """How a panorama becomes numbers."""

    separation: str = "top_fraction"
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
        for name, width in (("height", 2 * self.height), ("map_height", 2 * self.map_height)):
            if width % self.azimuths:
                raise ValueError(
                    f"expected {name} whose double is a multiple of azimuths = {self.azimuths}, got {width // 2}"
                )


@dataclass(frozen=True)
class LightLabels:
    """The light of one panorama, for `azimuths` viewing directions, as it is and mirrored left to right.

    Everything is linear in the panorama's radiance, so that a gain of the photo (one number or one
    per channel) is applied by multiplication. Azimuth k looks 2 pi k / azimuths to the right of the
    panorama's centre.
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
        """Anchor energy, ambient coefficients and small map as seen at one azimuth."""
        count = self.anchor_energy.shape[1]
        small = self.small_map.roll(-azimuth * (self.small_map.shape[1] // count), 1)
        small = equirect.mirror(small) if mirrored else small
        row = int(mirrored)
        return self.anchor_energy[row, azimuth], self.ambient[row, azimuth], small


def make_labels(panorama: Float[Tensor, "height width 3"], settings: LabelSettings) -> LightLabels:
    """Separates the panorama once and reads the light off for every azimuth, plain and mirrored.

    Turning by a whole number of texels moves source texels to other anchors exactly; the ambient
    coefficients are rotated analytically.
    """
    height, count = settings.height, settings.azimuths
    panorama = equirect.resize(panorama, height)
    sources, ambient = separate.separate(panorama, settings.separation, settings.fraction)
    row, column = sources.sum(-1).nonzero(as_tuple=True)
    solid_angle = equirect.solid_angle(height)
    energy = sources[row, column] * solid_angle[row, column, None]
    nearest = points.anchor_map(settings.anchors, height)
    step, width = 2 * height // count, 2 * height

    anchor_energy = torch.zeros(2, count, settings.anchors, 3)
    rotated = torch.zeros(2, count, 9, 3)
    coefficients = harmonics.project(ambient, 2)
    for k in range(count):
        seen = (column - k * step) % width
        anchor_energy[0, k].index_add_(0, nearest[row, seen], energy)
        anchor_energy[1, k].index_add_(0, nearest[row, width - 1 - seen], energy)
        # The light turns left when the viewer turns right.
        turn = frames.rotation(-2 * torch.pi * k / count)
        rotated[0, k] = harmonics.rotate(coefficients, turn)
        rotated[1, k] = harmonics.mirror(rotated[0, k])
    return LightLabels(anchor_energy, rotated, equirect.resize(panorama, settings.map_height))


def cached_labels(
    path: Path, panorama: Float[Tensor, "height width 3"], settings: LabelSettings, cache: Path
) -> LightLabels:
    """Reads the labels of a panorama file from the cache, or makes them and leaves them there.

    The key holds the file's content, every setting and the version of this module, so that a changed
    file or setting is never served old labels. A damaged cache entry is made anew.
    """
    digest = hashlib.sha256(path.read_bytes())
    digest.update(repr((_VERSION, [getattr(settings, f.name) for f in fields(settings)])).encode())
    entry = cache / f"{path.stem}-{digest.hexdigest()[:16]}.safetensors"
    if entry.is_file():
        try:
            with safe_open(entry, "pt") as stored:
                return LightLabels(**{f.name: stored.get_tensor(f.name) for f in fields(LightLabels)})
        except (SafetensorError, OSError):
            entry.unlink()
    labels = make_labels(panorama, settings)
    cache.mkdir(parents=True, exist_ok=True)
    with atomic_path(entry) as temporary:
        save_file({f.name: getattr(labels, f.name).contiguous() for f in fields(labels)}, temporary)
    return labels


def default_cache() -> Path:
    """The user's cache folder for labels: `$XDG_CACHE_HOME/mixlight/labels` or below `~/.cache`."""
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "mixlight" / "labels"
