"""The card that travels inside the weights: what they are, and what they were made from."""

from __future__ import annotations

import platform
import subprocess
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from mixlight import __version__
from mixlight.data.panoramas import PanoramaRecord
from mixlight.network import weights
from mixlight.network.settings import ANCHORED, ModelSettings
from mixlight.training.config import WORDS, TrainingConfig, to_plain

_PACKAGE = Path(__file__).resolve().parent.parent


def make_card(
    config: TrainingConfig, records: Sequence[PanoramaRecord], metrics: Mapping[str, float]
) -> dict[str, Any]:
    """The card of a trained model, as plain values; it holds no path of the machine that trained.

    Args:
        config: of the run.
        records: the panoramas trained on.
        metrics: validation metrics of the weights.
    """
    plain = to_plain(config)
    plain["tables"] = [Path(table).name for table in config.tables]
    plain["backbone_weights"] = Path(config.backbone_weights).name
    plain["model_weights"] = Path(config.model_weights).name
    return {
        "kind": config.method if config.method != "mixlight" else kind(config.model),
        "name": config.name,
        "settings": config.model.to_card(),
        "frame": "mixlight: +X right, +Y up, -Z forward; the photo's azimuth is the map's centre",
        "units": "radiance 1.0 is the photo's linear white",
        "config": plain,
        "commit": commit(),
        **_ancestor(config),
        "data": {
            "tables": plain["tables"],
            "panoramas": len(records),
            "by_category": dict(Counter(record.category for record in records)),
        },
        "validation": dict(metrics),
        "versions": versions(),
        "licence": f"Apache-2.0; backbone {_origin(config)}",
    }


def kind(settings: ModelSettings) -> str:
    """What the weights are: `mixlight`, which the estimator loads, or `variant`, for comparisons alone.

    >>> kind(ModelSettings()), kind(ModelSettings(ambient="sg9"))
    ('mixlight', 'variant')
    """
    return "mixlight" if settings.ambient == "sh2" and settings.sources in ANCHORED else "variant"


def versions() -> dict[str, str]:
    """What computes: this package, PyTorch, NumPy, Python."""
    return {
        "mixlight": __version__,
        "torch": torch.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


def commit() -> str:
    """The commit of this package's source tree, with `-dirty` for a changed one; `unknown` outside a
    checkout.
    """
    try:
        top = _git("rev-parse", "--show-toplevel")
        # An installed package may lie inside somebody else's repository.
        if (Path(top) / "src" / "mixlight").resolve() != _PACKAGE:
            return "unknown"
        return _git("describe", "--always", "--dirty")
    except (OSError, subprocess.SubprocessError):
        return "unknown"


def _git(*arguments: str) -> str:
    done = subprocess.run(
        ["git", *arguments], cwd=_PACKAGE, capture_output=True, text=True, check=True, timeout=30
    )
    return done.stdout.strip()


def _ancestor(config: TrainingConfig) -> dict[str, Any]:
    """The card of the model that a run went on from: what that one was made from counts for this one, too."""
    if not config.model_weights:
        return {}
    return {"started_from": weights.load(weights.find(config.model_weights))[1]}


def _origin(config: TrainingConfig) -> str:
    start = config.backbone_weights
    if config.model_weights:
        return f"as in the model it went on from ({Path(config.model_weights).name})"
    if start == "none":
        return "initialised at random"
    if start not in WORDS:
        return f"initialised from {Path(start).name}"
    if config.model.backbone == "efficientnet_lite0":
        return "initialised from EfficientNet-Lite0 (Apache-2.0, ImageNet)"
    return f"initialised from the shipped {config.model.backbone} weights (ImageNet)"
