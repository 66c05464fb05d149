"""The same place seen from elsewhere: as if the camera had moved and the room were stretched."""

from __future__ import annotations

import math

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.sphere import equirect

_REACH = 0.45
_LIFT = 0.15
_STRETCH = 1.35


def moved(
    panorama: Float[Tensor, "height width 3"],
    offset: tuple[float, float, float],
    stretch: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> Float[Tensor, "height width 3"]:
    """The panorama as a camera at another place would see it, if all light came from an ellipsoid around.

    The surroundings lie on the unit sphere, which is first stretched along the axes; the camera stands at
    `offset` in it. A ray from there with direction d meets the ellipsoid at a point, and the radiance is that
    of the panorama in the point's direction before the stretch. Radiance is kept, so what comes nearer grows
    and gives more light, as it should.

    Convention: an offset towards -Z (forward) makes what is ahead larger.

    Args:
        panorama: linear radiance.
        offset: x, y, z in radii of the stretched sphere, inside it.
        stretch: factors along x, y and z, above 0.

    Raises:
        ValueError: not a panorama, an offset outside the ellipsoid, or a factor that is not above 0.

    Source: the sphere model of Gardner et al. 2017 (recentring warp), for any direction; stretching after
    Sun et al. 2019 (HorizonNet).

    >>> dot = torch.zeros(16, 32, 3); dot[8, 16] = 1.0
    >>> near = moved(dot, (0.0, 0.0, -0.5))
    >>> bool(equirect.integrate(near)[0] > 2 * equirect.integrate(dot)[0])
    True
    """
    equirect.check(panorama)
    scale = torch.tensor(stretch)
    if not bool((scale > 0).all()):
        raise ValueError(f"expected stretch factors above 0, got {stretch}")
    place = torch.tensor(offset)
    start = place / scale
    if float(start.square().sum()) >= 1:
        raise ValueError(f"expected an offset inside the ellipsoid of {stretch}, got {offset}")
    rays = equirect.pixel_directions(panorama.shape[0]) / scale
    # |start + t ray| = 1 for the one t > 0.
    a, b, c = rays.square().sum(-1), (rays * start).sum(-1), start.square().sum() - 1
    distance = ((b.square() - a * c).sqrt() - b) / a
    points = start + distance[..., None] * rays
    return equirect.sample(panorama, torch.nn.functional.normalize(points, dim=-1))


def random_move(
    generator: np.random.Generator,
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Draws an offset (mostly level, at most .45) and a stretch of the plan (by at most 35 %)."""
    angle, reach = generator.uniform(0, 2 * math.pi), _REACH * math.sqrt(generator.random())
    offset = (reach * math.cos(angle), _LIFT * generator.uniform(-1, 1), reach * math.sin(angle))
    x, z = np.exp(math.log(_STRETCH) * generator.uniform(-1, 1, 2))
    return offset, (float(x), 1.0, float(z))
