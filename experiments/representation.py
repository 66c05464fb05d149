"""What each correction of the paper is worth, measured on real indoor panoramas without any network.

    python -m experiments.representation data/panoramas.csv

Every number of `docs/method.md` that speaks of the representation comes from the file that this writes. Only
panoramas of the train and val splits are read: what is decided here must not be decided on test.
"""

import argparse
import json
import math
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, get_args

import torch
from torch import Tensor

from experiments.corrections import HEIGHT, exposure, gram, intensity, normaliser, sparse, transport
from experiments.numbers import distribution_of, rounded
from experiments.provenance import provenance
from mixlight.data.evaluation_set import EvaluationSample, samples_of
from mixlight.data.panoramas import PanoramaRecord, read_table
from mixlight.evaluation.statistics import paired_ratio, summarise
from mixlight.light import gaussians, harmonics
from mixlight.light.compare import rmse_and_si_rmse
from mixlight.light.fit import ANCHORS, Parameters, parameters
from mixlight.light.gaussians import SHARPNESS
from mixlight.light.lighting import Lighting
from mixlight.light.lights import merge
from mixlight.light.separate import Method, luminance, separate, source_mask
from mixlight.network.canonical import CanonicalView
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect, points
from mixlight.training.validation import SPHERES

AZIMUTHS = 4
CATEGORIES = ("indoor", "studio")
FRACTIONS = (0.02, 0.05, 0.1)
RULES: tuple[tuple[Method, float], ...] = tuple((m, f) for m in get_args(Method) for f in FRACTIONS)
DEGREES = (1, 3, 4)
CELLS = tuple(f"{sphere}_{kind}" for kind in ("rmse", "si_rmse") for sphere in SPHERES)
PROTOCOL = (
    "M, on the true light itself: four views of each panorama (FOV 60, pitch -8 degrees), light times gain = "
    ".18 / median luminance of the view, panorama centred on the view; fitted at 128x256 and rendered from "
    "128x256 onto spheres of 64x64 pixels (diffuse .8, GGX alpha .107 colour .8, mirror .8), orthographic, "
    "no ground; RMSE and si-RMSE over the sphere's pixels and channels, linear, unclipped, against the "
    "panorama's own spheres"
)


def main() -> None:
    """Measure, write the results and print the tables."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("table", type=Path, help="CSV of panoramas")
    arguments.add_argument(
        "--out", type=Path, default=Path(__file__).parent / "results" / "representation.json"
    )
    options = arguments.parse_args()
    start = time.perf_counter()
    records = [
        record
        for record in read_table(options.table)
        if record.split in ("train", "val") and record.category in CATEGORIES
    ]
    real = measure(records)
    result = {
        "question": "what each correction of the paper is worth, without a network",
        "provenance": provenance(PROTOCOL, len(records) * AZIMUTHS, 0),
        "panoramas": {
            "count": len(records),
            "views": len(records) * AZIMUTHS,
            "scenes": {split: [r.scene for r in records if r.split == split] for split in ("train", "val")},
        },
        "projection": {**gram(), **real.pop("projection")},
        "normaliser": normaliser(),
        "transport": transport(),
        **real,
        "seconds": round(time.perf_counter() - start),
    }
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(rounded(result), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    show(result)


class Workbench:
    """Tables that all views share: lobes, harmonics and solid angle of one map size."""

    def __init__(self) -> None:
        self.lobes = gaussians.lobe_maps(points.vogel(ANCHORS), SHARPNESS, HEIGHT).flatten(1).T.contiguous()
        self.basis = harmonics.basis(equirect.pixel_directions(HEIGHT), max(DEGREES))
        self.solid_angle = equirect.solid_angle(HEIGHT)
        self.anchor = points.anchor_map(ANCHORS, HEIGHT).flatten()
        self.uniform = (4 * math.pi / self.solid_angle.numel() / self.solid_angle)[..., None]
        """Times this, a map that is integrated with solid angle gives the paper's plain sum 4 pi / (w h)."""
        self.renderer = SphereRenderer(resolution=64, height=HEIGHT)

    def signed_ambient(self, lighting: Lighting) -> Tensor:
        return self.basis[..., : lighting.ambient.shape[0]] @ lighting.ambient

    def sources(self, lighting: Lighting) -> Tensor:
        return (self.lobes @ lighting.energy).view(HEIGHT, 2 * HEIGHT, 3)

    def environment(self, lighting: Lighting) -> Tensor:
        """`Lighting.environment`, from tables."""
        return self.signed_ambient(lighting).clamp(min=0) + self.sources(lighting)

    def anchor_energy(self, sources: Tensor) -> Tensor:
        energy = (sources * self.solid_angle[..., None]).flatten(0, 1)
        return torch.zeros(ANCHORS, 3).index_add_(0, self.anchor, energy)

    def integral(self, panorama: Tensor) -> float:
        return float(luminance(equirect.integrate(panorama)))

    def score(self, true: Tensor, predicted: Sequence[Tensor]) -> Tensor:
        """[variants, 2, 3]: RMSE and si-RMSE of each sphere."""
        pictures = self.renderer.render(torch.stack([true, *predicted]))
        seen = pictures[:, :, self.renderer.mask]
        return torch.stack(rmse_and_si_rmse(seen[1:], seen[:1].expand_as(seen[1:])), -2)


