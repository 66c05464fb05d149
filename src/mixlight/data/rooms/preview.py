"""Look at one room: `python -m mixlight.data.rooms.preview SEED OUT.png [WIDTH [SAMPLES]]`."""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import OpenEXR

from mixlight.blender.session import Session
from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.job import Settings, write_job
from mixlight.data.rooms.plan import Plan
from mixlight.data.rooms.scene import build
from mixlight.image import ldr, tonemap


def main() -> None:
    """Render the room of a seed."""
    seed, out = int(sys.argv[1]), Path(sys.argv[2])
    width, samples = [int(a) for a in sys.argv[3:5]] + [256, 8][len(sys.argv) - 3 :]
    t = time.perf_counter()
    scene = build(_plan(seed), catalogue=Catalogue.find())
    t1 = time.perf_counter()
    with (
        tempfile.TemporaryDirectory(prefix="mixlight-") as name,
        Session(Path(__file__).with_name("cycles") / "room.py", ["2"]) as blender,
    ):
        write_job(scene, Settings(width=width, samples=samples), Path(name))
        t2 = time.perf_counter()
        answer = blender.ask(Path(name), 600)
        sys.stdout.write(
            f"{answer} plan {t1 - t:.2f} write {t2 - t1:.2f} total {time.perf_counter() - t:.2f}\n"
        )
        if answer["ok"]:
            for k in range(len(scene.cameras)):
                found = OpenEXR.File(str(Path(name) / f"camera-{k}.exr"), separate_channels=True)
                planes = {n: c.pixels for p in found.parts for n, c in p.channels.items()}
                sys.stdout.write(f"{sorted(planes)}\n")
                total = np.sum(
                    [np.stack([planes[f"{g}.{c}"] for c in "RGB"], -1) for g in scene.groups], axis=0
                )
                path = out if k == 0 else out.with_stem(f"{out.stem}-{k}")
                ldr.write_png(path, tonemap.preview(total, tonemap.exposure_for(total)))


def _plan(seed: int) -> Plan:
    try:
        module = importlib.import_module("mixlight.data.rooms.make_plan")
    except ModuleNotFoundError:
        from mixlight.data.rooms.box_room import box_plan

        return box_plan(seed)
    plan = module.make_plan(seed, library=Catalogue.find(), skies=())
    assert isinstance(plan, Plan)
    return plan


if __name__ == "__main__":
    main()
