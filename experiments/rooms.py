"""Do rendered rooms help? Equal trainings on real panoramas, on rooms and on both, scored on real photos.

    python -m experiments.rooms tables data/rooms-set --keep data/rooms.csv --sizes 60 180 --out build/rooms
    python -m experiments.rooms score data/panoramas.csv runs/H_* --label rooms=prototype

`tables` writes a training table for each size of a set (the first rooms by seed, so that the smaller lies
within the larger; a room that cannot be read is left out) with one and the same validation rooms, and prints
the trainings to be run. However many rooms there are, they are drawn as often as those of `--keep`: only
their variety differs, not their share of a batch.

`score` takes whatever runs are finished, tells from their cards what each was trained on, and refuses runs
that differ in anything else. Every run is scored once and kept (`--cache`), so that it can be called again as
runs come in. Runs that differ in their seed only are one condition; its number is the mean over the seeds of
the median error over all views. Intervals are bootstrapped over panoramas and over seeds, both at once;
ratios pair the panoramas.
"""

import argparse
import csv
import hashlib
import io
import json
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from experiments.provenance import provenance
from mixlight.data.evaluation_set import EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.data.relit import has_groups
from mixlight.data.rooms.store import read_room
from mixlight.image.atomic import atomic_path
from mixlight.network.estimator import Estimator
from mixlight.network.model import MixLightNet
from mixlight.render.spheres import SphereRenderer
from mixlight.training.validation import SPHERES, predicted_environments, score_spheres

OUT = Path(__file__).parent / "results" / "rooms.json"
CELLS = tuple(f"{sphere}_{kind}" for kind in ("rmse", "si_rmse") for sphere in SPHERES)
REAL = ("indoor", "studio", "covered", "outdoor")
"""Categories of real panoramas."""

FREE = ("tables", "name", "seed", "workers", "tensorboard", "checkpoint_every", "sampling.weights.")
"""Keys of a config, or beginnings of them, in which compared runs may differ: how often each category is
drawn is the question itself."""

RESAMPLES = 4000
_BATCH = 16


