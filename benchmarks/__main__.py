"""Measures the benchmarks and prints their table: `python -m benchmarks [a b c d e f] [--out JSON]`."""

import argparse
import json
from pathlib import Path
from typing import Any

from benchmarks import cold_start, estimate, fit, slsparsemax, spheres, training_step
from benchmarks.report import HEAD, basis, cells, save
from benchmarks.timing import Result
from experiments.provenance import provenance

ROWS = {"a": estimate, "b": cold_start, "c": slsparsemax, "d": fit, "e": training_step, "f": spheres}
PROTOCOL = "wall time of both in turn, order swapped every round; median and quartiles of the rounds' ratios"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", nargs="*", metavar="ROW", help="a to f (default: all)")
    parser.add_argument("--out", type=Path, help="JSON file; rows that are not measured now stay in it")
    arguments = parser.parse_args()
    unknown = set(arguments.rows) - set(ROWS)
    if unknown:
        parser.error(f"expected rows out of {', '.join(ROWS)}, got {', '.join(sorted(unknown))}")
    kept = arguments.out is not None and arguments.out.is_file()
    rows = json.loads(arguments.out.read_text(encoding="utf-8"))["rows"] if kept else {}
    made = provenance(PROTOCOL, 1, 0)
    print(f"{basis(made)}\n\n| {' | '.join(HEAD)} |\n{'|---' * len(HEAD)}|")
    for name in arguments.rows or ROWS:
        rows[name] = as_json(ROWS[name].measure(), made)
        print(f"| {' | '.join(cells(name, rows[name]))} |", flush=True)
        if arguments.out:
            save(arguments.out, {"rows": dict(sorted(rows.items()))})


def as_json(row: Result, made: dict[str, Any]) -> dict[str, Any]:
    """One row of the table."""
    return {
        "ours": row.ours,
        "against": row.reference,
        "seconds": [round(value, 4) for value in row.seconds],
        "ratio": round(row.ratio, 5),
        "quartiles": [round(value, 5) for value in row.spread],
        "limit": row.limit,
        "provenance": made | {"n": len(row.ratios)},
    }


if __name__ == "__main__":
    main()
