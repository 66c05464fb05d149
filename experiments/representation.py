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

import numpy as np
import torch
from scipy.optimize import linear_sum_assignment
from torch import Tensor

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
from mixlight.loss.transport import SphericalSinkhorn
from mixlight.network.canonical import CanonicalView
from mixlight.network.sparsemax import MODES, slsparsemax
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect, points
from mixlight.training.validation import SPHERES

HEIGHT = 128
AZIMUTHS = 4
CATEGORIES = ("indoor", "studio")
FRACTIONS = (0.02, 0.05, 0.1)
RULES: tuple[tuple[Method, float], ...] = tuple((m, f) for m in get_args(Method) for f in FRACTIONS)
DEGREES = (1, 3, 4)
NOISE = (0.005, 0.01, 0.02)
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


def gram() -> dict[str, Any]:
    """Gram matrix of the nine functions under both sums; the identity is what a projection needs.

    The plain sum is worst where the harmonics' own pole (z) is the panorama's, as textbooks and the paper
    have it; in our frame the panorama's pole is y.
    """
    directions = equirect.pixel_directions(HEIGHT, dtype=torch.float64).flatten(0, 1)
    exact = equirect.solid_angle(HEIGHT, dtype=torch.float64).flatten()
    plain = torch.full_like(exact, 4 * math.pi / len(exact))
    x, y, z = directions.unbind(-1)
    turned = torch.stack((z, x, y), -1)  # y, the panorama's pole, becomes the harmonics' z
    sides = {
        "with solid angle": (directions, exact),
        "4 pi / (w h), our frame": (directions, plain),
        "4 pi / (w h), one pole for both": (turned, plain),
    }
    result = {}
    for name, (where, weight) in sides.items():
        basis = harmonics.basis(where)
        matrix = basis.T @ (weight[:, None] * basis)
        diagonal = matrix.diagonal()
        result[f"Gram matrix, {name}"] = {
            "smallest on the diagonal": float(diagonal.min()),
            "largest on the diagonal": float(diagonal.max()),
            "largest off the diagonal": float((matrix - torch.diag(diagonal)).abs().max()),
        }
    return result


def normaliser() -> dict[str, float]:
    """A lobe's normaliser with the paper's exponent -2s, over the right one with -2/s."""
    paper = 1 / (2 * math.pi * SHARPNESS * (1 - math.exp(-2 * SHARPNESS)))
    axis = points.vogel(ANCHORS)[64:65]
    lobe = gaussians.evaluate_map(axis, torch.ones(1, 1), SHARPNESS, HEIGHT, conserve=False)
    return {
        "q": gaussians.normaliser(SHARPNESS),
        "q of the paper": paper,
        "factor": paper / gaussians.normaliser(SHARPNESS),
        "integral of a lobe on 128x256 with q": float(equirect.integrate(lobe)[0]),
    }


def intensity(facts: dict[str, list[float]]) -> dict[str, Any]:
    """What the network has to regress when E is the squared norm and R = T / E."""
    values = np.array(facts["E"])
    decades = np.log10(np.quantile(values, 0.95) / np.quantile(values, 0.05))
    return {
        "E": distribution_of(values),
        "decades of E from p5 to p95": float(decades),
        "decades of E squared from p5 to p95": float(2 * decades),
        "length of R = T / E squared": distribution_of(1 / values),
    }


def transport() -> dict[str, Any]:
    """A unit light on a wrong anchor: what it costs, near and far."""
    axes = points.vogel(ANCHORS)
    loss = SphericalSinkhorn(axes)
    light = torch.eye(ANCHORS)
    near = points.neighbours(axes, 1)[:, 0]
    far = (axes @ axes.T).argmin(1)
    generator = torch.Generator().manual_seed(0)
    dense = torch.softmax(2 * torch.randn(2, 64, ANCHORS, generator=generator), -1).double()
    moved, stayed = torch.cat([light[near], light[far]]).double(), torch.cat([light, light]).double()
    released = torch.cat([_emlight_loss(axes, moved, stayed), _emlight_loss(axes, dense[0], dense[1])])
    error = torch.cat([moved - stayed, dense[0] - dense[1]]).square().mean(-1)
    return {
        "Sinkhorn divergence (radians)": {
            "next": distribution_of(loss(light[near], light).tolist()),
            "antipode": distribution_of(loss(light[far], light).tolist()),
            "anchor 64 to 77": float(loss(light[64], light[77])),
            "anchor 64 to 60": float(loss(light[64], light[60])),
        },
        "EMLight as released": {
            "next": distribution_of(released[:ANCHORS].tolist()),
            "antipode": distribution_of(released[ANCHORS : 2 * ANCHORS].tolist()),
            "over the mean squared error, all moves and 64 dense pairs": distribution_of(
                (released / error).tolist()
            ),
        },
    }