def main() -> None:
    """One of the two actions."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    actions = parser.add_subparsers(dest="action", required=True)
    made = actions.add_parser("tables", help="tables of two or more sizes, and the trainings to run")
    made.add_argument("rooms", type=Path, help="folder of a set with its rooms.csv, or such a table")
    made.add_argument("--name", help="of the set (default: the folder's)")
    made.add_argument("--keep", type=Path, required=True, help="table whose validation rooms all runs share")
    made.add_argument("--real", type=Path, default=Path("data/panoramas.csv"))
    made.add_argument("--sizes", type=int, nargs="+", required=True, help="numbers of training rooms")
    made.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    made.add_argument(
        "--with-kept", action="store_true", help="train on the training rooms of --keep as well"
    )
    made.add_argument("--out", type=Path, required=True)
    scored = actions.add_parser("score", help="score finished runs")
    scored.add_argument("table", type=Path, help="real panoramas")
    scored.add_argument("runs", type=Path, nargs="+", help="folders of runs")
    scored.add_argument(
        "--label", action="append", default=[], metavar="TABLE=NAME", help="what a table is called"
    )
    scored.add_argument("--split", default="test", choices=("val", "test"))
    scored.add_argument("--categories", nargs="+", default=["indoor"])
    scored.add_argument("--cache", type=Path, default=Path("build/rooms-scores"))
    scored.add_argument("--out", type=Path, default=OUT)
    arguments = parser.parse_args()
    if arguments.action == "tables":
        for line in write_tables(arguments):
            print(line)
    else:
        score(arguments)


# ----------------------------------------------------------------------------------------------------- tables


def write_tables(arguments: argparse.Namespace) -> list[str]:
    """Write a table for each size; returns the commands that train on them."""
    source = arguments.rooms / "rooms.csv" if arguments.rooms.is_dir() else arguments.rooms
    name = arguments.name or source.resolve().parent.name
    kept = read_table(arguments.keep)
    reference = len(select(kept, "train"))
    further = select(kept, "train") if arguments.with_kept else []
    if further:
        name += f"-and-{arguments.keep.stem}"
    rooms: dict[str, list[PanoramaRecord]] = {}
    for record in read_table(source):
        if record.split == "train" and _whole(record):
            rooms.setdefault(record.group, []).append(record)
    arguments.out.mkdir(parents=True, exist_ok=True)
    commands = []
    for size in sorted(arguments.sizes):
        if size > len(rooms):
            raise SystemExit(f"{source}: expected at least {size} training rooms, got {len(rooms)}")
        chosen = [record for group in sorted(rooms)[:size] for record in rooms[group]] + further
        table = arguments.out / f"{name}-{size}.csv"
        with atomic_path(table) as temporary:
            temporary.write_text(as_csv([*chosen, *select(kept, "val")], table.parent), encoding="utf-8")
        weight = round(reference / len(chosen), 4)
        tables = json.dumps([str(arguments.real.resolve()), str(table.resolve())])
        for seed in arguments.seeds:
            for what, weights in (
                ("rooms", {"room": weight} | dict.fromkeys(REAL, 0.0)),
                ("both", {"room": weight}),
            ):
                overrides = [f"tables={tables}", f"seed={seed}"]
                overrides += [f"sampling.weights.{key}={value}" for key, value in weights.items()]
                sets = " ".join(f"--set '{override}'" for override in overrides)
                run = f"runs/{name}-{size}_{what}_{seed}"
                commands.append(f"mixlight train experiments/quick.toml --out {run} {sets}")
    return commands


def _whole(record: PanoramaRecord) -> bool:
    """Whether a room can be trained on; says so where not."""
    if not has_groups(record):
        return True
    try:
        read_room(record.path)
    except ValueError as error:
        print(f"left out: {error}", file=sys.stderr)
        return False
    return True


def as_csv(records: Sequence[PanoramaRecord], folder: Path) -> str:
    """A table of panoramas that shall lie in a folder."""
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    rows.writerow(("scene", "file", "split", "category", "group"))
    for record in records:
        path = os.path.relpath(record.path.resolve(), folder.resolve())
        rows.writerow((record.scene, path, record.split, record.category, record.group))
    return stream.getvalue()


# ------------------------------------------------------------------------------------------------------ score


@dataclass(frozen=True)
class Condition:
    """What a network was trained on."""

    real: int
    """Real panoramas."""
    rooms: int
    """Panoramas of rooms."""
    tables: tuple[str, ...]
    """Names of the tables that the rooms came from; none where there were none."""

    @property
    def label(self) -> str:
        """A name for tables."""
        names = " + ".join(self.tables)
        if not self.rooms:
            return "real only"
        return f"rooms only: {names}" if not self.real else f"real and rooms: {names}"


@dataclass(frozen=True)
class Run:
    """A finished training."""

    name: str
    condition: Condition
    seed: int
    config: Mapping[str, Any]
    commit: str
    validation: float
    """The score that chose its weights."""
    step: int
    cells: np.ndarray
    """[views, 6] errors, in the order of `CELLS`."""


def score(arguments: argparse.Namespace) -> None:
    """Score every finished run and write the results."""
    labels = dict(text.split("=", 1) for text in arguments.label)
    records = select(read_table(arguments.table), arguments.split, arguments.categories)
    if not records:
        raise SystemExit(f"{arguments.table}: expected {arguments.split} panoramas, got none")
    views: dict[Any, list[EvaluationSample]] = {}
    runs = []
    for folder in arguments.runs:
        if not (folder / "model.safetensors").is_file():
            print(f"{folder}: left out, not finished")
            continue
        estimator = Estimator.load(str(folder / "model.safetensors"))
        canonical = estimator.model.settings.canonical
        if canonical not in views:
            views[canonical] = collect(records, canonical)
        if "members" in estimator.card:
            raise SystemExit(f"{folder}: expected a single training, got a mean of members")
        cells = _cells(folder, estimator, views[canonical], arguments.cache)
        runs.append(_run(folder.name, estimator.card, labels, cells))
        medians = np.median(cells, 0)
        print(f"{folder.name:28s} {runs[-1].condition.label:44s}", *(f"{cell:.3f}" for cell in medians))
    if not runs:
        raise SystemExit("expected at least one finished run, got none")
    check_equal(runs)
    scenes = [sample.scene for sample in next(iter(views.values()))]
    result = {
        "question": "do rendered rooms help, trained on alone and beside real panoramas",
        "split": arguments.split,
        "categories": arguments.categories,
        "panoramas": sorted(set(scenes)),
        "views": len(scenes),
        "provenance": provenance("M", len(scenes), 0),
        "numbers": "error: mean over seeds of the median over views; ratio: to real only, on the same "
        f"panoramas; interval_95: {RESAMPLES} bootstrap draws over panoramas and over seeds",
        "conditions": summarise(runs, scenes),
    }
    with atomic_path(arguments.out) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for entry in result["conditions"]:
        numbers = [entry["cells"][cell] for cell in CELLS]
        print(f"{entry['label']:44s}", *(f"{n['error']:.3f} {n['interval_95']}" for n in numbers[:2]))


def _cells(
    folder: Path, estimator: Estimator, samples: Sequence[EvaluationSample], cache: Path
) -> np.ndarray:
    """Errors of a run on every view, from the cache where they are known."""
    digest = hashlib.sha256((folder / "model.safetensors").read_bytes())
    digest.update(repr(SphereRenderer(resolution=1).rim_step).encode())
    for sample in samples:
        digest.update(sample.scene.encode())
        digest.update(sample.photo.numpy().tobytes())
    entry = cache / f"{folder.name}-{digest.hexdigest()[:16]}.json"
    if entry.is_file():
        return np.array(json.loads(entry.read_text(encoding="utf-8")))
    cells = view_errors(estimator.model, samples)
    cache.mkdir(parents=True, exist_ok=True)
    with atomic_path(entry) as temporary:
        temporary.write_text(json.dumps(np.round(cells, 6).tolist()), encoding="utf-8")
    return np.round(cells, 6)


def view_errors(model: MixLightNet, samples: Sequence[EvaluationSample]) -> np.ndarray:
    """[views, 6] errors of a network, in the order of `CELLS`."""
    renderer = SphereRenderer(resolution=64)
    model.eval()
    rows = []
    with torch.inference_mode():
        for start in range(0, len(samples), _BATCH):
            batch = samples[start : start + _BATCH]
            found = model(torch.stack([sample.photo for sample in batch]))
            predicted = predicted_environments(found, model.settings.sharpness)
            rows.append(score_spheres(renderer, predicted, torch.stack([s.environment for s in batch])))
    return torch.cat(rows).flatten(1).double().numpy()


def columns(found: np.ndarray) -> dict[str, list[float]]:
    """Each cell's errors, as `view_errors` gives them, by its name."""
    return {cell: found[:, k].tolist() for k, cell in enumerate(CELLS)}


