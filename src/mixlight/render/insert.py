"""From a scene to the layers of an insertion: find the pixels that change, render those, and no others."""

import math
from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from mixlight.render.composite import Layers, make_layers, relative_change
from mixlight.render.insertion import InsertionScene, Region, Renders

__all__ = ["Renderer", "insert", "touched_region"]

ROUGH = 96
"""Longer side of the rough picture from which the region is found."""

VISIBLE = 0.01
"""Relative change of the ground's light from which on a pixel belongs to the region."""

SHADOW_PIXELS = 2e5
"""A region of more pixels gets its shadow from a smaller picture, but for the surroundings of the object:
far from what throws it, a shadow has no detail."""

BUDGET = 8e6
"""Samples in all; larger objects get fewer for each pixel, as their noise is finer."""

RUNS = 8
"""Independent renderings, from which the noise is told."""


@runtime_checkable
class Renderer(Protocol):
    """What `mixlight.render.mitsuba.render` and its like are."""

    def __call__(
        self, scene: InsertionScene, region: Region, *, samples: int, runs: int = 1, seed: int = 0
    ) -> Renders:
        """Render a region of the scene's picture, with `samples` for each pixel in each of the runs."""
        ...


def insert(
    scene: InsertionScene,
    photo: Float[np.ndarray, "height width 3"],
    render: Renderer,
    *,
    samples: int = 128,
    seed: int = 0,
) -> Layers:
    """Render the object into the photo.

    Args:
        scene: object, ground, light and camera.
        photo: the whole photo, linear.
        render: for instance `mixlight.render.mitsuba.render`.
        samples: for each pixel, at most; large regions get fewer (`BUDGET`).
        seed: of the random numbers; the same seed gives the same picture.

    Raises:
        ValueError: the object lies outside the photo, or the renderer is missing.
    """
    region, outline = touched_region(scene, render, seed=seed)
    shrink = math.sqrt(region.width * region.height / SHADOW_PIXELS)
    margin = math.ceil(6 * shrink + 0.1 * max(outline.width, outline.height))
    box = _clipped(outline, margin, region)
    if shrink <= 1 or box == region:
        renders = render(scene, region, samples=_each(samples, region), runs=RUNS, seed=seed + 1)
        return make_layers(scene, renders, region, region, relative_change(scene, renders, region), photo)
    small = _shrunk(scene, shrink)
    scale = np.array([scene.camera.width / small.camera.width, scene.camera.height / small.camera.height])
    low = Region(
        int(region.left / scale[0]),
        int(region.top / scale[1]),
        min(small.camera.width, math.ceil(region.right / scale[0])),
        min(small.camera.height, math.ceil(region.bottom / scale[1])),
    )
    far = render(small, low, samples=_each(samples, low), runs=RUNS, seed=seed + 1)
    change = _enlarged(relative_change(small, far, low), low, region, scale)
    near = render(scene, box, samples=_each(samples, box), runs=RUNS, seed=seed + 1 + RUNS)
    inside = (
        slice(box.top - region.top, box.bottom - region.top),
        slice(box.left - region.left, box.right - region.left),
    )
    ramp = [
        np.minimum(np.arange(first, first + count), np.arange(first + count, first, -1) - 1)
        for first, count in ((0, box.height), (0, box.width))
    ]
    weight = np.clip(np.minimum(ramp[0][:, None], ramp[1]) / margin, 0, 1)[..., None]
    # At the edge of the photo the box has no far side to be blended with.
    change[inside] += weight * (relative_change(scene, near, box) - change[inside])
    return make_layers(scene, near, box, region, change, photo)


def touched_region(scene: InsertionScene, render: Renderer, *, seed: int = 0) -> tuple[Region, Region]:
    """The rectangle of the photo that object and shadow touch, and that of the object alone in it.

    The object's is its projection; the shadow's is told from a rough picture.

    Raises:
        ValueError: the object lies wholly outside the photo.
    """
    camera = scene.camera
    points = np.concatenate([camera.project(part.positions)[0] for part in scene.parts])
    low, high = points.min(0), points.max(0)
    whole = Region(0, 0, camera.width, camera.height)
    if high[0] <= 0 or high[1] <= 0 or low[0] >= camera.width or low[1] >= camera.height:
        raise ValueError("expected an object inside the photo, received one that is wholly outside of it")
    outline = Region(
        max(0, math.floor(low[0]) - 1),
        max(0, math.floor(low[1]) - 1),
        min(camera.width, math.ceil(high[0]) + 1),
        min(camera.height, math.ceil(high[1]) + 1),
    )
    small = _shrunk(scene, max(1.0, max(camera.width, camera.height) / ROUGH))
    picture = Region(0, 0, small.camera.width, small.camera.height)
    change = relative_change(small, render(small, picture, samples=4, runs=RUNS, seed=seed), picture)
    rows, columns = np.nonzero(np.abs(change).max(-1) > VISIBLE)
    if not len(rows):
        return _clipped(outline, 2, whole), outline
    scale_x, scale_y = camera.width / small.camera.width, camera.height / small.camera.height
    # A rough pixel more on every side.
    shadow = Region(
        math.floor((columns.min() - 1) * scale_x),
        math.floor((rows.min() - 1) * scale_y),
        math.ceil((columns.max() + 2) * scale_x),
        math.ceil((rows.max() + 2) * scale_y),
    )
    union = Region(
        min(shadow.left, outline.left),
        min(shadow.top, outline.top),
        max(shadow.right, outline.right),
        max(shadow.bottom, outline.bottom),
    )
    return _clipped(union, 2, whole), outline


def _clipped(region: Region, margin: int, whole: Region) -> Region:
    """The region with a margin, within the whole."""
    return Region(
        max(whole.left, region.left - margin),
        max(whole.top, region.top - margin),
        min(whole.right, region.right + margin),
        min(whole.bottom, region.bottom + margin),
    )


def _shrunk(scene: InsertionScene, factor: float) -> InsertionScene:
    """The scene in a smaller picture."""
    camera = scene.camera
    width, height = max(1, round(camera.width / factor)), max(1, round(camera.height / factor))
    return replace(scene, camera=replace(camera, width=width, height=height))


def _each(samples: int, region: Region) -> int:
    """Samples for each pixel in each run."""
    affordable = int(BUDGET / (region.width * region.height))
    return max(2, min(samples, affordable) // RUNS)


def _enlarged(
    field: Float[np.ndarray, "low_rows low_columns 3"],
    low: Region,
    region: Region,
    scale: Float[np.ndarray, "2"],
) -> Float[np.ndarray, "rows columns 3"]:
    """A field of a smaller picture, read between its pixels at those of the region."""
    for axis, (first, last, start, count) in enumerate(
        ((region.top, region.bottom, low.top, low.height), (region.left, region.right, low.left, low.width))
    ):
        position = (np.arange(first, last) + 0.5) / scale[1 - axis] - 0.5 - start
        position = position.clip(0, count - 1)
        index = np.minimum(position.astype(int), max(count - 2, 0))
        part = (position - index).reshape(-1, *([1] * (2 - axis)))
        above = np.take(field, np.minimum(index + 1, count - 1), axis)
        field = np.take(field, index, axis) * (1 - part) + above * part
    return field
