"""Whole methods by name: what a config's `method` stands for, under what the file itself says.

The networks and losses of the baselines live where training can reach them; `mixlight.evaluation.baselines`
says what each is, and checks it against its own paper.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

__all__ = ["PRESETS", "with_preset"]

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "mixlight": {},
        # Three lamps of free direction, size and colour in constant light. The rendered map teaches first,
        # then
        # matched lamps.
        "gardner19": {
            "model": {"ambient": "constant", "sources": "lamps"},
            "loss": {
                "coefficients": 0.0,
                "reconstruction": 1.0,
                "rendering": 0.0,
                "spheres": [0.0, 0.0, 0.0],
                "spheres_si": [0.0, 0.0, 0.0],
            },
            "lamps": {"first_stage": 0.3},
        },
        # 128 anchors without sparsity in constant light. Its published weights are 1000 on the mean squared
        # error
        # of P and on its transport loss, 100 on that of R, .1 on E; ours are of sums, so 1000 / 128 and 100 /
        # 3.
        "emlight": {
            "model": {"ambient": "constant", "sources": "anchors", "sparse_mode": "softmax"},
            "loss": {
                "distribution": 7.8,
                "scores": 0.0,
                "transport": 1000.0,
                "transport_form": "mse",
                "masked_l1": 0.0,
                "concentration": 0.0,
                "intensity": 0.1,
                "colour": 33.0,
                "coefficients": 0.0,
                "reconstruction": 1.0,
                "rendering": 0.0,
                "spheres": [0.0, 0.0, 0.0],
                "spheres_si": [0.0, 0.0, 0.0],
            },
        },
    }
)
"""Name of a method: its training config's values, where they are not the defaults."""


def with_preset(values: Mapping[str, Any]) -> dict[str, Any]:
    """A config's values over those of its `method`, table by table.

    Raises:
        ValueError: an unknown method.

    >>> found = with_preset({"method": "gardner19", "model": {"height": 192}})
    >>> found["model"]
    {'ambient': 'constant', 'sources': 'lamps', 'height': 192}
    """
    method = values.get("method", "mixlight")
    if method not in PRESETS:
        raise ValueError(f"expected a method out of {', '.join(PRESETS)}, got {method!r}")
    return _merged(PRESETS[method], values)


def _merged(under: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(under)
    for key, value in over.items():
        below = merged.get(key)
        both = isinstance(below, Mapping) and isinstance(value, Mapping)
        merged[key] = _merged(below, value) if both else value  # type: ignore[arg-type]
    return merged
