"""The comparison of `stats` as a picture; needs matplotlib, the extra `figures`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from mixlight.data.rooms.stats import LABELS, Reference, RoomStatistics, compare
from mixlight.image.atomic import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw", "require"]

ROOMS, REAL = "#c8553d", "#3d6b8f"
_DPI = 110
_PERCENTILES = (1.0, 99.0)


def require() -> None:
    """Makes sure that there is something to draw with.

    Raises:
        ImportError: matplotlib is missing; the message names the extra that brings it.
    """
    if find_spec("matplotlib") is None:
        raise ImportError('expected matplotlib, found none: pip install "mixlight[figures]"')


def draw(rooms: Sequence[RoomStatistics], reference: Reference, path: Path) -> None:
    """Draws one strip for each statistic and writes them as a PNG.

    Each strip has the rooms above and the reference below: a thin line from the 10 % to the 90 % quantile, a
    thick one between the quartiles, a dot at the median, and a speck for every panorama. The band behind is
    where the rooms' median should lie.

    Raises:
        ValueError: either set is empty.
        ImportError: no matplotlib.
        OSError: the file cannot be written.
    """
    require()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows = compare(rooms, reference)
    figure = Figure(figsize=(9.0, 1.05 * len(rows) + 0.7), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    strips = figure.subplots(len(rows), 1)
    for axes, row in zip(strips, rows, strict=True):
        every = (
            [getattr(one, row.name) for one in rooms],
            [getattr(one, row.name) for one in reference.measured.values()],
        )
        axes.axvspan(row.reference[1], row.reference[3], color=REAL, alpha=0.13, linewidth=0)
        _strip(axes, 1.0, every[0], row.rooms, ROOMS)
        _strip(axes, 0.0, every[1], row.reference, REAL)
        _frame(axes, [*every[0], *every[1]])
        colour = "black" if row.verdict == "inside" else ROOMS
        axes.set_title(
            LABELS[row.name] + ("" if row.verdict == "inside" else f": {row.verdict}"),
            loc="left", fontsize=9, color=colour, pad=3,
        )  # fmt: skip
    figure.suptitle(f"{len(rooms)} panoramas of rooms (above) and {reference.name} (below)", fontsize=10)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png")


def _strip(axes: Axes, level: float, every: Sequence[float], found: Sequence[float], colour: str) -> None:
    low, lower, median, upper, high = found
    # Specks alternate in height so that equal ones show; nothing random, so that the same set is one picture.
    heights = [level + 0.12 * ((k * 0.618) % 1.0 - 0.5) - 0.24 for k in range(len(every))]
    alpha = min(1.0, max(0.15, 40 / len(every)))
    axes.plot(every, heights, ".", color=colour, markersize=2.5, alpha=alpha)
    axes.plot([low, high], [level, level], color=colour, linewidth=1.2)
    axes.plot([lower, upper], [level, level], color=colour, linewidth=5, solid_capstyle="butt")
    axes.plot(
        [median], [level], "o", color="white", markeredgecolor=colour, markersize=5, markeredgewidth=1.5
    )


def _frame(axes: Axes, every: Sequence[float]) -> None:
    """Limits that a few far-out panoramas do not stretch, and no box."""
    import numpy as np

    low, high = (float(value) for value in np.percentile(every, _PERCENTILES))
    margin = 0.04 * (high - low) or 0.5
    axes.set_xlim(low - margin, high + margin)
    axes.set_ylim(-0.5, 1.4)
    axes.set_yticks([1.0, 0.0], ["rooms", "real"], fontsize=8)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=8)
    for side in ("top", "left", "right"):
        axes.spines[side].set_visible(False)
