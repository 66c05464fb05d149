"""What smaller or coarser ONNX files cost: sphere errors by protocol M, size, speed.

    python -m experiments.onnx_variants data/panoramas.csv data/rooms.csv \
        --out experiments/results/onnx.json

Each variant of the model is run in onnxruntime on views of the split `val` (32 of each indoor panorama and
rendered room: the median of fewer moves by a per cent with a view or two) and compared, view by view, with
the network in PyTorch. The first three
are those that `mixlight export --for onnx --precision` offers: their weights are narrowed in the file and
widened on loading. The others compute in low precision and are here to say what that would cost.

`cost` is the worst of the six cells (three spheres, RMSE and si-RMSE): by how much the error's geometric mean
over all views, or its median, exceeds the network's. Times are processor time (what else the machine does
counts little) of one photo on one thread, the variants in turn, round after round; `--web` adds those of
onnxruntime-web.
"""

import argparse
import json
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
import torch
from onnx import ModelProto
from onnxruntime.quantization import (
    CalibrationDataReader,
    QuantFormat,
    QuantType,
    quantize_dynamic,
    quantize_static,
)
from onnxruntime.transformers.float16 import convert_float_to_float16
from torch import Tensor

from experiments.provenance import provenance
from mixlight.app.self_test import digest
from mixlight.data.evaluation_set import EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.export.onnx import OUTPUTS, to_onnx
from mixlight.export.onnx_precision import PRECISIONS, store
from mixlight.image.atomic import atomic_path
from mixlight.light.lighting import Lighting
from mixlight.network.estimator import Estimator, to_lighting
from mixlight.network.weights import find
from mixlight.render.spheres import SphereRenderer
from mixlight.training.validation import SPHERES, score_spheres

LIMIT = 0.01
"""What a variant may cost and still be offered."""

