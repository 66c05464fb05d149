"""What an evaluation says: tables with intervals as Markdown, LaTeX, CSV and JSON."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from mixlight.evaluation.cells import SPHERES, describe
from mixlight.evaluation.log import Row
from mixlight.evaluation.protocols import Protocol
from mixlight.evaluation.statistics import Summary, summarise

__all__ = ["Report", "Tables", "latex", "markdown", "report_of", "samples_csv", "shown"]

Tables = dict[str, dict[str, Summary]]
"""Category of panoramas -> method -> cell -> mean, median and their intervals."""

_LETTERS = ("D", "S", "M")
"""Diffuse, matte silver and mirror, as the paper heads its columns."""

_ABREAST = 4
"""Methods side by side in a LaTeX table."""


@dataclass(frozen=True)
class Report:
    """What an evaluation found."""

    protocol: Protocol
    """What was measured, and how."""
    tables: Tables
    """The indoor table, the outdoor table, ..."""
    counts: Mapping[str, Mapping[str, int]]
    """`photos`, `panoramas` and `groups` of each category."""
    oracles: frozenset[str]
    """Methods that see the truth, and so compete with nobody."""


def report_of(
    protocol: Protocol, rows: Sequence[Row], oracles: Collection[str] = (), resamples: int = 2000
) -> Report:
    """Summarises the scores: each category of panoramas is a table of its own.

    Categories come in the order in which they are met, methods likewise.

    Args:
        protocol: which the scores are of.
        rows: scores of any methods.
        oracles: names of methods that see the truth.
        resamples: draws for the intervals.

    Raises:
        ValueError: no score at all.
    """
    if not rows:
        raise ValueError("expected scores to summarise, got none")
    tables: Tables = {}
    counts = {}
    for category in dict.fromkeys(row.category for row in rows):
        tables[category] = {}
        here = [row for row in rows if row.category == category]
        counts[category] = {
            "photos": len({row.sample for row in here}),
            "panoramas": len({row.scene for row in here}),
            "groups": len({row.group for row in here}),
        }
        for method in dict.fromkeys(row.method for row in here):
            chosen = [row for row in here if row.method == method]
            values = {cell: [row.cells.get(cell, math.nan) for row in chosen] for cell in protocol.cells}
            tables[category][method] = summarise(values, [row.group for row in chosen], resamples)
    return Report(protocol, tables, counts, frozenset(oracles))


def markdown(report: Report) -> str:
    """The tables for people: the means, the best in bold, then every cell with its intervals."""
    protocol = report.protocol
    parts = [f"Protocol {protocol.letter}: {protocol.title}.\n"]
    for category, methods in report.tables.items():
        count = report.counts[category]
        parts.append(f"## {category}: {count['photos']} photos of {count['panoramas']} panoramas\n")
        head = ["mean", *(_heading(cell) for cell in protocol.cells)]
        best = _best(report, methods)
        body = [
            [name, *(_bold(_number(cells, cell, "mean"), (name, cell) in best) for cell in protocol.cells)]
            for name, cells in methods.items()
        ]
        parts.append(_table(head, body))
        for statistic in ("mean", "median"):
            head = [f"{statistic} (95 %)", *(_heading(cell) for cell in protocol.cells)]
            body = [
                [name, *(_with_interval(cells, cell, statistic) for cell in protocol.cells)]
                for name, cells in methods.items()
            ]
            parts.append(_table(head, body))
    return "\n".join(parts)


def latex(report: Report) -> str:
    """The means in the paper's layout: methods side by side with a column for each sphere, measures below
    each other, data sets below each other, the best of a row in bold; four methods abreast.

    Protocol L has no spheres: there each method is a row and each measure a column.
    """
    protocol = report.protocol
    names = list(dict.fromkeys(name for methods in report.tables.values() for name in methods))
    note = f"% protocol {protocol.letter}: {protocol.title}; means\n"
    if not protocol.measures:
        return note + _latex_rows(report)
    return note + "\n".join(
        _latex_block(report, names[k : k + _ABREAST]) for k in range(0, len(names), _ABREAST)
    )


def shown(value: float, digits: int) -> str:
    """A number with so many decimals; what rounds to 0 has no sign.

    >>> shown(-0.0004, 2), shown(-1.5, 2)
    ('0.00', '-1.50')
    """
    return f"{round(value, digits) + 0.0:.{digits}f}"


def samples_csv(protocol: Protocol, rows: Sequence[Row]) -> str:
    """One line a sample and method: where it is from, and every cell; empty where a cell is not defined."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(
        ("sample", "scene", "group", "category", "azimuth_deg", "gain", "method", *protocol.cells)
    )
    for row in rows:
        values = [row.cells.get(cell, math.nan) for cell in protocol.cells]
        where = (row.sample, row.scene, row.group, row.category, f"{row.azimuth_deg:g}", f"{row.gain:.6g}")
        writer.writerow(
            (*where, row.method, *("" if math.isnan(value) else f"{value:.6g}" for value in values))
        )
    return stream.getvalue()


