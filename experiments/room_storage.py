"""What lossy storage of rooms' light groups costs, measured on the light that is fitted to their remixes.

    python -m experiments.room_storage SET

SET holds rooms that were stored losslessly (`mixlight rooms --lossless`). Each position is stored again
with every codec; its plan's own light and a few random remixes are mixed from both, and compared as pixels,
as fitted lights, and as spheres under the fitted lights.
"""

import argparse
import json
import random
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from experiments.provenance import provenance
from mixlight.data.rooms.remix import plan_recipe, random_recipe, remix
from mixlight.data.rooms.store import read_room, write_camera, write_document
from mixlight.image.atomic import atomic_path
from mixlight.light.fit import parameters
from mixlight.light.lighting import Lighting
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect

RESULTS = Path(__file__).parent / "results" / "room_storage.json"
VARIANTS = {
    "zip": ("zip", 45.0),
    "dwab 20": ("dwab", 20.0),
    "dwab 45": ("dwab", 45.0),
    "dwab 100": ("dwab", 100.0),
}
REMIXES = 4
HEIGHT = 128


def main() -> None:
    """Measure, write the results and print the table."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("set", type=Path, help="folder of rooms stored losslessly")
    folder = arguments.parse_args().set
    files = sorted(folder.glob("room-*/camera-*.exr"))
    if not files:
        raise SystemExit("expected room-*/camera-*.exr in the set, found none")
    header = json.loads((folder / "rooms.json").read_text(encoding="utf-8"))
    if not header.get("lossless"):
        raise SystemExit(f"{folder}: expected rooms of `mixlight rooms --lossless`, got others")
    seeds = [int(file.parent.name.split("-")[1]) for file in files]
    pictures = len(files) * (1 + REMIXES)
    made = provenance("each codec against the lossless light, see the script", pictures, range(REMIXES))
    renderer = SphereRenderer(resolution=64, height=HEIGHT)
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in VARIANTS}
    for file in files:
        for name, found in of_camera(file, renderer).items():
            rows[name] += found
    result: dict[str, Any] = {
        "question": "what lossy storage of light groups costs",
        "provenance": made,
        "rooms": {"made by": header["mixlight"], "width": header["width"], "seeds": seeds},
        "cameras": len(files),
        "remixes of each camera": REMIXES,
        "variants": {name: summary(found) for name, found in rows.items()},
    }
    with atomic_path(RESULTS) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(table(result["variants"]))


def of_camera(file: Path, renderer: SphereRenderer) -> dict[str, list[dict[str, float]]]:
    """Errors of each variant for every picture of one camera position."""
    room = read_room(file)
    plan = room.plan
    recipes = [plan_recipe(plan)]
    recipes += [random_recipe(room.groups, plan, random.Random(k)) for k in range(REMIXES)]
    true = [remix(room.groups, recipe) for recipe in recipes]
    fits = [fitted(panorama) for panorama in true]
    seen = [spheres(renderer, light) for light in fits]
    on = {f.group: f.on for f in plan.fixtures}
    found: dict[str, list[dict[str, float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, (codec, level) in VARIANTS.items():
            path = Path(folder) / "camera.exr"
            groups = {group: pixels.numpy() for group, pixels in room.groups.items()}
            write_camera(
                path, groups, room.depth.numpy(),
                document="room.json", camera=room.camera, on=on, codec=codec, level=level,
            )  # fmt: skip
            write_document(path.with_name("room.json"), room.document)
            stored = read_room(path).groups
            size = path.stat().st_size / 1e6
            found[name] = []
            for recipe, panorama, light, balls in zip(recipes, true, fits, seen, strict=True):
                again = remix(stored, recipe)
                other = fitted(again)
                pictures = spheres(renderer, other)
                error = (pictures - balls).square().mean((1, 2)).sqrt()
                error = error / balls.square().mean((1, 2)).sqrt()
                found[name].append(
                    {
                        "megabytes": size,
                        "pixels": float((again - panorama).abs().mean() / panorama.mean()),
                        "energy": abs(
                            float(equirect.integrate(again).sum() / equirect.integrate(panorama).sum()) - 1
                        ),
                        "sources": float(
                            (other.energy - light.energy).abs().sum() / light.energy.sum().clamp(min=1e-9)
                        ),
                        "ambient": float((other.ambient - light.ambient).norm() / light.ambient.norm()),
                        **dict(zip(("diffuse", "matte", "mirror"), error.tolist(), strict=True)),
                    }
                )
    return found


def fitted(panorama: Tensor) -> Lighting:
    """The fit of `mixlight fit`: ambient harmonics and anchors."""
    found = parameters(equirect.resize(panorama, HEIGHT))
    return Lighting(found.ambient, found.anchor_energy)


def spheres(renderer: SphereRenderer, light: Lighting) -> Tensor:
    """[3, pixels, 3]: the three spheres under a light."""
    pictures = renderer.render(light.environment(HEIGHT)[None])
    return pictures[0][:, renderer.mask]


def summary(rows: list[dict[str, float]]) -> dict[str, dict[str, float]]:
    """Median, 95th percentile and maximum of each number."""
    return {
        key: {
            "median": float(np.median([row[key] for row in rows])),
            "p95": float(np.quantile([row[key] for row in rows], 0.95)),
            "max": max(row[key] for row in rows),
        }
        for key in rows[0]
    }


def table(variants: dict[str, Any]) -> str:
    """The medians and the 95th percentiles, as Markdown."""
    keys = ("pixels", "energy", "sources", "ambient", "diffuse", "matte", "mirror")
    lines = ["| storage | MB a position | " + " | ".join(keys) + " |", "| --- " * (len(keys) + 2) + "|"]
    for name, found in variants.items():
        cells = [f"{found[k]['median']:.2%} ({found[k]['p95']:.2%})" for k in keys]
        lines.append(f"| {name} | {found['megabytes']['median']:.2f} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
