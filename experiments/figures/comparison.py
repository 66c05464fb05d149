"""Photos, their true light and what methods make of them: maps and the three spheres.

    python -m experiments.figures.comparison data/panoramas.csv --method mixlight --method
    emlight=RUN/model.safetensors

Views are chosen by rule: those whose error (sqrt(RMSE si-RMSE) of the diffuse sphere, first method) lies at
the quantiles .1, .35, .65 and .9 of all views of the split, each of another place.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from experiments.figures.common import grid, parser, picture, save, show, spheres
from mixlight.data.evaluation_set import EvaluationSample
from mixlight.data.panoramas import read_table, select
from mixlight.evaluation.methods import Method, Methods
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.evaluation.renderers import Renderer, matrix
from mixlight.evaluation.scoring import score
from mixlight.light.lighting import Lighting
from mixlight.network import srgb

QUANTILES = (0.1, 0.35, 0.65, 0.9)


def main() -> None:
    arguments = parser(__doc__, "comparison")
    arguments.add_argument("table", help="CSV of panoramas")
    arguments.add_argument("--method", action="append", required=True, help="as `mixlight evaluate` knows it")
    arguments.add_argument("--split", default="test")
    arguments.add_argument("--category", action="append")
    options = arguments.parse_args()
    records = read_table(options.table)
    protocol = PROTOCOLS["M"]
    methods = [Methods(protocol, records).open(name) for name in options.method]
    renderer = matrix("M")
    chosen = [r for r in select(records, options.split) if r.category in (options.category or ["indoor"])]
    samples = [sample for record in chosen for sample in protocol.samples(record)]
    errors = [error(methods[0], sample, renderer) for sample in samples]
    save(
        draw([samples[k] for k in at_quantiles(errors, [s.scene for s in samples])], methods, renderer),
        options.out,
    )


def error(method: Method, sample: EvaluationSample, renderer: Renderer) -> float:
    """By which views are chosen."""
    (cells,) = score(PROTOCOLS["M"], [light(method, sample)], sample.environment, renderer)
    return cells["diffuse_geometric"]


def light(method: Method, sample: EvaluationSample):  # type: ignore[no-untyped-def]
    """A method's answer as a map."""
    answer = method.answer(sample)
    return answer.environment(len(sample.environment)) if isinstance(answer, Lighting) else answer


def at_quantiles(
    errors: Sequence[float], scenes: Sequence[str], quantiles: Sequence[float] = QUANTILES
) -> list[int]:
    """Views nearest to the quantiles, each of a scene that was not taken yet."""
    order = np.argsort(errors)
    taken: list[int] = []
    for quantile in quantiles:
        place = quantile * (len(order) - 1)
        near = sorted(range(len(order)), key=lambda rank: abs(rank - place))
        free = [order[rank] for rank in near if scenes[order[rank]] not in {scenes[k] for k in taken}]
        taken.append(int((free or [order[near[0]]])[0]))
    return taken


def draw(samples: Sequence[EvaluationSample], methods: Sequence[Method], renderer: Renderer) -> Figure:
    """Two rows of pictures a photo: maps above, spheres below."""
    titles = ["truth", *(method.name for method in methods)]
    columns = 1 + len(titles)
    figure, axes = grid(
        2 * len(samples), columns, [4 / 3, *[2] * len(titles)], (1.75 * columns, 1.45 * len(samples))
    )
    for k, sample in enumerate(samples):
        show(axes[2 * k, 0], picture(srgb.decode(sample.photo).permute(1, 2, 0)), "photo" if k == 0 else "")
        axes[2 * k + 1, 0].axis("off")
        maps = [sample.environment, *(light(method, sample) for method in methods)]
        for column, (title, panorama) in enumerate(zip(titles, maps, strict=True), 1):
            note = ""
            if column > 1:
                (cells,) = score(PROTOCOLS["M"], [panorama], sample.environment, renderer)
                note = " / ".join(f"{cells[f'{s}_rmse']:.2f}" for s in ("diffuse", "matte", "mirror"))
            show(axes[2 * k, column], picture(panorama), title if k == 0 else "")
            show(axes[2 * k + 1, column], picture(spheres(renderer, panorama)), note=note and f"RMSE {note}")
    return figure


if __name__ == "__main__":
    main()
