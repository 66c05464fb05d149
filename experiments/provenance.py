"""Where a number comes from: what every file of `experiments/results` says of itself.

`tests/experiments/test_results.py` holds the files to it.
"""

import importlib.metadata
import os
import platform
from collections.abc import Sequence
from typing import Any

from mixlight.training.card import commit

PACKAGES = ("mixlight", "torch", "numpy")

NOTHING_RANDOM = "none: nothing is drawn"
"""What stands for the seed where there is none."""


def provenance(protocol: str, n: int, seed: int | Sequence[int] | None) -> dict[str, Any]:
    """Commit, machine and versions, and how the result was measured.

    To be called before anything is written, since what is written may change the tree.

    Args:
        protocol: what was measured how: a letter of `mixlight evaluate`, or words.
        n: how many things (photos, panoramas, repetitions) the numbers are taken over.
        seed: all that is random comes from it; None if nothing is.

    Raises:
        ValueError: nothing was measured.
    """
    if n < 1:
        raise ValueError(f"expected a result over one thing or more, got {n}")
    return {
        "commit": commit(),
        "machine": f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: importlib.metadata.version(name) for name in PACKAGES},
        "protocol": protocol,
        "n": n,
        "seed": NOTHING_RANDOM if seed is None else seed if isinstance(seed, int) else list(seed),
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
