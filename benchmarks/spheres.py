"""(f) protocol S's three spheres by light transport against a plain loop over pixels in NumPy."""

import numpy as np
import torch

from benchmarks.timing import Result, side_by_side
from mixlight.light.sphere_camera import SphereCamera
from mixlight.light.surfaces import PRINCIPLED
from mixlight.render.spheres import SphereRenderer
from tests.render import plain_spheres

WIDTH, HEIGHT = 96, 54
"""A tenth of protocol S's picture: at its full size one loop takes minutes."""


def measure() -> Result:
    maps = torch.rand(1, 128, 256, 3, generator=torch.Generator().manual_seed(0)) + 0.1
    camera = SphereCamera.perspective((16.0, 2.0, 0.0), 85.0, 36.0, WIDTH, HEIGHT)
    renderer = SphereRenderer(camera=camera, materials=PRINCIPLED, interpolation="linear")
    environment = maps[0].double().numpy()
    normals, views, _ = plain_spheres.points(WIDTH, HEIGHT)
    surfaces = [plain_spheres.Surface(False, 0.364), plain_spheres.Surface(True, 0.3271)]

    def loop() -> list[np.ndarray]:
        pictures = [plain_spheres.rough(environment, normals, views, surface) for surface in surfaces]
        return [*pictures, plain_spheres.mirror(environment, normals, views)]

    return side_by_side(
        "f",
        0.01,
        ("three spheres of protocol S at 96x54", lambda: renderer.render(maps)),
        ("loop over pixels in NumPy", loop),
        5,
        1,
    )
