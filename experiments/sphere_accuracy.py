"""The exact sphere renderer against Blender's Cycles and Mitsuba, under real indoor panoramas.

    MIXLIGHT_BLENDER_PYTHON=... python -m experiments.sphere_accuracy data/panoramas.csv \
        --out experiments/results/sphere_accuracy.json

Spheres, camera and maps are those of protocols M (linear, in the photo's exposure) and S (encoded); S's
picture has 256 columns instead of 960. Cycles renders each map with several seeds, never denoised, and what
it rendered is kept: a run that was cut short goes on. Errors are root mean squares over the sphere's pixels
and channels, values clipped to 1, relative to the mean.

Cycles is noisy at any number of samples. Two seeds A and B are independent, so the mean of (x - A)(x - B)
is the squared error of x against what Cycles converges to, without the noise; the error against the mean of
all seeds and that mean's own noise stand beside it.
"""

import argparse
import json
import math
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from experiments.provenance import provenance
from mixlight.data import display
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.evaluation.protocols import find
from mixlight.evaluation.renderers import Scene, scene_of
from mixlight.image.atomic import atomic_path
from mixlight.image.cache import cache_folder
from mixlight.light.reflection import Material
from mixlight.light.sphere_camera import SphereCamera
from mixlight.render.cycles_spheres import CyclesSpheres, Job
from mixlight.render.spheres import SphereRenderer
from mixlight.sphere import equirect, frames


@dataclass(frozen=True)
class Setting:
    """How Cycles renders a protocol's scene here."""

    camera: SphereCamera
    samples: int


SETTINGS: dict[Scene, Setting] = {
    "S": Setting(SphereCamera.perspective((16.0, 2.0, 0.0), 85.0, 36.0, 256, 144).cropped(), 512),
    "M": Setting(SphereCamera.orthographic(64), 1024),
}
MITSUBA_SAMPLES = 1024


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", help="CSV table of panoramas")
    parser.add_argument("--maps", type=int, default=10)
    parser.add_argument(
        "--maps-m", type=int, default=10, help="first of them that light protocol M's spheres"
    )
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--scenes", nargs="+", default=list(SETTINGS), choices=list(SETTINGS))
    parser.add_argument("--mitsuba-maps", type=int, default=3, help="0: no Mitsuba (default: %(default)s)")
    parser.add_argument("--cache", type=Path, default=cache_folder("cycles"))
    parser.add_argument("--out", type=Path, default=Path("experiments/results/sphere_accuracy.json"))
    arguments = parser.parse_args()
    if arguments.seeds < 2:
        parser.error(f"argument --seeds: expected at least 2, received {arguments.seeds}")

    records = chosen(arguments.table, arguments.maps)
    seeds = list(range(1, arguments.seeds + 1))
    result: dict[str, Any] = {
        "what": "exact spheres against Cycles, percent of the mean, values clipped to 1",
        "provenance": provenance("spheres of S and M under the same maps", len(records), seeds),
        "panoramas": [record.scene for record in records],
        "scenes": {},
    }
    for scene in arguments.scenes:
        used = records if scene == "S" else records[: arguments.maps_m]
        maps = [protocol_map(scene, record) for record in used]
        result["scenes"][scene] = against_cycles(scene, maps, arguments.seeds, arguments.cache)
        print(scene, json.dumps(result["scenes"][scene]["spheres"], indent=1), flush=True)
    if arguments.mitsuba_maps:
        maps = [protocol_map("M", record) for record in records[: arguments.mitsuba_maps]]
        result["mitsuba"] = against_mitsuba(maps)
        print("mitsuba", json.dumps(result["mitsuba"]), flush=True)
    with atomic_path(arguments.out) as temporary:
        temporary.write_text(json.dumps(result, indent=1) + "\n")


def chosen(table: str, count: int) -> list[PanoramaRecord]:
    """Panoramas evenly through the sorted names of those that no network was trained on."""
    records = [r for split in ("test", "val") for r in select(read_table(table), split, ["indoor"])]
    records.sort(key=lambda record: record.scene)
    if not 2 <= count <= len(records):
        raise SystemExit(f"expected 2 to {len(records)} maps, received {count}")
    return [records[round(i * (len(records) - 1) / (count - 1))] for i in range(count)]


def protocol_map(scene: Scene, record: PanoramaRecord) -> Tensor:
    """What lights the spheres in the protocol's first view of a panorama."""
    environment = next(find(scene).samples(record, 1)).environment.float()
    return display.encode(environment) if find(scene).encoding == "display" else environment


def against_cycles(scene: Scene, maps: list[Tensor], seeds: int, cache: Path) -> dict[str, Any]:
    """Errors of each sphere."""
    setting, found = SETTINGS[scene], scene_of(scene)
    ours = SphereRenderer(camera=setting.camera, materials=found.materials, interpolation=found.interpolation)
    pictures = ours.render(torch.stack(maps))[:, :, ours.mask].double()
    names = [material.name for material in found.materials]
    references = []
    for seed in range(1, seeds + 1):
        cycles = CyclesSpheres(Job(setting.camera, found.materials, setting.samples, seed), cache=cache)
        # A few maps a process: what a process has rendered is kept when the next one is stopped.
        parts = [cycles.render(torch.stack(maps[k : k + 5])) for k in range(0, len(maps), 5)]
        references.append(torch.cat(parts)[:, :, ours.mask].double())
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in names}
    for k in range(len(maps)):
        for i, name in enumerate(names):
            rows[name].append(errors(pictures[k, i], [r[k, i] for r in references]))
    return {
        "blender": cycles.version,
        "panoramas": len(maps),
        "camera": "perspective" if math.isfinite(setting.camera.distance) else "orthographic",
        "pixels": int(ours.mask.sum()),
        "samples": setting.samples * seeds,
        "spheres": {name: summary(values) for name, values in rows.items()},
        "maps": rows,
    }


