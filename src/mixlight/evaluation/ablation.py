"""Runs an ablation variant by variant and seed by seed, and can be stopped at any moment."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from mixlight.data.panoramas import PanoramaRecord, check_split, read_table
from mixlight.evaluation.bench import Bench, columns
from mixlight.evaluation.experiment import Experiment, Variant
from mixlight.evaluation.representations import Part
from mixlight.evaluation.statistics import paired_ratio, summarise
from mixlight.image.atomic import atomic_path
from mixlight.network.canonical import CanonicalView
from mixlight.network.heads import Prediction
from mixlight.network.methods import AnyNet, environments
from mixlight.training import checkpoint as checkpoints
from mixlight.training.card import commit, versions
from mixlight.training.config import TrainingConfig, read_config, to_plain
from mixlight.training.loop import Run
from mixlight.training.validation import ValidationSet

__all__ = ["Piece", "ablate", "pieces"]

_CHUNK = 32
_ACTIVE = 1e-4
"""Anchors with a smaller share of the sources' light count as off."""

_NUMBERS = re.compile(r"\[\s+([-+.\deE,\s]+?)\s+\]")
"""A list of nothing but numbers, which takes one line of a file."""

_PROTOCOL = {
    "letter": "M",
    "spheres": "diffuse, matte, mirror; 64 x 64 pixels, orthographic, linear, unclipped; "
    "mirror sampled every half texel",
    "rmse": "over the sphere's pixels and channels, in the photo's exposure",
    "pitch_deg": -8,
    "fov_deg": 60,
}


@dataclass(frozen=True)
class Piece:
    """One variant under one seed."""

    variant: Variant
    seed: int


def pieces(experiment: Experiment) -> list[Piece]:
    """All that an experiment consists of; seed by seed, so that a stopped run has every variant once
    first.
    """
    seeds = experiment.seeds if experiment.level == "network" else (0,)
    return [Piece(variant, seed) for seed in seeds for variant in experiment.variants]


