"""What a network of each method learns: the truth in its own terms, where it starts, and its loss."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from mixlight.data.training_set import Batch
from mixlight.light import functions, lamps
from mixlight.light.separate import luminance, separate
from mixlight.loss.expanded import ExpandedLoss
from mixlight.loss.lamps import LampLoss
from mixlight.loss.total import TotalLoss
from mixlight.network.methods import AnyNet
from mixlight.network.settings import ANCHORED
from mixlight.training.config import TrainingConfig
from mixlight.training.features import FeatureBatch

Terms = tuple[Float[Tensor, ""], dict[str, Tensor]]


@dataclass(frozen=True)
class Truth:
    """True light of a batch of photos, in the photos' exposure (see `mixlight.data.training_set.Batch`)."""

    anchor_energy: Float[Tensor, "batch anchors 3"]
    ambient: Float[Tensor, "batch 9 3"]
    small_map: Float[Tensor, "batch height width 3"]
    camera: Float[Tensor, "batch 2"]

    def to(self, device: torch.device) -> Truth:
        """On another device."""
        parts = (self.anchor_energy, self.ambient, self.small_map, self.camera)
        return Truth(*(part.to(device) for part in parts))

    @classmethod
    def joined(cls, parts: Sequence[Truth]) -> Truth:
        """Several batches as one."""
        names = [field.name for field in fields(cls)]
        return cls(**{name: torch.cat([getattr(part, name) for part in parts]) for name in names})

    def scaled(self, gain: Float[Tensor, "batch 3"]) -> Truth:
        """The same light with every channel multiplied by a gain."""
        gain = gain[:, None]
        small_map = self.small_map * gain[:, None]
        return Truth(self.anchor_energy * gain, self.ambient * gain, small_map, self.camera)


def truth_of(batch: Batch | FeatureBatch) -> Truth:
    """The light of a batch."""
    return Truth(batch.anchor_energy, batch.ambient, batch.small_map, batch.camera)


class Objective(nn.Module, ABC):
    """The loss of one method. Targets that a batch does not hold are read off its small map."""

    def __init__(self, config: TrainingConfig) -> None:
        super().__init__()
        self.settings = config.model
        self.separation, self.fraction = config.labels.separation, config.labels.fraction

    @abstractmethod
    def forward(self, light: Any, truth: Truth, unit: Tensor | None, progress: float) -> Terms:
        """The loss and its terms; `progress` is the share of the run that is done."""

    @abstractmethod
    def start(self, model: AnyNet, truth: Truth) -> None:
        """Sets the heads' biases to the mean of some light that is given relative to the photos' mean
        colours.
        """

    def ambient(self, truth: Truth) -> Float[Tensor, "batch k 3"]:
        """The true ambient light in the settings' functions."""
        if self.settings.ambient == "sh2":
            return truth.ambient
        if self.settings.ambient == "constant":
            return truth.ambient[:, :1]
        return functions.project(self._separated(truth)[1], self.settings.ambient)

    def _separated(self, truth: Truth) -> tuple[Tensor, Tensor]:
        return separate(truth.small_map, self.separation, self.fraction)


class AnchorObjective(Objective):
    """Sources on anchors."""

    def __init__(self, config: TrainingConfig) -> None:
        super().__init__(config)
        model = config.model
        self.loss = TotalLoss(
            config.loss, model.anchors, model.sharpness, config.labels.map_height, model.ambient
        )

    def forward(self, light: Any, truth: Truth, unit: Tensor | None, progress: float) -> Terms:
        """As `TotalLoss`."""
        result: Terms = self.loss(
            light.scores,
            light.distribution,
            light.intensity,
            light.colour,
            light.ambient,
            light.camera,
            truth.anchor_energy,
            self.ambient(truth),
            truth.small_map,
            truth.camera,
            unit,
        )
        return result

    def start(self, model: AnyNet, truth: Truth) -> None:
        """Mean distribution, and geometric means of intensity and colour."""
        share = luminance(truth.anchor_energy)
        share = share / share.sum(-1, keepdim=True).clamp(min=1e-9)
        total = truth.anchor_energy.sum(1).clamp(min=1e-6)
        model.heads.start_from(  # type: ignore[operator]
            share.mean(0),
            float(total.norm(dim=-1).log().mean()),
            total.log().mean(0) - total.log().mean(),
            mean_expansion(self.ambient(truth), self.settings.ambient),
            truth.camera.mean(0),
        )


