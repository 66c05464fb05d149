"""How trainings fare on real places that they have not seen: 36 of the training split instead of five of val.

    python -m experiments.unseen tables data/panoramas.csv --out runs/tables
    python -m experiments.unseen score data/panoramas.csv --model "rooms alone=runs/rooms_first" \\
        --model "both=runs/fold/both-A+runs/fold/both-B"

`tables` halves the indoor, studio and covered panoramas of the training split, and writes a table without
each half; a training on either says what that way of training is worth on the half that it lacks. `score`
scores a model on what its card says it has not seen: all of them where it was trained on rooms alone. Ratios
are to the first model: geometric means over the same views, intervals over places.
"""

import argparse
import json
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from experiments.provenance import provenance
from experiments.rooms import CELLS, as_csv, columns, view_errors
from mixlight.data.evaluation_set import collect
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.evaluation.statistics import paired_ratio
from mixlight.image.atomic import atomic_path
from mixlight.network.estimator import Estimator

RESULT = Path(__file__).parent / "results" / "unseen.json"
CATEGORIES = ("indoor", "studio", "covered")
FOLDS = ("A", "B")


def main() -> None:
    """One of the two actions."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    actions = parser.add_subparsers(dest="action", required=True)
    made = actions.add_parser("tables", help="a table without each half of the places")
    made.add_argument("table", type=Path, help="real panoramas")
    made.add_argument("--out", type=Path, required=True, help="folder of the tables")
    scored = actions.add_parser("score", help="score models on what they have not seen")
    scored.add_argument("table", type=Path, help="real panoramas")
    scored.add_argument("--model", action="append", required=True, metavar="NAME=RUN[+RUN]")
    arguments = parser.parse_args()
    records = read_table(arguments.table)
    if arguments.action == "tables":
        arguments.out.mkdir(parents=True, exist_ok=True)
        for fold in FOLDS:
            table = arguments.out / f"without-{fold}.csv"
            with atomic_path(table) as temporary:
                temporary.write_text(as_csv(without(records, fold), table.parent), encoding="utf-8")
            print(table)
    else:
        score(records, arguments.model)


def halves(records: Sequence[PanoramaRecord]) -> dict[str, set[str]]:
    """The places (groups) of either half."""
    groups = sorted({record.group for record in select(records, "train", CATEGORIES)})
    random.Random(0).shuffle(groups)
    return {fold: set(groups[k :: len(FOLDS)]) for k, fold in enumerate(FOLDS)}


def without(records: Sequence[PanoramaRecord], fold: str) -> list[PanoramaRecord]:
    """What a training may see that lacks a half; never a test panorama."""
    left_out = halves(records)[fold]
    train = [record for record in select(records, "train") if record.group not in left_out]
    return train + select(records, "val")


def unseen(card: dict[str, Any], folds: dict[str, set[str]]) -> set[str]:
    """The places that a model has not seen, by its card and that of the model that it went on from.

    Raises:
        ValueError: it has seen real panoramas of both halves.
    """
    places = set().union(*folds.values())
    if set(card["data"]["by_category"]) != {"room"}:
        left_out = [fold for fold in folds if f"without-{fold}.csv" in card["data"]["tables"]]
        if len(left_out) != 1:
            tables = ", ".join(card["data"]["tables"])
            raise ValueError(
                f"{card['name']}: expected rooms alone or a table without one half, got {tables}"
            )
        places = folds[left_out[0]]
    before = card.get("started_from")
    return places & unseen(before, folds) if before else places


def score(records: Sequence[PanoramaRecord], models: Sequence[str]) -> None:
    """Score every model and write the result."""
    folds = halves(records)
    places = select(records, "train", CATEGORIES)
    cells: dict[str, np.ndarray] = {}
    rows: dict[str, Any] = {}
    groups = [record.group for record in places for _ in range(8)]
    for text in models:
        name, _, runs = text.partition("=")
        found = np.full((len(groups), len(CELLS)), np.nan)
        commits, val = [], []
        for run in runs.split("+"):
            estimator = Estimator.load(Path(run) / "model.safetensors")
            here = unseen(estimator.card, folds)
            mine = [record for record in places if record.group in here]
            samples = collect(mine, estimator.model.settings.canonical)
            found[[group in here for group in groups]] = view_errors(estimator.model, samples)
            commits.append(estimator.card["commit"])
            val.append(round(estimator.card["validation"]["score"], 4))
        if np.isnan(found).any():
            raise SystemExit(f"{name}: expected runs that lack every place once, got {runs}")
        cells[name] = found
        first = columns(cells[next(iter(cells))])
        rows[name] = {
            "commits": sorted(set(commits)),
            "val_score": val,
            "geometric_mean": dict(zip(CELLS, np.exp(np.log(found).mean(0)).round(4).tolist(), strict=True)),
            "median": dict(zip(CELLS, np.median(found, 0).round(4).tolist(), strict=True)),
            "ratio": paired_ratio(columns(found), first, groups),
        }
        print(name, rows[name]["geometric_mean"], rows[name]["ratio"]["diffuse_rmse"])
    result = {
        "question": "which way of training is better on real places that the network has not seen",
        "provenance": provenance("M, 8 views of each panorama", len(groups), 0),
        "panoramas": len(places),
        "places": len({record.group for record in places}),
        "models": rows,
    }
    with atomic_path(RESULT) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
