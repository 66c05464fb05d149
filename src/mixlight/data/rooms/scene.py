"""A plan, gathered: every mesh in its place, objects of the library, sky, sun, portals and cameras."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from torch import Tensor

from mixlight.data.rooms import dressings, fixture_shapes, pieces, shell, windows
from mixlight.data.rooms.catalogue import Catalogue
from mixlight.data.rooms.mesh import Emission, Part
from mixlight.data.rooms.outline import edges
from mixlight.data.rooms.plan import Camera, Plan, Surface
from mixlight.data.rooms.skies import OutdoorSky
from mixlight.data.rooms.sky import LUMENS_PER_UNIT, sky_map
from mixlight.data.rooms.store import group_names
from mixlight.image.temperature import black_body

__all__ = ["Placement", "Portal", "RoomScene", "Sun", "build"]


@dataclass(frozen=True)
class Placement:
    """An object of the furniture library, in its place."""

    name: str
    """The object's name in the library's file."""
    matrix: Float[np.ndarray, "4 4"]
    surfaces: tuple[Surface, ...] = ()
    """New colours for its plain materials, in their order."""


@dataclass(frozen=True)
class Portal:
    """A rectangle through which the sky comes in."""

    matrix: Float[np.ndarray, "4 4"]
    """From its own axes (x along the width, y up, -z into the room) to the room's; its middle is the
    origin."""
    width: float
    height: float


@dataclass(frozen=True)
class Sun:
    """Parallel light."""

    direction: tuple[float, float, float]
    """Towards it."""
    irradiance: tuple[float, float, float]
    """On a plane that faces it; 1 is 683 lux."""
    angle: float
    """Angular diameter in radians."""


@dataclass(frozen=True)
class RoomScene:
    """All that a renderer needs."""

    name: str
    seed: int
    parts: tuple[Part, ...]
    groups: tuple[str, ...]
    """Names of all light groups."""
    placements: tuple[Placement, ...]
    library: Path | None
    """The Blender file with the placed objects."""
    sky: Float[Tensor, "height width 3"]
    """Radiance from outside, the sun apart; the centre column looks along the room's +Y."""
    sun: Sun | None
    portals: tuple[Portal, ...]
    cameras: tuple[Camera, ...]


def sun_of(plan: Plan) -> Sun | None:
    """The plan's sun as light; none without illuminance.

    The irradiance is the sun's illuminance over 683 lm/W in the colour of a black body of its temperature.
    """
    sky = plan.sky
    if sky.sun_direction is None or sky.sun_illuminance <= 0:
        return None
    red, green, blue = black_body(sky.sun_temperature) * (sky.sun_illuminance / LUMENS_PER_UNIT)
    return Sun(sky.sun_direction, (float(red), float(green), float(blue)), sky.sun_angle)


def portals_of(plan: Plan) -> tuple[Portal, ...]:
    """One portal in the outer face of every window."""
    found = []
    for opening in plan.openings:
        if opening.kind != "window" or opening.leads is not None:
            continue
        edge = edges(plan.spaces[opening.space].outline)[opening.edge]
        x, y = edge.at((opening.start + opening.end) / 2, -opening.depth)
        outward = np.array([-edge.inward[0], -edge.inward[1], 0.0])
        up = np.array([0.0, 0.0, 1.0])
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = np.cross(up, outward), up, outward
        matrix[:3, 3] = x, y, (opening.bottom + opening.top) / 2
        found.append(Portal(matrix, opening.end - opening.start, opening.top - opening.bottom))
    return tuple(found)


def build(
    plan: Plan, *, catalogue: Catalogue | None = None, skies: Sequence[OutdoorSky] = (), sky_height: int = 512
) -> RoomScene:
    """Gather the scene of a plan.

    Args:
        plan: the room.
        catalogue: the library that the plan's `library:` pieces are of.
        skies: where the plan's sky is looked up.
        sky_height: rows of the map of an analytic sky.

    Raises:
        ValueError: the plan names a piece, a sky or an object of the library that is not there.
    """
    parts, groups = _parts(plan), tuple(group_names(plan))
    strays = {part.material.group for part in parts if isinstance(part.material, Emission)} - set(groups)
    if strays:
        raise ValueError(
            f"expected light in the groups {', '.join(groups)}, received {', '.join(sorted(strays))}"
        )
    return RoomScene(
        name=f"room-{plan.seed:05d}",
        seed=plan.seed,
        parts=parts,
        groups=groups,
        placements=_placements(plan, catalogue),
        library=None if catalogue is None else catalogue.blend,
        sky=sky_map(plan.sky, skies, sky_height),
        sun=sun_of(plan),
        portals=portals_of(plan),
        cameras=plan.cameras,
    )


def _placements(plan: Plan, catalogue: Catalogue | None) -> tuple[Placement, ...]:
    found = []
    for item in plan.items:
        if item.piece.startswith("library:"):
            if catalogue is None:
                raise ValueError(f"expected a library of furniture with {item.piece!r}, received none")
            found.append(Placement(catalogue.entry(item.piece).name, catalogue.matrix(item), item.surfaces))
    return tuple(found)


def _parts(plan: Plan) -> tuple[Part, ...]:
    return (
        *shell.parts(plan),
        *windows.parts(plan),
        *dressings.parts(plan),
        *pieces.parts_of(plan.items),
        *fixture_shapes.parts(plan),
    )