CELLS = tuple(f"{sphere}_{kind}" for kind in ("rmse", "si_rmse") for sphere in SPHERES)
ROUNDS = 15
AZIMUTHS = 32
"""Views of each panorama."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="+", help="CSV tables of panoramas")
    parser.add_argument("--model", default="default", metavar="NAME_OR_PATH")
    parser.add_argument(
        "--web", type=Path, help="folder with onnx_run.mjs and node_modules (tests/interop/web)"
    )
    parser.add_argument("--calibration", type=int, default=64, help="training views for static quantisation")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()

    torch.set_num_threads(1)
    records = [record for table in arguments.tables for record in read_table(table)]
    estimator = Estimator.load(arguments.model)
    samples = views(records, "val", estimator)
    photos = torch.stack([sample.photo for sample in samples]).numpy()
    train = views(records, "train", estimator, arguments.calibration)

    renderer = SphereRenderer(resolution=64)
    truth = [sample.environment for sample in samples]
    with torch.inference_mode():
        network = to_lighting(estimator.model(torch.from_numpy(photos)), estimator.model.settings.sharpness)
    reference = errors(renderer, network, truth)

    result: dict[str, Any] = {
        "provenance": provenance(f"M, at {AZIMUTHS} azimuths", len(samples), None)
        | {"onnxruntime": onnxruntime.__version__},
        "model": {key: estimator.card.get(key) for key in ("name", "commit")}
        | {"sha256": digest(find(arguments.model))},
        "split": "val",
        "scenes": len({sample.scene for sample in samples}),
        "limit": LIMIT,
        "network": {cell: summary(reference[:, k]) for k, cell in enumerate(CELLS)},
        "variants": {},
    }
    with tempfile.TemporaryDirectory() as name:
        files = dict(variants(estimator, np.stack([s.photo.numpy() for s in train]), Path(name)))
        sessions = {label: session(path) for label, path in files.items()}
        times = timed({label: runner(found, photos[:1]) for label, found in sessions.items()})
        for label, path in files.items():
            found = run(sessions[label], photos)
            lights = lightings(found, estimator.model.settings.sharpness)
            cells = errors(renderer, lights, truth)
            entry: dict[str, Any] = {
                "offered": label in PRECISIONS,
                "bytes": path.stat().st_size,
                "ms": times[label],
                "largest_output_error": largest_error(found, network, estimator, photos),
                "cost": round(cost(cells, reference), 5),
                "cells": {
                    cell: summary(cells[:, k]) | {"ratio": ratio(cells[:, k], reference[:, k])}
                    for k, cell in enumerate(CELLS)
                },
            }
            if arguments.web:
                entry["web_ms"] = web(arguments.web, path, photos[:1])
            result["variants"][label] = entry
            print(f"{label:18s} {entry['bytes']:9d} B  {entry['ms']['median']:7.1f} ms  {entry['cost']:+.4f}")
    wrong = [
        label for label, entry in result["variants"].items() if entry["offered"] and entry["cost"] >= LIMIT
    ]
    result["offered_within_limit"] = not wrong
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    if wrong:
        raise SystemExit(
            f"expected every offered variant to cost under {LIMIT:.0%}, found {', '.join(wrong)}"
        )


def views(
    records: Sequence[PanoramaRecord], split: str, estimator: Estimator, limit: int | None = None
) -> list[EvaluationSample]:
    """The fixed views of a split; with a limit, that many spread over its indoor panoramas."""
    canonical = estimator.model.settings.canonical
    if limit is not None:
        indoor = select(records, split, ("indoor",))
        return collect(indoor[: -(-limit // 4)], canonical, 4)[:limit]
    return collect(select(records, split, ("indoor", "room")), canonical, AZIMUTHS)


def variants(estimator: Estimator, calibration: np.ndarray, folder: Path) -> Iterator[tuple[str, Path]]:
    """Name and file of each variant."""
    whole = to_onnx(estimator).SerializeToString()
    for precision in PRECISIONS:
        proto = ModelProto.FromString(whole)
        store(proto, precision)  # type: ignore[arg-type]
        yield precision, save(proto, folder / f"{precision}.onnx")
    plain = str(folder / "float32.onnx")
    half = convert_float_to_float16(ModelProto.FromString(whole), keep_io_types=True)
    yield "float16 arithmetic", save(half, folder / "half.onnx")

    dynamic = folder / "dynamic.onnx"
    quantize_dynamic(plain, dynamic, weight_type=QuantType.QUInt8)
    yield "int8 dynamic", dynamic

    for label, kinds in (("int8 static", None), ("int8 static, kernels", ["Conv"])):
        static = folder / f"{label.replace(', ', '_').replace(' ', '_')}.onnx"
        quantize_static(
            plain,
            static,
            _Photos(calibration),
            quant_format=QuantFormat.QDQ,
            per_channel=True,
            op_types_to_quantize=kinds,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
        )
        yield label, static


class _Photos(CalibrationDataReader):  # type: ignore[misc]
    """Hands the photos to the calibration one by one."""

    def __init__(self, photos: np.ndarray) -> None:
        self._left = iter(photos[:, None])

    def get_next(self) -> dict[str, np.ndarray] | None:
        photo = next(self._left, None)
        return None if photo is None else {"photo": photo}


def save(proto: ModelProto, path: Path) -> Path:
    path.write_bytes(proto.SerializeToString(deterministic=True))
    return path


def session(path: Path) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


def run(found: onnxruntime.InferenceSession, photos: np.ndarray) -> dict[str, Tensor]:
    """The outputs for all photos, one at a time, since low precision may scale by the batch."""
    parts = [found.run(list(OUTPUTS), {"photo": photo[None]}) for photo in photos]
    return {
        name: torch.from_numpy(np.concatenate([part[k] for part in parts])) for k, name in enumerate(OUTPUTS)
    }


def runner(found: onnxruntime.InferenceSession, photos: np.ndarray) -> Callable[[], object]:
    return lambda: found.run(None, {"photo": photos})


def lightings(found: dict[str, Tensor], sharpness: float) -> list[Lighting]:
    return [
        Lighting(ambient=ambient, energy=energy.clamp(min=0), sharpness=sharpness)
        for ambient, energy in zip(found["ambient"], found["anchor_energy"], strict=True)
    ]


def errors(renderer: SphereRenderer, lights: Sequence[Lighting], truth: Sequence[Tensor]) -> np.ndarray:
    """[views, 6] in the order of `CELLS`."""
    rows = []
    for light, environment in zip(lights, truth, strict=True):
        rows.append(score_spheres(renderer, light.environment(environment.shape[0])[None], environment[None]))
    return torch.cat(rows).flatten(1).double().numpy()


def largest_error(
    found: dict[str, Tensor], network: Sequence[Lighting], estimator: Estimator, photos: np.ndarray
) -> dict[str, float]:
    """Largest difference of each output from the network's, relative to its largest value for that photo."""
    with torch.inference_mode():
        camera = estimator.model(torch.from_numpy(photos)).camera
    expected = {
        "ambient": torch.stack([light.ambient for light in network]),
        "anchor_energy": torch.stack([light.energy for light in network]),
        "camera": camera,
    }
    result = {}
    for name, value in expected.items():
        scale = value.abs().flatten(1).amax(1)
        if name == "camera":
            scale = torch.ones_like(scale)  # radians have a scale of their own
        result[name] = float(((found[name] - value).abs().flatten(1).amax(1) / scale).max())
    return {name: float(f"{value:.3g}") for name, value in result.items()}


