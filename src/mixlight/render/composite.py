"""Differential rendering: the object and its shadow laid into a photo, in linear light.

    composite = object + (1 - coverage) (photo + shadow)
    shadow = min(photo, b) (with - without) / without

`object` is premultiplied by its coverage. The quotient is how much it changes the light on the ground; a
matte surface changes in proportion. What is brighter than b, a highlight or a lamp, changes no more than a
surface of that brightness would: b is the radiance E / pi of a white surface in the irradiance E of the free
ground, or twice that of the ground around the object where that is more, as the light may be estimated too
dim.

Source: P. Debevec, Rendering synthetic objects into real scenes, 1998.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from mixlight.render.denoise import denoise, robust_mean
from mixlight.render.insertion import InsertionScene, Region, Renders

__all__ = ["Layers", "composite", "make_layers", "relative_change"]

UNTOUCHED = 3e-3
"""A relative change of the light on the ground below this is none."""

HIGHLIGHT = 2.0
"""What is so many times as bright as the ground around the object is not ground in another light."""

FADE = (0.6, 0.95)
"""Between these shares of the ground patch's half side the shadow fades out, and over this many pixels:"""

FADE_PIXELS = 12
"""near the horizon the ground is so foreshortened that the patch would end in a line."""


@dataclass(frozen=True, eq=False)
class Layers:
    """What is laid over a region of the photo."""

    region: Region
    beauty: Float[np.ndarray, "rows columns 3"]
    """The object's radiance, premultiplied by its coverage."""
    coverage: Float[np.ndarray, "rows columns"]
    """Share of each pixel that the object covers: the mask."""
    shadow: Float[np.ndarray, "rows columns 3"]
    """What is added to the photo's radiance on the ground; negative in the shadow."""

    @property
    def touched(self) -> Bool[np.ndarray, "rows columns"]:
        """The pixels that change."""
        return np.asarray((self.coverage > 0) | (self.shadow != 0).any(-1))


def make_layers(
    scene: InsertionScene,
    renders: Renders,
    box: Region,
    region: Region,
    change: Float[np.ndarray, "rows columns 3"],
    photo: Float[np.ndarray, "height width 3"],
) -> Layers:
    """The layers of a region, from the renders of the box in it that holds the object.

    Args:
        scene: what was rendered.
        renders: of the box, at the photo's resolution.
        box: the pixels that `renders` are of; the object covers none outside of it.
        region: the pixels that the layers are of; it holds the box.
        change: how much the object changes the light on the ground, of the region (`relative_change`).
        photo: the whole photo, linear.
    """
    inside = (
        slice(box.top - region.top, box.bottom - region.top),
        slice(box.left - region.left, box.right - region.left),
    )
    coverage = np.zeros((region.height, region.width))
    coverage[inside] = renders.coverage
    # Of a pixel at the object's rim the ground's part is taken off. How bright the ground is there is known
    # only nearly, but what is taken off here is put back by the photo, which is as bright.
    share = (1 - renders.coverage)[..., None]
    ground = renders.ground.mean(0) * (1 + change[inside])
    held, variance = robust_mean(renders.scene - share * ground)
    held = denoise(held, variance, renders.coverage > 0, levels=3)
    beauty = np.zeros_like(change)
    beauty[inside] = np.where((renders.coverage > 0)[..., None], np.maximum(held, 0), 0.0)
    here = photo[region.slices].astype(np.float64)
    brightest = np.maximum(scene.irradiance / math.pi, HIGHLIGHT * scene.ground.mean_radiance)
    shadow = np.minimum(here, brightest) * change
    shadow[coverage >= 1] = 0
    return Layers(region, beauty, coverage, shadow)


def relative_change(
    scene: InsertionScene, renders: Renders, region: Region
) -> Float[np.ndarray, "rows columns 3"]:
    """How much the object changes the light on the ground: (with - without) / without, at least -1.

    0 where there is no ground. Where the object covers a part of the pixel it is that of the pixels beside.

    Args:
        scene: what was rendered, with the camera that it was rendered by.
        renders: of the region.
        region: pixels of that camera.
    """
    ground = renders.ground.mean(0)
    free = renders.coverage == 0
    y, x = region.top + np.arange(region.height) + 0.5, region.left + np.arange(region.width) + 0.5
    rays = scene.camera.directions(np.stack(np.meshgrid(x, y), -1))
    below = rays[..., 1] < -1e-6
    place = rays / np.maximum(-rays[..., 1:2], 1e-6) - scene.ground.centre
    reach = np.where(below, np.abs(place[..., [0, 2]]).max(-1) / scene.ground.half_side, np.inf)
    lit = (ground > 1e-6).all(-1) & (reach < FADE[1])
    noisy, variance = robust_mean(
        np.where(lit[..., None], (renders.scene - renders.ground) / np.maximum(ground, 1e-6), 0.0)
    )
    change = denoise(noisy, variance, lit & free)
    near = np.minimum(reach, 9.0)
    slopes = [np.abs(np.gradient(near, axis=axis)) for axis in (0, 1) if near.shape[axis] > 1]
    slope = np.max([np.zeros_like(near), *slopes], axis=0)
    width = np.maximum(FADE[1] - FADE[0], FADE_PIXELS * slope)
    change *= np.clip((FADE[1] - reach) / width, 0, 1)[..., None]
    # The last thousandths are let go smoothly, so that the region has no edge.
    size = np.abs(change).max(-1, keepdims=True)
    change = np.maximum(change, -1.0) * np.clip((size - UNTOUCHED) / UNTOUCHED, 0, 1)
    return _fill(np.where((lit & free)[..., None], change, 0.0), free)


def _fill(
    values: Float[np.ndarray, "rows columns 3"], known: Bool[np.ndarray, "rows columns"]
) -> Float[np.ndarray, "rows columns 3"]:
    """Values carried from known pixels into their neighbours that the object covers, a few pixels deep."""
    filled = np.where(known[..., None], values, 0.0)
    weight = known.astype(float)
    for _ in range(6):
        total, count = np.zeros_like(filled), np.zeros_like(weight)
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                total += _shifted(filled * weight[..., None], dy, dx)
                count += _shifted(weight, dy, dx)
        new = (weight == 0) & (count > 0)
        filled[new] = total[new] / count[new][:, None]
        weight[new] = 1.0
    return filled


def _shifted(
    values: Float[np.ndarray, "rows columns *c"], dy: int, dx: int
) -> Float[np.ndarray, "rows columns *c"]:
    """The picture moved by a pixel at most, black coming in."""
    pad = [(1, 1), (1, 1)] + [(0, 0)] * (values.ndim - 2)
    rows, columns = values.shape[:2]
    return np.pad(values, pad)[1 - dy : 1 - dy + rows, 1 - dx : 1 - dx + columns]


def composite(
    photo: Float[np.ndarray, "height width 3"], layers: Layers
) -> Float[np.ndarray, "rows columns 3"]:
    """The region of the photo with the object in it, linear; untouched pixels are the photo's.

    Args:
        photo: the whole photo, linear.
        layers: of one region.

    >>> pixel = np.ones((1, 1, 3))
    >>> layers = Layers(Region(0, 0, 1, 1), 0.1 * pixel, np.full((1, 1), 0.5), -0.2 * pixel)
    >>> composite(0.6 * pixel, layers)[0, 0].round(3)
    array([0.3, 0.3, 0.3])
    """
    here = photo[layers.region.slices].astype(np.float64)
    share = (1 - layers.coverage)[..., None]
    over = layers.beauty + share * np.maximum(here + layers.shadow, 0)
    return np.asarray(np.where(layers.touched[..., None], over, here))
