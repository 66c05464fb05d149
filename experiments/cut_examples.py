"""Cuts the example photos out of test panoramas (CC0), so that the true light around each is known.

    python experiments/cut_examples.py data/panoramas.csv

The network never saw these panoramas. Each photo is an ordinary 8-bit JPEG with the focal length in its EXIF.
"""

import math
import sys
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from mixlight.data.camera_model import exposure_gain
from mixlight.data.panoramas import load_panorama, read_table
from mixlight.image.color import linear_to_srgb
from mixlight.sphere import camera

OUT = Path("src/mixlight/assets/examples")
FOV = math.radians(60)
HEIGHT, WIDTH = 480, 640
PITCH = math.radians(-8)
VIEWS = {"lythwood_room": 0, "comfy_cafe": 45, "artist_workshop": 180, "anniversary_lounge": 0}
"""Scene and azimuth in degrees: views of the evaluation, so that their true light is part of the test set."""


def main(table: str) -> None:
    OUT.mkdir(parents=True, exist_ok=True)
    records = {record.scene: record for record in read_table(table)}
    for scene, azimuth in VIEWS.items():
        if records[scene].split != "test":
            raise SystemExit(f"{scene}: expected a test panorama, got split {records[scene].split}")
        panorama = load_panorama(records[scene].path, 1024)
        view = camera.view(panorama, HEIGHT, WIDTH, FOV, math.radians(azimuth), PITCH, supersample=2)
        gain = exposure_gain(view, torch.ones(HEIGHT, WIDTH, dtype=torch.bool))
        encoded = linear_to_srgb((view * gain).clamp(0, 1).numpy())
        picture = Image.fromarray((encoded * 255 + 0.5).astype(np.uint8))
        exif = Image.Exif()
        # 36 mm film behind this lens sees the view's field of view.
        exif.get_ifd(0x8769)[0xA405] = round(18 / math.tan(FOV / 2))
        picture.save(OUT / f"{scene}.jpg", quality=92, exif=exif)
        print(f"{scene}.jpg  azimuth {azimuth}  gain {gain:.4f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