def ablate(
    experiment: Experiment,
    out: Path,
    store: Path | None = None,
    cache: Path | None = None,
    progress: Callable[[Piece], None] = lambda piece: None,
) -> dict[str, Any]:
    """Runs what is not there yet and writes the results.

    A finished piece is kept in a file that is named by a digest of all that it depends on (configuration,
    panoramas, protocol). So it is run once, however many experiments have it.

    Args:
        experiment: what to compare.
        out: the file of the results.
        store: folder of the finished pieces; `pieces` beside `out` if not given.
        cache: where labels and features are kept between runs; the user's cache folder if not given.
        progress: called after each piece.

    Returns:
        What `out` holds.

    Raises:
        ValueError: bad tables, panoramas or configurations.
        FloatingPointError: a training run has diverged.
        OSError: a file is missing, or `out` cannot be written.
    """
    store = store or out.parent / "pieces"
    store.mkdir(parents=True, exist_ok=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    records = _records(experiment)
    plan = _Networks(experiment, records, store, cache) if experiment.level == "network" else None
    bench = plan.bench if plan else Bench(records, CanonicalView(), experiment.azimuths)
    done: dict[str, list[dict[str, Any]]] = {variant.name: [] for variant in experiment.variants}
    for piece in pieces(experiment):
        digest = _digest(experiment, piece, records, plan.config(piece) if plan else None)
        file = store / f"{digest}.json"
        found = _read(file, experiment.parts)
        if found is None:
            started = time.process_time()
            found = plan.run(piece, digest) if plan else _represented(experiment, piece.variant, bench)
            found |= {"variant": piece.variant.name, "seed": piece.seed, "commit": commit()}
            found["cpu_seconds"] = round(time.process_time() - started, 1)
            _write(file, found)
        done[piece.variant.name].append(found)
        progress(piece)
    result = _result(experiment, bench, done, plan)
    _write(out, result)
    return result


class _Networks:
    """Trains and scores networks; what all of them share is made once."""

    def __init__(
        self, experiment: Experiment, records: Sequence[PanoramaRecord], store: Path, cache: Path | None
    ) -> None:
        self.experiment, self.store, self.cache = experiment, store, cache
        base = read_config(experiment.config)
        self.base = base
        self.bench = Bench(records, base.model.canonical, experiment.azimuths)
        train = [record for table in base.tables for record in read_table(table)]
        check_split([*train, *(r for r in records if r.scene not in {t.scene for t in train})])
        val = [r for r in train if r.split == "val"]
        self.validation = ValidationSet(val, base.model.canonical, base.validation_rooms)
        self._features: dict[str, tuple[Tensor, Tensor]] = {}

    def config(self, piece: Piece) -> TrainingConfig:
        """The training config of a piece.

        Raises:
            ValueError: a variant that changes what the network sees, whose photos are taken already.
        """
        config = read_config(self.experiment.config, {**piece.variant.overrides, "seed": piece.seed})
        if config.model.canonical != self.base.model.canonical or config.tables != self.base.tables:
            raise ValueError(
                f"{piece.variant.name}: expected the tables and the view of the base config, got others"
            )
        return config

    def run(self, piece: Piece, digest: str) -> dict[str, Any]:
        """Trains one network, or goes on with it, and scores it."""
        folder = self.store / digest
        run = Run(self.config(piece), folder, resume=True, cache=self.cache, validation=self.validation)
        run.finish()
        run.model.load_state_dict(run.best)
        run.model.eval()
        cells, active = self.score(run.model)
        (folder / checkpoints.FILE_NAME).unlink(missing_ok=True)
        chosen = {k: round(v, 5) for k, v in run.best_metrics.items()}
        return {"cells": cells, "active_anchors": active, "validation": chosen, "steps": run.step}

    @torch.no_grad()
    def score(self, model: AnyNet) -> tuple[dict[str, list[list[float]]], list[int] | None]:
        """Errors of each part on every view, and the number of sources of each where they are on anchors."""
        features, mean = self._of(model)
        cells: dict[str, list[list[float]]] = {part: [] for part in self.experiment.parts}
        active: list[int] | None = None
        for start in range(0, len(self.bench), _CHUNK):
            block = slice(start, start + _CHUNK)
            light = model.exposed(model.heads(features[block], mean[block]), mean[block])
            for part in self.experiment.parts:
                maps = environments(light, model.settings, part=part)
                cells[part] += _rounded(self.bench.score(maps, start, part))
            if isinstance(light, Prediction):
                share = light.distribution / light.distribution.sum(-1, keepdim=True).clamp(min=1e-12)
                active = [*(active or []), *(share > _ACTIVE).sum(-1).tolist()]
        return cells, active

    def _of(self, model: AnyNet) -> tuple[Tensor, Tensor]:
        """Features of the photos; computed once for each set of backbone weights."""
        digest = hashlib.sha256()
        for tensor in model.backbone.state_dict().values():
            digest.update(tensor.detach().cpu().contiguous().numpy().tobytes())
        key = digest.hexdigest()
        if key not in self._features:
            self._features = {key: self.bench.features(model.backbone)}
        return self._features[key]


def _represented(experiment: Experiment, variant: Variant, bench: Bench) -> dict[str, Any]:
    cells: dict[str, list[list[float]]] = {part: [] for part in experiment.parts}
    for start in range(0, len(bench), _CHUNK):
        chunk = bench.samples[start : start + _CHUNK]
        for part in experiment.parts:
            maps = [variant.representation.environment(s.environment, part) for s in chunk]
            cells[part] += _rounded(bench.score(torch.stack(maps), start, part))
    return {"cells": cells, "active_anchors": None}


def _result(
    experiment: Experiment, bench: Bench, done: Mapping[str, list[dict[str, Any]]], plan: _Networks | None
) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for variant in experiment.variants:
        runs = done[variant.name]
        row: dict[str, Any] = {"parts": {}}
        if plan is not None:
            row |= {"set": dict(variant.overrides), "seeds": [run["seed"] for run in runs]}
            row["validation_score"] = [run["validation"]["score"] for run in runs]
            row["cpu_seconds"] = [run["cpu_seconds"] for run in runs]
            if runs[0]["active_anchors"] is not None:
                row["active_anchors"] = [statistics.median(run["active_anchors"]) for run in runs]
        else:
            row |= {"representation": asdict(variant.representation)}
            row["numbers"] = variant.representation.numbers
        for part in experiment.parts:
            row["parts"][part] = _part(part, runs, done[experiment.reference], bench.groups)
            if experiment.keep_views:
                row["parts"][part]["views"] = {
                    cell: [float(f"{value:.4g}") for value in values]
                    for cell, values in _typical(runs, part).items()
                    if cell.endswith("_geometric")
                }
        table[variant.name] = row
    return {
        "question": experiment.question,
        "level": experiment.level,
        "reference": experiment.reference,
        "protocol": _PROTOCOL | {"azimuths": experiment.azimuths},
        "splits": list(experiment.splits),
        "categories": list(experiment.categories),
        "panoramas": len(set(bench.groups)),
        "views": len(bench),
        "training": _training(plan),
        "commit": commit(),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}",
        "versions": versions(),
        "variants": table,
    }


