"""What the sparse layer changes on the spheres: no sparsemax, sparsemax and SLSparsemax beside the truth.

    python -m experiments.figures.error_maps data/panoramas.csv --method NS=A.safetensors --method
        S=B.safetensors \\ --method SLS=C.safetensors

The weights are those of one seed of experiments/ablations/sparse.toml. The view is chosen by rule: the one
whose error under the last method is the median of all. Below each row of spheres stands the absolute error of
luminance, on one scale for all.
"""

import numpy as np
import torch
from matplotlib.figure import Figure

from experiments.figures.common import grid, parser, picture, save, show, spheres
from experiments.figures.comparison import at_quantiles, error, light
from mixlight.data.panoramas import read_table, select
from mixlight.evaluation.methods import Methods
from mixlight.evaluation.protocols import PROTOCOLS
from mixlight.evaluation.renderers import matrix
from mixlight.light.separate import luminance
from mixlight.network import srgb


def main() -> None:
    arguments = parser(__doc__, "sparse_errors")
    arguments.add_argument("table", help="CSV of panoramas")
    arguments.add_argument("--method", action="append", required=True, help="LABEL=WEIGHTS.safetensors")
    arguments.add_argument("--split", default="test")
    options = arguments.parse_args()
    records = read_table(options.table)
    protocol = PROTOCOLS["M"]
    methods = [Methods(protocol, records).open(name) for name in options.method]
    renderer = matrix("M")
    chosen = [r for r in select(records, options.split) if r.category == "indoor"]
    samples = [sample for record in chosen for sample in protocol.samples(record)]
    errors = [error(methods[-1], sample, renderer) for sample in samples]
    (k,) = at_quantiles(errors, [s.scene for s in samples], (0.5,))
    sample = samples[k]
    lights = [sample.environment, *(light(method, sample) for method in methods)]
    shown = [spheres(renderer, one) for one in lights]
    names = ["truth", *(method.name for method in methods)]
    save(draw(srgb.decode(sample.photo).permute(1, 2, 0), names, lights, shown), options.out)


def draw(
    photo: torch.Tensor, names: list[str], lights: list[torch.Tensor], shown: list[torch.Tensor]
) -> Figure:
    """Maps, spheres and errors in three rows, the photo below the truth."""
    wrong = [luminance((one - shown[0]).abs()) for one in shown[1:]]
    limit = float(np.quantile(torch.stack(wrong).numpy(), 0.995))
    figure, axes = grid(3, len(names), [1] * len(names), (2.3 * len(names), 3.4))
    for column, (name, one, three) in enumerate(zip(names, lights, shown, strict=True)):
        show(axes[0, column], picture(one), name)
        show(axes[1, column], picture(three))
    show(axes[2, 0], picture(photo), note="photo")
    for column, error_map in enumerate(wrong, 1):
        drawn = axes[2, column].imshow(error_map.numpy(), cmap="magma", vmin=0, vmax=limit)
        axes[2, column].set(xticks=[], yticks=[])
        axes[2, column].set_xlabel(f"mean {float(error_map.mean()):.3f}", fontsize=6.5)
    figure.colorbar(drawn, ax=axes[2, 1:].tolist(), shrink=0.8, label="error").ax.tick_params(labelsize=6)
    return figure


if __name__ == "__main__":
    main()
