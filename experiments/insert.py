"""One object in one photo under the true panorama and under the estimate, side by side, with the error.

    python -m experiments.insert data/panoramas.csv --out experiments/results/insert.json

The photos are the shipped examples, whose panoramas the network never saw (`cut_examples.py`). Camera, object
and place are the same in both pictures, so that what differs is the light alone. Pictures go to docs/images.
"""

import argparse
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image
from torch import Tensor

from experiments.cut_examples import FOV, HEIGHT, OUT, PITCH, VIEWS, WIDTH
from experiments.provenance import provenance
from mixlight.app.photos import field_of_view, linear_tensor
from mixlight.data.camera_model import exposure_gain
from mixlight.data.panoramas import load_panorama, read_table
from mixlight.image.atomic import atomic_path
from mixlight.image.color import linear_to_srgb
from mixlight.image.ldr import read_photo
from mixlight.network.estimator import Estimator
from mixlight.render import mitsuba
from mixlight.render.composite import Layers, composite
from mixlight.render.insert import insert
from mixlight.render.insertion import make_scene
from mixlight.render.model import load_model
from mixlight.render.scene_camera import SceneCamera, place
from mixlight.sphere import camera, equirect


@dataclass(frozen=True)
class Setting:
    """What is set where, and the part of the photo that the documentation shows."""

    object: str
    at: tuple[float, float]
    scale: float
    turn_deg: float
    crop: tuple[int, int]
    """Left and top of the part that is shown."""


SETTINGS = {
    "comfy_cafe": Setting("chair", (0.72, 0.905), 1.15, -35, (270, 210)),
    "anniversary_lounge": Setting("teapot", (0.185, 0.484), 0.55, 20, (0, 110)),
    "artist_workshop": Setting("spheres", (0.805, 0.806), 0.62, 0, (300, 230)),
    "lythwood_room": Setting("teapot", (0.71, 0.80), 0.60, 160, (290, 230)),
}
SHOWN = 340, 250
"""Width and height of the part that is shown."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", help="CSV table of panoramas")
    parser.add_argument("--model", default="default")
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("--only", nargs="*", default=list(SETTINGS), choices=list(SETTINGS))
    parser.add_argument("--out", type=Path, default=Path("experiments/results/insert.json"))
    parser.add_argument("--images", type=Path, default=Path("docs/images"))
    arguments = parser.parse_args()
    # Now, before the pictures that it writes change the tree.
    made = provenance("one view of M a panorama, rendered by Mitsuba scalar_rgb", len(arguments.only), 0)

    arguments.images.mkdir(parents=True, exist_ok=True)
    records = {record.scene: record for record in read_table(arguments.table)}
    estimator = Estimator.load(arguments.model)
    scenes = {}
    for scene in arguments.only:
        panorama = load_panorama(records[scene].path, 512)
        scenes[scene] = compare(scene, panorama, estimator, arguments.samples, arguments.images)
        print(scene, json.dumps(scenes[scene]), flush=True)
    result = {
        "what": "an object lit by the estimate against the same lit by the true panorama; linear, in the "
        "photo's exposure",
        "provenance": made,
        "model": estimator.card.get("name", arguments.model),
        "model_commit": estimator.card.get("commit"),
        "samples": arguments.samples,
        "scenes": scenes,
        "median": {
            key: round(float(np.median([row[key] for row in scenes.values()])), 4)
            for key in next(iter(scenes.values()))
            if key.startswith(("object_", "shadow_"))
        },
    }
    with atomic_path(arguments.out) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n")


def compare(scene: str, panorama: Tensor, estimator: Estimator, samples: int, images: Path) -> dict[str, Any]:
    setting = SETTINGS[scene]
    photo = read_photo(OUT / f"{scene}.jpg")
    fov = field_of_view(photo).radians
    estimate = estimator.estimate(linear_tensor(photo), fov)
    # The light of the panorama as this photo was exposed.
    azimuth = math.radians(VIEWS[scene])
    view = camera.view(panorama, HEIGHT, WIDTH, FOV, azimuth, PITCH)
    gain = exposure_gain(view, torch.ones(HEIGHT, WIDTH, dtype=torch.bool))
    true = equirect.rotate_azimuth(panorama, azimuth) * gain
    # The camera is the one that took the photo: what is compared is the light alone.
    seen_by = SceneCamera(*photo.size, fov, PITCH, 0.0)
    model = load_model(setting.object)
    placement = place(
        seen_by, *model.bounds, *setting.at, scale=setting.scale, turn=math.radians(setting.turn_deg)
    )
    lights = {"estimate": estimate.lighting.pruned().environment(256), "panorama": true}
    layers, pictures = {}, {"photo": photo.linear}
    for name, environment in lights.items():
        built = make_scene(photo.linear, seen_by, model, placement, environment)
        layers[name] = insert(built, photo.linear, mitsuba.render, samples=samples)
        picture = photo.linear.copy()
        picture[layers[name].region.slices] = composite(photo.linear, layers[name])
        pictures[name] = picture
    left, top = setting.crop
    width, height = SHOWN
    strip = np.concatenate([p[top : top + height, left : left + width] for p in pictures.values()], axis=1)
    encoded = (linear_to_srgb(strip.clip(0, 1)) * 255 + 0.5).astype(np.uint8)
    with atomic_path(images / f"insert_{scene}.jpg") as temporary:
        Image.fromarray(encoded).save(temporary, format="JPEG", quality=92)
    error = errors(layers["estimate"], layers["panorama"], photo.linear.shape[:2])
    return {"object": setting.object, "at": setting.at, "gain": round(float(gain), 5)} | error


def errors(estimate: Layers, truth: Layers, size: tuple[int, int]) -> dict[str, float]:
    """Of the object, over the pixels that it covers; of the shadow, over those that either light changes."""

    def whole(layers: Layers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        beauty, shadow, coverage = np.zeros((*size, 3)), np.zeros((*size, 3)), np.zeros(size)
        beauty[layers.region.slices] = layers.beauty
        shadow[layers.region.slices] = layers.shadow * (1 - layers.coverage)[..., None]
        coverage[layers.region.slices] = layers.coverage
        return beauty, shadow, coverage

    (p, p_shadow, coverage), (g, g_shadow, _) = whole(estimate), whole(truth)
    changed = ((p_shadow != 0) | (g_shadow != 0)).any(-1)
    covered = 3 * coverage.sum()
    best = (p * g).sum() / (p * p).sum()
    scale = math.sqrt((g * g).sum() / covered)
    return {
        "object_rmse": round(math.sqrt(((p - g) ** 2).sum() / covered), 4),
        "object_si_rmse": round(math.sqrt(((best * p - g) ** 2).sum() / covered), 4),
        "object_rms_of_truth": round(scale, 4),
        "object_mean_over_true_mean": round(float(p.sum() / g.sum()), 4),
        "shadow_rmse": round(math.sqrt(((p_shadow - g_shadow)[changed] ** 2).mean()), 4),
        "shadow_sum_over_true_sum": round(float(p_shadow.sum() / g_shadow.sum()), 4),
        "shadow_deepest_true": round(float(-g_shadow.min()), 4),
    }


if __name__ == "__main__":
    main()
