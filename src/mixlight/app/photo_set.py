"""The photos of a protocol as files, so that any other system can be scored by it."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.protocols import Protocol
from mixlight.image.atomic import atomic_folder
from mixlight.image.ldr import write_png

__all__ = ["TABLE", "write_photos"]

TABLE = "photos.csv"
"""Names each photo, and says how it was taken."""


def write_photos(
    protocol: Protocol, records: Sequence[PanoramaRecord], folder: Path, *, quiet: bool = False
) -> int:
    """Write each photo as `<name>.png`, and `photos.csv` with a line for each; returns how many there are.

    A prediction for a photo has the photo's name, and `.exr` or `.hdr` for `.png`. The true light is not
    written. All of the folder appears, or nothing.

    Raises:
        ValueError: a panorama that is none.
        OSError: a file cannot be read or written.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    count = 0
    with atomic_folder(folder) as fresh, (fresh / TABLE).open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("file", "scene", "azimuth_deg", "pitch_deg", "fov_deg", "width", "height"))
        for record in tqdm(records, unit="panorama", disable=quiet or None):
            for sample in protocol.samples(record):
                path = fresh / f"{sample.name}.png"
                path.parent.mkdir(parents=True, exist_ok=True)
                pixels = (sample.photo.permute(1, 2, 0) * 255).round().numpy().astype(np.uint8)
                write_png(path, pixels)
                view = (f"{math.degrees(angle):.6g}" for angle in (sample.pitch, sample.fov))
                size = (pixels.shape[1], pixels.shape[0])
                table.writerow((f"{sample.name}.png", sample.scene, f"{sample.azimuth_deg:g}", *view, *size))
                count += 1
    return count
