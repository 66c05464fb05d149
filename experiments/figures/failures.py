"""Where a method fails, chosen by rule: the views of the largest error, one a place.

    python -m experiments.figures.failures data/panoramas.csv --method mixlight

The error is sqrt(RMSE si-RMSE) of the diffuse sphere, divided by the true sphere's mean, so that bright
photos do not win by being bright. The four worst places are shown with their worst view.
"""

from experiments.figures.common import parser, save, spheres
from experiments.figures.comparison import draw, error
from mixlight.data.panoramas import read_table, select
from mixlight.evaluation.methods import Methods
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.evaluation.renderers import matrix

PLACES = 4


def main() -> None:
    arguments = parser(__doc__, "failures")
    arguments.add_argument("table", help="CSV of panoramas")
    arguments.add_argument("--method", required=True, help="as `mixlight evaluate` knows it")
    arguments.add_argument("--split", default="test")
    options = arguments.parse_args()
    records = read_table(options.table)
    protocol = PROTOCOLS["M"]
    method = Methods(protocol, records).open(options.method)
    renderer = matrix("M")
    chosen = [r for r in select(records, options.split) if r.category == "indoor"]
    samples = [sample for record in chosen for sample in protocol.samples(record)]
    brightness = [
        float(spheres(renderer, s.environment)[:, : renderer.mask.shape[1]][renderer.mask].mean())
        for s in samples
    ]
    relative = [error(method, s, renderer) / b for s, b in zip(samples, brightness, strict=True)]
    taken = worst(relative, [s.scene for s in samples])
    save(draw([samples[k] for k in taken], [method], renderer), options.out)


def worst(errors: list[float], scenes: list[str], places: int = PLACES) -> list[int]:
    """The worst view of each of the worst places, the worst first."""
    best_of: dict[str, int] = {}
    for k in sorted(range(len(errors)), key=lambda k: -errors[k]):
        best_of.setdefault(scenes[k], k)
    return list(best_of.values())[:places]


if __name__ == "__main__":
    main()
