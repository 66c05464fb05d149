"""What is measured on a sample: the names of all numbers, their units, and which way is better."""

from __future__ import annotations

from dataclasses import dataclass

from mixlight.training.validation import SPHERES

__all__ = ["LIGHT_CELLS", "SPHERES", "Cell", "describe"]


@dataclass(frozen=True)
class Cell:
    """One measured number."""

    title: str
    """As tables head it."""
    unit: str = ""
    """Empty where the number has none, or that of the radiance."""
    digits: int = 3
    """Decimals in tables."""
    better: str = "lower"
    """`lower`, `nearer 0`, or empty: a number that says something without being an error."""


_MEASURES = {
    "si_rmse": Cell("si-RMSE"),
    "normalised_rmse": Cell("normalised RMSE"),
    "rmse": Cell("RMSE"),
    "geometric": Cell("√(RMSE·si-RMSE)"),
    "angle_deg": Cell("RGB angle", "°", 2),
}

_LIGHTS = {
    "strongest_angle_deg": Cell("strongest light off by", "°", 1),
    "blob_angle_deg": Cell("five strongest matched", "°", 1),
    "energy_log2": Cell("log2 of energy ratio", "stops", 2, "nearer 0"),
    "energy_off_log2": Cell("its size", "stops", 2),
    "sources": Cell("sources", "", 1, ""),
    "true_sources": Cell("true sources", "", 1, ""),
    "active_anchors": Cell("active anchors", "", 1, ""),
}

LIGHT_CELLS = tuple(_LIGHTS)
"""Names of what protocol L measures."""


def describe(cell: str) -> Cell:
    """What a cell's name means.

    Raises:
        KeyError: no such cell.

    >>> describe("diffuse_si_rmse").title, describe("blob_angle_deg").unit
    ('diffuse si-RMSE', '°')
    """
    if cell in _LIGHTS:
        return _LIGHTS[cell]
    sphere, _, measure = cell.partition("_")
    if sphere not in SPHERES:
        raise KeyError(cell)
    found = _MEASURES[measure]
    return Cell(f"{sphere} {found.title}", found.unit, found.digits, found.better)
