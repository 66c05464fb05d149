"""Measures the real interiors that `mixlight rooms stats` compares with, and writes the file that ships.

    python scripts/measure_real_interiors.py data/panoramas.csv

Run it whenever a statistic changes. Only the train split is measured: rooms are tuned by these numbers, and
what is scored on must have no part in that.
"""

import argparse
import json
from importlib import resources
from pathlib import Path
from typing import Any

from mixlight.data import rooms
from mixlight.data.panoramas import read_radiance, read_table, select
from mixlight.data.rooms.stats import Reference, measure, reference_document
from mixlight.image.atomic import atomic_path


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", type=Path, help="CSV table of panoramas")
    arguments = parser.parse_args()
    records = select(read_table(arguments.table), "train", ("indoor",))
    measured = {record.scene: measure(read_radiance(record.path)) for record in records}
    name = f"{len(measured)} real training interiors"
    document = reference_document(Reference(name, measured))
    with atomic_path(Path(str(resources.files(rooms))) / "real_interiors.json") as temporary:
        temporary.write_text(_one_line_each(document), encoding="utf-8")


def _one_line_each(document: dict[str, Any]) -> str:
    """JSON with a line for each panorama."""
    panoramas = [
        f"  {json.dumps(scene)}: {json.dumps(values)}" for scene, values in document["panoramas"].items()
    ]
    rest = [
        f" {json.dumps(key)}: {json.dumps(value)}" for key, value in document.items() if key != "panoramas"
    ]
    return "{\n" + ",\n".join([*rest, ' "panoramas": {\n' + ",\n".join(panoramas) + "\n }"]) + "\n}\n"


if __name__ == "__main__":
    main()
