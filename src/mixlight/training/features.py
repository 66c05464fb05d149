"""Features of a frozen backbone on fixed views, computed once: heads then train in seconds on a CPU.

A comparison of many heads needs many runs. Where the backbone is the same and is not trained, its features
need not be computed again for each.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as to_bytes
from torch import Tensor
from tqdm import tqdm

from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.training_set import TrainingSet
from mixlight.image.atomic import atomic_path
from mixlight.network.backbones import Backbone
from mixlight.network.model import mean_linear_colour
from mixlight.training.config import TrainingConfig, to_plain

_LOG = logging.getLogger(__name__)
_VERSION = 1  # raised whenever the meaning of the cached numbers changes
_CHUNK = 32
_SEED = 0
"""Of the views: the same for every run, whatever its own seed."""


@dataclass(frozen=True)
class FeatureBatch:
    """What the backbone makes of photos, and the light around each, as in
    `mixlight.data.training_set.Batch`.
    """

    features: Float[Tensor, "batch channels rows columns"]
    """The backbone's feature map."""
    mean: Float[Tensor, "batch 3"]
    """The photos' mean linear colour."""
    anchor_energy: Float[Tensor, "batch anchors 3"]
    """Integrated radiance of the sources at each anchor."""
    ambient: Float[Tensor, "batch 9 3"]
    """Radiance SH of the ambient light."""
    small_map: Float[Tensor, "batch map_height map_width 3"]
    """The whole environment, small."""
    camera: Float[Tensor, "batch 2"]
    """Pitch and roll in radians."""


class FeatureBank:
    """Fixed views as features; batches are drawn from them by seed and step, as `TrainingSet` draws views."""

    records: Sequence[PanoramaRecord]
    """The panoramas that the views are of."""

    def __init__(self, views: FeatureBatch, records: Sequence[PanoramaRecord]) -> None:
        """Takes all views as one large batch; features may be float16."""
        self.views, self.records = views, records

    def __len__(self) -> int:
        """Number of views."""
        return len(self.views.mean)

    def batch(self, seed: int, step: int, size: int) -> FeatureBatch:
        """Draws the views of one step, each at most once; the same arguments give the same batch."""
        generator = np.random.default_rng((seed, step))
        chosen = torch.from_numpy(generator.choice(len(self), min(size, len(self)), replace=False))
        return FeatureBatch(
            **{f.name: getattr(self.views, f.name)[chosen].float() for f in fields(FeatureBatch)}
        )

    @classmethod
    def make(cls, training_set: TrainingSet, backbone: Backbone, count: int) -> FeatureBank:
        """Photographs `count` views and runs the backbone on them, without dropping any of its branches."""
        backbone.eval()
        device = next(backbone.parameters()).device
        parts: list[tuple[Tensor, ...]] = []
        with (
            torch.inference_mode(),
            tqdm(total=count, unit="view", desc="features", disable=None) as progress,
        ):
            for step in range(-(-count // _CHUNK)):
                batch = training_set.batch(_SEED, step, min(_CHUNK, count - step * _CHUNK))
                features = backbone(batch.photo.to(device)).half().cpu()
                mean = mean_linear_colour(batch.photo)
                parts.append(
                    (features, mean, batch.anchor_energy, batch.ambient, batch.small_map, batch.camera)
                )
                progress.update(len(mean))
        views = FeatureBatch(*(torch.cat(column).clone() for column in zip(*parts, strict=True)))
        return cls(views, training_set.records)


def cached_bank(
    config: TrainingConfig,
    records: Sequence[PanoramaRecord],
    backbone: Backbone,
    make_set: Callable[[], TrainingSet],
    cache: Path,
) -> FeatureBank:
    """Reads the bank of a config from the cache, or makes it and leaves it there.

    The key holds all that views, labels and features depend on: panoramas, their settings, and the backbone's
    weights. A damaged entry is made anew; a cache that cannot be written costs time only.

    Args:
        config: of the run; `frozen_views` is the number of views.
        records: training panoramas.
        backbone: with its weights.
        make_set: makes the training set, which takes a while, where there is no entry.
        cache: folder of the labels' cache; banks lie beside them.
    """
    entry = cache.parent / "features" / f"{_digest(config, records, backbone)}.safetensors"
    seen = [r for r in records if config.sampling.weights.get(r.category, 1.0) > 0]
    try:
        with safe_open(entry, "pt") as stored:
            return FeatureBank(
                FeatureBatch(**{f.name: stored.get_tensor(f.name) for f in fields(FeatureBatch)}), seen
            )
    except FileNotFoundError:
        pass
    except (SafetensorError, OSError) as error:
        _LOG.warning("%s: damaged, made anew (%s)", entry, error)
    bank = FeatureBank.make(make_set(), backbone, config.frozen_views)
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(entry) as temporary:
            tensors = {f.name: getattr(bank.views, f.name).contiguous() for f in fields(FeatureBatch)}
            temporary.write_bytes(to_bytes(tensors))
    except (SafetensorError, OSError) as error:
        _LOG.warning("%s: features are not kept (%s)", entry.parent, error)
    return bank


def _digest(config: TrainingConfig, records: Sequence[PanoramaRecord], backbone: Backbone) -> str:
    plain = to_plain(config)
    model = {k: plain["model"][k] for k in ("backbone", "height", "width", "fov_deg")}
    settings = [plain[k] for k in ("labels", "crops", "camera", "sampling", "frozen_views")]
    files = [(r.scene, r.category, r.path.stat().st_size) for r in records]
    digest = hashlib.sha256(repr((_VERSION, model, settings, files)).encode())
    for name, tensor in sorted(backbone.state_dict().items()):
        digest.update(name.encode() + tensor.detach().cpu().contiguous().numpy().tobytes())
    return digest.hexdigest()[:16]
