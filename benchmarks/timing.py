"""Two pieces of work timed in turn, so that whatever else the machine does falls on both."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Result:
    """One row of the table."""

    name: str
    ours: str
    reference: str
    limit: float
    ratios: tuple[float, ...]
    seconds: tuple[float, float]

    @property
    def ratio(self) -> float:
        return statistics.median(self.ratios)

    @property
    def spread(self) -> tuple[float, float]:
        """Quartiles of the ratios."""
        low, _, high = statistics.quantiles(self.ratios, n=4)
        return low, high


def side_by_side(
    name: str,
    limit: float,
    ours: tuple[str, Callable[[], object]],
    reference: tuple[str, Callable[[], object]],
    rounds: int = 9,
    warm_up: int = 2,
) -> Result:
    """Runs both in turn, the order swapped every round; each round gives one ratio."""
    for _ in range(warm_up):
        ours[1]()
        reference[1]()
    pairs = []
    for k in range(rounds):
        order = (ours[1], reference[1]) if k % 2 == 0 else (reference[1], ours[1])
        times = [_seconds(work) for work in order]
        pairs.append(tuple(times if k % 2 == 0 else reversed(times)))
    return Result(
        name,
        ours[0],
        reference[0],
        limit,
        tuple(a / b for a, b in pairs),
        (statistics.median(a for a, _ in pairs), statistics.median(b for _, b in pairs)),
    )


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