def _heading(cell: str) -> str:
    found = describe(cell)
    return f"{found.title} [{found.unit}]" if found.unit else found.title


def _number(cells: Summary, cell: str, statistic: str) -> str:
    value = cells[cell][statistic]
    return shown(float(value), describe(cell).digits) if isinstance(value, float | int) else "–"


def _with_interval(cells: Summary, cell: str, statistic: str) -> str:
    interval = cells[cell][f"{statistic}_95"]
    if not isinstance(interval, list):
        return "–"
    low, high = (shown(bound, describe(cell).digits) for bound in interval)
    return f"{_number(cells, cell, statistic)} ({low} to {high})"


def _best(report: Report, methods: Mapping[str, Summary]) -> set[tuple[str, str]]:
    """(method, cell) with the best mean of each cell."""
    best = set()
    for cell in report.protocol.cells:
        means = {
            name: abs(float(value))
            for name, cells in methods.items()
            if name not in report.oracles and isinstance(value := cells[cell]["mean"], float | int)
        }
        if describe(cell).better and means:
            least = min(means.values())
            best |= {(name, cell) for name, value in means.items() if value == least}
    return best


def _bold(text: str, bold: bool) -> str:
    return f"**{text}**" if bold else text


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
    return "\n".join(lines) + "\n"


def _latex_block(report: Report, names: Sequence[str]) -> str:
    columns = 3 * len(names)
    heads = "".join(
        f" & \\multicolumn{{3}}{{c{'|' if k + 1 < len(names) else ''}}}{{{_escaped(name)}}}"
        for k, name in enumerate(names)
    )
    lines = [
        f"\\begin{{tabular}}{{c|{'|'.join(['ccc'] * len(names))}}}",
        "\\hline",
        f"{heads} \\\\ \\cline{{2-{columns + 1}}}",
        "Metrics" + "".join(f" & {letter}" for _ in names for letter in _LETTERS) + " \\\\ \\hline\\hline",
    ]
    for category, methods in report.tables.items():
        count = report.counts[category]
        where = f"on \\textit{{{_escaped(category)}}} ({count['photos']} photos)"
        lines.append(f" & \\multicolumn{{{columns}}}{{c}}{{{where}}} \\\\ \\hline")
        best = _best(report, methods)
        for measure in report.protocol.measures:
            row = [_measure_title(measure)]
            for name in names:
                for sphere in SPHERES:
                    cell = f"{sphere}_{measure}"
                    text = _number(methods[name], cell, "mean") if name in methods else "–"
                    row.append(f"\\textbf{{{text}}}" if (name, cell) in best else text.replace("–", "--"))
            lines.append(" & ".join(row) + " \\\\")
        lines.append("\\hline")
    return "\n".join([*lines, "\\end{tabular}"]) + "\n"


def _latex_rows(report: Report) -> str:
    cells = report.protocol.cells
    lines = [f"\\begin{{tabular}}{{l|{'c' * len(cells)}}}", "\\hline"]
    lines.append("".join(f" & {_escaped(_heading(cell))}" for cell in cells) + " \\\\ \\hline\\hline")
    for category, methods in report.tables.items():
        count = report.counts[category]
        where = f"on \\textit{{{_escaped(category)}}} ({count['photos']} photos)"
        lines.append(f" & \\multicolumn{{{len(cells)}}}{{c}}{{{where}}} \\\\ \\hline")
        best = _best(report, methods)
        for name, summary in methods.items():
            texts = [_number(summary, cell, "mean").replace("–", "--") for cell in cells]
            bold = [
                f"\\textbf{{{text}}}" if (name, cell) in best else text
                for text, cell in zip(texts, cells, strict=True)
            ]
            lines.append(" & ".join([_escaped(name), *bold]) + " \\\\")
        lines.append("\\hline")
    return "\n".join([*lines, "\\end{tabular}"]) + "\n"


def _measure_title(measure: str) -> str:
    found = describe(f"{SPHERES[0]}_{measure}")
    title = found.title.removeprefix(f"{SPHERES[0]} ")
    if measure == "geometric":
        title = "$\\sqrt{\\mathrm{RMSE}\\cdot\\mathrm{si\\mbox{-}RMSE}}$"
    unit = " [$^\\circ$]" if found.unit == "°" else ""
    return f"{title}{unit}$\\downarrow$"


def _escaped(text: str) -> str:
    """Plain text for LaTeX."""
    special = {c: f"\\{c}" for c in "&%$#_{}"} | {"\\": "\\textbackslash{}", "~": "\\textasciitilde{}"}
    special |= {"^": "\\textasciicircum{}", "°": "$^\\circ$"}
    return "".join(special.get(character, character) for character in text)
