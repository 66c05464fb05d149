"""One sample's numbers: predicted maps against the true one, by a protocol."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data import display
from mixlight.evaluation.cells import SPHERES
from mixlight.evaluation.metrics import normalised_rmse, rgb_angle, rmse_and_si_rmse
from mixlight.evaluation.protocols import Protocol
from mixlight.evaluation.renderers import Renderer
from mixlight.evaluation.sources import find_sources, light_cells
from mixlight.sphere import equirect

__all__ = ["score", "sphere_cells"]


def score(
    protocol: Protocol,
    predicted: Sequence[Float[Tensor, "_ _ 3"]],
    true: Float[Tensor, "_ _ 3"],
    renderer: Renderer | None = None,
) -> list[dict[str, float]]:
    """What a protocol measures on predictions of one true map; `Protocol.cells` but for `active_anchors`.

    Args:
        protocol: says what is measured.
        predicted: maps in our frame and the photo's exposure, 2:1, any height.
        true: the true map, in the same frame and exposure.
        renderer: of the protocol's scene, where it has one.

    Raises:
        ValueError: a map that is no panorama of radiance, or no renderer where the protocol wants one.

    >>> from mixlight.evaluation.protocols import find
    >>> true = torch.full((32, 64, 3), 0.25)
    >>> score(find("L"), [2 * true], true)[0]["energy_log2"]
    1.0
    """
    maps = []
    for panorama in (true, *predicted):
        equirect.check(panorama)
        at_size = panorama.shape[0] == protocol.map_height
        maps.append(panorama if at_size else equirect.resize(panorama, protocol.map_height))
    rows: list[dict[str, float]] = [{} for _ in predicted]
    if protocol.scene is not None:
        if renderer is None:
            raise ValueError(f"expected a renderer for the spheres of protocol {protocol.letter}, got none")
        for row, cells in zip(rows, sphere_cells(protocol, renderer, maps), strict=True):
            row.update(cells)
    if protocol.lights:
        sources = find_sources(maps[0])
        for row, light in zip(rows, maps[1:], strict=True):
            row.update(light_cells(light, maps[0], sources))
    return rows


def sphere_cells(
    protocol: Protocol, renderer: Renderer, maps: Sequence[Float[Tensor, "height width 3"]]
) -> list[dict[str, float]]:
    """Errors of the three spheres under all maps but the first, against those under the first."""
    shown = [display.encode(light) for light in maps] if protocol.encoding == "display" else list(maps)
    pictures = renderer.render(torch.stack(shown).float())
    mask = renderer.mask
    true, predicted = pictures[:1].expand_as(pictures[1:]), pictures[1:]
    values = {}
    for i, sphere in enumerate(SPHERES):
        p, g = predicted[:, i], true[:, i]
        count = int(mask.sum()) * (3 if protocol.divisor == "values" else 1)
        rmse, si_rmse = rmse_and_si_rmse(p[:, mask], g[:, mask], count)
        values[f"{sphere}_rmse"], values[f"{sphere}_si_rmse"] = rmse, si_rmse
        values[f"{sphere}_geometric"] = (rmse.double() * si_rmse.double()).sqrt()
        if "angle_deg" in protocol.measures:
            values[f"{sphere}_angle_deg"] = rgb_angle(p, g, mask) * (180 / math.pi)
        if "normalised_rmse" in protocol.measures:
            values[f"{sphere}_normalised_rmse"] = normalised_rmse(p, g, mask, renderer.frame)
    wanted = [cell for cell in protocol.cells if cell in values]
    return [{cell: float(values[cell][k]) for cell in wanted} for k in range(len(predicted))]
