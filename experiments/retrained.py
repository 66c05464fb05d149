"""Trainings that might go into the box, side by side: light and camera on val, and the errors on test.

    python -m experiments.retrained data/panoramas.csv data/rooms.csv --model S=default --model U=FILE

Val decides; test stands beside it so that nothing that was seen is kept back. Of several files, with a `+`
between them, it is the mean of their weights.
"""

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
import torch

from experiments.evaluation import camera_error
from experiments.provenance import provenance
from experiments.rooms import CELLS, view_errors
from mixlight.data.evaluation_set import collect
from mixlight.data.panoramas import read_table, select
from mixlight.image.atomic import atomic_path
from mixlight.network import weights
from mixlight.network.estimator import Estimator
from mixlight.training.members import average
from mixlight.training.validation import ValidationSet

RESULT = Path(__file__).parent / "results" / "retrained.json"
ROOM_AZIMUTHS = 2


def main() -> None:
    """Score every model and write the result."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs=2, type=Path, help="real panoramas, and rooms")
    parser.add_argument("--model", action="append", required=True, metavar="NAME=WEIGHTS[+WEIGHTS...]")
    arguments = parser.parse_args()
    real, rooms = (read_table(table) for table in arguments.tables)
    val = {"real": select(real, "val", ["indoor"]), "rooms": select(rooms, "val")}
    models = {name: load(paths.split("+")) for name, _, paths in (m.partition("=") for m in arguments.model)}
    canonical = next(iter(models.values())).model.settings.canonical
    validation = ValidationSet([*val["real"], *val["rooms"]], canonical, ROOM_AZIMUTHS)
    photos = collect(select(real, "test", ["indoor"]), canonical)
    rows = {}
    for name, estimator in models.items():
        model = estimator.model.eval()
        with torch.inference_mode():
            camera = {kind: camera_error(records, model) for kind, records in val.items()}
        medians = np.median(view_errors(model, photos), 0)
        found_on_val = validation.evaluate(model)
        rows[name] = {
            "commit": estimator.card["commit"],
            "seed": estimator.card["config"]["seed"],
            "val": {key: round(value, 4) for key, value in found_on_val.items() if "score" in key},
            "camera_on_val": {
                kind: {key: round(value, 2) for key, value in row.items()} for kind, row in camera.items()
            },
            "test_medians": {c: round(float(v), 4) for c, v in zip(CELLS, medians, strict=True)},
        }
        print(name, rows[name])
    result = {
        "val_panoramas": {kind: len(records) for kind, records in val.items()},
        "models": rows,
        "provenance": provenance("M on test, validation's score on val", len(photos), None),
    }
    with atomic_path(RESULT) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def load(paths: list[str]) -> Estimator:
    """A model, or the mean of several, with the card of the first."""
    if len(paths) == 1:
        return Estimator.load(paths[0])
    found = [weights.load(weights.find(path)) for path in paths]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mean.safetensors"
        weights.save(file, average([state for state, _ in found]), found[0][1], half=True)
        return Estimator.load(file)


if __name__ == "__main__":
    main()
