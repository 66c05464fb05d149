"""Gathers training runs into one table: what their configs differ in, and what validation said.

    python -m experiments.trials runs/a runs/b ... --out experiments/results/trials.json

Reads `config.json` and `log.jsonl` of each run. Runs that were stopped early are marked by their last step.
A run of several members has no step of its own; there it is the card of the model.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from experiments.provenance import provenance
from mixlight.image.atomic import atomic_path
from mixlight.network import weights
from mixlight.training.members import begun_by

CELLS = tuple(
    f"{kind}/{cell}"
    for kind in ("real", "rooms")
    for cell in ("diffuse/rmse", "diffuse/si_rmse", "matte/rmse")
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    configs = {run.name: _config(run) for run in arguments.runs}
    keys = sorted({key for config in configs.values() for key in config} - {"tables", "name", "workers"})
    differing = [k for k in keys if len({json.dumps(c.get(k)) for c in configs.values()}) > 1]
    trials = []
    for run in arguments.runs:
        if not (run / "log.jsonl").is_file():
            trials.append(_averaged(run) | {"config": {key: configs[run.name].get(key) for key in differing}})
            continue
        records = [json.loads(line) for line in (run / "log.jsonl").read_text().splitlines()]
        checks = [r for r in records if r["kind"] == "validation"]
        best = min(checks, key=lambda r: r["score"])
        trials.append(
            {
                "run": run.name,
                "commit": next((r["commit"] for r in records if r["kind"] == "start"), "unknown"),
                "config": {key: configs[run.name].get(key) for key in differing},
                "last_step": checks[-1]["step"],
                "best_step": best["step"],
                "best_score": best["score"],
                "best": {cell: best[cell] for cell in CELLS},
                "curve": [
                    {"step": c["step"], "score": c["score"]} | {cell: c[cell] for cell in CELLS}
                    for c in checks
                ],
            }
        )
        print(f"{run.name:10s} best at {best['step']:5d}", *(f"{best[cell]:.3f}" for cell in CELLS))
    seeds = sorted({config["seed"] for config in configs.values()})
    made = provenance("validation during training, see mixlight.training.validation", len(trials), seeds)
    result = {"provenance": made, "split": "val", "trials": trials}
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(json.dumps(result, indent=1) + "\n")


def _averaged(run: Path) -> dict[str, Any]:
    """A mean of members."""
    _, card = weights.load(run / "model.safetensors")
    found = card["validation"]
    return {
        "run": run.name,
        "commit": card["commit"],
        "last_step": None,
        "best_step": None,
        "best_score": round(found["score"], 5),
        "best": {cell: round(found[cell], 5) for cell in CELLS},
        "members": [
            {
                "averaged": row["averaged"],
                "commit": begun_by(run / f"member-{number}"),
                "step": row["validation"]["step"],
                "score": round(row["validation"]["score"], 5),
            }
            for number, row in enumerate(card["members"])
        ],
    }


def _config(run: Path) -> dict[str, Any]:
    """What a run was told, without a path of the machine that it ran on."""
    config = _flat(json.loads((run / "config.json").read_text()))
    files = {key: Path(config[key]) for key in ("backbone_weights", "model_weights") if config.get(key)}
    return config | {key: f"{path.parent.name}/{path.name}".lstrip("/") for key, path in files.items()}


def _flat(values: dict[str, Any], where: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in values.items():
        flat |= _flat(value, f"{where}{key}.") if isinstance(value, dict) else {f"{where}{key}": value}
    return flat


if __name__ == "__main__":
    main()
