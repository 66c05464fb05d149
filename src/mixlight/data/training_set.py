"""Training batches: random views of panoramas through random cameras, with the light of each.

A batch is a pure function of (seed, step), so that a resumed run sees exactly what an unbroken one would.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.camera_model import GAIN_RANGE, CameraSettings, random_photo
from mixlight.data.crops import CropSettings, frame_mask, random_crop, take_view
from mixlight.data.labels import LabelSettings, LightLabels, cached_labels
from mixlight.data.panoramas import PanoramaRecord, load_panorama
from mixlight.data.relit import has_groups, relightings
from mixlight.data.rooms.remix import white_balance_gain
from mixlight.data.viewpoints import moved, random_move
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

_TRIES = 20
"""Views drawn before a sample is given up; each has its own panorama and exposure."""


@dataclass(frozen=True)
class Batch:
    """Photos and the light around each, in the photo's own exposure.

    Convention: radiance 1.0 is the photo's linear white; the map's centre (-Z) is the photo's azimuth, the
        horizon is level.
    """

    photo: Float[Tensor, "batch 3 height width"]
    """sRGB-encoded photos in [0, 1]."""
    anchor_energy: Float[Tensor, "batch anchors 3"]
    """Integrated radiance of the sources at each anchor."""
    ambient: Float[Tensor, "batch 9 3"]
    """Radiance SH of the ambient light."""
    small_map: Float[Tensor, "batch map_height map_width 3"]
    """The whole environment, small: linear radiance."""
    camera: Float[Tensor, "batch 2"]
    """Pitch and roll in radians, up and clockwise."""


@dataclass(frozen=True)
class SamplingSettings:
    """How often each kind of panorama is drawn, and how rendered rooms are made to look photographed."""

    weights: Mapping[str, float] = field(
        default_factory=lambda: {"indoor": 1.0, "studio": 1.0, "covered": 1.0, "outdoor": 0.25, "room": 1.0}
    )
    """Relative frequency of one panorama of each category; 0 leaves the category out. Every category of the
    tables needs one."""
    moved_real: int = 0
    """Further viewpoints made from each real panorama but outdoor ones (`mixlight.data.viewpoints`)."""
    moved_rooms: int = 0
    """The same for each rendered room."""
    remixes_rooms: int = 0
    """Further relightings made from each position of a rendered room that was stored with its light groups
    (`mixlight.data.relit`): other lamps, another time of day, exact. Others have none."""
    room_white_balance: tuple[float, float] = (0.6, 1.0)
    """Rendered rooms are not white-balanced: the share of their mean colour cast that is taken out."""

    def __post_init__(self) -> None:
        for name in ("moved_real", "moved_rooms", "remixes_rooms"):
            if getattr(self, name) < 0:
                raise ValueError(f"expected {name} of at least 0, got {getattr(self, name)}")
        for category, weight in self.weights.items():
            if not weight >= 0:
                raise ValueError(f"expected a weight of at least 0 for {category}, got {weight}")
        low, high = self.room_white_balance
        if not 0 <= low <= high <= 1:
            raise ValueError(
                f"expected room_white_balance from a lower to a higher share in [0, 1], got {[low, high]}"
            )


class TrainingSet:
    """All training panoramas in memory, with their labels."""

    records: list[PanoramaRecord]
    """The panoramas that are trained on, each once, however many viewpoints are made from it."""

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

        Args:
            records: training panoramas; those whose category weighs 0 are left out.
            canonical: the view that the network takes.
            labels: how panoramas become targets.
            cache: folder in which labels are kept between runs.
            crops: which views are taken.
            camera: how they are photographed.
            sampling: how often each kind of panorama is drawn.

        Raises:
            ValueError: a category without a weight, no record with a weight above 0, or a file that is no
                panorama of radiance.
            OSError: a file cannot be read.
        """
        self.canonical = canonical
        self.azimuths = labels.azimuths
        self.crops = crops or CropSettings()
        self.camera = camera or CameraSettings()
        self.sampling = sampling or SamplingSettings()
        weights = self.sampling.weights
        unknown = sorted({r.category for r in records} - set(weights))
        if unknown:
            raise ValueError(
                f"expected a weight for every category of the panoramas, got none for {', '.join(unknown)} "
                f"(0 leaves a category out); weights are {dict(weights)}"
            )
        records = [r for r in records if weights[r.category] > 0]
        if not records:
            raise ValueError(
                f"expected training panoramas of a category with a weight in {dict(weights)}, got none"
            )
        self.records = records
        self._seen: list[PanoramaRecord] = []
        """The record behind each viewpoint."""
        self._panoramas: list[Tensor] = []
        self._labels: list[LightLabels] = []
        shares = []
        for record in records:
            views = list(self._views(record, cache))
            for variant, seen in views:
                self._seen.append(record)
                self._labels.append(cached_labels(record.path, seen.float(), labels, cache, variant))
                # Half precision halves memory; light above its range still counts in the labels.
                self._panoramas.append(seen if seen.dtype == torch.half else seen.clamp(max=6e4).half())
                shares.append(weights[record.category] / len(views))
        share = np.array(shares, dtype=np.float64)
        self._share = share / share.sum()

    def batch(self, seed: int, step: int, size: int) -> Batch:
        """Makes the batch of one step; the same arguments give the same batch, in any process.

        Raises:
            ValueError: a negative seed or step; no usable exposure in many tries, as of panoramas that are
                almost black.
        """
        samples = [self._sample(np.random.default_rng((seed, step, i))) for i in range(size)]
        photo, energy, ambient, small_map, pose = (torch.stack(parts) for parts in zip(*samples, strict=True))
        return Batch(photo, energy, ambient, small_map, pose)

    def _sample(self, generator: np.random.Generator) -> tuple[Tensor, ...]:
        for _ in range(_TRIES):
            index = int(generator.choice(len(self._seen), p=self._share))
            crop = random_crop(self.azimuths, self.crops, generator, self.canonical.fov)
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
        raise ValueError(
            f"{self._seen[index].path}: expected views that an exposure gain between {GAIN_RANGE[0]:g} and "
            f"{GAIN_RANGE[1]:g} can show, got none in {_TRIES} tries on this and other panoramas; are they "
            "almost black, or on another scale?"
        )

    def _views(self, record: PanoramaRecord, cache: Path) -> Iterator[tuple[str, Tensor]]:
        """The panorama of a record and what is made from it, each under a name of its own."""
        panorama = load_panorama(record.path)
        yield "", panorama
        for copy in range(1, 1 + self._copies(record)):
            # The scene's name, not its place in the table, so that adding a row changes no other panorama.
            move = random_move(np.random.default_rng((copy, *record.scene.encode())))
            yield f"moved {move}", moved(panorama, *move)
        if record.category == "room" and self.sampling.remixes_rooms and has_groups(record):
            yield from relightings(record, self.sampling.remixes_rooms, cache)

    def _copies(self, record: PanoramaRecord) -> int:
        """How many further viewpoints are made of a panorama; the sphere model does not fit the open."""
        if record.category == "room":
            return self.sampling.moved_rooms
        return 0 if record.category == "outdoor" else self.sampling.moved_real

    def _white_balance(self, index: int, generator: np.random.Generator) -> Tensor:
        """Channel gains that take part of a rendered room's colour cast out, keeping the mean's luminance."""
        if self._seen[index].category != "room":
            return torch.ones(3)
        mean = equirect.integrate(self._labels[index].small_map)
        return white_balance_gain(mean, generator.uniform(*self.sampling.room_white_balance))
