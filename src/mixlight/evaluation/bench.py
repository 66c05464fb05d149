"""Many predictions of the same photos, scored by protocol M: what is the same for all is made once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample, collect
from mixlight.data.panoramas import PanoramaRecord
from mixlight.evaluation.cells import SPHERES
from mixlight.evaluation.representations import Part, true_part
from mixlight.light.compare import rmse_and_si_rmse
from mixlight.network.backbones import Backbone
from mixlight.network.canonical import CanonicalView
from mixlight.network.model import mean_linear_colour
from mixlight.render.spheres import SphereRenderer

__all__ = ["CELLS", "Bench"]

CELLS = tuple(f"{sphere}_{kind}" for kind in ("rmse", "si_rmse") for sphere in SPHERES)
"""The six numbers of a sample, in order."""

_CHUNK = 32


class Bench:
    """Photos of panoramas, the spheres under their true light, and what a frozen backbone makes of them.

    The numbers are protocol M's (`mixlight.evaluation.scoring`), for many maps at once.
    """

    def __init__(
        self,
        records: Sequence[PanoramaRecord],
        canonical: CanonicalView,
        azimuths: int = 8,
        renderer: SphereRenderer | None = None,
    ) -> None:
        """Takes the photos.

        Args:
            records: panoramas.
            canonical: the view that networks take.
            azimuths: views of each panorama.
            renderer: of the spheres; protocol M's if not given.

        Raises:
            ValueError: no view with light in it.
            OSError: a panorama cannot be read.
        """
        self.samples: list[EvaluationSample] = collect(records, canonical, azimuths)
        if not self.samples:
            raise ValueError("expected panoramas with light in them, got none")
        self.renderer = renderer or SphereRenderer(resolution=64)
        group = {record.scene: record.group for record in records}
        self.groups = [group[sample.scene] for sample in self.samples]
        self.truth = cache(self._truth)

    def __len__(self) -> int:
        """Number of views."""
        return len(self.samples)

    def score(
        self, maps: Float[Tensor, "chunk height width 3"], start: int = 0, part: Part = "whole"
    ) -> Float[Tensor, "chunk 6"]:
        """Errors of maps of the samples from `start` on, in the order of `CELLS`.

        Raises:
            ValueError: more maps than samples from there on, or maps that are not 2:1.
        """
        true = self.truth(part)[start : start + len(maps)]
        if len(true) != len(maps):
            raise ValueError(f"expected at most {len(true)} maps from sample {start} on, got {len(maps)}")
        shown = self.renderer.render(maps)[:, :, self.renderer.mask]
        rmse, si_rmse = rmse_and_si_rmse(shown, true)
        return torch.cat([rmse, si_rmse], -1)

    def features(self, backbone: Backbone) -> tuple[Tensor, Tensor]:
        """Feature maps of all photos, and the photos' mean linear colours."""
        photos = torch.stack([sample.photo for sample in self.samples])
        backbone.eval()
        with torch.inference_mode():
            found = [backbone(photos[k : k + _CHUNK]) for k in range(0, len(photos), _CHUNK)]
        return torch.cat(found).clone(), mean_linear_colour(photos)

    def _truth(self, part: Part) -> Tensor:
        """[samples, 3, pixels, 3]: the spheres' pixels under the true light."""
        shown = []
        for start in range(0, len(self.samples), _CHUNK):
            maps = [true_part(s.environment, part) for s in self.samples[start : start + _CHUNK]]
            shown.append(self.renderer.render(torch.stack(maps))[:, :, self.renderer.mask])
        return torch.cat(shown)


def columns(cells: Float[Tensor, "samples 6"]) -> dict[str, list[float]]:
    """Cell by cell, for `mixlight.evaluation.statistics`; and sqrt(RMSE si-RMSE) of each sphere.

    >>> columns(torch.tensor([[0.4, 1, 1, 0.1, 1, 1]]))["diffuse_geometric"]
    [0.2]
    """
    table: dict[str, Any] = {cell: cells[:, k].tolist() for k, cell in enumerate(CELLS)}
    for k, sphere in enumerate(SPHERES):
        both = (cells[:, k].double() * cells[:, k + len(SPHERES)].double()).sqrt()
        table[f"{sphere}_geometric"] = [round(value, 7) for value in both.tolist()]
    return table