class ExpandedObjective(Objective):
    """Sources in harmonics of degree 6."""

    def __init__(self, config: TrainingConfig) -> None:
        super().__init__(config)
        self.loss = ExpandedLoss(config.loss, config.labels.map_height, config.model.ambient)

    def forward(self, light: Any, truth: Truth, unit: Tensor | None, progress: float) -> Terms:
        """As `ExpandedLoss`."""
        result: Terms = self.loss(
            light.sources,
            light.ambient,
            light.camera,
            self._sources(truth),
            self.ambient(truth),
            truth.small_map,
            truth.camera,
            unit,
        )
        return result

    def start(self, model: AnyNet, truth: Truth) -> None:
        """Mean shape and geometric mean level of sources and ambient light."""
        model.heads.start_from(  # type: ignore[operator]
            mean_expansion(self._sources(truth), "sh6"),
            mean_expansion(self.ambient(truth), self.settings.ambient),
            truth.camera.mean(0),
        )

    def _sources(self, truth: Truth) -> Tensor:
        return functions.project(self._separated(truth)[0], "sh6")


class LampObjective(Objective):
    """A few free lamps in constant light."""

    def __init__(self, config: TrainingConfig) -> None:
        super().__init__(config)
        self.loss = LampLoss(config.loss, config.lamps, config.labels.map_height)

    def forward(self, light: Any, truth: Truth, unit: Tensor | None, progress: float) -> Terms:
        """As `LampLoss`."""
        result: Terms = self.loss(
            light.lamps(),
            light.camera,
            lamps.find(truth.small_map),
            truth.small_map,
            truth.camera,
            unit,
            progress,
        )
        return result

    def start(self, model: AnyNet, truth: Truth) -> None:
        """Lamps around the mean direction of all true ones, in their mean size and energy.

        They need to differ, or every lamp would learn the same: they stand 40 degrees apart.
        """
        found = lamps.find(truth.small_map)
        lit = found.energy.sum(-1) > 0
        mean = functional.normalize(found.direction[lit].mean(0), dim=0)
        count = found.energy.shape[1]
        side = functional.normalize(
            torch.linalg.cross(mean, mean.roll(1) + torch.tensor([0.0, 0, 1e-3])), dim=0
        )
        other = torch.linalg.cross(mean, side)
        angle = 2 * torch.pi * torch.arange(count) / count
        ring = angle.cos()[:, None] * side + angle.sin()[:, None] * other
        model.heads.start_from(  # type: ignore[operator]
            functional.normalize(mean + 0.4 * ring, dim=-1),
            found.sharpness[lit].log().mean().exp().expand(count),
            found.energy[lit].clamp(min=1e-4).log().mean(0).exp().expand(count, 3),
            found.ambient.clamp(min=1e-4).log().mean(0).exp(),
            truth.camera.mean(0),
        )


def make_objective(config: TrainingConfig) -> Objective:
    """The objective for the kind of sources that the config's model has."""
    if config.model.sources in ANCHORED:
        return AnchorObjective(config)
    return LampObjective(config) if config.model.sources == "lamps" else ExpandedObjective(config)


def mean_expansion(
    coefficients: Float[Tensor, "batch k 3"], name: functions.Functions
) -> Float[Tensor, "k 3"]:
    """Mean of the coefficients relative to their level, times the geometric mean of the levels.

    >>> mean_expansion(torch.tensor([[[1.0] * 3, [0.5] * 3], [[4.0] * 3, [0.0] * 3]]), "sh2")[:, 0]
    tensor([2.0000, 0.5000])
    """
    level = coefficients.mean(1) if name == "sg9" else coefficients[:, 0]
    level = level.clamp(min=1e-4)
    base = level.log().mean(0).exp()
    shape = (coefficients / level[:, None]).mean(0) * base
    return shape if name == "sg9" else torch.cat([base[None], shape[1:]])
