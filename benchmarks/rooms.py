"""What a room costs: core-seconds by kind of work, and how many rooms a core makes in an hour.

    python -m benchmarks.rooms [--seed N] [--count N] [--width W] [--samples N] [--out JSON]

Time is counted as CPU time of Blender and of everything around it, so that what else the machine does hardly
matters; on an idle machine with one Blender on all cores it is wall time times cores.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.report import save
from experiments.provenance import provenance
from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.job import Settings
from mixlight.data.rooms.render import Outcome, Rooms, render_rooms

SHARE = 0.05
"""Of the time that may go into anything but Cycles and its denoiser."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=0, help="of the first room")
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--width", type=int, default=1024)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--out", type=Path, help="JSON file")
    arguments = parser.parse_args()
    rooms = Rooms(Settings(arguments.width, arguments.samples), 1, Catalogue.find())
    seeds = range(arguments.seed, arguments.seed + arguments.count)
    made = provenance("processor time of whole rooms, by kind of work", arguments.count, arguments.seed)
    with tempfile.TemporaryDirectory() as folder:
        before = time.process_time()
        outcomes = render_rooms(seeds, Path(folder) / "set", rooms)
        around = time.process_time() - before
    found = costs([outcome for outcome in outcomes if outcome.error is None], around)
    settings = {key: getattr(arguments, key) for key in ("count", "width", "samples")}
    result = {"provenance": made, **settings, **found}
    print(json.dumps(result, indent=1))
    if arguments.out:
        save(arguments.out, result)


def costs(outcomes: list[Outcome], around: float) -> dict[str, Any]:
    """Core-seconds a panorama by kind of work; `around` is what the host spent."""
    if not outcomes:
        raise SystemExit("expected a room, got none: all have failed")
    count = len(outcomes)
    blender = {
        kind: sum(o.core_seconds[kind] for o in outcomes) / count for kind in ("build", "render", "denoise")
    }
    spent = {"host": around / count, **blender}
    total = sum(spent.values())
    return {
        "rooms": count,
        "core_seconds": {kind: round(value, 3) for kind, value in spent.items()},
        "panoramas_an_hour_and_core": round(3600 / total, 1),
        "share_not_cycles": round((spent["host"] + spent["build"]) / total, 4),
        "limit": SHARE,
    }


if __name__ == "__main__":
    main()