def measure(records: Sequence[PanoramaRecord]) -> dict[str, Any]:
    """All sections that need panoramas."""
    bench = Workbench()
    errors: dict[str, list[Tensor]] = {}
    facts: dict[str, list[float]] = {}
    groups: list[str] = []
    shares: list[Tensor] = []
    gains: list[float] = []
    for sample in views(records):
        groups.append(sample.scene)
        gains.append(sample.gain)
        variants, said = variants_of(sample.environment, bench, shares)
        for name, value in said.items():
            facts.setdefault(name, []).append(value)
        cells = bench.score(sample.environment, list(variants.values()))
        for name, row in zip(variants, cells, strict=True):
            errors.setdefault(name, []).append(row)
    scores = {
        name: dict(zip(CELLS, torch.stack(rows).flatten(1).T.tolist(), strict=True))
        for name, rows in errors.items()
    }
    table = {name: summarise(values, groups) for name, values in scores.items()}
    spread = {name: distribution_of(values) for name, values in facts.items()}

    def named(prefix: str) -> dict[str, Any]:
        return {key.removeprefix(prefix): value for key, value in spread.items() if key.startswith(prefix)}

    def ratio(first: str, second: str) -> dict[str, Any]:
        return paired_ratio(scores[first], scores[second], groups)

    base = "top_fraction 0.05"
    return {
        "separation": {
            **{
                f"{method} {fraction:g}": {
                    **named(f"{method} {fraction:g}: "),
                    "spheres": table[f"{method} {fraction:g}"],
                }
                for method, fraction in RULES
            },
            "error ratio of top_fraction 0.05 to max_fraction 0.05": ratio(base, "max_fraction 0.05"),
            "one colour": {
                "error ratio of top_fraction 0.05 to max_fraction 0.05": ratio(
                    f"{base}, one colour", "max_fraction 0.05, one colour"
                )
            },
        },
        "projection": {
            "spheres, ambient without solid angle": table["ambient without solid angle"],
            "spheres, nothing with solid angle": table["nothing with solid angle"],
            "error ratio, ambient without to with": ratio("ambient without solid angle", base),
            "error ratio, nothing with to all with": ratio("nothing with solid angle", base),
            "source energy without over with solid angle": spread["source energy, plain sum"],
        },
        "intensity": intensity(facts),
        "colour": {
            "misplaced": spread["one colour: misplaced"],
            "spheres, one colour": table[f"{base}, one colour"],
            "spheres, one colour, max_fraction 0.05": table["max_fraction 0.05, one colour"],
            "error ratio of one colour to per anchor": ratio(f"{base}, one colour", base),
        },
        "clamping": {
            **named("clamping: "),
            "spheres, negative light kept": table["negative light kept"],
            "spheres, clamped and rescaled": table["clamped and rescaled"],
            "error ratio, clamped to negative kept": ratio(base, "negative light kept"),
            "error ratio, rescaled to clamped": ratio("clamped and rescaled", base),
        },
        "ambient degree": {
            **{f"spheres, degree {degree}": table[f"degree {degree}"] for degree in DEGREES},
            "spheres, degree 2": table[base],
            "spheres, degree 2 without any source": table["harmonics alone"],
        },
        "sparse layer": sparse(torch.stack(shares)),
        "exposure": exposure(gains, groups),
    }


def views(records: Sequence[PanoramaRecord]) -> Iterator[EvaluationSample]:
    for record in records:
        yield from samples_of(record, CanonicalView(), AZIMUTHS)


