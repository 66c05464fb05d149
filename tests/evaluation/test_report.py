"""Tables: indoor and outdoor apart, intervals, the best in bold, in the paper's layout."""

import csv
import io
import math
import re
from dataclasses import replace

import pytest

from mixlight.evaluation.cells import describe
from mixlight.evaluation.log import Row
from mixlight.evaluation.protocols import PROTOCOLS, Protocol
from mixlight.evaluation.report import latex, markdown, report_of, samples_csv


def rows(
    protocol: Protocol, methods: dict[str, float], category: str = "indoor", count: int = 4
) -> list[Row]:
    """Scene k has the method's number times 1 + k in every cell."""
    return [
        Row(
            f"{category}{k}_az000", f"{category}{k}", f"g{k}", category, 0.0, 1.5, name,
            dict.fromkeys(protocol.cells, value * (1 + k)),
        )
        for name, value in methods.items()
        for k in range(count)
    ]  # fmt: skip


M = PROTOCOLS["M"]
METHODS = {"photo-mean": 0.2, "oracle:sh2": 0.01, "a_b & c": 0.1, "d": 0.4, "e": 0.5}


def test_means_medians_and_counts_by_category() -> None:
    report = report_of(M, [*rows(M, METHODS), *rows(M, METHODS, "outdoor", 2)], ["oracle:sh2"], 50)
    assert list(report.tables) == ["indoor", "outdoor"]
    assert report.counts["indoor"] == {"photos": 4, "panoramas": 4, "groups": 4}
    cell = report.tables["indoor"]["d"]["diffuse_rmse"]
    assert cell["mean"] == pytest.approx(0.4 * 2.5)
    assert cell["median"] == pytest.approx(0.4 * 2.5)
    assert report.tables["outdoor"]["d"]["diffuse_rmse"]["n"] == 2


def test_markdown_has_every_number_and_sets_the_best_in_bold() -> None:
    text = markdown(report_of(M, rows(M, METHODS), ["oracle:sh2"], 50))
    (line,) = [line for line in text.splitlines() if line.startswith("| a_b & c | **")]
    assert line.count("**0.250**") == len(M.cells)
    assert "**0.025**" not in text  # an oracle wins nothing
    assert re.search(r"\| d \| 1\.000 \(0\.\d{3} to 1\.\d{3}\) \|", text)
    for cell in M.cells:
        assert describe(cell).title in text


def test_latex_is_the_papers_layout_four_methods_abreast() -> None:
    report = report_of(M, [*rows(M, METHODS), *rows(M, {"d": 0.3}, "outdoor")], ["oracle:sh2"], 50)
    text = latex(report)
    blocks = re.findall(r"\\begin\{tabular\}\{(.*?)\}\n(.*?)\\end\{tabular\}", text, re.DOTALL)
    assert [spec for spec, _ in blocks] == ["c|ccc|ccc|ccc|ccc", "c|ccc"]
    for spec, body in blocks:
        columns = spec.replace("|", "").count("c")
        for line in body.splitlines():
            if "\\\\" in line:
                cells = sum(int(n) for n in re.findall(r"multicolumn\{(\d+)\}", line))
                plain = line.count("&") + 1 - line.count("multicolumn")
                assert cells + plain - line.count("\\&") == columns, line
        assert body.count("{") == body.count("}")
    assert "a\\_b \\& c" in text
    assert "on \\textit{outdoor} (4 photos)" in text
    assert "RMSE$\\downarrow$ & 0.500 & 0.500 & 0.500 & 0.025" in text
    assert "\\textbf{0.250}" in text
    assert "--" in text  # a method that outdoors has no score
    assert "–" not in text


def test_protocol_l_sets_what_is_nearest_zero_in_bold_and_counts_not() -> None:
    protocol = PROTOCOLS["L"]
    found = rows(protocol, {"low": -0.2, "high": 0.3})
    text = markdown(report_of(protocol, found, [], 50))
    line = next(line for line in text.splitlines() if line.startswith("| low |"))
    assert "**-0.50**" in line
    values = [cell.strip() for cell in line.strip("|").split("|")][1:]
    sources = protocol.cells.index("sources")
    assert not values[sources].startswith("**")
    assert latex(report_of(protocol, found, [], 50)).count("\\\\") == 4


def test_what_is_not_defined_is_a_dash() -> None:
    protocol = PROTOCOLS["L"]
    found = [
        replace(row, cells=dict(row.cells) | {"active_anchors": math.nan})
        for row in rows(protocol, {"a": 1.0})
    ]
    text = markdown(report_of(protocol, found, [], 50))
    assert all(line.endswith("| – |") for line in text.splitlines() if line.startswith("| a |"))
    (first, *_) = list(csv.DictReader(io.StringIO(samples_csv(protocol, found))))
    assert first["active_anchors"] == ""


def test_samples_as_csv() -> None:
    table = list(csv.DictReader(io.StringIO(samples_csv(M, rows(M, METHODS)))))
    assert len(table) == 20
    assert table[7] == {
        "sample": "indoor3_az000", "scene": "indoor3", "group": "g3", "category": "indoor",
        "azimuth_deg": "0", "gain": "1.5", "method": "oracle:sh2", **dict.fromkeys(M.cells, "0.04"),
    }  # fmt: skip


def test_no_score_is_refused() -> None:
    with pytest.raises(ValueError, match="expected scores"):
        report_of(M, [])
