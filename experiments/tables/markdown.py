"""Numbers and tables as the pages show them."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

QUARTILES = "25 % / **median** / 75 %"
"""Head of a column of `quartiles`."""


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table; the text of its cells is not escaped."""
    names = list(head)
    lines = ["| " + " | ".join(row) + " |" for row in (names, ["---"] * len(names), *rows)]
    return "\n".join(lines) + "\n"


def number(value: float) -> str:
    """Three significant digits; an exponent only where nobody would count the zeros."""
    if value == 0:
        return "0"
    return plain(value, 3) if abs(value) >= 1e-4 else f"{value:.2g}"


def percent(value: float) -> str:
    """One decimal, or two significant digits below 1 %."""
    if not value:
        return "0 %"
    return f"{100 * value:.1f} %" if abs(value) >= 0.01 else f"{plain(100 * value, 2)} %"


def plain(value: float, digits: int) -> str:
    """That many significant digits, without an exponent."""
    return f"{value:.{max(0, digits - 1 - math.floor(math.log10(abs(value))))}f}"


def spread(entry: Mapping[str, Any], form: Callable[[float], str] = number) -> str:
    """Median, and the quantiles of 5 and 95 %."""
    return f"{form(entry['median'])} ({form(entry['p5'])} to {form(entry['p95'])})"


def interval(value: float, bounds: Sequence[float], digits: int = 2) -> str:
    """A value and the interval that it lies in."""
    low, high = bounds
    return f"{value:.{digits}f} ({low:.{digits}f}–{high:.{digits}f})"


def quartiles(low: float, median: float, high: float) -> str:
    """The quartiles, the median in bold."""
    return f"{low:.2f} / **{median:.2f}** / {high:.2f}"
