"""Tables of an ablation: medians, and each variant against the reference with its interval."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from mixlight.evaluation.bench import CELLS
from mixlight.evaluation.cells import describe
from mixlight.evaluation.representations import Part

__all__ = ["markdown", "medians", "ratios"]


def markdown(result: Mapping[str, Any]) -> str:
    """Both tables of every part, with what they stand on."""
    lines = [result["question"], "", basis(result), ""]
    for part in next(iter(result["variants"].values()))["parts"]:
        title = {"whole": "", "ambient": " (ambient light alone)", "sources": " (sources alone)"}[part]
        lines += [f"Medians{title}:", "", medians(result, part)]
        lines += [f"Errors over those of {result['reference']}{title}:", "", ratios(result, part)]
    return "\n".join(lines)


def basis(result: Mapping[str, Any]) -> str:
    """One line: level, number of views, what was trained."""
    line = (
        f"Protocol {result['protocol']['letter']}, {result['level']} level; {result['views']} views of "
        f"{result['panoramas']} places ({', '.join(result['splits'])}; {', '.join(result['categories'])})"
    )
    training = result["training"]
    if training:
        seeds = len(next(iter(result["variants"].values()))["seeds"])
        line += (
            f"; {training['backbone']}; {training['steps']} steps of {training['batch_size']} views, "
            f"{seeds} seeds"
        )
    return f"{line}; commit `{result['commit']}`; {result['machine']}."


def medians(result: Mapping[str, Any], part: Part = "whole") -> str:
    """Median of each cell; at network level the mean over seeds with its spread (standard deviation)."""
    rows = []
    extra = "numbers" if result["level"] == "representation" else "active anchors"
    for name, row in result["variants"].items():
        cells = row["parts"][part]
        if "medians_by_seed" in cells:
            numbers = [_spread(cells["medians_by_seed"][cell]) for cell in CELLS]
        else:
            numbers = [f"{cells['errors'][cell]['median']:.3f}" for cell in CELLS]
        active = row.get("active_anchors")
        more = str(row["numbers"]) if extra == "numbers" else f"{_mean(active):.0f}" if active else "–"
        rows.append([name, more, *numbers])
    return table(("variant", extra, *(describe(cell).title for cell in CELLS)), rows)


def ratios(result: Mapping[str, Any], part: Part = "whole") -> str:
    """Geometric mean of the ratio of errors to the reference's, with its 95 % interval over places; bold
    where that leaves out 1, and where every seed agrees.
    """
    rows = []
    for name, row in result["variants"].items():
        if name != result["reference"]:
            cells = row["parts"][part]
            rows.append([name, *(ratio(cells, cell) for cell in CELLS)])
    return table(("variant", *(describe(cell).title for cell in CELLS)), rows)


def ratio(cells: Mapping[str, Any], cell: str) -> str:
    """One ratio with its interval."""
    found = cells["ratio_to_reference"][cell]
    if found["ratio"] is None:
        return "–"
    if found["interval_95"] is None:  # of one place there is none
        return f"{found['ratio']:.2f}"
    low, high = found["interval_95"]
    text = f"{found['ratio']:.2f} ({low:.2f}–{high:.2f})"
    return f"**{text}**" if decided(cells, cell) else text


def decided(cells: Mapping[str, Any], cell: str) -> int:
    """-1 where the variant is better than the reference, 1 where it is worse, 0 where that is open.

    Decided means that the interval over places leaves out 1, that the ratio is not 1.00 to two digits, and
    that all seeds are on the same side.
    """
    found = cells["ratio_to_reference"][cell]
    if found["ratio"] is None or found["interval_95"] is None or abs(found["ratio"] - 1) < 0.005:
        return 0
    low, high = found["interval_95"]
    seeds = cells.get("ratios_by_seed", {}).get(cell, [])
    if high < 1 and all(r < 1 for r in seeds):
        return -1
    return 1 if low > 1 and all(r > 1 for r in seeds) else 0


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table."""
    names = list(head)
    return "\n".join("| " + " | ".join(row) + " |" for row in (names, ["---"] * len(names), *rows)) + "\n"


def _spread(values: list[float]) -> str:
    mean = _mean(values)
    deviation = (sum((v - mean) ** 2 for v in values) / max(1, len(values) - 1)) ** 0.5
    return f"{mean:.3f} ± {deviation:.3f}"


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)
