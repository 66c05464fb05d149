"""Scores the model in the box by protocols M, S and L, indoors and outdoors, beside floors and ceilings.

    python -m experiments.evaluation data/panoramas.csv --work runs/evaluation \
        --out experiments/results/evaluation.json

Calls `mixlight evaluate` once for each protocol and gathers what it writes; a run that was stopped goes on.
Beside the tables stand the model's errors over those of each other method, photo by photo, and how well it
tells the camera's pose.
"""

import argparse
import itertools
import json
import math
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch

from experiments.numbers import rounded
from experiments.provenance import provenance
from mixlight.app import cli
from mixlight.data.camera_model import exposure_gain, plain_photo
from mixlight.data.crops import Crop, take_view
from mixlight.data.panoramas import PanoramaRecord, load_panorama, read_table, select
from mixlight.evaluation.statistics import paired_ratio
from mixlight.image.atomic import atomic_path
from mixlight.network.estimator import Estimator
from mixlight.network.methods import AnyNet

LETTERS = ("M", "S", "L")
MODEL = "mixlight"
METHODS = (MODEL, "mixlight+detail")
SPLIT = "test"
CATEGORIES = ("indoor", "outdoor")
PITCHES_DEG = (-30.0, -15.0, 0.0, 15.0)
ROLLS_DEG = (-6.0, 0.0, 6.0)
"""Poses of the views on which the camera's pitch and roll are scored."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="+", type=Path, help="CSV tables of panoramas")
    parser.add_argument("--work", type=Path, default=Path("runs/evaluation"))
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    records = [record for table in arguments.tables for record in read_table(table)]
    scored = select(records, SPLIT, CATEGORIES)
    made = provenance("M, S and L, each described below", len(scored), 0)
    result: dict[str, Any] = {"provenance": made, "split": SPLIT, "protocols": {}}
    for letter in LETTERS:
        result["protocols"][letter] = evaluate(letter, arguments.tables, arguments.work / letter)
    result["camera"] = camera_error(select(records, SPLIT, ("indoor",)))
    text = json.dumps(rounded(result), indent=1)
    # A cell on one line: thousands of numbers stay readable, and differences of two runs too.
    text = re.sub(r"\{[^{}]*\"n\"[^{}]*\}", lambda match: " ".join(match[0].split()), text)
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(text + "\n", encoding="utf-8")


def evaluate(letter: str, tables: Sequence[Path], work: Path) -> dict[str, Any]:
    """The results of one protocol, and ratios of errors."""
    words = ["evaluate", "--protocol", letter, "--split", SPLIT, "--out", os.fspath(work)]
    words += [word for table in tables for word in ("--panoramas", os.fspath(table))]
    words += [word for name in CATEGORIES for word in ("--category", name)]
    words += [word for name in METHODS for word in ("--method", name)]
    if cli.main(words):
        raise SystemExit(f"mixlight {' '.join(words)} failed")
    found: dict[str, Any] = json.loads((work / "results.json").read_text(encoding="utf-8"))
    rows = json.loads((work / "samples.json").read_text(encoding="utf-8"))["rows"]
    kept = ("protocol", "renderer", "counts", "left_out", "methods", "tables")
    return {key: found[key] for key in kept} | {"ratios": ratios(rows, found["tables"])}


def ratios(rows: Sequence[dict[str, Any]], tables: dict[str, Any]) -> dict[str, Any]:
    """Errors of the model over those of each other method, on the same photos."""
    result: dict[str, Any] = {}
    for category, methods in tables.items():
        cells: dict[str, dict[str, list[float]]] = {}
        groups: dict[str, list[str]] = {}
        for row in rows:
            if row["category"] == category:
                groups.setdefault(row["method"], []).append(row["group"])
                for cell, value in row["cells"].items():
                    column = cells.setdefault(row["method"], {}).setdefault(cell, [])
                    column.append(math.nan if value is None else value)
        result[category] = {
            name: paired_ratio(cells[MODEL], cells[name], groups[MODEL]) for name in methods if name != MODEL
        }
    return result


@torch.inference_mode()
def camera_error(records: Sequence[PanoramaRecord], model: AnyNet | None = None) -> dict[str, float]:
    """Median absolute error of pitch and roll in degrees, on views of their own with known poses.

    Beside them stands what the best constant guess (the median of the true poses) reaches. Without a model it
    is the one in the box.
    """
    model = model or Estimator.load("default").model
    canonical = model.settings.canonical
    inside = torch.ones(canonical.height, canonical.width, dtype=torch.bool)
    found, true = [], []
    for record in records:
        panorama = load_panorama(record.path)
        for k, (pitch, roll) in enumerate(itertools.product(PITCHES_DEG, ROLLS_DEG)):
            pose = (math.radians(pitch), math.radians(roll))
            crop = Crop(azimuth=k, azimuths=len(PITCHES_DEG) * len(ROLLS_DEG), pitch=pose[0], roll=pose[1])
            view = take_view(panorama, crop, canonical)
            photo = plain_photo(view, inside, exposure_gain(view, inside)).photo
            found.append(model(photo.permute(2, 0, 1)[None]).camera[0])
            true.append(torch.tensor(pose))
    poses, truth = torch.rad2deg(torch.stack(found)), torch.rad2deg(torch.stack(true))
    errors = (poses - truth).abs().median(0).values.tolist()
    guesses = (truth.median(0).values - truth).abs().median(0).values.tolist()
    return {
        "pitch_error_deg": errors[0],
        "roll_error_deg": errors[1],
        "constant_pitch_error_deg": guesses[0],
        "constant_roll_error_deg": guesses[1],
        "views": len(found),
    }


if __name__ == "__main__":
    main()