def _run(name: str, card: Mapping[str, Any], labels: Mapping[str, str], cells: np.ndarray) -> Run:
    """A run as its card describes it."""
    counts = dict(card["data"]["by_category"])
    rooms = int(counts.pop("room", 0))
    # The first table holds the real panoramas, the others rooms.
    stems = [Path(table).stem for table in card["data"]["tables"][1:]]
    tables = tuple(labels.get(stem, stem) for stem in stems) if rooms else ()
    return Run(
        name=name,
        condition=Condition(sum(counts.values()), rooms, tables),
        seed=int(card["config"]["seed"]),
        config=_flat(card["config"]),
        commit=card["commit"],
        validation=float(card["validation"]["score"]),
        step=int(card["validation"]["step"]),
        cells=cells,
    )


def _flat(values: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in values.items():
        flat |= _flat(value, f"{where}{key}.") if isinstance(value, Mapping) else {f"{where}{key}": value}
    return flat


def check_equal(runs: Sequence[Run]) -> None:
    """Refuse a comparison of runs that differ in more than their data.

    A key that a run does not have is of a version before it, whose behaviour is its default: not compared.
    """
    first = runs[0]
    for run in runs[1:]:
        shared = first.config.keys() & run.config.keys()
        differing = sorted(
            key for key in shared if not key.startswith(FREE) and first.config[key] != run.config[key]
        )
        if differing:
            raise SystemExit(
                f"{run.name}: expected a training like {first.name} but for its data, they differ in "
                f"{', '.join(differing)}"
            )
        if len(run.cells) != len(first.cells):
            raise SystemExit(f"{run.name}: expected {len(first.cells)} views, got {len(run.cells)}")


def summarise(runs: Sequence[Run], scenes: Sequence[str]) -> list[dict[str, Any]]:
    """The table: a condition a row, real only first, then by what is in it."""
    conditions: dict[Condition, list[Run]] = {}
    for run in runs:
        conditions.setdefault(run.condition, []).append(run)
    ordered = sorted(
        conditions, key=lambda c: (bool(c.rooms), bool(c.real), c.rooms if c.tables else 0, c.tables)
    )
    baseline = next((conditions[c] for c in ordered if not c.rooms), None)
    base = None if baseline is None else np.stack([run.cells for run in baseline])
    base_drawn = np.ones((1, len(CELLS))) if base is None else _medians(base, scenes, role=1)
    table = []
    for condition in ordered:
        members = sorted(conditions[condition], key=lambda run: run.seed)
        if len({run.seed for run in members}) < len(members):
            raise SystemExit(f"{condition.label}: expected every seed once, got {[r.name for r in members]}")
        entry: dict[str, Any] = {
            "label": condition.label,
            "real": condition.real,
            "rooms": condition.rooms,
            "tables": list(condition.tables),
            "seeds": [run.seed for run in members],
            "commits": sorted({run.commit for run in members}),
            "validation": [round(run.validation, 4) for run in members],
            "steps": [run.step for run in members],
            "cells": {},
        }
        ours = np.stack([run.cells for run in members])
        drawn = _medians(ours, scenes, role=0)
        for k, cell in enumerate(CELLS):
            seeds = np.median(ours[:, :, k], 1)
            entry["cells"][cell] = {
                "error": _rounded(seeds.mean()),
                "interval_95": _interval(drawn[:, k]),
                "seeds": [_rounded(value) for value in seeds],
            }
            if base is not None and condition.rooms:
                ratio = seeds.mean() / np.median(base[:, :, k], 1).mean()
                entry["cells"][cell]["ratio"] = _rounded(ratio)
                entry["cells"][cell]["ratio_interval_95"] = _interval(drawn[:, k] / base_drawn[:, k])
        table.append(entry)
    return table


def _medians(cells: np.ndarray, scenes: Sequence[str], role: int) -> np.ndarray:
    """Bootstrap draws [draws, cells] of the mean over seeds of the median over views.

    Every call draws the same panoramas, so that two conditions are compared on the same ones; seeds are drawn
    anew for each role, since equal seeds of two conditions have nothing in common.

    Args:
        cells: [seeds, views, cells].
        scenes: the panorama of each view.
        role: 0 for a condition, 1 for what it is compared with.
    """
    places, seeds = np.random.default_rng(0), np.random.default_rng(1 + role)
    names = sorted(set(scenes))
    members = [np.flatnonzero(np.array(scenes) == name) for name in names]
    draws = np.empty((RESAMPLES, cells.shape[-1]))
    for k in range(RESAMPLES):
        views = np.concatenate([members[i] for i in places.integers(len(names), size=len(names))])
        rows = seeds.integers(len(cells), size=len(cells))
        draws[k] = np.median(cells[:, views], 1)[rows].mean(0)
    return draws


def _interval(draws: np.ndarray) -> list[float]:
    low, high = np.quantile(draws, (0.025, 0.975))
    return [_rounded(low), _rounded(high)]


def _rounded(value: float) -> float:
    return round(float(value), 4)


if __name__ == "__main__":
    main()