def errors(picture: Tensor, references: list[Tensor]) -> dict[str, float]:
    """Of one sphere under one map, in percent of the mean."""
    x, seen = picture.clamp(max=1), [reference.clamp(max=1) for reference in references]
    mean = torch.stack(seen).mean(0)
    level = mean.mean()
    products = [((x - a) * (x - b)).mean() for a, b in combinations(seen, 2)]
    # Two seeds differ by twice the variance of one; the mean of n has an n-th of that.
    variance = torch.stack([(a - b).square().mean() / 2 for a, b in combinations(seen, 2)]).mean()
    values = {
        "error": 100 * torch.stack(products).mean().clamp(min=0).sqrt() / level,
        "with_noise": 100 * (x - mean).square().mean().sqrt() / level,
        "noise": 100 * (variance / len(seen)).sqrt() / level,
        "mean_ratio": picture.mean() / torch.stack(references).mean(),
    }
    return {name: round(float(value), 5) for name, value in values.items()}


def summary(rows: list[dict[str, float]]) -> dict[str, float]:
    """Over all maps: root mean squares, the worst, and the mean of the means' ratios."""
    return {
        **{
            name: round(float(np.sqrt(np.mean([row[name] ** 2 for row in rows]))), 4)
            for name in ("error", "with_noise", "noise")
        },
        "worst_error": round(max(row["error"] for row in rows), 4),
        "mean_ratio": round(float(np.mean([row["mean_ratio"] for row in rows])), 5),
    }


def against_mitsuba(maps: list[Tensor]) -> dict[str, Any]:
    """Our means over the disc over Mitsuba's: protocol M's materials, from afar and from S's camera."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    materials = scene_of("M").materials
    cameras = {
        "orthographic": SphereCamera.orthographic(40),
        "perspective": SphereCamera.perspective((16.0, 2.0, 0.0), 85.0, 36.0, 128, 72).cropped(),
    }
    result: dict[str, Any] = {"version": mitsuba.__version__, "samples": MITSUBA_SAMPLES}
    for name, camera in cameras.items():
        ours = SphereRenderer(camera=camera, materials=materials, interpolation="linear")
        ratios = []
        for environment in maps:
            means = ours.render(environment)[:, covered(camera)].mean((1, 2)).tolist()
            ratios.append(
                [
                    mean / mitsuba_mean(mitsuba, camera, material, environment)
                    for mean, material in zip(means, materials, strict=True)
                ]
            )
        result[name] = {
            material.name: [round(row[i], 5) for row in ratios] for i, material in enumerate(materials)
        }
    return result


def mitsuba_mean(mi: Any, camera: SphereCamera, material: Material, environment: Tensor) -> float:
    """Mean radiance over the disc."""
    # Mitsuba has its first and last row at the poles: it gets our map's values there.
    height, width = 4 * environment.shape[0] + 1, 8 * environment.shape[0]
    v, u = torch.arange(height) / (height - 1), (torch.arange(width) + 0.5) / width
    uv = torch.stack(torch.meshgrid(v, u, indexing="ij")[::-1], -1)
    values = equirect.sample(environment, equirect.uv_to_directions(uv))
    bitmap = mi.Bitmap(frames.convert_panorama(values, "mixlight", "mitsuba").numpy())
    _, up, towards = camera.axes
    distance = camera.distance if math.isfinite(camera.distance) else 8.0
    place = mi.ScalarTransform4f().look_at(
        origin=(towards * distance).tolist(), target=[0, 0, 0], up=up.tolist()
    )
    size = {"width": camera.width, "height": camera.height, "rfilter": {"type": "box"}}
    sensor: dict[str, Any] = {"film": {"type": "hdrfilm", "pixel_format": "rgb"} | size}
    if camera.fov_x is None:
        sensor |= {"type": "orthographic", "to_world": place}
    else:
        sensor |= {
            "type": "perspective",
            "fov": math.degrees(camera.fov_x),
            "fov_axis": "x",
            "to_world": place,
        }
    colour = {"type": "rgb", "value": material.reflectance}
    surface: dict[str, Any]
    if material.kind == "diffuse":
        surface = {"type": "diffuse", "reflectance": colour}
    elif material.kind == "ggx":
        surface = {"type": "roughconductor", "distribution": "ggx", "alpha": material.alpha}
        surface |= {"material": "none", "specular_reflectance": colour}
    else:
        surface = {"type": "conductor", "material": "none", "specular_reflectance": colour}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": sensor,
            "light": {"type": "envmap", "bitmap": bitmap},
            "sphere": {"type": "sphere", "bsdf": surface},
        }
    )
    picture = np.array(mi.render(scene, spp=MITSUBA_SAMPLES, seed=1))
    return float(picture[covered(camera).numpy()].mean())


def covered(camera: SphereCamera) -> Tensor:
    """Pixels that the sphere covers whole: in Mitsuba the others show the world too."""
    x = (torch.arange(camera.width) + 0.5 - camera.width / 2).abs() + 0.5
    y = (torch.arange(camera.height) + 0.5 - camera.height / 2).abs() + 0.5
    return torch.hypot(x, y[:, None]) < camera.radius


if __name__ == "__main__":
    main()
