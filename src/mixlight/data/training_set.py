"""Training batches: random views of panoramas through random cameras, with the light of each.

A batch is a pure function of (seed, step), so that a resumed run sees exactly what an unbroken one would.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.camera_model import CameraSettings, random_photo
from mixlight.data.crops import CropSettings, frame_mask, random_crop, take_view
from mixlight.data.labels import LabelSettings, LightLabels, cached_labels
from mixlight.data.panoramas import PanoramaRecord, load_panorama
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

_TRIES = 20


@dataclass(frozen=True)
class Batch:
    """Photos and the light around each, in the photo's own exposure."""

    photo: Float[Tensor, "batch 3 height width"]
    """sRGB-encoded photos in [0, 1]."""
    anchor_energy: Float[Tensor, "batch anchors 3"]
    """Integrated radiance of the sources at each anchor."""
    ambient: Float[Tensor, "batch 9 3"]
    """Radiance SH of the ambient light."""
    small_map: Float[Tensor, "batch map_height map_width 3"]
    """The whole environment, small."""
    camera: Float[Tensor, "batch 2"]
    """Pitch and roll in radians."""


@dataclass(frozen=True)
class SamplingSettings:
    """How often each kind of panorama is drawn, and how rendered rooms are made to look photographed."""

    weights: Mapping[str, float] = field(
        default_factory=lambda: {"indoor": 1.0, "studio": 1.0, "covered": 1.0, "outdoor": 0.25, "room": 1.0}
    )
    """Relative frequency of one panorama of each category; 0 leaves the category out."""
    room_white_balance: tuple[float, float] = (0.6, 1.0)
    """Rendered rooms are not white-balanced: the share of their mean colour cast that is taken out."""


class TrainingSet:
    """All training panoramas in memory, with their labels."""

    def __init__(
        self,
        records: Sequence[PanoramaRecord],
        canonical: CanonicalView,
        labels: LabelSettings,
        cache: Path,
        crops: CropSettings | None = None,
        camera: CameraSettings | None = None,
        sampling: SamplingSettings | None = None,
    ) -> None:
        """Loads the panoramas (512 rows at most) and makes or reads their labels.

        Raises:
            ValueError: no record has a positive weight.
        """
        self.canonical = canonical
        self.azimuths = labels.azimuths
        self.crops = crops or CropSettings()
        self.camera = camera or CameraSettings()
        self.sampling = sampling or SamplingSettings()
        records = [r for r in records if self.sampling.weights.get(r.category, 0) > 0]
        if not records:
            raise ValueError(
                f"expected training panoramas of a category with weight > 0 in {dict(self.sampling.weights)}, got none"
            )
        self.records = records
        self._panoramas: list[Tensor] = []
        self._labels: list[LightLabels] = []
        for record in records:
            panorama = load_panorama(record.path)
            self._labels.append(cached_labels(record.path, panorama, labels, cache))
            # Half precision halves memory; light above its range still counts in the labels.
            self._panoramas.append(panorama.clamp(max=6e4).half())
        share = np.array([self.sampling.weights[r.category] for r in records], dtype=np.float64)
        self._share = share / share.sum()

    def batch(self, seed: int, step: int, size: int) -> Batch:
        """Makes the batch of one step; the same arguments give the same batch."""
        samples = [self._sample(np.random.default_rng((seed, step, i))) for i in range(size)]
        photo, energy, ambient, small_map, pose = (torch.stack(parts) for parts in zip(*samples, strict=True))
        return Batch(photo, energy, ambient, small_map, pose)

    def _sample(self, generator: np.random.Generator) -> tuple[Tensor, ...]:
        for _ in range(_TRIES):
            index = int(generator.choice(len(self.records), p=self._share))
            crop = random_crop(self.azimuths, self.crops, generator)
            view = take_view(self._panoramas[index].float(), crop, self.canonical)
            cast = self._white_balance(index, generator)
            inside = frame_mask(crop, self.canonical)
            exposed = random_photo(view * cast, inside, self.camera, generator)
            if exposed is None:
                continue
            energy, ambient, small_map = self._labels[index].at(crop.azimuth, crop.mirrored)
            gain = cast * exposed.gain
            roll = -crop.roll if crop.mirrored else crop.roll
            return (
                exposed.photo.permute(2, 0, 1),
                energy * gain,
                ambient * gain,
                small_map * gain,
                torch.tensor([crop.pitch, roll]),
            )
        raise RuntimeError(
            f"no view with a usable exposure in {_TRIES} tries; are the panoramas almost black? "
            f"last: {self.records[index].path}"
        )

    def _white_balance(self, index: int, generator: np.random.Generator) -> Tensor:
        """Channel gains that take part of a rendered room's colour cast out, keeping the mean's luminance."""
        if self.records[index].category != "room":
            return torch.ones(3)
        mean = equirect.integrate(self._labels[index].small_map).clamp(min=1e-6)
        weights = torch.tensor([0.2126, 0.7152, 0.0722])
        cast = (mean @ weights / mean) ** generator.uniform(*self.sampling.room_white_balance)
        return cast * (mean @ weights) / ((mean * cast) @ weights)
