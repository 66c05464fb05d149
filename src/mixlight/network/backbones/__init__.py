"""Backbones by name: each turns an sRGB picture into a feature map behind one interface."""

from __future__ import annotations

from typing import Any

from torch import nn

from mixlight.network import weights
from mixlight.network.backbones.efficientnet_lite0 import EfficientNetLite0

__all__ = ["create", "names"]

_BACKBONES: dict[str, type[nn.Module]] = {"efficientnet_lite0": EfficientNetLite0}


def names() -> tuple[str, ...]:
    """Names that ``create`` knows, sorted."""
    return tuple(sorted(_BACKBONES))


def create(name: str, pretrained: bool = True, **options: Any) -> nn.Module:
    """A backbone by its name."""
    if name not in _BACKBONES:
        raise ValueError(f"expected a backbone out of {', '.join(names())}, received {name!r}")
    backbone = _BACKBONES[name](**options)
    if pretrained:
        path = weights.find(f"{name}_imagenet")
        weights.load_into(backbone, weights.load(path)[0], path)
    return backbone
