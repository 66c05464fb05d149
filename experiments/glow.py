"""What few sources cost: light that stays with the chosen ones, against light that joins the ambient.

    python -m experiments.glow data/panoramas.csv data/rooms.csv --out experiments/results/glow.json

The model in the box predicts a spread distribution of source light. At each gain the sparse layer chooses the
same anchors for two variants: `renormalised` gives them the energy of the others, as a sparse layer at the
end of a network does; `glow` adds the others' light to the ambient coefficients (`mixlight.network.glow`).
Protocol M on the val split: 5 real panoramas at 8 azimuths, 19 rendered rooms at 2.
"""

import argparse
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from experiments.provenance import provenance
from mixlight.data.evaluation_set import collect
from mixlight.data.panoramas import read_table, select
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.evaluation.renderers import matrix
from mixlight.evaluation.scoring import score
from mixlight.evaluation.statistics import summarise
from mixlight.image.atomic import atomic_path
from mixlight.network.estimator import Estimator
from mixlight.network.glow import Glow
from mixlight.network.heads import Prediction
from mixlight.training.validation import predicted_environments

GAINS = (3.0, 10.0, 20.0, 40.0)
ROOM_AZIMUTHS = 2


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="+", help="CSV tables of panoramas")
    parser.add_argument("--model", default="default")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    records = select([r for table in arguments.tables for r in read_table(table)], "val")
    estimator = Estimator.load(arguments.model)
    model, settings = estimator.model, estimator.model.settings
    model.glow = None  # the light as it is predicted
    mode = settings.sparse_mode if settings.sparse_mode != "softmax" else "masked"  # as the model's own
    real = collect([r for r in records if r.category != "room"], settings.canonical)
    rooms = collect([r for r in records if r.category == "room"], settings.canonical, ROOM_AZIMUTHS)
    samples = [*real, *rooms]
    variants: dict[str, Callable[[Prediction], Prediction]] = {"all anchors": lambda light: light}
    for gain in GAINS:
        glow = Glow(settings.anchors, settings.sharpness, gain, mode)
        variants[f"renormalised {gain:g}"] = _renormalised(glow)
        variants[f"glow {gain:g}"] = glow
    predictions = {}
    with torch.inference_mode():
        for k, sample in enumerate(samples):
            predictions[k] = model(sample.photo[None])
    place = {id(sample): k for k, sample in enumerate(samples)}
    result: dict[str, Any] = {
        "split": "val",
        "provenance": provenance("M", len(samples), None),
        "weights": {key: estimator.card.get(key) for key in ("name", "commit")},
        "views": {"real": len(real), "rooms": len(rooms)},
        "variants": {},
    }
    renderer = matrix("M")
    for name, variant in variants.items():
        found = [variant(light) for light in predictions.values()]
        before = torch.cat([light.intensity for light in predictions.values()])
        entry: dict[str, Any] = {
            "active": float(torch.cat([(x.distribution > 1e-4).sum(1) for x in found]).float().median()),
            "kept": round(float((torch.cat([x.intensity for x in found]) / before).median()), 3),
        }
        for kind, chosen in (("real", real), ("rooms", rooms)):
            rows = [
                score(
                    PROTOCOLS["M"],
                    [predicted_environments(found[place[id(sample)]], settings.sharpness)[0]],
                    sample.environment,
                    renderer,
                )[0]
                for sample in chosen
            ]
            values = {cell: [row[cell] for row in rows] for cell in rows[0]}
            entry[kind] = summarise(values, [sample.scene for sample in chosen])
        result["variants"][name] = entry
        medians = [entry[kind]["diffuse_rmse"]["median"] for kind in ("real", "rooms")]
        print(f"{name:18s} {entry['active']:5.0f} {entry['kept']:.2f}", *(f"{m:.3f}" for m in medians))
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def _renormalised(glow: Glow) -> Callable[[Prediction], Prediction]:
    def variant(light: Prediction) -> Prediction:
        chosen: Prediction = glow(light)
        return replace(chosen, intensity=light.intensity, ambient=light.ambient)

    return variant


if __name__ == "__main__":
    main()
