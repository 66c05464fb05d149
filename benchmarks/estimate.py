"""(a) Light of 64 photos in memory against the bare backbone on the same canonical views."""

import torch

from benchmarks.timing import Result, side_by_side
from mixlight.network.estimator import Estimator

COUNT, CHUNK = 64, 32


def measure() -> Result:
    estimator = Estimator.load("default")
    canonical = estimator.model.settings.canonical
    generator = torch.Generator().manual_seed(0)
    views = torch.rand(COUNT, canonical.height, canonical.width, 3, generator=generator)
    inputs = views.permute(0, 3, 1, 2).contiguous()

    def ours() -> None:
        for start in range(0, COUNT, CHUNK):
            estimator.estimate_views(views[start : start + CHUNK])

    def backbone() -> None:
        with torch.inference_mode():
            for start in range(0, COUNT, CHUNK):
                estimator.model.backbone(inputs[start : start + CHUNK])

    return side_by_side(
        "a", 1.3, ("estimate, 64 views to Lighting", ours), ("backbone forward on the same views", backbone)
    )
