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
from mixlight.network.methods import AnyNet, environments
from mixlight.render.spheres import SphereRenderer

SPHERES = ("diffuse", "matte", "mirror")
"""Order of the spheres in every table of errors."""

_CHUNK = 16
_SCORE_WEIGHTS = {"real": 2.0, "rooms": 1.0}


def predicted_environments(
    prediction: Prediction, sharpness: float, height: int = 128
) -> Float[Tensor, "batch height width 3"]:
    """Environment maps of a batch of predictions: ambient light clamped at 0, plus lobes.

    Args:
        prediction: light in the photo's exposure, or any other unit.
        sharpness: angular size s of the lobes.
        height: rows of the maps.

    Raises:
        ValueError: light that is not finite.
    """
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
    """RMSE and si-RMSE (axis 1) of the three spheres (axis 2).

    Protocol M: linear, unclipped, over the sphere's pixels and channels, in the maps' units.

    Raises:
        ValueError: maps that are not 2:1.
    """
    shown, truth = (sphere_pixels(renderer, maps) for maps in (predicted, true))
    return torch.stack(rmse_and_si_rmse(shown, truth), 1)


def sphere_pixels(
    renderer: SphereRenderer, maps: Float[Tensor, "batch height width 3"]
) -> Float[Tensor, "batch 3 pixels 3"]:
    """What the three spheres show under maps.

    Raises:
        ValueError: maps that are not 2:1.
    """
    return renderer.render(maps)[:, :, renderer.mask]


class ValidationSet:
    """Fixed photos with known light, and the score of a model on them."""

    def __init__(
        self,
        records: Sequence[PanoramaRecord],
        canonical: CanonicalView,
        room_azimuths: int = 2,
        renderer: SphereRenderer | None = None,
    ) -> None:
        """Takes the photos, once and for all.

        Args:
            records: panoramas that are not trained on.
            canonical: the view that the network takes.
            room_azimuths: views of each rendered room; real panoramas are seen at 8 azimuths.
            renderer: of the spheres; one of 64 pixels if not given.

        Raises:
            ValueError: no record to validate on, or none with light in it.
            OSError: a panorama cannot be read.
        """
        rooms = [r for r in records if r.category == "room"]
        real = [r for r in records if r.category != "room"]
        self.samples: dict[str, list[EvaluationSample]] = {}
        if real:
            self.samples["real"] = collect(real, canonical)
        if rooms and room_azimuths:
            self.samples["rooms"] = collect(rooms, canonical, room_azimuths)
        self.samples = {kind: samples for kind, samples in self.samples.items() if samples}
        if not self.samples:
            raise ValueError("expected at least one panorama with split val and light in it, got none")
        self.renderer = renderer or SphereRenderer(resolution=64)
        self._shown: dict[tuple[str, int], Tensor] = {}

    def _truth(self, kind: str, start: int) -> Tensor:
        """The spheres under the true light of a chunk, rendered once."""
        if (kind, start) not in self._shown:
            maps = torch.stack([s.environment for s in self.samples[kind][start : start + _CHUNK]])
            self._shown[kind, start] = sphere_pixels(self.renderer, maps)
        return self._shown[kind, start]

    @torch.no_grad()
    def evaluate(self, model: AnyNet) -> dict[str, float]:
        """Medians of all six cells for each kind, and `score`, which chooses a model (lower is better).

        The score is a geometric mean, so that no bright scene rules it: over the RMSE and si-RMSE of the
        diffuse sphere and, at a quarter of its weight, the matte one; over all views of a kind; real
        panoramas count twice as much as rendered rooms.
        """
        model.eval()
        device = next(model.parameters()).device
        result: dict[str, float] = {}
        total = weight = 0.0
        for kind, samples in self.samples.items():
            errors = []
            for start in range(0, len(samples), _CHUNK):
                chunk = samples[start : start + _CHUNK]
                prediction = model(torch.stack([s.photo for s in chunk]).to(device)).to("cpu")
                predicted = environments(prediction, model.settings)
                shown = sphere_pixels(self.renderer, predicted)
                errors.append(torch.stack(rmse_and_si_rmse(shown, self._truth(kind, start)), 1))
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
