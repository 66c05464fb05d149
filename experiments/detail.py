"""What the photo's own pixels in the map are worth: sphere errors with and without `--detail photo`.

    python -m experiments.detail data/panoramas.csv data/rooms.csv

Views of protocol M (8 azimuths, FOV 60, pitch -8 degrees). The map is estimated from the photo by the model
in the box; the photo is laid into it with the pose that the model found, as `mixlight estimate` does. The
variants are compared on the validation split (real panoramas and rendered rooms), the shipped one is scored
on the test split. Ratios are geometric means over views of the error with the photo over that without, with
intervals bootstrapped over whole panoramas.
"""

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from experiments.provenance import provenance
from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.image.atomic import atomic_path
from mixlight.image.color import linear_to_srgb, srgb_to_linear
from mixlight.light.compare import rmse_and_si_rmse
from mixlight.light.detail import FEATHER, GATHER, GATHER_AREA, Detail
from mixlight.light.lighting import Lighting
from mixlight.network.estimator import Estimator
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect
from mixlight.training.validation import SPHERES

OUT = Path(__file__).parent / "results" / "detail.json"
CELLS = (
    *(f"{sphere}_rmse" for sphere in SPHERES),
    *(f"{sphere}_si_rmse" for sphere in SPHERES),
    "mirror_shown",
    "mirror_seen_shown",
)
"""Errors of each view. `mirror_shown`: RMSE of the mirror as a screen shows it, clipped at white and sRGB
encoded; `mirror_seen_shown`: that over the part of the mirror in which the photo's part of the room shows."""

Variant = tuple[float, float, float, bool]
"""Feather, gather, gather area, and whether the camera's true pose is used."""

SHIPPED: Variant = (FEATHER, GATHER, GATHER_AREA, False)
VARIANTS: dict[str, Variant] = {
    "shipped": SHIPPED,
    "lobes keep their light": (FEATHER, GATHER, math.inf, False),
    "lobes reach half as far": (FEATHER, GATHER / 2, GATHER_AREA, False),
    "lobes reach twice as far": (FEATHER, 2 * GATHER, GATHER_AREA, False),
    "a tenth of the area draws as much": (FEATHER, GATHER, GATHER_AREA / 10, False),
    "hard edge": (0.0, GATHER, GATHER_AREA, False),
    "three times as soft an edge": (3 * FEATHER, GATHER, GATHER_AREA, False),
    "true pose of the camera": (FEATHER, GATHER, GATHER_AREA, True),
}