def variants_of(
    true: Tensor, bench: Workbench, shares: list[Tensor]
) -> tuple[dict[str, Tensor], dict[str, float]]:
    """Maps to be compared with the true one, and single numbers; appends the true P to `shares`."""
    maps: dict[str, Tensor] = {}
    facts: dict[str, float] = {}
    whole = bench.integral(true)
    found: dict[str, Parameters] = {}
    for method, fraction in RULES:
        name = f"{method} {fraction:g}"
        found[name] = parameters(true, separation=method, fraction=fraction)
        lighting = Lighting(found[name].ambient, found[name].anchor_energy).pruned()
        maps[name] = bench.environment(lighting)
        mask = source_mask(true, method, fraction)
        facts[f"{name}: energy error of the fit"] = abs(float(luminance(lighting.total_energy())) / whole - 1)
        facts[f"{name}: share of the sphere"] = float((mask * bench.solid_angle).sum()) / (4 * math.pi)
        facts[f"{name}: share of the energy"] = float(luminance(found[name].anchor_energy.sum(0))) / whole
        facts[f"{name}: active anchors"] = len(lighting.active)
        facts[f"{name}: lights"] = len(merge(lighting))
        signed = bench.signed_ambient(lighting)
        facts[f"{name}: energy added by clamping"] = bench.integral((-signed).clamp(min=0)) / whole
        if fraction == 0.05:
            one = Lighting(found[name].ambient, found[name].lobe_energy()).pruned()
            maps[f"{name}, one colour"] = bench.environment(one)

    base = found["top_fraction 0.05"]
    shares.append(base.distribution)
    energy = base.anchor_energy
    facts["one colour: misplaced"] = float((energy - base.lobe_energy()).abs().sum() / energy.sum())
    facts["E"] = float(base.intensity)

    lighting = Lighting(base.ambient, energy).pruned()
    signed = bench.signed_ambient(lighting)
    facts["clamping: share of the sphere"] = float(((signed < 0).any(-1) * bench.solid_angle).sum()) / (
        4 * math.pi
    )
    facts["clamping: energy added"] = facts["top_fraction 0.05: energy added by clamping"]
    maps["negative light kept"] = signed + bench.sources(lighting)
    clamped = signed.clamp(min=0)
    scale = equirect.integrate(signed).clamp(min=0) / equirect.integrate(clamped).clamp(min=1e-12)
    maps["clamped and rescaled"] = clamped * scale + bench.sources(lighting)

    sources, ambient = separate(true, "top_fraction", 0.05)
    plain_ambient = harmonics.project(ambient * bench.uniform)
    plain_energy = bench.anchor_energy(sources * bench.uniform)
    facts["source energy, plain sum"] = float(luminance(plain_energy.sum(0)) / luminance(energy.sum(0)))
    maps["ambient without solid angle"] = bench.environment(Lighting(plain_ambient, energy))
    maps["nothing with solid angle"] = bench.environment(Lighting(plain_ambient, plain_energy))

    for degree in DEGREES:
        maps[f"degree {degree}"] = bench.environment(Lighting(harmonics.project(ambient, degree), energy))
    maps["harmonics alone"] = bench.environment(Lighting(harmonics.project(true), torch.zeros(ANCHORS, 3)))
    return maps, facts


def show(result: dict[str, Any]) -> None:
    """Print a table of the medians of all sphere errors, and the other medians below."""
    count = result["panoramas"]
    print(f"{count['count']} panoramas, {count['views']} views, medians; {result['seconds']} s\n")
    short = [cell.replace("_si_rmse", " si").replace("_rmse", "") for cell in CELLS]
    print(f"{'':60s}" + "".join(f"{cell:>12s}" for cell in short))
    for section, entries in result.items():
        if isinstance(entries, dict):
            _show(section, entries)


def _show(name: str, entry: Any) -> None:
    if isinstance(entry, float | int):
        print(f"{name:60s}{entry:12.5g}")
    elif isinstance(entry, dict) and set(entry) == set(CELLS):
        key = "ratio" if "ratio" in entry[CELLS[0]] else "median"
        print(f"{name:60s}" + "".join(f"{entry[cell][key]:12.4f}" for cell in CELLS))
    elif isinstance(entry, dict) and "p95" in entry:
        print(f"{name:60s}{entry['median']:12.5g}   (p5 {entry['p5']:.4g}, p95 {entry['p95']:.4g})")
    elif isinstance(entry, dict):
        print()
        for key, value in entry.items():
            _show(f"{name} / {key}", value)


if __name__ == "__main__":
    main()
