"""From a photo to its light, with trained weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.image.color import linear_to_srgb
from mixlight.light.lighting import Lighting
from mixlight.network import weights
from mixlight.network.heads import Prediction
from mixlight.network.model import MixLightNet, ModelSettings

_KEPT_SHARE = 1e-4


@dataclass(frozen=True)
class Estimate:
    """The light around a photo and how its camera stood."""

    lighting: Lighting
    """In the photo's own exposure: radiance 1.0 is the photo's linear white; azimuth 0 is the photo's."""
    pitch: float
    """Elevation of the optical axis in radians; negative looks down."""
    roll: float
    """Clockwise turn of the camera in radians."""
    view: Float[Tensor, "height width 3"]
    """What the network saw: the canonical view, linear."""


class Estimator:
    """A trained network with its card."""

    def __init__(self, model: MixLightNet, card: dict[str, Any]) -> None:
        """Takes a network ready for inference."""
        self.model = model.eval()
        self.card = card

    @classmethod
    def load(cls, name_or_path: str | Path = "default") -> Estimator:
        """Loads weights that ship with the package (by name) or lie in a file.

        Raises:
            WeightsError: unknown name, missing, corrupt or foreign file, or weights that do not fit the card.
        """
        path = weights.find(name_or_path)
        state, card = weights.load(path)
        known = {f.name for f in fields(ModelSettings)}
        settings = card.get("settings")
        if card.get("kind") != "mixlight" or not isinstance(settings, dict) or set(settings) - known:
            raise weights.WeightsError(
                f"{path}: expected weights of a MixLight model with its settings on the card, "
                f"got kind {card.get('kind')!r}"
            )
        model = MixLightNet(ModelSettings(**settings))
        weights.load_into(model, state, path)
        return cls(model, card)

    def view(
        self, photo: Float[Tensor, "photo_height photo_width 3"], fov_x: float
    ) -> Float[Tensor, "height width 3"]:
        """The canonical view of a linear photo with horizontal field of view `fov_x` in radians."""
        return self.model.settings.canonical.resample(photo, fov_x)[0]

    def estimate(self, photo: Float[Tensor, "photo_height photo_width 3"], fov_x: float) -> Estimate:
        """Estimates the light around one linear photo (values in [0, 1], 1 = white).

        Raises:
            ValueError: a black view, since light is estimated relative to the photo's mean.
        """
        return self.estimate_views(self.view(photo, fov_x)[None])[0]

    def estimate_views(self, views: Float[Tensor, "batch height width 3"]) -> list[Estimate]:
        """Estimates the light around a batch of linear canonical views."""
        if not bool((views.amax((1, 2, 3)) > 0).all()):
            raise ValueError("expected a photo with light in it, got an all-black view")
        encoded = torch.from_numpy(linear_to_srgb(views.clamp(0, 1).numpy()))
        with torch.inference_mode():
            prediction = self.model(encoded.permute(0, 3, 1, 2).contiguous())
        lights = to_lighting(prediction, self.model.settings.sharpness)
        poses: Sequence[Sequence[float]] = prediction.camera.tolist()
        return [
            Estimate(lighting, pitch, roll, view)
            for lighting, (pitch, roll), view in zip(lights, poses, views, strict=True)
        ]


def to_lighting(prediction: Prediction, sharpness: float) -> list[Lighting]:
    """One `Lighting` a photo; anchors with less than 1e-4 of the sources' light count as 0 (method)."""
    share = prediction.distribution
    kept = share > _KEPT_SHARE * share.sum(-1, keepdim=True)
    energy = torch.where(kept[..., None], prediction.anchor_energy, 0.0)
    return [
        Lighting(ambient=a.clone(), energy=e.clone(), sharpness=sharpness)
        for a, e in zip(prediction.ambient, energy, strict=True)
    ]
