"""From a scene to the layers of an insertion: find the pixels that change, render those, and no others."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from jaxtyping import Float

from mixlight.render.composite import Layers, make_layers, relative_change
from mixlight.render.insertion import InsertionScene, Region, Renders

__all__ = ["Renderer", "insert", "touched_region"]

ROUGH = 96
"""Longer side of the rough picture from which the region is found."""

VISIBLE = 0.01
"""Relative change of the ground's light from which on a pixel belongs to the region."""

BUDGET = 5e7
"""Samples in all; larger regions get fewer for each pixel, as their noise is finer."""

RUNS = 4
"""Independent renderings, from which the noise is told."""


class Renderer(Protocol):
    """What `mixlight.render.mitsuba.render` and its like are."""

    def __call__(
        self, scene: InsertionScene, region: Region, *, samples: int, runs: int = 1, seed: int = 0
    ) -> Renders:
        """Render a region of the scene's picture."""
        ...


def touched_region(scene: InsertionScene, render: Renderer, *, seed: int = 0) -> Region:
    """The rectangle of the photo that the object and its shadow touch, from a rough picture of it.

    Raises:
        ValueError: the object lies wholly outside the photo.
    """
    camera = scene.camera
    shrink = max(1.0, max(camera.width, camera.height) / ROUGH)
    rough = replace(
        camera, width=max(1, round(camera.width / shrink)), height=max(1, round(camera.height / shrink))
    )
    small = replace(scene, camera=rough)
    whole = Region(0, 0, rough.width, rough.height)
    renders = render(small, whole, samples=16, runs=2, seed=seed)
    change = relative_change(small, renders, whole)
    touched = (renders.coverage > 0) | (np.abs(change).max(-1) > VISIBLE)
    points = np.concatenate([camera.project(part.positions)[0] for part in scene.parts])
    x, y = points[:, 0], points[:, 1]
    if not ((x > 0) & (x < camera.width) & (y > 0) & (y < camera.height)).any():
        raise ValueError("expected an object inside the photo, received one that is wholly outside of it")
    rows, columns = np.nonzero(touched)
    scale_x, scale_y = camera.width / rough.width, camera.height / rough.height
    # A rough pixel more on every side, and the outline of the object itself, which may be thin.
    left = min([x.min(), *((columns - 1) * scale_x)])
    right = max([x.max(), *((columns + 2) * scale_x)])
    top = min([y.min(), *((rows - 1) * scale_y)])
    bottom = max([y.max(), *((rows + 2) * scale_y)])
    return Region(
        max(0, math.floor(left) - 1),
        max(0, math.floor(top) - 1),
        min(camera.width, math.ceil(right) + 1),
        min(camera.height, math.ceil(bottom) + 1),
    )


def insert(
    scene: InsertionScene,
    photo: Float[np.ndarray, "height width 3"],
    render: Renderer,
    *,
    samples: int = 128,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Layers:
    """Render the object into the photo.

    Args:
        scene: object, ground, light and camera.
        photo: the whole photo, linear.
        render: for instance `mixlight.render.mitsuba.render`.
        samples: for each pixel, at most; large regions get fewer (`BUDGET`).
        seed: of the random numbers; the same seed gives the same picture.
        progress: called with a word on what is done next.

    Raises:
        ValueError: the object lies outside the photo, or the renderer is missing.
    """
    say = progress or (lambda _: None)
    say("looking for the pixels that change")
    region = touched_region(scene, render, seed=seed)
    affordable = max(16, int(BUDGET / (region.width * region.height)))
    each = max(4, min(samples, affordable) // RUNS)
    say(f"rendering {region.width} x {region.height} pixels with {each * RUNS} samples")
    renders = render(scene, region, samples=each, runs=RUNS, seed=seed + 1)
    return make_layers(scene, renders, region, photo)
