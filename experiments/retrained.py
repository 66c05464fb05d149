"""Trainings that might go into the box, side by side: light and camera on val, and the errors on test.

    python -m experiments.retrained data/panoramas.csv data/rooms.csv --model S=FILE --model R=default

Val decides; test stands beside it so that nothing that was seen is kept back. Of several files, with a `+`
between them, it is the mean of their weights. Ratios are of the last model's errors on test over each one's:
geometric means over the same photos, intervals over places.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import torch

from experiments.evaluation import camera_error
from experiments.provenance import provenance
from experiments.rooms import CELLS, columns, view_errors
from mixlight.data.evaluation_set import collect
from mixlight.data.panoramas import read_table, select
from mixlight.evaluation.statistics import paired_ratio
from mixlight.image.atomic import atomic_path
from mixlight.network import weights
from mixlight.network.estimator import Estimator
from mixlight.training.members import average
from mixlight.training.validation import ValidationSet

RESULT = Path(__file__).parent / "results" / "retrained.json"
ROOM_AZIMUTHS = 2
AZIMUTHS = 8
"""Views of each real panorama."""


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
    seen = [estimator.model.settings.canonical for estimator in models.values()]
    validations = {c: ValidationSet([*val["real"], *val["rooms"]], c, ROOM_AZIMUTHS) for c in set(seen)}
    test = select(real, "test", ["indoor"])
    photos = {c: collect(test, c) for c in set(seen)}
    groups = [record.group for record in test for _ in range(AZIMUTHS)]
    rows: dict[str, Any] = {}
    errors: dict[str, dict[str, list[float]]] = {}
    for name, estimator in models.items():
        model = estimator.model.eval()
        canonical = model.settings.canonical
        with torch.inference_mode():
            camera = {kind: camera_error(records, model) for kind, records in val.items()}
        found = view_errors(model, photos[canonical])
        errors[name] = columns(found)
        medians, means = np.median(found, 0), found.mean(0)
        found_on_val = validations[canonical].evaluate(model)
        rows[name] = {
            "commit": estimator.card["commit"],
            "seed": estimator.card["config"]["seed"],
            "val": {key: round(value, 4) for key, value in found_on_val.items() if "score" in key},
            "camera_on_val": {
                kind: {key: round(value, 2) for key, value in row.items()} for kind, row in camera.items()
            },
            "test_medians": {c: round(float(v), 4) for c, v in zip(CELLS, medians, strict=True)},
            "test_means": {c: round(float(v), 4) for c, v in zip(CELLS, means, strict=True)},
        }
        print(name, rows[name])
    last = errors[name]
    for name, row in rows.items():
        row["last_over_this"] = paired_ratio(last, errors[name], groups)
    result = {
        "val_panoramas": {kind: len(records) for kind, records in val.items()},
        "models": rows,
        "provenance": provenance("M on test, validation's score on val", len(groups), 0),
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