def _emlight_loss(axes: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """EMLight's released transport loss without its entropic blur.

    The points are evenly weighted, and the masses x and y stand in the cost:
    (.1 (x_i - y_j)^2 + |u_i - u_j|) / 2. Even weights make optimal transport an assignment.
    """
    chord = torch.cdist(axes.double(), axes.double()).fill_diagonal_(0)
    values = []
    for a, b in zip(x, y, strict=True):
        cost = ((0.1 * (a[:, None] - b) ** 2 + chord) / 2).numpy()
        values.append(cost[linear_sum_assignment(cost)].sum() / len(axes))
    return torch.tensor(values, dtype=torch.float64)


def sparse(true: Tensor) -> dict[str, Any]:
    """The sparse layer's modes on noisy distributions."""
    axes = points.vogel(ANCHORS)
    neighbours = points.neighbours(axes, 6)
    loss = SphericalSinkhorn(axes)
    generator = torch.Generator().manual_seed(0)
    result: dict[str, Any] = {
        "input": "true P of top_fraction 0.05, as it is or averaged with its six neighbours, plus normal "
        "noise of standard deviation sigma, seed 0",
        "active anchors of the true P": distribution_of((true > 1e-4).sum(-1).tolist()),
    }
    # A regression blurs as well: each share is also averaged with those of the six neighbours.
    blurred = (true + true[:, neighbours].sum(-1)) / (1 + neighbours.shape[1])
    for name, mean in (("", true), (", blurred", blurred / blurred.sum(-1, keepdim=True))):
        for sigma in NOISE:
            noisy = mean + sigma * torch.randn(true.shape, generator=generator)
            rows = {}
            for mode in MODES:
                out = slsparsemax(noisy, neighbours, mode)
                total = out.clamp(min=0).sum(-1)
                rows[mode] = {
                    "sum": distribution_of(total.tolist()),
                    "active anchors": distribution_of((out > 1e-4 * total[:, None]).sum(-1).tolist()),
                    "squared error": distribution_of((out - true).square().sum(-1).tolist()),
                    "transport": distribution_of(loss(out, true).tolist()),
                }
            result[f"sigma {sigma:g}{name}"] = rows
    logits = torch.randn(1000, ANCHORS, generator=generator)
    result["sum of the literal mode on standard normal scores"] = distribution_of(
        slsparsemax(logits, neighbours, "literal").sum(-1).tolist()
    )
    soft = torch.softmax(logits, -1)
    result["largest change after a softmax"] = float((slsparsemax(soft, neighbours) - soft).abs().max())
    return result


def exposure(gains: Sequence[float], groups: Sequence[str]) -> dict[str, Any]:
    """A gain that is worked out after the response curve x^(1/2.4) and multiplied onto linear light."""
    wrong = np.array(gains) ** (1 / 2.4 - 1)  # applied gain over the right one
    names = sorted(set(groups))
    within = [np.ptp(np.log(wrong[[g == name for g in groups]])) for name in names]
    return {
        "target over truth": distribution_of(wrong),
        "largest over smallest among the views of one panorama": distribution_of(np.exp(within)),
    }


def distribution_of(values: Sequence[float] | np.ndarray) -> dict[str, float]:
    array = np.asarray(values, dtype=np.float64)
    low, median, high = np.quantile(array, (0.05, 0.5, 0.95))
    return {
        "median": float(median),
        "mean": float(array.mean()),
        "p5": float(low),
        "p95": float(high),
        "max": float(array.max()),
    }


def rounded(value: Any) -> Any:
    """Five significant digits: more would say nothing."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: rounded(entry) for key, entry in value.items()}
    return [rounded(entry) for entry in value] if isinstance(value, list) else value


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
