"""Stands in for the script inside Blender: grey pictures, at once, and every trouble on demand.

The environment variable TROUBLES maps names of rooms to error, die, die_once, hang or garbage, in JSON.
"""

import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import OpenEXR


def main() -> None:
    troubles = json.loads(os.environ.get("TROUBLES", "{}"))
    while line := sys.stdin.readline():
        folder = Path(line.rstrip("\n"))
        job = json.loads((folder / "scene.json").read_text())
        trouble = troubles.get(job["name"])
        if trouble == "die" or (trouble == "die_once" and not (folder / "tried").exists()):
            (folder / "tried").touch()
            sys.stderr.write("Segmentation fault (not really)\n")
            sys.stderr.flush()
            os._exit(11)
        if trouble == "hang":
            time.sleep(300)
        width = job["render"]["width"]
        for index in range(len(job["cameras"])):
            channels = {
                f"{group}.{c}": np.full((width // 2, width), 1.0 + k, np.float32)
                for k, group in enumerate(job["groups"])
                for c in "RGBA"
            }
            channels["depth.V"] = np.full((width // 2, width), 2.0, np.float32)
            path = folder / f"camera-{index}.exr"
            if trouble == "garbage":
                path.write_bytes(b"no picture")
            else:
                OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(path))
        seconds = {"build": 0.1, "render": 1.0, "denoise": 0.2}
        answer = {"ok": True, "seconds": seconds, "core_seconds": seconds, "blender": "stand-in"}
        if trouble == "error":
            answer = {"ok": False, "error": "ValueError: no such shader"}
        (folder / "part").write_text(json.dumps(answer))
        os.replace(folder / "part", folder / "answer.json")


if __name__ == "__main__":
    main()
