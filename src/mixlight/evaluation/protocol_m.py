"""Protocol M on fixed views: linear renderings of three spheres in the photo's exposure, errors unscaled."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample
from mixlight.render.spheres import SphereRenderer
from mixlight.training.validation import SPHERES, score_spheres

Method = Callable[[EvaluationSample], Float[Tensor, "height width 3"]]
"""A method maps a sample (of which it may look at the photo) to an environment map."""


@dataclass(frozen=True)
class Scores:
    """Errors of one method on every sample."""

    rmse: Float[Tensor, "samples 3"]
    """RMSE of the diffuse, matte and mirror sphere."""
    si_rmse: Float[Tensor, "samples 3"]
    """The same after the best single scale."""

    def summary(
        self, groups: Sequence[str], resamples: int = 2000
    ) -> dict[str, dict[str, float | list[float]]]:
        """Median and mean of the six cells, and a 95 % interval of the median.

        The interval is bootstrapped over `groups`: views of one panorama are not independent, so whole
        panoramas are drawn. The draws are always the same.

        Args:
            groups: the panorama of each sample.
            resamples: number of draws.

        Returns:
            `<sphere>_rmse` and `<sphere>_si_rmse`, each with `median`, `mean` and `median_95` (low, high), to
            four digits.

        Raises:
            ValueError: not one group for each sample.

        >>> scores = Scores(torch.tensor([[0.1, 0.2, 0.3], [0.3, 0.4, 0.5]]), torch.zeros(2, 3))
        >>> scores.summary(["room", "room"], resamples=50)["diffuse_rmse"]
        {'median': 0.2, 'mean': 0.2, 'median_95': [0.2, 0.2]}
        """
        if len(groups) != len(self.rmse):
            raise ValueError(f"expected one group for each of {len(self.rmse)} samples, got {len(groups)}")
        table: dict[str, dict[str, float | list[float]]] = {}
        for name in ("rmse", "si_rmse"):
            for i, sphere in enumerate(SPHERES):
                values = getattr(self, name)[:, i].double().numpy()
                table[f"{sphere}_{name}"] = {
                    "median": round(float(np.median(values)), 4),
                    "mean": round(float(values.mean()), 4),
                    "median_95": [round(v, 4) for v in _interval(values, groups, resamples)],
                }
        return table


def evaluate(
    methods: Mapping[str, Method], samples: Sequence[EvaluationSample], renderer: SphereRenderer | None = None
) -> dict[str, Scores]:
    """Scores every method on every sample.

    Args:
        methods: by name; each gets the sample, of which it may look at the photo only (the oracle may look at
            more).
        samples: photos with known light.
        renderer: of the spheres; one of 64 pixels if not given.

    Raises:
        ValueError: no method or no sample.
    """
    if not methods or not samples:
        raise ValueError(f"expected methods and samples, got {len(methods)} and {len(samples)}")
    renderer = renderer or SphereRenderer(resolution=64)
    results: dict[str, list[Tensor]] = {name: [] for name in methods}
    for sample in samples:
        predicted = torch.stack([method(sample) for method in methods.values()])
        true = sample.environment.expand_as(predicted)
        for name, cells in zip(methods, score_spheres(renderer, predicted, true), strict=True):
            results[name].append(cells)
    return {
        name: Scores(torch.stack(cells)[:, 0], torch.stack(cells)[:, 1]) for name, cells in results.items()
    }


def _interval(values: np.ndarray, groups: Sequence[str], resamples: int) -> tuple[float, float]:
    generator = np.random.default_rng(0)
    names = sorted(set(groups))
    members = [np.flatnonzero(np.array(groups) == name) for name in names]
    medians = []
    for _ in range(resamples):
        drawn = generator.integers(len(names), size=len(names))
        medians.append(np.median(values[np.concatenate([members[k] for k in drawn])]))
    low, high = np.quantile(medians, (0.025, 0.975))
    return float(low), float(high)
