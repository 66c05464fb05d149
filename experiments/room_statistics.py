"""The light of a set of rooms beside that of real interiors, as `mixlight rooms stats` measures it.

    python -m experiments.room_statistics SET --made-by COMMIT

`--made-by` is the commit that rendered the set, which the set's own files do not know.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

from experiments.provenance import provenance
from mixlight.image.atomic import atomic_path

RESULT = Path(__file__).parent / "results" / "room_statistics.json"
PLOT = Path(__file__).parents[1] / "docs" / "images" / "rooms_statistics.png"
KEPT = ("width", "samples", "cameras")
"""What of a set's header says how its rooms look."""


def main() -> None:
    """Measure, draw and write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("set", type=Path, help="folder that `mixlight rooms` wrote")
    parser.add_argument("--made-by", required=True, metavar="COMMIT")
    parser.add_argument("--recipes", type=int, default=3, help="random relightings of each panorama")
    parser.add_argument("--seed", type=int, default=0, help="of the relightings")
    arguments = parser.parse_args()
    command = [sys.executable, "-m", "mixlight.app.cli", "rooms", "stats", str(arguments.set), "--json"]
    command += ["--recipes", str(arguments.recipes), "--seed", str(arguments.seed), "--plot", str(PLOT)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    found = json.loads(done.stdout)
    del found["input"], found["ok"]
    header = json.loads((arguments.set / "rooms.json").read_text(encoding="utf-8"))
    seeds = sorted(int(folder.name.split("-")[1]) for folder in arguments.set.glob("room-*"))
    found |= {
        "recipes": arguments.recipes,
        "set": {key: header[key] for key in KEPT}
        | {"seeds": [seeds[0], seeds[-1]], "commit": arguments.made_by},
        "provenance": provenance("mixlight rooms stats", found["panoramas"], arguments.seed),
    }
    with atomic_path(RESULT) as temporary:
        temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
