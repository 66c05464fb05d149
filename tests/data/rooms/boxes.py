"""Small rooms with few lights, for tests of everything that renders."""

from dataclasses import replace

import numpy as np
import torch

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Emission, Mesh, Part
from mixlight.data.rooms.plan import Camera, Fixture, Plan, Sky, Space, Surface
from mixlight.data.rooms.scene import Portal, RoomScene, Sun

LAMP = (20.0, 12.0, 5.0)
"""Radiance of the box's lamp."""


def box_scene(*, cameras: int = 1) -> RoomScene:
    """Four by five metres with a window in the wall at +Y, a lamp at the ceiling, and a box on the floor."""
    t, h = 0.2, 2.6
    walls = [
        ((-t, -t, -t), (4 + t, 0, h + t)),
        ((-t, 0, -t), (0, 5, h + t)),
        ((4, 0, -t), (4 + t, 5, h + t)),
        ((-t, 5, -t), (1, 5 + t, h + t)),
        ((3, 5, -t), (4 + t, 5 + t, h + t)),
        ((1, 5, -t), (3, 5 + t, 0.8)),
        ((1, 5, 2.2), (3, 5 + t, h + t)),
        ((0, 0, h), (4, 5, h + t)),
    ]
    low, high = np.array(walls).transpose(1, 0, 2)
    parts = (
        Part(shapes.boxes(low, high), Surface("paint", (0.7, 0.68, 0.62)), "walls"),
        Part(shapes.box((0, 0, -t), (4, 5, 0)), Surface("planks", (0.4, 0.25, 0.15), bump=1.0), "floor"),
        Part(shapes.box((0.3, 3.0, 0), (1.2, 4.5, 0.7)), Surface("fabric", (0.1, 0.15, 0.3)), "box"),
        Part(shapes.box((1.85, 2.35, 2.5), (2.15, 2.65, 2.55)), Emission("lamp", LAMP, True), "lamp"),
    )
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = (-1, 0, 0), (0, 0, 1), (0, 1, 0)
    matrix[:3, 3] = 2, 5 + t, 1.5
    places = [Camera(0, (2.0, 1.5 + 0.8 * k, 1.5), 0.4 * k) for k in range(cameras)]
    return RoomScene(
        name="room-00007",
        seed=7,
        parts=parts,
        groups=("lamp", "sky", "sun"),
        placements=(),
        library=None,
        sky=torch.full((16, 32, 3), 8.0),
        sun=Sun((0.0, 0.8, 0.6), (60.0, 55.0, 40.0), 0.03),
        portals=(Portal(matrix, 2.0, 1.4),),
        cameras=tuple(places),
    )


def open_scene(**changes: object) -> RoomScene:
    """Nothing but the sky; `changes` are the scene's fields."""
    scene = replace(box_scene(), parts=(), groups=("sky",), sun=None, portals=())
    return replace(scene, **changes)  # type: ignore[arg-type]


def patch(z: float, half: float = 0.5, *, up: bool = True) -> Mesh:
    """A level square around the origin."""
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return Mesh(corners, np.array([[0, 1, 2, 3] if up else [3, 2, 1, 0]]))


def plain_plan(seed: int = 0, cameras: int = 1) -> Plan:
    """An empty room without windows and with a lamp."""
    white = Surface("paint", (0.7, 0.7, 0.7))
    lamp = Fixture("flush_0", "ceiling", "flush", 0, (2.0, 2.5, 2.5), 0.0, 2000.0, 3000.0, (0.3, 0.3, 0.1))
    return Plan(
        seed=seed,
        spaces=(Space("empty", ((0, 0), (4, 0), (4, 5), (0, 5)), 2.6, (white,) * 4, white, white),),
        openings=(),
        items=(),
        fixtures=(lamp, replace(lamp, name="flush_1", group="off", on=False)),
        sky=Sky("day", None, 0.0, 10_000.0, (1.0, 1.0, 1.0), None),
        cameras=tuple(Camera(0, (1.0 + 0.5 * k, 2.0, 1.5), 0.0) for k in range(cameras)),
    )
