"""The six errors of the three spheres, as most tables show them."""

from collections.abc import Sequence

from experiments.tables.markdown import interval
from experiments.tables.results import Json

SPHERES = ("diffuse", "matte", "mirror")
CELLS = tuple(f"{sphere}_{kind}" for kind in ("rmse", "si_rmse") for sphere in SPHERES)
CELL_NAMES = tuple(f"{sphere} {kind}" for kind in ("RMSE", "si-RMSE") for sphere in SPHERES)


def medians(spheres: Json) -> list[str]:
    """Median error of each cell."""
    return [f"{spheres[cell]['median']:.3f}" for cell in CELLS]


def error_ratios(cells: Json, names: Sequence[str] = CELLS) -> list[str]:
    """Ratio of errors with its interval; in bold where it is not 1.00 and the interval leaves out 1."""
    entries = []
    for cell in names:
        ratio, (low, high) = cells[cell]["ratio"], cells[cell]["interval_95"]
        text = interval(ratio, (low, high))
        sure = (high < 1 or low > 1) and abs(ratio - 1) >= 0.005
        entries.append(f"**{text}**" if sure else text)
    return entries
