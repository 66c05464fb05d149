"""The pages that hold measured tables, and their blocks.

A block stands between `<!-- table NAME -->` and `<!-- /table -->`. It is left empty where its result is not
there yet. `tests/test_docs.py` fails when a block is not what this would write.
"""

import re
from pathlib import Path

from experiments.tables import (
    ablations,
    costs,
    detail,
    evaluation,
    insertion,
    onnx,
    representation,
    rooms,
    spheres,
    training,
    turning,
)
from experiments.tables.results import Tables

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"(<!-- table ([\w-]+) -->\n).*?(<!-- /table -->)", re.DOTALL)
TABLES: Tables = {
    **evaluation.TABLES,
    **spheres.TABLES,
    **representation.TABLES,
    **training.TABLES,
    **rooms.TABLES,
    **detail.TABLES,
    **turning.TABLES,
    **onnx.TABLES,
    **insertion.TABLES,
    **ablations.TABLES,
    **costs.TABLES,
}
"""Every table by the name that the pages call it."""


def pages() -> list[Path]:
    """README.md, the pages below docs and that of the benchmarks."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), ROOT / "benchmarks/README.md"]


def filled(text: str) -> str:
    """The text with every block made anew."""
    return BLOCK.sub(lambda match: match[1] + TABLES[match[2]]() + match[3], text)
