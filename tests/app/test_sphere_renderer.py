"""The spheres that people look at sample a mirror's rim more finely than protocol M does."""

import torch

from mixlight.app.scene import sphere_renderer
from mixlight.render.spheres import SphereRenderer


def test_the_rim_of_the_mirror_is_sampled_finely() -> None:
    """A lamp behind the sphere shows in the rim alone; 64 pixels, where protocol M's steps are too wide."""
    shown, coarse, exact = (
        sphere_renderer(64),
        SphereRenderer(64),
        SphereRenderer(64, rim_step=0.0015),
    )
    lamps = torch.full((8, 128, 256, 3), 0.1)
    for k in range(8):
        lamps[k, 60 + k, 8 * k] = 500.0  # about +Z, which the camera at +Z cannot see directly
        lamps[k, 60 + k, 128 + 4 * k] = 500.0
    mirrors = [renderer(lamps)[:, 2].clamp(max=1) for renderer in (shown, coarse, exact)]
    errors = [(picture - mirrors[2]).square().mean().sqrt() for picture in mirrors[:2]]
    assert errors[0] < 0.5 * errors[1]
