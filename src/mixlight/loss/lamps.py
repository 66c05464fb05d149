"""The objective for a few free lamps, in two stages: first the whole map, then lamp by lamp (Gardner
2019).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from mixlight.light.lamps import Lamps, environment
from mixlight.loss.common import LightLoss, LossWeights, huber
from mixlight.loss.sources import colour_loss


@dataclass(frozen=True)
class LampWeights:
    """Weight of each term on lamps; those on ambient light, spheres and camera are in `LossWeights`."""

    first_stage: float = 0.3
    """Share of the steps in which the rendered map alone teaches the lamps: nothing says yet which lamp is
    which."""
    environment: float = 1.0
    """Mean squared error of the rendered small map (in both stages)."""
    direction: float = 1.0
    """Squared distance of matched unit vectors."""
    size: float = 0.1
    """Squared error of log s of matched lamps."""
    intensity: float = 0.1
    """Squared error of the log energy of matched lamps."""
    colour: float = 0.3
    """Squared distance of the matched lamps' unit colours."""

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) >= 0:
                raise ValueError(f"expected {field.name} of at least 0, got {getattr(self, field.name)}")
        if self.first_stage > 1:
            raise ValueError(f"expected first_stage of at most 1, got {self.first_stage}")


class LampLoss(LightLoss):
    """Lamps and constant ambient light, weighed as `LightLoss` says.

    Lamps have no order, so predicted and true ones are matched by the assignment of the least total cost.
    With three there are six assignments; all are tried, which is what Hungarian matching finds.
    """

    def __init__(self, weights: LossWeights, lamp_weights: LampWeights, map_height: int = 32) -> None:
        """Build the tables."""
        super().__init__(weights, map_height, "constant")
        self.lamp_weights = lamp_weights

    def forward(
        self,
        predicted: Lamps,
        camera: Float[Tensor, "batch 2"],
        true: Lamps,
        true_map: Float[Tensor, "batch height width 3"],
        true_camera: Float[Tensor, "batch 2"],
        unit: Float[Tensor, " batch"] | None = None,
        progress: float = 1.0,
    ) -> tuple[Float[Tensor, ""], dict[str, Tensor]]:
        """The weighted sum, and each term as the mean over the batch (detached).

        Args:
            predicted: lamps in the photo's exposure.
            camera: predicted pose.
            true: the true lamps.
            true_map: the whole environment.
            true_camera: true pose.
            unit: as in `TotalLoss`.
            progress: share of the run that is done; below `first_stage` lamps are not matched.
        """
        scale = self.unit_of(true_map, unit)
        predicted, true = _divided(predicted, scale), _divided(true, scale)
        true_map = true_map / scale[:, None, None, None]
        light_map = environment(predicted, self.map_height)
        weights = self.lamp_weights
        terms: dict[str, Tensor] = {}
        if weights.environment:
            terms["lamp_environment"] = huber((light_map - true_map).square().mean((1, 2, 3)))
        if progress >= weights.first_stage:
            terms |= matched_terms(predicted, true, weights)
        root = math.sqrt(4 * math.pi)
        terms |= self.expansion_terms(
            root * predicted.ambient[:, None], root * true.ambient[:, None], self.ambient
        )
        shown = light_map if self.sphere_loss is not None else None
        terms |= self.shared_terms(shown, camera, true_map, true_camera)
        return self.weigh(terms)

    def weight_of(self, name: str) -> float:
        """Weight of a term by its name."""
        if name.startswith("lamp_"):
            return float(getattr(self.lamp_weights, name.removeprefix("lamp_")))
        return super().weight_of(name)


def matched_terms(predicted: Lamps, true: Lamps, weights: LampWeights) -> dict[str, Tensor]:
    """Terms lamp by lamp, [batch] each, under the assignment whose weighted sum is least.

    A true lamp of no energy has neither place, size nor colour: only the energy of its partner counts.

    >>> up, ahead = torch.tensor([0.0, 1.0, 0.0]), torch.tensor([0.0, 0.0, -1.0])
    >>> two = Lamps(torch.stack([up, ahead])[None], *map(torch.ones, ((1, 2), (1, 2, 3), (1, 3))))
    >>> terms = matched_terms(two, two._replace(direction=two.direction.flip(1)), LampWeights())
    >>> sum(float(term) for term in terms.values())
    0.0
    """
    count = true.energy.shape[1]
    pairs = _pairs(predicted, true)
    cost = torch.stack([getattr(weights, name) * value for name, value in pairs.items()]).sum(0)
    orders = torch.tensor(list(itertools.permutations(range(count))), device=cost.device)
    place = torch.arange(count, device=cost.device)
    totals = cost[:, orders, place].sum(-1)  # [batch, permutations]: predicted orders[i] for true i
    best = orders[totals.argmin(-1)]
    rows = torch.arange(len(best), device=cost.device)[:, None]
    return {f"lamp_{name}": value[rows, best, place].mean(-1) for name, value in pairs.items()}


def _pairs(predicted: Lamps, true: Lamps) -> dict[str, Tensor]:
    """Each term for each pair, [batch, predicted, true]."""
    energy, true_energy = predicted.energy[:, :, None], true.energy[:, None]
    strength = true_energy.norm(dim=-1)
    there = (strength > 1e-6).float()
    shape = (len(energy), energy.shape[1], true_energy.shape[2], 3)
    ratio = energy.norm(dim=-1).clamp(min=1e-3).log() - strength.clamp(min=1e-3).log()
    return {
        "direction": (predicted.direction[:, :, None] - true.direction[:, None]).square().sum(-1) * there,
        "size": (predicted.sharpness[:, :, None].log() - true.sharpness[:, None].log()).square() * there,
        "intensity": functional.smooth_l1_loss(ratio, torch.zeros_like(ratio), reduction="none"),
        "colour": colour_loss(
            functional.normalize(energy, dim=-1).expand(shape),
            functional.normalize(true_energy, dim=-1).expand(shape),
        )
        * there,
    }


def _divided(lamps: Lamps, scale: Tensor) -> Lamps:
    energy, ambient = lamps.energy / scale[:, None, None], lamps.ambient / scale[:, None]
    return lamps._replace(energy=energy, ambient=ambient)
