"""Validation during training: protocol M's spheres on fixed views of panoramas that are never trained on."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord
from mixlight.light.compare import rmse_and_si_rmse
from mixlight.light.lighting import Lighting
from mixlight.network.canonical import CanonicalView
from mixlight.network.heads import Prediction
from mixlight.network.model import MixLightNet
from mixlight.render.spheres import SphereRenderer

SPHERES = ("diffuse", "matte", "mirror")
_CHUNK = 16
_SCORE_WEIGHTS = {"real": 2.0, "rooms": 1.0}


def predicted_environments(
    prediction: Prediction, sharpness: float, height: int = 128
) -> Float[Tensor, "batch height width 3"]:
    """Environment maps of a batch of predictions (ambient clamped at 0, plus lobes)."""
    return torch.stack(
        [
            Lighting(ambient=ambient, energy=energy, sharpness=sharpness).environment(height)
            for ambient, energy in zip(prediction.ambient, prediction.anchor_energy, strict=True)
        ]
    )


def score_spheres(
    renderer: SphereRenderer,
    predicted: Float[Tensor, "batch height width 3"],
    true: Float[Tensor, "batch height width 3"],
) -> Float[Tensor, "batch 2 3"]:
    """RMSE and si-RMSE of the three spheres (protocol M: linear, unclipped, over pixels and channels)."""
    images, truth = renderer.render(predicted), renderer.render(true)
    mask = renderer.mask
    rows = []
    for i in range(len(SPHERES)):
        rmse, si_rmse = rmse_and_si_rmse(images[:, i][:, mask], truth[:, i][:, mask])
        rows.append(torch.stack([rmse, si_rmse], -1))
    return torch.stack(rows, -1)


class ValidationSet:
    """Fixed photos with known light, and the score of a model on them."""

    def __init__(
        self,
        records: Sequence[PanoramaRecord],
        canonical: CanonicalView,
        room_azimuths: int = 2,
        renderer: SphereRenderer | None = None,
    ) -> None:
        """Real panoramas are seen at 8 azimuths, rendered rooms at `room_azimuths`.

        Raises:
            ValueError: no record to validate on.
        """
        rooms = [r for r in records if r.category == "room"]
        real = [r for r in records if r.category != "room"]
        self.samples: dict[str, list[EvaluationSample]] = {}
        if real:
            self.samples["real"] = collect(real, canonical)
        if rooms and room_azimuths:
            self.samples["rooms"] = collect(rooms, canonical, room_azimuths)
        if not self.samples:
            raise ValueError("expected at least one panorama with split val, got none")
        self.renderer = renderer or SphereRenderer(resolution=64)

    @torch.no_grad()
    def evaluate(self, model: MixLightNet) -> dict[str, float]:
        """Medians of all six cells for each kind, and `score`, the number that chooses a model (lower is better).

        The score is a geometric mean, so that no bright scene rules it: over the RMSE and si-RMSE of the diffuse
        sphere and, at a quarter of its weight, the matte one; over all views of a kind; real panoramas count twice
        as much as rendered rooms.
        """
        model.eval()
        result: dict[str, float] = {}
        total = weight = 0.0
        for kind, samples in self.samples.items():
            errors = []
            for start in range(0, len(samples), _CHUNK):
                chunk = samples[start : start + _CHUNK]
                prediction = model(torch.stack([s.photo for s in chunk]))
                predicted = predicted_environments(prediction, model.settings.sharpness)
                true = torch.stack([s.environment for s in chunk])
                errors.append(score_spheres(self.renderer, predicted, true))
            cells = torch.cat(errors)
            for i, sphere in enumerate(SPHERES):
                result[f"{kind}/{sphere}/rmse"] = float(cells[:, 0, i].median())
                result[f"{kind}/{sphere}/si_rmse"] = float(cells[:, 1, i].median())
            logs = cells.clamp(min=1e-6).log().mean((0, 1))
            result[f"{kind}/score"] = float(torch.exp((logs[0] + logs[1] / 4) / 1.25))
            total += _SCORE_WEIGHTS[kind] * float((logs[0] + logs[1] / 4) / 1.25)
            weight += _SCORE_WEIGHTS[kind]
        result["score"] = math.exp(total / weight)
        return result