def main() -> None:
    """Measure and write the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="+", help="CSV tables of panoramas")
    parser.add_argument("--model", default="default", metavar="NAME_OR_PATH")
    parser.add_argument("--out", type=Path, default=OUT)
    arguments = parser.parse_args()

    records = [record for table in arguments.tables for record in read_table(table)]
    estimator = Estimator.load(arguments.model)
    measure = Measurement(estimator)
    validation = {
        kind: measure.variants(select(records, "val", (category,)), VARIANTS, azimuths)
        for kind, category, azimuths in (("panoramas", "indoor", 8), ("rendered rooms", "room", 2))
    }
    result: dict[str, Any] = {
        "question": "what the photo's own pixels in the map are worth",
        "provenance": provenance(
            " ".join(str(__doc__).split("\n\n")[2].split()), len(select(records, "test", ("indoor",))), 0
        )
        | {"model": estimator.card.get("name")},
        "cells": "rmse and si_rmse as protocol M; mirror_shown: RMSE of the mirror clipped at white and sRGB "
        "encoded; mirror_seen_shown: that where the mirror shows the photo's part of the room",
        "test": measure.variants(select(records, "test", ("indoor",)), {"shipped": SHIPPED}, 8),
        "validation": validation,
    }
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for name, group in (("test", result["test"]), *validation.items()):
        for variant, entry in group["with the photo"].items():
            cells = " ".join(f"{entry['ratio'][cell]['ratio']:.3f}" for cell in CELLS)
            print(f"{name:16s} {variant:36s} {cells}")


class Measurement:
    """One model on views of panoramas, with and without the photo in the map."""

    def __init__(self, estimator: Estimator) -> None:
        self.estimator = estimator
        self.canonical = estimator.model.settings.canonical
        self.renderer = SphereRenderer(resolution=64)

    def variants(
        self, records: Sequence[PanoramaRecord], variants: dict[str, Variant], azimuths: int
    ) -> dict[str, Any]:
        """Medians of all errors, and each variant's ratio to the map without the photo."""
        samples = collect(records, self.canonical, azimuths)
        groups = [sample.scene for sample in samples]
        errors = torch.stack([self._errors(sample, variants.values()) for sample in samples]).double()
        return {
            "panoramas": len(set(groups)),
            "views": len(samples),
            "without": _medians(errors[:, 0]),
            "with the photo": {
                name: {
                    "median": _medians(errors[:, k]),
                    "ratio": _ratios(errors[:, k], errors[:, 0], groups),
                }
                for k, name in enumerate(variants, start=1)
            },
        }

    @torch.no_grad()
    def _errors(self, sample: EvaluationSample, variants: Any) -> Tensor:
        """[1 + variants, cells] of one view: without the photo first."""
        linear = torch.from_numpy(srgb_to_linear(sample.photo.permute(1, 2, 0).numpy()))
        (estimate,) = self.estimator.estimate_views(linear[None])
        lighting = estimate.lighting.pruned()
        maps = [lighting.environment(ENVIRONMENT_HEIGHT)]
        for feather, gather, area, true_pose in variants:
            pitch, roll = (sample.pitch, 0.0) if true_pose else (estimate.pitch, estimate.roll)
            detail = Detail.of_photo(
                linear, self.canonical.fov, ENVIRONMENT_HEIGHT, pitch=pitch, roll=roll, feather=feather
            )
            maps.append(replace(detail, gather=gather, gather_area=area).environment(lighting))
            _check_energy(maps[-1], lighting)
        seen = Detail.of_photo(
            linear, self.canonical.fov, ENVIRONMENT_HEIGHT, pitch=sample.pitch, feather=0.0
        ).weight
        reflects = self.renderer.render(seen[..., None])[SPHERES.index("mirror"), ..., 0]
        return self._scores(torch.stack(maps), sample.environment, reflects > reflects.max() / 2)

    def _scores(self, maps: Tensor, true: Tensor, seen: Tensor) -> Tensor:
        pictures, truth = self.renderer.render(maps), self.renderer.render(true)
        mask = self.renderer.mask
        pairs = [
            rmse_and_si_rmse(pictures[:, k][:, mask], truth[k][mask].expand(len(maps), -1, -1))
            for k in range(len(SPHERES))
        ]
        mirror, true_mirror = _shown(pictures[:, -1]), _shown(truth[-1])
        shown = [
            rmse_and_si_rmse(mirror[:, some], true_mirror[some].expand(len(maps), -1, -1))[0]
            for some in (mask, seen)
        ]
        return torch.stack([rmse for rmse, _ in pairs] + [si for _, si in pairs] + shown, -1)


def _check_energy(environment: Tensor, lighting: Lighting) -> None:
    before, after = (
        equirect.integrate(panorama) for panorama in (lighting.environment(ENVIRONMENT_HEIGHT), environment)
    )
    torch.testing.assert_close(after, before, rtol=1e-5, atol=0)


def _shown(linear: Tensor) -> Tensor:
    return torch.from_numpy(linear_to_srgb(linear.clamp(0, 1).numpy()))


def _medians(errors: Tensor) -> dict[str, float]:
    return {cell: round(float(errors[:, k].median()), 4) for k, cell in enumerate(CELLS)}


def _ratios(
    first: Tensor, second: Tensor, groups: Sequence[str], resamples: int = 2000
) -> dict[str, dict[str, Any]]:
    """Geometric mean of first over second for each cell, with a 95 % interval over whole panoramas."""
    generator = np.random.default_rng(0)
    logs = (first.log() - second.log()).numpy()
    names = sorted(set(groups))
    members = [logs[[group == name for group in groups]] for name in names]
    draws = generator.integers(len(names), size=(resamples, len(names)))
    means = np.stack([np.concatenate([members[k] for k in draw]).mean(0) for draw in draws])
    low, high = np.quantile(means, (0.025, 0.975), axis=0)
    return {
        cell: {
            "ratio": round(float(np.exp(logs[:, k].mean())), 4),
            "interval_95": [round(float(np.exp(low[k])), 4), round(float(np.exp(high[k])), 4)],
            "views that gain": round(float((logs[:, k] < 0).mean()), 3),
        }
        for k, cell in enumerate(CELLS)
    }


if __name__ == "__main__":
    main()
