"""Backbones by name: each turns sRGB pictures into feature maps behind one interface."""

from __future__ import annotations

from typing import Any

from mixlight.network import weights
from mixlight.network.backbones.backbone import Backbone
from mixlight.network.backbones.densenet121 import DenseNet121, from_torchvision
from mixlight.network.backbones.efficientnet_lite0 import EfficientNetLite0

__all__ = ["Backbone", "DenseNet121", "EfficientNetLite0", "create", "from_torchvision", "names"]

_BACKBONES: dict[str, type[Backbone]] = {
    "densenet121": DenseNet121,
    "efficientnet_lite0": EfficientNetLite0,
}


def names() -> tuple[str, ...]:
    """Names that `create` knows, sorted.

    >>> names()
    ('densenet121', 'efficientnet_lite0')
    """
    return tuple(sorted(_BACKBONES))


def create(name: str, pretrained: bool = True, **options: Any) -> Backbone:
    """Make a backbone by its name.

    Args:
        name: One of `names()`.
        pretrained: Start from the ImageNet weights that ship with the package. They ship for
            `efficientnet_lite0`; for `densenet121` take `from_torchvision` and `weights.load_into`.
        options: Passed to the backbone: `drop_path` for `efficientnet_lite0`, `drop_rate` for `densenet121`.

    Returns:
        The backbone, in training mode. Its `channels` says how many its feature maps have.

    Raises:
        ValueError: unknown name, or `pretrained` where no weights ship.

    >>> create("efficientnet_lite0").channels
    1280
    """
    if name not in _BACKBONES:
        raise ValueError(f"expected a backbone out of {', '.join(names())}, received {name!r}")
    trained = f"{name}_imagenet"
    if pretrained and trained not in weights.names():
        raise ValueError(f"expected pretrained=False for {name!r}: no ImageNet weights ship for it")
    backbone = _BACKBONES[name](**options)
    if pretrained:
        path = weights.find(trained)
        weights.load_into(backbone, weights.load(path)[0], path)
    return backbone
