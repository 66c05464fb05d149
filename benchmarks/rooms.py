"""What a room costs: core-seconds by kind of work, and how many rooms a core makes in an hour.

    python -m benchmarks.rooms [SEED [COUNT [WIDTH [SAMPLES]]]]

Time is counted as CPU time of Blender and of everything around it, so that what else the machine does hardly
matters; on an idle machine with one Blender on all cores it is wall time times cores.
"""

import sys
import tempfile
import time
from pathlib import Path

from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.job import Settings
from mixlight.data.rooms.render import Outcome, Rooms, render_rooms

SHARE = 0.05
"""Of the time that may go into anything but Cycles and its denoiser."""


def main(seed: int = 0, count: int = 4, width: int = 1024, samples: int = 16) -> None:
    rooms = Rooms(Settings(width, samples), 1, Catalogue.find())
    with tempfile.TemporaryDirectory() as folder:
        before = time.process_time()
        outcomes = render_rooms(range(seed, seed + count), Path(folder) / "set", rooms)
        around = time.process_time() - before
    print(table([outcome for outcome in outcomes if outcome.error is None], around))


def table(outcomes: list[Outcome], around: float) -> str:
    """Markdown; `around` is what the host spent."""
    count = len(outcomes)
    cores = {
        kind: sum(o.core_seconds[kind] for o in outcomes) / count for kind in ("build", "render", "denoise")
    }
    rows = {
        "plan, files, packing (MixLight)": around / count,
        "scene (Blender)": cores["build"],
        "light paths (Cycles)": cores["render"],
        "denoising of every group, and raw files (Blender)": cores["denoise"],
    }
    total = sum(rows.values())
    lines = ["| work | core-seconds a panorama | share |", "|---|---|---|"]
    lines += [f"| {name} | {value:.2f} | {100 * value / total:.1f} % |" for name, value in rows.items()]
    lines.append(f"| all | {total:.2f} | {3600 / total:.0f} panoramas an hour and core |")
    other = (rows["plan, files, packing (MixLight)"] + rows["scene (Blender)"]) / total
    verdict = "met" if other <= SHARE else "not met"
    lines.append(f"\nNot Cycles: {100 * other:.1f} %, limit {100 * SHARE:g} %: {verdict}")
    return "\n".join(lines)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
