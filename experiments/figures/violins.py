"""Harmonics against Gaussians at equal numbers of parameters, for ambient light and for sources.

    python -m experiments.figures.violins [--level representation|network]

Each violin holds sqrt(RMSE si-RMSE) of three spheres in every view, lit by one part of the light alone,
against the same part of the truth: ambient light in 9 harmonics or 9 smooth Gaussians (27 numbers), sources
in 128 sharp Gaussians (132) or harmonics of degree 6 (147). Made from the results of `mixlight ablate`.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.figures.common import COLOURS, INK, parser, save

RESULTS = Path(__file__).parents[1] / "results" / "ablations"
EXPERIMENTS = {"representation": "representation", "network": "combinations"}
OURS = "MixLight (SH2 + 128 SG)"
PANELS = (
    ("ambient", "ambient light", (("SH", OURS, "9 harmonics"), ("SG", "SGG (9 SG + 128 SG)", "9 smooth SG"))),
    ("sources", "sources", (("SH", "SHH (SH2 + SH6)", "49 harmonics"), ("SG", OURS, "128 sharp SG"))),
)
"""Part of the light, its title, and for each violin colour, variant and label."""


def main() -> None:
    arguments = parser(__doc__, "sh_against_sg")
    arguments.add_argument("--level", choices=EXPERIMENTS, default="representation")
    options = arguments.parse_args()
    file = RESULTS / f"{EXPERIMENTS[options.level]}.json"
    out = options.out.with_name(f"{options.out.name}_{options.level}")
    save(draw(json.loads(file.read_text(encoding="utf-8"))), out)


def draw(result: dict[str, Any]) -> Figure:
    """Two panels; errors on a logarithmic scale, the mark is the median."""
    figure = Figure(figsize=(6.4, 3.2), layout="constrained")
    for axes, (part, title, kinds) in zip(figure.subplots(1, 2), PANELS, strict=True):
        values = [np.log10(errors(result, name, part)) for _, name, _ in kinds]
        drawn = axes.violinplot(values, widths=0.8, showextrema=False, showmedians=True, points=200)
        for body, (kind, _, _) in zip(drawn["bodies"], kinds, strict=True):
            body.set(facecolor=COLOURS[kind], alpha=0.85, edgecolor="none")
        drawn["cmedians"].set(color=INK, linewidth=1)
        for place, column in enumerate(values, 1):
            median = 10 ** float(np.median(column))
            above = {"xytext": (0, 3), "textcoords": "offset points", "ha": "center"}
            axes.annotate(f"{median:.3g}", (place, np.log10(median)), fontsize=8, color="white", **above)
        low, high = np.floor(min(map(np.min, values))), np.ceil(max(map(np.max, values)))
        ticks = np.arange(low, high + 1)
        axes.set_yticks(ticks, [f"{10.0**tick:g}" for tick in ticks])
        axes.set_xticks(range(1, len(kinds) + 1), [label for _, _, label in kinds])
        axes.set_title(title, fontsize=10, color=INK)
        axes.spines[["top", "right"]].set_visible(False)
    figure.axes[0].set_ylabel("√(RMSE · si-RMSE)")
    return figure


def errors(result: dict[str, Any], variant: str, part: str) -> np.ndarray:
    """Of all spheres and views together, as the paper draws them."""
    views = result["variants"][variant]["parts"][part]["views"]
    found: np.ndarray = np.concatenate([np.array(column) for column in views.values()])
    return found.clip(1e-6)


if __name__ == "__main__":
    main()
