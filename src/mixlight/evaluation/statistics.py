"""Means, medians and ratios, with intervals over groups: views of one place are not independent."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

__all__ = ["Summary", "paired_ratio", "summarise"]

Values = Mapping[str, Sequence[float]]
"""Cell -> its value on each sample; NaN where it is not defined."""

Summary = dict[str, dict[str, float | int | list[float] | None]]

_BLOCK = 1 << 22
"""Values that are drawn at once."""


def summarise(values: Values, groups: Sequence[str], resamples: int = 2000) -> Summary:
    """Mean and median of each cell, each with a 95 % interval by bootstrap over groups.

    The draws are always the same, and the same for all cells. Samples where a cell is NaN are left out of it.

    Args:
        values: of each cell on each sample.
        groups: the group of each sample; all samples of a group are drawn together.
        resamples: number of draws.

    Returns:
        For each cell `mean`, `mean_95` (low, high), `median`, `median_95` and `n`, the number of samples, to
        four decimals, or four significant digits where these are more. Without a sample all are None, and
        with samples of a single group the intervals: there is nothing to draw from.

    Convention: 0.1 and 0.3, of two groups, have the mean 0.2 and the interval 0.1 to 0.3.

    Raises:
        ValueError: not one group for each sample, or no draw.

    Source: percentile bootstrap over clusters; Davison and Hinkley, Bootstrap Methods, 1997, section 3.8.

    >>> summarise({"rmse": [0.1, 0.3]}, ["room", "hall"], 50)["rmse"]
    {'mean': 0.2, 'mean_95': [0.1, 0.3], 'median': 0.2, 'median_95': [0.1, 0.3], 'n': 2}
    """
    if resamples < 1:
        raise ValueError(f"expected at least one draw, got {resamples}")
    table = _matrix(values, groups)
    summary: Summary = {}
    for cell, column in zip(values, table.T, strict=True):
        defined = ~np.isnan(column)
        if not defined.any():
            summary[cell] = {"mean": None, "mean_95": None, "median": None, "median_95": None, "n": 0}
            continue
        kept = column[defined]
        whose = [g for g, d in zip(groups, defined, strict=True) if d]
        several = len(set(whose)) > 1
        means, medians = _draws(kept, whose, resamples) if several else (kept, kept)
        summary[cell] = {
            "mean": _rounded(float(kept.mean())),
            "mean_95": _interval(means) if several else None,
            "median": _rounded(float(np.median(kept))),
            "median_95": _interval(medians) if several else None,
            "n": len(kept),
        }
    return summary


def paired_ratio(
    first: Values, second: Values, groups: Sequence[str], resamples: int = 2000
) -> dict[str, dict[str, float | int | list[float] | None]]:
    """Geometric mean over all samples of one method's error over another's, with a 95 % interval.

    Both methods are seen on the same samples, so what makes a sample hard drops out. Each group counts once:
    the mean of its samples' logarithms. Samples where either is NaN or 0 are left out.

    Args:
        first: errors of one method.
        second: errors of the other, on the same samples; cells that both have are compared.
        groups: the group of each sample.
        resamples: number of draws.

    Returns:
        For each cell `ratio`, `interval_95`, `first_better` (share of samples where the first error is lower)
        and `n`; a ratio below 1 with an interval below 1 says that the first method is better. `interval_95`
        is None for a single group.

    Raises:
        ValueError: not one group for each sample.

    >>> paired_ratio({"rmse": [1.0, 2.0]}, {"rmse": [2.0, 4.0]}, ["a", "b"], 50)["rmse"]
    {'ratio': 0.5, 'interval_95': [0.5, 0.5], 'first_better': 1.0, 'n': 2}
    """
    cells = [cell for cell in first if cell in second]
    one, other = ({cell: values[cell] for cell in cells} for values in (first, second))
    result: dict[str, dict[str, float | int | list[float] | None]] = {}
    names = np.array(groups)
    for cell, a, b in zip(cells, _matrix(one, groups).T, _matrix(other, groups).T, strict=True):
        defined = (a > 0) & (b > 0)
        if not defined.any():
            result[cell] = {"ratio": None, "interval_95": None, "first_better": None, "n": 0}
            continue
        logs = np.log(a[defined]) - np.log(b[defined])
        means = np.array([logs[names[defined] == name].mean() for name in np.unique(names[defined])])
        generator = np.random.default_rng(0)
        drawn = means[generator.integers(len(means), size=(resamples, len(means)))].mean(1)
        result[cell] = {
            "ratio": _rounded(float(np.exp(means.mean()))),
            "interval_95": _interval(np.exp(drawn)) if len(means) > 1 else None,
            "first_better": _rounded(float((logs < 0).mean())),
            "n": int(defined.sum()),
        }
    return result


def _matrix(values: Values, groups: Sequence[str]) -> Float[np.ndarray, "samples cells"]:
    wrong = [cell for cell, column in values.items() if len(column) != len(groups)]
    if wrong:
        raise ValueError(f"expected one group for each of {len(values[wrong[0]])} samples, got {len(groups)}")
    return np.array([list(values[cell]) for cell in values], dtype=np.float64).reshape(-1, len(groups)).T


def _draws(values: np.ndarray, groups: Sequence[str], resamples: int) -> tuple[np.ndarray, np.ndarray]:
    """Means and medians of samples of drawn groups.

    A draw is a weight for each group; over the sorted values the median is where the running weight passes a
    half, so that no sample is copied.
    """
    generator = np.random.default_rng(0)
    names, member = np.unique(np.array(groups), return_inverse=True)
    order = np.argsort(values, kind="stable")
    ranked, member = values[order], member[order]
    means, medians = [], []
    block = max(1, _BLOCK // len(values))
    for start in range(0, resamples, block):
        count = min(block, resamples - start)
        drawn = generator.integers(len(names), size=(count, len(names)))
        weight = np.zeros((count, len(names)), dtype=np.int64)
        np.add.at(weight, (np.arange(count)[:, None], drawn), 1)
        copies = weight[:, member]
        running = copies.cumsum(1)
        total = running[:, -1]
        low = (running > ((total - 1) // 2)[:, None]).argmax(1)
        high = (running > (total // 2)[:, None]).argmax(1)
        means.append((copies @ ranked) / total)
        medians.append((ranked[low] + ranked[high]) / 2)
    return np.concatenate(means), np.concatenate(medians)


def _interval(draws: np.ndarray) -> list[float]:
    low, high = np.quantile(draws, (0.025, 0.975))
    return [_rounded(float(low)), _rounded(float(high))]


def _rounded(value: float) -> float:
    """Four decimals, or four significant digits where these are more: others would say nothing."""
    if not math.isfinite(value) or value == 0:
        return value
    return round(value, max(4, 3 - math.floor(math.log10(abs(value)))))
