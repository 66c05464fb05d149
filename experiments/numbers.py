"""Numbers as results keep them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


def distribution_of(values: Sequence[float] | np.ndarray) -> dict[str, float]:
    """Median, mean, 5th and 95th percentile, and maximum."""
    array = np.asarray(values, dtype=np.float64)
    low, median, high = np.quantile(array, (0.05, 0.5, 0.95))
    return {
        "median": float(median),
        "mean": float(array.mean()),
        "p5": float(low),
        "p95": float(high),
        "max": float(array.max()),
    }


def rounded(value: Any) -> Any:
    """Five significant digits: more would say nothing."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: rounded(entry) for key, entry in value.items()}
    return [rounded(entry) for entry in value] if isinstance(value, list) else value
