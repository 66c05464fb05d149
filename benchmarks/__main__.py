"""Prints the table of benchmarks as Markdown: `python -m benchmarks [a b c d e f]`."""

import importlib.metadata
import platform
import sys

import torch

from benchmarks import cold_start, estimate, fit, slsparsemax, spheres, training_step

ROWS = {"a": estimate, "b": cold_start, "c": slsparsemax, "d": fit, "e": training_step, "f": spheres}


def main(wanted: list[str]) -> None:
    versions = ", ".join(
        f"{name} {importlib.metadata.version(name)}" for name in ("mixlight", "torch", "numpy")
    )
    print(
        f"{_processor()}, {torch.get_num_threads()} threads, Python {platform.python_version()}, {versions}\n"
    )
    print("| | ours | against | seconds | ratio (quartiles) | limit | |")
    print("|---|---|---|---|---|---|---|")
    for name in wanted or ROWS:
        row = ROWS[name].measure()
        low, high = row.spread
        verdict = "met" if row.ratio <= row.limit else "not met"
        print(
            f"| {row.name} | {row.ours} | {row.reference} | {row.seconds[0]:.3f} / {row.seconds[1]:.3f} "
            f"| {_ratio(row.ratio)} ({_ratio(low)} to {_ratio(high)}) | {row.limit:g} | {verdict} |",
            flush=True,
        )


def _ratio(value: float) -> str:
    return f"{value:.2f}" if value >= 0.1 else f"{value:.2g}"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()


if __name__ == "__main__":
    main(sys.argv[1:])
