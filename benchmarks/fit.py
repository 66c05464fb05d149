"""(d) `fit` of a 4096x2048 EXR, the reading included, against reading it."""

import tempfile
from pathlib import Path

import numpy as np
import torch

from benchmarks.timing import Result, side_by_side
from mixlight.image import exr
from mixlight.light.fit import fit

HEIGHT = 2048


def measure() -> Result:
    generator = np.random.default_rng(0)
    # Noise does not compress: reading it is neither easier nor harder than a photographed panorama's grain.
    rgb = generator.lognormal(-1, 1, (HEIGHT // 8, HEIGHT // 4, 3)).repeat(8, 0).repeat(8, 1)
    rgb = (rgb * generator.uniform(0.9, 1.1, rgb.shape)).astype(np.float32)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "panorama.exr"
        exr.write(path, rgb)
        return side_by_side(
            "d",
            2.0,
            ("read and fit a 4096x2048 EXR", lambda: fit(torch.from_numpy(exr.read(path)[0]))),
            ("read it", lambda: exr.read(path)),
            15,
            1,
        )
