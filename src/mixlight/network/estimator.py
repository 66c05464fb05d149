"""From a photo to its light, with trained weights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light.lighting import Lighting
from mixlight.network import srgb, weights
from mixlight.network.heads import Prediction
from mixlight.network.model import MixLightNet, ModelSettings

_KEPT_SHARE = 1e-4
"""Anchors with less of the sources' light count as 0 (method, section 4)."""


@dataclass(frozen=True)
class Estimate:
    """The light around a photo and how its camera stood.

    Convention: our frame, level, with the photo's azimuth ahead (-Z): whatever the photo's pitch and roll,
        its shape and its field of view.
    """

    lighting: Lighting
    """In the photo's own exposure: radiance 1.0 is the photo's linear white; azimuth 0 is the photo's."""
    pitch: float
    """Elevation of the optical axis in radians; negative looks down."""
    roll: float
    """Clockwise turn of the camera in radians."""
    view: Float[Tensor, "height width 3"]
    """What the network saw: the canonical view, linear, in [0, 1]."""


class Estimator:
    """A trained network with its card.

    A photo of any size, shape and field of view is seen through the network's canonical view
    (`mixlight.network.canonical`): a wider one is cut to it, a narrower, flatter or portrait one leaves a rim
    that is filled with the photo's mean colour. The photo clips at 1.0, as every camera does, so a linear
    file and the JPEG made of it give the same light.
    """

    def __init__(self, model: MixLightNet, card: dict[str, Any]) -> None:
        """Takes a network and what is known of it; the network is put into evaluation mode."""
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
        settings = card.get("settings")
        if card.get("kind") != "mixlight" or not isinstance(settings, dict):
            raise weights.WeightsError(
                f"{path}: expected weights of a MixLight model with its settings on the card, "
                f"got kind {card.get('kind')!r}"
            )
        try:
            known = ModelSettings.from_card(settings)
            if known.ambient != "sh2":
                raise ValueError(f"expected ambient light in sh2, got {known.ambient}")
            model = MixLightNet(known)
        except ValueError as error:
            raise weights.WeightsError(f"{path}: settings on the card: {error}") from error
        weights.load_into(model, state, path)
        model.backbone = model.backbone.folded()
        return cls(model, card)

    def view(
        self, photo: Float[Tensor, "photo_height photo_width 3"], fov_x: float
    ) -> Float[Tensor, "height width 3"]:
        """The canonical view of a linear photo, clipped at white.

        Args:
            photo: linear light, 1.0 is white; what is above counts as white.
            fov_x: horizontal field of view in radians.

        Raises:
            ValueError: NaN, infinite or negative values, a field of view outside (0, pi), or so small a photo
                that the view shows none of it.
        """
        low, high = (float(bound) for bound in photo.aminmax())  # NaN goes through both
        if not (low >= 0 and high < math.inf):
            raise ValueError(f"expected a photo of finite values of at least 0, got {low:g} to {high:g}")
        if high > 1:
            photo = photo.clamp(max=1)
        return self.model.settings.canonical.resample(photo, fov_x)[0]

    def estimate(self, photo: Float[Tensor, "photo_height photo_width 3"], fov_x: float) -> Estimate:
        """Estimates the light around one linear photo.

        Args:
            photo: linear light, any size; 1.0 is white.
            fov_x: horizontal field of view in radians.

        Raises:
            ValueError: as `view`; or a black view, since light is estimated relative to the photo's mean.
        """
        return self.estimate_views(self.view(photo, fov_x)[None])[0]

    def estimate_views(self, views: Float[Tensor, "batch height width 3"]) -> list[Estimate]:
        """Estimates the light around a batch of canonical views, as `view` gives them.

        The result is on the views' device, whatever the network's.

        Raises:
            ValueError: views of another size, with NaN or infinite values, or black ones.
        """
        canonical = self.model.settings.canonical
        if views.shape[1:3] != (canonical.height, canonical.width):
            raise ValueError(
                f"expected views of {canonical.height} x {canonical.width}, got {tuple(views.shape[1:3])}"
            )
        if not bool(views.isfinite().all()):
            raise ValueError("expected views of finite values, got NaN or infinity")
        black = (views.amax((1, 2, 3)) <= 0).nonzero().flatten().tolist()
        if black:
            raise ValueError(f"expected photos with light in them, got an all-black view (number {black[0]})")
        with torch.inference_mode():
            device = next(self.model.parameters()).device
            encoded = srgb.encode(views.to(device).clamp(0, 1).float())
            prediction = self.model(encoded.permute(0, 3, 1, 2)).to(views.device)
        lights = to_lighting(prediction, self.model.settings.sharpness)
        poses: Sequence[Sequence[float]] = prediction.camera.tolist()
        return [
            Estimate(lighting, pitch, roll, view)
            for lighting, (pitch, roll), view in zip(lights, poses, views, strict=True)
        ]


def kept_energy(prediction: Prediction) -> Float[Tensor, "batch anchors 3"]:
    """Energy of the lobes without the weak ones: anchors with less than 1e-4 of the sources' light are 0.

    >>> share = torch.tensor([[0.6, 0.4, 1e-5]])
    >>> one, gray = torch.ones(1), torch.full((1, 3), 3**-0.5)
    >>> light = Prediction(share, share, one, gray, torch.zeros(1, 9, 3), torch.zeros(1, 2))
    >>> kept_energy(light)[0, :, 0]
    tensor([0.3464, 0.2309, 0.0000])
    """
    share = prediction.distribution
    kept = share > _KEPT_SHARE * share.sum(-1, keepdim=True)
    return torch.where(kept[..., None], prediction.anchor_energy, 0.0)


def to_lighting(prediction: Prediction, sharpness: float) -> list[Lighting]:
    """One `Lighting` a photo, with the energies of `kept_energy`.

    `sharpness` is the angular size s of the lobes.
    """
    return [
        Lighting(ambient=a.clone(), energy=e.clone(), sharpness=sharpness)
        for a, e in zip(prediction.ambient, kept_energy(prediction), strict=True)
    ]
