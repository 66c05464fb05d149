"""Maps a second of the exact sphere renderer and of Cycles at the same error.

    python -m benchmarks.spheres_blender data/panoramas.csv [--out JSON]

Both render protocol S's three spheres at 960x540. Cycles' error falls with the square root of the number of
samples; the number at which it is as far from the truth as ours comes from
experiments/results/sphere_accuracy.json, and the time of one sample from two short runs. Time is that of all
threads on the processor, so that whatever else the machine does hardly matters.
"""

import argparse
import json
import statistics
import time
from pathlib import Path

import torch

from benchmarks.report import save
from experiments.provenance import provenance
from mixlight.data import display
from mixlight.data.panoramas import read_table, select
from mixlight.evaluation.protocols import find
from mixlight.evaluation.renderers import matrix, scene_of
from mixlight.render.cycles_spheres import Job, render


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", help="CSV table of panoramas")
    parser.add_argument("--accuracy", type=Path, default=Path("experiments/results/sphere_accuracy.json"))
    parser.add_argument("--maps", type=int, default=2)
    parser.add_argument("--samples", type=int, default=8, help="of the timed pictures (default: %(default)s)")
    parser.add_argument("--out", type=Path, help="JSON file")
    arguments = parser.parse_args()

    made = provenance("processor time of spheres of S at equal error", arguments.maps, Job.seed)
    measured = json.loads(arguments.accuracy.read_text())["scenes"]["S"]
    records = select(read_table(arguments.table), "test", ["indoor"])[: arguments.maps]
    maps = [display.encode(next(find("S").samples(r, 1)).environment.float()) for r in records]

    exact = matrix("S")
    exact.render(torch.stack(maps))
    times = []
    for _ in range(5):
        start = time.process_time()
        exact.render(torch.stack(maps))
        times.append((time.process_time() - start) / len(maps))
    ours = statistics.median(times)

    found = scene_of("S")
    count = len(found.materials)
    few, many = (
        render(Job(found.camera, found.materials, samples), [m.numpy() for m in maps])[1]
        for samples in (arguments.samples, 5 * arguments.samples)
    )
    by_sphere = {}
    sample_seconds = 0.0
    for i, material in enumerate(found.materials):
        spent = [statistics.median(report["processor_seconds"][i::count]) for report in (few, many)]
        of_one = (spent[1] - spent[0]) / (4 * arguments.samples)
        sample_seconds += of_one
        error, noise = (measured["spheres"][material.name][key] for key in ("error", "noise"))
        # The accuracy was measured on pixels of another size; what counts is the number of samples in one.
        needed = measured["samples"] * (noise / error) ** 2
        by_sphere[material.name] = {
            "our_error_percent": error,
            "samples_for_it": round(needed),
            "cycles_seconds": round(of_one * needed, 2),
        }
    cycles = sum(row["cycles_seconds"] for row in by_sphere.values())
    result = {
        "provenance": made,
        "maps": len(maps),
        "samples": [arguments.samples, 5 * arguments.samples],
        "maps_per_processor_second": round(1 / ours, 2),
        "maps_per_processor_second_cycles": round(1 / cycles, 7),
        "cycles_seconds_of_1024_samples": round(1024 * sample_seconds, 1),
        "ratio": round(cycles / ours),
        "blender": few["version"],
        "threads": torch.get_num_threads(),
        "spheres": by_sphere,
    }
    print(json.dumps(result, indent=1))
    if arguments.out:
        save(arguments.out, result)


if __name__ == "__main__":
    main()
