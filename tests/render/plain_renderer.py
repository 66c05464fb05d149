"""A renderer that needs no program: a flat object and a shadow worked out by hand, with noise on request."""

from dataclasses import dataclass, field

import numpy as np

from mixlight.render.insertion import InsertionScene, Region, Renders

OBJECT, SHADE = 0.3, 0.5
"""Radiance of the object, and the light that is left in its round shadow."""


@dataclass
class PlainRenderer:
    """Renders the outline of the object's box, and a disc of shade twice as wide around its foot."""

    noise: float = 0.0
    calls: list[tuple[int, int, int]] = field(default_factory=list)
    """Width of the picture and width and height of the region of each call."""

    def __call__(
        self, scene: InsertionScene, region: Region, *, samples: int, runs: int = 1, seed: int = 0
    ) -> Renders:
        camera = scene.camera
        self.calls.append((camera.width, region.width, region.height))
        # Coverage by 4 x 4 samples a pixel, so that rims are soft.
        steps = (np.arange(4) + 0.5) / 4
        x = (region.left + np.arange(region.width)[:, None] + steps).ravel()
        y = (region.top + np.arange(region.height)[:, None] + steps).ravel()
        rays = camera.directions(np.stack(np.meshgrid(x, y), -1))
        points = np.concatenate([camera.project(part.positions)[0] for part in scene.parts])
        low, high = points.min(0), points.max(0)
        inside = ((x >= low[0]) & (x < high[0]))[None] & ((y >= low[1]) & (y < high[1]))[:, None]
        down = rays[..., 1] < -1e-3
        place = rays / np.where(down, -rays[..., 1], 1)[..., None] - scene.ground.centre
        size = scene.ground.half_side / 5.0
        shaded = down & (np.hypot(place[..., 0], place[..., 2]) < 2 * size)
        free = np.where(down[..., None], scene.ground.mean_albedo * scene.irradiance / np.pi, 0.0)
        with_object = np.where(inside[..., None], OBJECT, np.where(shaded[..., None], SHADE, 1.0) * free)

        def pixels(values: np.ndarray) -> np.ndarray:
            return values.reshape(region.height, 4, region.width, 4, -1).mean((1, 3))

        grain = np.random.default_rng(seed).normal(size=(runs, region.height, region.width, 1)) * self.noise
        hit = pixels((inside | shaded)[..., None].astype(float)) > 0
        return Renders(
            pixels(with_object)[None] * (1 + grain * hit),
            np.repeat(pixels(free)[None], runs, 0),
            pixels(inside[..., None].astype(float))[..., 0],
        )
