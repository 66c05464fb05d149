"""What turning a light by any angle costs when lobes live on fixed anchors, and when the anchors turn.

    python -m experiments.turning data/panoramas.csv

Lights fitted to indoor panoramas (train and val) are turned about the vertical by angles that a map of 256
columns can be rolled by exactly, which gives the truth. Compared: the anchors turn with the light
(`mixlight.light.edit.turn`), each lobe moves to the nearest fixed anchor, each lobe is split among three
fixed anchors such that its energy and its mean direction are kept.
"""

import argparse
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from experiments.provenance import provenance
from mixlight.data.panoramas import load_panorama, read_table
from mixlight.image.atomic import atomic_path
from mixlight.light import edit
from mixlight.light.fit import fit
from mixlight.light.lighting import Lighting
from mixlight.light.separate import luminance
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect, frames
from mixlight.training.validation import SPHERES

OUT = Path(__file__).parent / "results" / "turning.json"
HEIGHT = 128
COLUMNS = (9, 37, 75, 110)
"""Turns, in columns of 360 / 256 degrees."""

Method = Callable[[Lighting, float], Lighting]


def main() -> None:
    """Measure and write the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", help="CSV table of panoramas")
    parser.add_argument("--out", type=Path, default=OUT)
    arguments = parser.parse_args()

    records = [
        record
        for record in read_table(arguments.table)
        if record.split in ("train", "val") and record.category == "indoor"
    ]
    renderer = SphereRenderer(resolution=64)
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in METHODS}
    for record in records:
        lighting = fit(load_panorama(record.path, 256))
        for columns in COLUMNS:
            angle = columns * math.pi / HEIGHT
            true = equirect.rotate_azimuth(lighting.environment(HEIGHT), -angle)
            for name, method in METHODS.items():
                cells = _directions(lighting, method, angle)
                rows[name].append(cells | _cost(renderer, lighting, method(lighting, angle), true))
    result: dict[str, Any] = {
        "question": "what turning a light costs",
        "provenance": provenance("lights fitted to panoramas, see cells", len(records), None),
        "turns_deg": [round(columns * 180 / HEIGHT, 4) for columns in COLUMNS],
        "cells": "off_deg: angle between a lobe's mean direction and its turned axis; spread_deg: mean angle "
        "of its energy to that axis; both weighted by luminance; energy: largest relative error of a "
        "channel's total; spheres: RMSE against the sphere under the exactly turned map, over that sphere's "
        "root mean square",
        "methods": {name: _summary(cells) for name, cells in rows.items()},
    }
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for name, cells in result["methods"].items():
        print(f"{name:40s}", {cell: entry["median"] for cell, entry in cells.items()})


def nearest_anchor(lighting: Lighting, angle: float) -> Lighting:
    """Each lobe to the nearest fixed anchor."""
    return lighting.rotated(frames.rotation(angle))


def split_among_three(lighting: Lighting, angle: float) -> Lighting:
    """Each lobe to the three fixed anchors whose positive mixture has its direction, nearest ones first."""
    turned = lighting.rotated(frames.rotation(angle))
    axes = lighting.axes.double()
    energy = torch.zeros_like(lighting.energy)
    for lobe in (lighting.energy != 0).any(-1).nonzero()[:, 0].tolist():
        target = frames.rotation(angle, dtype=torch.float64) @ axes[lobe]
        for anchors, weights in _mixtures(axes, target):
            energy[anchors] += weights[:, None].float() * lighting.energy[lobe]
            break
    return Lighting(turned.ambient, energy, sharpness=lighting.sharpness)


def _mixtures(axes: Tensor, target: Tensor) -> Any:
    """Triples of anchors around a direction with weights of sum 1 whose mean points there, tightest first."""
    near = (axes @ target).argsort(descending=True)[:9].tolist()
    found = []
    for a in range(9):
        for b in range(a + 1, 9):
            for c in range(b + 1, 9):
                anchors = [near[a], near[b], near[c]]
                weights = torch.linalg.lstsq(axes[anchors].T, target[:, None]).solution[:, 0]
                if bool((weights >= -1e-9).all()):
                    weights = weights.clamp(min=0) / weights.clamp(min=0).sum()
                    spread = float((weights * (axes[anchors] @ target).clamp(-1, 1).acos()).sum())
                    found.append((spread, anchors, weights))
    found.sort(key=lambda entry: entry[0])
    return [(anchors, weights) for _, anchors, weights in found]


METHODS: dict[str, Method] = {
    "the anchors turn (as shipped)": edit.turn,
    "each lobe to the nearest fixed anchor": nearest_anchor,
    "each lobe split among three fixed anchors": split_among_three,
}


def _directions(lighting: Lighting, method: Method, angle: float) -> dict[str, float]:
    """Where each lobe's light goes, one lobe at a time."""
    power = luminance(lighting.energy).double()
    off = spread = 0.0
    for lobe in (power > 1e-4 * power.sum()).nonzero()[:, 0].tolist():
        alone = torch.zeros_like(lighting.energy)
        alone[lobe] = 1
        after = method(Lighting(lighting.ambient, alone), angle)
        target = frames.rotation(angle, dtype=torch.float64) @ lighting.axes[lobe].double()
        share, axes = after.energy[:, 0].double(), after.axes.double()
        mean = torch.nn.functional.normalize(share @ axes, dim=0)
        weight = float(power[lobe] / power.sum())
        off += weight * _angle(mean, target)
        spread += weight * sum(float(share[k]) * _angle(axes[k], target) for k in share.nonzero()[:, 0])
    return {"off_deg": off, "spread_deg": spread}


def _angle(first: Tensor, second: Tensor) -> float:
    """Degrees, from the chord: the cosine of a small angle has no digits left."""
    return math.degrees(2 * math.asin(min(1.0, float((first - second).norm()) / 2)))


def _cost(renderer: SphereRenderer, before: Lighting, after: Lighting, true: Tensor) -> dict[str, float]:
    """What the turned light gets wrong: energy, and the three spheres."""
    total, kept = before.total_energy().double(), after.total_energy().double()
    pictures, truth = renderer.render(torch.stack([after.environment(HEIGHT), true]))
    mask = renderer.mask
    cells = {"energy": float((kept / total - 1).abs().max())}
    for k, sphere in enumerate(SPHERES):
        error = (pictures[k][mask] - truth[k][mask]).square().mean().sqrt()
        cells[sphere] = float(error / truth[k][mask].square().mean().sqrt())
    return cells


def _summary(rows: list[dict[str, float]]) -> dict[str, dict[str, float]]:
    return {
        cell: {
            "median": float(f"{np.median([row[cell] for row in rows]):.3g}"),
            "p95": float(f"{np.quantile([row[cell] for row in rows], 0.95):.3g}"),
        }
        for cell in rows[0]
    }


if __name__ == "__main__":
    main()
