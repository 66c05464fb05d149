"""Runs inside Blender: renders the rooms whose folders are named on stdin, one a line.

    python room.py -- THREADS

A folder holds scene.json and arrays.npz (see `mixlight.data.rooms.job`). Each camera's panorama goes to
camera-K.exr there; at the end answer.json says how long it took, or what went wrong.
"""

import json
import math
import os
import sys
import time
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import library
import meshes
import numpy as np
import outdoors
import passes
import shaders


def main(threads):
    """Render until stdin ends."""
    while line := sys.stdin.readline():
        folder = Path(line.rstrip("\n"))
        try:
            answer = {"ok": True, **render(folder, threads)}
        except Exception as error:
            traceback.print_exc()
            answer = {"ok": False, "error": f"{type(error).__name__}: {error}"}
        sys.stdout.flush()
        part = folder / "answer.part"
        part.write_text(json.dumps(answer))
        os.replace(part, folder / "answer.json")


def render(folder, threads):
    """One room, all its cameras; returns the seconds it took, and those of all cores together."""
    clock = Clock()
    job = json.loads((folder / "scene.json").read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    settings(scene, job["render"], threads)
    build(scene, job, folder)
    output = passes.compositor(scene, job["groups"], folder, job["render"]["denoise"])
    clock.lap("build")
    # The compositor takes the noise off, and writes.
    bpy.app.handlers.render_stats[:] = [
        lambda text, _: clock.lap("render") if text.startswith("Compositing") else None
    ]
    for index, camera in enumerate(job["cameras"]):
        look(scene, camera)
        scene.frame_set(index)
        scene.cycles.seed = (job["render"]["seed"] + index) % 2**31
        for old in folder.glob("raw*"):  # of a Blender that was killed
            old.unlink()
        passes.name_output(output, "raw")
        bpy.ops.render.render()
        made = sorted(folder.glob("raw*"))
        if len(made) != 1 or made[0].stat().st_size == 0:
            raise OSError(f"expected Blender to write one panorama, found {[path.name for path in made]}")
        os.replace(made[0], folder / f"camera-{index}.exr")
        clock.lap("denoise")
    return {"seconds": clock.seconds, "core_seconds": clock.cores, "blender": bpy.app.version_string}


class Clock:
    """Sums up what each kind of work takes: seconds, and seconds of all cores together."""

    def __init__(self):
        self.seconds, self.cores = {}, {}
        self.last = time.perf_counter(), time.process_time()

    def lap(self, kind):
        """What went by since the last lap was of this kind."""
        now = time.perf_counter(), time.process_time()
        for sums, before, after in zip((self.seconds, self.cores), self.last, now, strict=True):
            sums[kind] = sums.get(kind, 0.0) + after - before
        self.last = now


def settings(scene, given, threads):
    """Cycles without anything that would make light groups differ from their sum."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = given["samples"]
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False  # of the sum, which nobody reads: every group is denoised by itself
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = given["bounces"], given["diffuse"], 4
    cycles.transmission_bounces, cycles.transparent_max_bounces = 6, 16
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = given["clamp"]
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.blur_glossy = 0.5
    cycles.use_light_tree = True
    cycles.light_sampling_threshold = 0.0  # faint lights are bright after a remix
    picture = scene.render
    picture.resolution_x, picture.resolution_y = given["width"], given["width"] // 2
    picture.resolution_percentage = 100
    picture.threads_mode, picture.threads = "FIXED", threads
    picture.use_persistent_data = True
    picture.film_transparent = False
    picture.compositor_device, picture.compositor_precision = "CPU", "FULL"
    scene.view_settings.view_transform = "Raw"


def build(scene, job, folder):
    """Everything but the camera."""
    passes.groups(scene, job["groups"])
    with np.load(folder / "arrays.npz") as arrays:
        for index, given in enumerate(job["meshes"]):
            material = shaders.material(given["material"], given["name"])
            placed = meshes.mesh(given["name"], arrays, f"m{index}", material, given["smooth"])
            if "group" in given["material"]:
                placed.lightgroup = given["material"]["group"]
    library.place(scene, job["library"], job["placements"])
    outdoors.sky(scene, folder / "sky.exr")
    if job["sun"]:
        outdoors.sun(scene, job["sun"])
    for portal in job["portals"]:
        outdoors.portal(scene, portal)


def look(scene, given):
    """A level panoramic camera whose centre looks along `turn`."""
    data = bpy.data.cameras.new("camera")
    data.type = "PANO"
    data.panorama_type = "EQUIRECTANGULAR"
    data.clip_start, data.clip_end = 0.01, 1e4
    placed = bpy.data.objects.new("camera", data)
    placed.location = given["position"]
    placed.rotation_euler = (math.pi / 2, 0.0, given["turn"])
    scene.collection.objects.link(placed)
    scene.camera = placed


if __name__ == "__main__":
    main(int(sys.argv[sys.argv.index("--") + 1]))