def ratio(cells: np.ndarray, reference: np.ndarray) -> float:
    """Geometric mean, over the views, of error over the network's error."""
    return round(float(np.exp(np.log(np.maximum(cells, 1e-9) / np.maximum(reference, 1e-9)).mean())), 5)


def cost(cells: np.ndarray, reference: np.ndarray) -> float:
    """The worst cell's excess over the network, of the geometric mean or of the median."""
    means = max(ratio(cells[:, k], reference[:, k]) for k in range(cells.shape[1]))
    medians = (np.median(cells, 0) / np.median(reference, 0)).max()
    return float(max(means, medians)) - 1


def summary(values: np.ndarray) -> dict[str, float]:
    return {"median": round(float(np.median(values)), 5), "mean": round(float(values.mean()), 5)}


def timed(work: dict[str, Callable[[], object]]) -> dict[str, dict[str, Any]]:
    """Milliseconds of processor time of each, in turn; and as a ratio to the first of the same round."""
    rounds: dict[str, list[float]] = {label: [] for label in work}
    for count in range(ROUNDS + 2):
        for label, call in work.items():
            start = time.thread_time()
            call()
            if count >= 2:  # the first rounds warm up
                rounds[label].append(1e3 * (time.thread_time() - start))
    first = rounds[next(iter(work))]
    return {
        label: {
            "median": round(statistics.median(times), 2),
            "least": round(min(times), 2),
            "ratio": round(statistics.median(a / b for a, b in zip(times, first, strict=True)), 3),
        }
        for label, times in rounds.items()
    }


def web(folder: Path, model: Path, photos: np.ndarray) -> dict[str, Any]:
    """The same in onnxruntime-web, or why it does not run there."""
    with tempfile.NamedTemporaryFile(suffix=".f32") as file:
        file.write(photos.astype("<f4").tobytes())
        file.flush()
        words = json.dumps({"shape": list(photos.shape), "rounds": ROUNDS})
        done = subprocess.run(
            ["node", folder / "onnx_run.mjs", model, file.name, words],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "Error" in line]
        return {"error": (lines or ["unknown"])[0].strip()[:200]}
    found = json.loads(done.stdout.splitlines()[-1])
    return {
        "version": found["version"],
        "median": round(statistics.median(found["times"][1:]), 2),
        "least": round(min(found["times"]), 2),
        "load": round(found["load"], 1),
    }


if __name__ == "__main__":
    main()
