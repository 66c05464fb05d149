"""Random rigs, small and of every kind."""

import math
from dataclasses import dataclass

import torch
from hypothesis import strategies as st

from mixlight.export.rig import Rig, make_rig
from mixlight.light.lighting import Lighting


@dataclass(frozen=True)
class Recipe:
    """What hypothesis draws: a few numbers. The tests make lightings and rigs of them."""

    seed: int
    sources: int
    gain: float
    count: int | None
    residual: bool
    height: int
    name: str

    def lighting(self) -> Lighting:
        return lighting(self.seed, self.sources, self.gain)

    def rig(self) -> Rig:
        return make_rig(
            self.lighting(), lights=self.count, residual=self.residual, height=self.height, name=self.name
        )


def lighting(seed: int, sources: int = 4, gain: float = 1.0) -> Lighting:
    """An uneven surround and coloured lobes in random places, over four decades of brightness."""
    generator = torch.Generator().manual_seed(seed)
    ambient = 0.3 * torch.randn(9, 3, generator=generator)
    ambient[0] = math.sqrt(4 * math.pi) * (0.2 + torch.rand(3, generator=generator))
    energy = torch.zeros(128, 3)
    anchors = torch.randperm(128, generator=generator)[:sources]
    energy[anchors] = 10 ** (4 * torch.rand(sources, 1, generator=generator) - 2) * (
        0.1 + torch.rand(sources, 3, generator=generator)
    )
    return Lighting(ambient, energy, exposure_gain=gain)


def recipes() -> st.SearchStrategy[Recipe]:
    """All lights, some or none; residual and full maps."""
    return st.builds(
        Recipe,
        seed=st.integers(0, 9999),
        sources=st.integers(0, 12),
        gain=st.sampled_from([1.0, 0.125, 3.7]),
        count=st.sampled_from([None, 0, 1, 3]),
        residual=st.booleans(),
        height=st.sampled_from([16, 32]),
        name=st.sampled_from(["mixlight", "kitchen, north"]),
    )
