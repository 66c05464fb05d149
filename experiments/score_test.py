"""Scores models on fixed views of a split by protocol M, beside the floors and the ceiling.

    python experiments/score_test.py data/panoramas.csv data/rooms.csv --model default \
        --out experiments/results/first_light.json

Views: 8 azimuths, FOV 60 degrees, pitch -8 degrees, exposure .18 / median luminance, sRGB, 8 bits. Errors are
linear and unclipped, over the pixels and channels of each sphere. Intervals of the medians are bootstrapped
over whole panoramas.
"""

import argparse
import itertools
import json
import math
import platform
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from mixlight.data.camera_model import exposure_gain, plain_photo
from mixlight.data.crops import Crop, take_view
from mixlight.data.evaluation_set import EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord, load_panorama, read_table, select
from mixlight.evaluation import floors, protocol_m
from mixlight.image.atomic import atomic_path
from mixlight.network.canonical import CanonicalView
from mixlight.network.estimator import Estimator
from mixlight.network.model import MixLightNet
from mixlight.training.validation import predicted_environments

PITCHES_DEG = (-30.0, -15.0, 0.0, 15.0)
ROLLS_DEG = (-6.0, 0.0, 6.0)
"""Poses of the views on which the camera's pitch and roll are scored."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="+", help="CSV tables of panoramas")
    parser.add_argument("--model", action="append", default=[], metavar="[LABEL=]NAME_OR_PATH")
    parser.add_argument("--split", default="test", choices=("val", "test"))
    parser.add_argument("--categories", nargs="+", default=["indoor"])
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()

    records = [record for table in arguments.tables for record in read_table(table)]
    result: dict[str, Any] = {
        "protocol": "M",
        "split": arguments.split,
        "categories": arguments.categories,
        "machine": f"{platform.machine()}, {torch.get_num_threads()} threads, torch {torch.__version__}",
        "commit": _commit(),
        "methods": {},
    }
    # Views are taken in the size that each model sees; floors and ceiling belong to the first.
    for k, argument in enumerate(arguments.model or ["default"]):
        label, _, name = argument.rpartition("=")
        estimator = Estimator.load(name)
        model = estimator.model
        samples = collect(select(records, arguments.split, arguments.categories), model.settings.canonical)
        scenes = [sample.scene for sample in samples]
        methods: dict[str, protocol_m.Method] = {}
        if k == 0:
            methods |= _floors(records, model.settings.canonical)
            result |= {"panoramas": len(set(scenes)), "views": len(scenes)}
        label = label or f"MixLight ({estimator.card.get('name', name)})"
        methods[label] = _network(model)
        for method, scores in protocol_m.evaluate(methods, samples).items():
            result["methods"][method] = scores.summary(scenes)
        result["methods"][label]["camera"] = _camera_error(
            model, select(records, arguments.split, arguments.categories)
        )
        result["methods"][label]["weights"] = {key: estimator.card.get(key) for key in ("name", "commit")}
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(arguments.out) as temporary:
        Path(temporary).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for method, cells in result["methods"].items():
        medians = [
            f"{cells[f'{s}_{m}']['median']:.3f}" for m in ("rmse", "si_rmse") for s in protocol_m.SPHERES
        ]
        print(f"{method:34s} {' '.join(medians)}")


def _floors(records: list[Any], canonical: CanonicalView) -> dict[str, protocol_m.Method]:
    indoor = select(records, "train", ("indoor",))
    mean = floors.training_mean_light(indoor, canonical)
    typical = floors.training_mean_light(indoor, canonical, geometric=True)
    return {
        "training-mean light": lambda sample: mean,
        "training-mean light, geometric": lambda sample: typical,
        "photo's mean colour": floors.photo_mean_light,
        "oracle": floors.oracle_light,
    }


def _network(model: MixLightNet) -> Callable[[EvaluationSample], Tensor]:
    @torch.inference_mode()
    def method(sample: EvaluationSample) -> Tensor:
        return predicted_environments(model(sample.photo[None]), model.settings.sharpness)[0]

    return method


@torch.inference_mode()
def _camera_error(model: MixLightNet, records: list[PanoramaRecord]) -> dict[str, float]:
    """Median absolute error of pitch and roll in degrees, on views of their own with known poses.

    Beside them stands what the best constant guess (the median of the true poses) reaches.
    """
    canonical = model.settings.canonical
    inside = torch.ones(canonical.height, canonical.width, dtype=torch.bool)
    found, true = [], []
    for record in records:
        panorama = load_panorama(record.path)
        for k, (pitch, roll) in enumerate(itertools.product(PITCHES_DEG, ROLLS_DEG)):
            pose = (math.radians(pitch), math.radians(roll))
            crop = Crop(azimuth=k, azimuths=len(PITCHES_DEG) * len(ROLLS_DEG), pitch=pose[0], roll=pose[1])
            view = take_view(panorama, crop, canonical)
            photo = plain_photo(view, inside, exposure_gain(view, inside)).photo
            found.append(model(photo.permute(2, 0, 1)[None]).camera[0])
            true.append(torch.tensor(pose))
    poses, truth = torch.rad2deg(torch.stack(found)), torch.rad2deg(torch.stack(true))
    errors = (poses - truth).abs().median(0).values.tolist()
    guesses = (truth.median(0).values - truth).abs().median(0).values.tolist()
    return {
        "pitch_error_deg": round(errors[0], 2),
        "roll_error_deg": round(errors[1], 2),
        "constant_pitch_error_deg": round(guesses[0], 2),
        "constant_roll_error_deg": round(guesses[1], 2),
        "views": len(found),
    }


def _commit() -> str:
    found = subprocess.run(
        ["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False
    )
    return found.stdout.strip() or "unknown"


if __name__ == "__main__":
    main()