def _part(
    part: Part, runs: Sequence[dict[str, Any]], reference: Sequence[dict[str, Any]], groups: list[str]
) -> dict[str, Any]:
    """Errors of a variant: over seeds the geometric mean for each view, and the seeds' own medians."""
    first, second = _typical(runs, part), _typical(reference, part)
    by_seed = [columns(torch.tensor(run["cells"][part])) for run in runs]
    medians = {cell: [statistics.median(run[cell]) for run in by_seed] for cell in by_seed[0]}
    summary: dict[str, Any] = {"errors": summarise(first, groups)}
    if len(runs) > 1:
        summary["medians_by_seed"] = {cell: [round(m, 4) for m in ms] for cell, ms in medians.items()}
        others = [columns(torch.tensor(run["cells"][part])) for run in reference]
        ratios = [paired_ratio(a, b, groups, 1) for a, b in zip(by_seed, others, strict=False)]
        summary["ratios_by_seed"] = {cell: [r[cell]["ratio"] for r in ratios] for cell in first}
    summary["ratio_to_reference"] = paired_ratio(first, second, groups)
    return summary


def _typical(runs: Sequence[dict[str, Any]], part: Part) -> dict[str, list[float]]:
    """Geometric mean over the seeds of each view's errors."""
    cells = torch.tensor([run["cells"][part] for run in runs], dtype=torch.float64)
    return columns(cells.clamp(min=1e-9).log().mean(0).exp())


def _training(plan: _Networks | None) -> dict[str, Any] | None:
    """What every variant was trained on."""
    if plan is None:
        return None
    config = plan.base
    frozen = f"frozen (ImageNet), features of {config.frozen_views} views cached; only heads are trained"
    return {
        "backbone": f"{config.model.backbone}, "
        + (frozen if config.frozen_views else "trained together with the heads"),
        "view": [config.model.height, config.model.width],
        "steps": config.steps,
        "batch_size": config.batch_size,
        "tables": [Path(table).name for table in config.tables],
    }


def _records(experiment: Experiment) -> list[PanoramaRecord]:
    records = [record for table in experiment.tables for record in read_table(table)]
    check_split(records)
    chosen = [r for r in records if r.split in experiment.splits and r.category in experiment.categories]
    if not chosen:
        raise ValueError(
            f"expected panoramas of the splits {', '.join(experiment.splits)} and the categories "
            f"{', '.join(experiment.categories)} in the tables, got none"
        )
    return chosen


def _digest(
    experiment: Experiment, piece: Piece, records: Sequence[PanoramaRecord], config: TrainingConfig | None
) -> str:
    """Of all that a piece's numbers depend on, the code excepted."""
    scored = [(r.scene, r.group, r.path.stat().st_size) for r in records]
    what: list[Any] = [_PROTOCOL, experiment.azimuths, scored]
    if config is None:
        what.append(asdict(piece.variant.representation))
    else:
        plain = to_plain(config)
        plain["tables"] = [
            [(r.scene, r.category, r.split) for r in read_table(table)] for table in config.tables
        ]
        what.append(plain)
    return hashlib.sha256(repr(what).encode()).hexdigest()[:16]


def _read(path: Path, parts: Sequence[Part]) -> dict[str, Any] | None:
    """A finished piece, if it has all the parts that are wanted."""
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return None
    return found if set(parts) <= set(found["cells"]) else None


def _write(path: Path, value: Mapping[str, Any]) -> None:
    text = json.dumps(value, indent=1, allow_nan=False)
    text = _NUMBERS.sub(lambda found: "[" + " ".join(found[1].split()) + "]", text)
    with atomic_path(path) as temporary:
        Path(temporary).write_text(text + "\n", encoding="utf-8")


def _rounded(cells: Tensor) -> list[list[float]]:
    return [[float(f"{value:.6g}") for value in row] for row in cells.tolist()]
