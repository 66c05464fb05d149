"""Every network that can be trained, by its settings, and the maps of the light that each predicts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import functions, gaussians, harmonics, lamps
from mixlight.light.lighting import Lighting
from mixlight.network.expanded_heads import ExpandedHeads, ExpandedLight
from mixlight.network.heads import Prediction
from mixlight.network.lamp_heads import LampHeads, LampLight
from mixlight.network.model import MixLightNet
from mixlight.network.photo_net import PhotoNet
from mixlight.network.settings import ANCHORED, ModelSettings
from mixlight.sphere import points

Part = Literal["whole", "ambient", "sources"]
AnyLight = Prediction | ExpandedLight | LampLight

AnyNet = PhotoNet[Any]
"""A network of any method."""


def create(settings: ModelSettings, pretrained: bool = False) -> AnyNet:
    """Builds the network that the settings describe; `pretrained` loads the backbone's ImageNet weights.

    Raises:
        ValueError: a backbone without ImageNet weights.

    >>> type(create(ModelSettings(ambient="constant", sources="lamps")).heads).__name__
    'LampHeads'
    """
    if settings.sources in ANCHORED:
        return MixLightNet(settings, pretrained)
    backbone = settings.make_backbone(pretrained)
    common = (
        backbone.channels,
        (settings.grid_rows, settings.grid_columns),
        settings.hidden,
        settings.grid_channels,
        settings.dropout,
    )
    if settings.sources == "lamps":
        return PhotoNet(settings, backbone, LampHeads(*common))
    return PhotoNet(settings, backbone, ExpandedHeads(*common, ambient=settings.ambient))


def environments(
    light: AnyLight,
    settings: ModelSettings,
    height: int = 128,
    part: Part = "whole",
) -> Float[Tensor, "batch height width 3"]:
    """Environment maps of a batch of predicted lights, in their units.

    Ambient light is clamped at 0 and the lobes are added. Sources that are an expansion ring below 0; there
    the sum of both is clamped, which keeps more of the energy right.

    Args:
        light: what the network of these settings predicts.
        settings: of the network.
        height: rows of the maps.
        part: all of the light, or the ambient light or the sources alone.

    Raises:
        ValueError: light that is not finite.
    """
    if part not in get_args(Part):
        raise ValueError(f"expected a part out of {', '.join(get_args(Part))}, got {part!r}")
    light = _only(light, part)
    if isinstance(light, LampLight):
        result = lamps.environment(light.lamps(), height)
    elif isinstance(light, ExpandedLight):
        ambient = _expansion(light.ambient, settings.ambient, height)
        result = (ambient + _expansion(light.sources, "sh6", height)).clamp(min=0)
    elif settings.ambient == "sg9":
        ambient = _expansion(light.ambient, settings.ambient, height).clamp(min=0)
        axes = points.vogel(settings.anchors).to(light.ambient)
        result = ambient + gaussians.evaluate_map(axes, light.anchor_energy, settings.sharpness, height)
    else:
        return Lighting(
            ambient=light.ambient, energy=light.anchor_energy, sharpness=settings.sharpness
        ).environment(height)
    if not bool(result.isfinite().all()):
        raise ValueError("expected finite light, got NaN or infinity")
    return result


def _only(light: AnyLight, part: Part) -> AnyLight:
    """The light without what is no part of it."""
    if part == "whole":
        return light
    if isinstance(light, Prediction):
        if part == "ambient":
            return replace(light, intensity=torch.zeros_like(light.intensity))
    elif isinstance(light, ExpandedLight):
        if part == "ambient":
            return replace(light, sources=torch.zeros_like(light.sources))
    elif part == "ambient":
        return replace(light, energy=torch.zeros_like(light.energy))
    return replace(light, ambient=torch.zeros_like(light.ambient))


def _expansion(coefficients: Tensor, name: functions.Functions, height: int) -> Tensor:
    if name != "sg9":
        return harmonics.evaluate_map(coefficients, height)
    flat = functions.maps(name, height).flatten(0, 1).to(coefficients) @ coefficients
    return flat.view(*coefficients.shape[:-2], height, 2 * height, 3)
