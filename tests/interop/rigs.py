"""Lights that every consumer's tests share."""

import functools
import math
from pathlib import Path

import torch
from torch import Tensor

from mixlight.export.rig import Rig
from mixlight.light import harmonics
from mixlight.light.document import load
from mixlight.light.lighting import Lighting
from mixlight.sphere.calibration import calibration_card

PICTURE = Path(__file__).with_name("room.json")
"""The light of a room as `mixlight estimate` found it once; what the docs' pictures are lit by."""


@functools.cache
def card_rig(height: int = 256) -> Rig:
    """The calibration card as a map, without lights."""
    card = calibration_card(height)
    ambient = harmonics.project(card)
    return Rig(environment=card, lights=(), residual=False, ambient=ambient, sh=ambient, name="card")


def uniform_rig(radiance: float = 1.0, height: int = 64) -> Rig:
    """The same radiance from everywhere: whatever reflects all light cannot be seen in it."""
    environment = torch.full((height, 2 * height, 3), radiance)
    ambient = harmonics.project(environment)
    return Rig(environment=environment, lights=(), residual=False, ambient=ambient, sh=ambient)


def random_lighting(seed: int, sources: int = 4) -> Lighting:
    """An uneven surround of positive radiance and some coloured lobes in random places."""
    generator = torch.Generator().manual_seed(seed)
    ambient = 0.25 * torch.randn(9, 3, generator=generator)
    ambient[0] = math.sqrt(4 * math.pi) * (0.5 + torch.rand(3, generator=generator))
    energy = torch.zeros(128, 3)
    anchors = torch.randperm(128, generator=generator)[:sources]
    energy[anchors] = 0.3 + 2 * torch.rand(sources, 3, generator=generator)
    return Lighting(ambient, energy)


def picture_lighting() -> Lighting:
    """The light of the docs' pictures."""
    return load(PICTURE)


def sphere_normals(size: int, *, behind: bool = False) -> tuple[Tensor, Tensor]:
    """Normals of a unit sphere seen along -Z by an orthographic camera that it fills.

    Returns:
        [size, size, 3] normals, and the mask [size, size] of pixels well inside of the rim, where no
        tessellation shows.
    """
    across = (torch.arange(size, dtype=torch.float64) + 0.5) * (2 / size) - 1
    x, y = across.expand(size, size), -across[:, None].expand(size, size)
    square = x * x + y * y
    z = (1 - square).clamp_min(0).sqrt()
    front = torch.stack([x, y, z], -1)
    normals = front * torch.tensor([-1.0, 1.0, -1.0], dtype=torch.float64) if behind else front
    return normals, square < 0.85**2
