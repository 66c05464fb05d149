"""How much brighter than a photo is the light around it? In real interiors, and in sets of rooms.

    python -m experiments.brightness data/panoramas.csv "prototype rooms=data/rooms.csv" \\
        "rooms, seeds 7000 to 7103=SET/rooms.csv" --count 92

What a network has to add to a photo is mostly this one number: the logarithm of the panorama's mean luminance
over the mean luminance of the (linear, clipped) photo. The views are protocol M's. Rooms are lit as they were
planned; at most `--count` panoramas of a table are taken, spread evenly over it.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from experiments.provenance import provenance
from mixlight.data.evaluation_set import samples_of
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.image.atomic import atomic_path
from mixlight.image.color import LUMINANCE_WEIGHTS
from mixlight.network import srgb
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

RESULT = Path(__file__).parent / "results" / "brightness.json"
VIEW = CanonicalView(24, 32)


def main() -> None:
    """Measure every table and write the result."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("real", type=Path, help="table of real panoramas")
    parser.add_argument("rooms", nargs="+", metavar="NAME=TABLE", help="tables of rooms")
    parser.add_argument("--count", type=int, default=60, help="panoramas of each table of rooms")
    arguments = parser.parse_args()
    real = read_table(arguments.real)
    groups = {f"real, {split}": select(real, split, ["indoor"]) for split in ("train", "val")}
    for text in arguments.rooms:
        name, _, table = text.partition("=")
        records = select(read_table(Path(table)), "train")
        groups[name] = records[:: max(1, len(records) // arguments.count)][: arguments.count]
    made = provenance("views of M; medians and quartiles over views", sum(map(len, groups.values())), None)
    result: dict[str, Any] = {
        "question": "ln(mean luminance of the panorama / mean luminance of the photo)",
        "groups": {name: measured(records) for name, records in groups.items()},
        "provenance": made,
    }
    with atomic_path(RESULT) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for name, row in result["groups"].items():
        print(f"{name:20s}", row)


def measured(records: Sequence[PanoramaRecord]) -> dict[str, Any]:
    """Quartiles and spread over all views."""
    weights = torch.tensor(LUMINANCE_WEIGHTS)
    logs = []
    for record in records:
        for sample in samples_of(record, VIEW):
            photo = srgb.decode(sample.photo.permute(1, 2, 0)) @ weights
            light = equirect.integrate(sample.environment) @ weights / (4 * torch.pi)
            logs.append(float(torch.log(light / photo.mean())))
    low, median, high = np.quantile(logs, (0.25, 0.5, 0.75))
    return {
        "panoramas": len(records),
        "views": len(logs),
        "quartiles": [round(float(value), 3) for value in (low, median, high)],
        "standard_deviation": round(float(np.std(logs)), 3),
    }


if __name__ == "__main__":
    main()
