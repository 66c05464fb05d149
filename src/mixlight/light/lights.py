"""A few named lights out of many lobes: what a renderer's user can grasp and move."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light.lighting import Lighting
from mixlight.light.separate import luminance
from mixlight.sphere.points import neighbours

_NEIGHBOURS = 6
"""Anchors around one on the sphere: neighbours in the sense of a cluster."""

_REACH = math.radians(40)
"""A cluster's anchors lie within this angle of its brightest: the two rings of anchors around it."""


@dataclass(frozen=True, eq=False)
class Light:
    """One light: a disc in the sky that stands for a cluster of lobes.

    Convention: a directional light of this irradiance from this direction gives any surface that sees the
        whole cluster the same irradiance (luminance exactly, and each channel exactly where the cluster is of
        one colour) as the cluster's lobes.
    """

    name: str
    """``light_1`` is the brightest, unless the lighting gives its lights lasting names."""
    direction: Float[Tensor, "3"]
    """Unit vector towards the light, in the lighting's frame."""
    irradiance: Float[Tensor, "3"]
    """Irradiance on a surface that faces it (radiance times steradian), rgb."""
    angular_diameter: float
    """Of the uniform disc of the same spread, in radians; a single lobe of s = 0.0025 has .1414 (8.1
    degrees)."""
    anchors: tuple[int, ...] = ()
    """The lobes it stands for, ascending: what to take out of a map that goes beside it
    (`Lighting.without`)."""


def merge(lighting: Lighting, limit: int | None = None) -> list[Light]:
    """Join neighbouring active lobes into lights, brightest first.

    The brightest active anchor that is still free seeds a cluster, which takes in the free active anchors
    that are connected to it through neighbours and lie within 40 degrees of it; so a row of ceiling lamps
    gives several lights and not a single one half the sky wide. A cluster's direction is the mean of its
    lobes' axes weighted by luminance; its irradiance is the sum of v_i (u_i . direction).

    Groups of the lighting (`Lighting.groups`) are lights as they are, under their own names, and their lobes
    join no other light; a group that is off, or whose lobes are dark, is none.

    Args:
        lighting: a single one, not a batch.
        limit: keep only the brightest that many; the other lobes stay in the lighting alone.

    Convention: directions point towards the light. One active lobe of energy v gives one light of irradiance
        v.

    Raises:
        ValueError: a batch of lightings, or a limit below 0.

    >>> energy = torch.zeros(128, 3)
    >>> energy[40], energy[41] = 2.0, torch.tensor([0.0, 1.0, 0.0])
    >>> lights = merge(Lighting(torch.zeros(9, 3), energy))
    >>> [(light.name, light.anchors, light.irradiance.tolist()) for light in lights]
    [('light_1', (40,), [2.0, 2.0, 2.0]), ('light_2', (41,), [0.0, 1.0, 0.0])]
    """
    if limit is not None and limit < 0:
        raise ValueError(f"limit: expected at least 0, received {limit}")
    axes = lighting.axes.double().cpu()
    energy = lighting.energy.detach().double().cpu()
    power = luminance(energy)
    grouped = {anchor for group in lighting.groups for anchor in group.anchors}
    clusters: list[tuple[str | None, list[int]]] = [
        (group.name, [anchor for anchor in group.anchors if power[anchor] > 0]) for group in lighting.groups
    ]
    free = [anchor for anchor in lighting.active.tolist() if anchor not in grouped]
    clusters += [(None, cluster) for cluster in _clusters(axes, power, free)]
    lights = [
        (name, *_light(axes, energy, cluster, lighting.sharpness)) for name, cluster in clusters if cluster
    ]
    lights.sort(key=lambda found: -float(luminance(found[2])))
    to, fresh = lighting.energy, _fresh_names({group.name for group in lighting.groups})
    return [
        Light(name or next(fresh), direction.to(to), irradiance.to(to), angular_diameter, anchors)
        for name, direction, irradiance, angular_diameter, anchors in lights[:limit]
    ]


def _fresh_names(taken: set[str]) -> Iterator[str]:
    return (name for number in itertools.count(1) if (name := f"light_{number}") not in taken)


def _clusters(axes: Tensor, power: Tensor, active: list[int]) -> list[list[int]]:
    links = neighbours(axes, min(_NEIGHBOURS, len(axes) - 1)).tolist() if len(axes) > 1 else [[]]
    linked = [set(row) for row in links]
    for index, row in enumerate(links):  # "one of the six nearest" is not mutual; being neighbours is
        for other in row:
            linked[other].add(index)
    near = axes @ axes.T >= math.cos(_REACH)
    free = set(active)
    clusters = []
    for seed in sorted(active, key=lambda index: (-float(power[index]), index)):
        if seed not in free:
            continue
        free.discard(seed)
        cluster, edge = [seed], [seed]
        while edge:
            joined = {index for index in linked[edge.pop()] & free if near[seed, index]}
            free -= joined
            cluster += joined
            edge += joined
        clusters.append(sorted(cluster))
    return clusters


def _light(
    axes: Tensor, energy: Tensor, cluster: list[int], sharpness: float
) -> tuple[Tensor, Tensor, float, tuple[int, ...]]:
    some, weight = axes[cluster], luminance(energy[cluster])
    mean = (weight[:, None] * some).sum(0) / weight.sum()
    length = float(torch.linalg.vector_norm(mean))
    direction = mean / length
    irradiance = (energy[cluster] * (some @ direction)[:, None]).sum(0)
    # A uniform disc of half-angle h has a mean cosine of (1 + cos h) / 2 to its axis, and a lobe is as wide
    # as a disc of cos h = 1 - s; the spread of the axes and of each lobe add up.
    cosine = 1 - sharpness - 2 * (1 - length)
    return direction, irradiance, 2 * math.acos(max(-1.0, cosine)), tuple(cluster)
