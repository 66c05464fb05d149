"""What any method has to beat, and what the representation could reach at best."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, EvaluationSample, samples_of
from mixlight.data.panoramas import PanoramaRecord
from mixlight.light.fit import fit
from mixlight.network.canonical import CanonicalView
from mixlight.network.model import mean_linear_colour


def training_mean_light(
    records: Sequence[PanoramaRecord], canonical: CanonicalView
) -> Float[Tensor, "height width 3"]:
    """The mean environment over the evaluation views of training panoramas, each in its photo's exposure.

    The constant prediction of somebody who knows the data but never looks at the photo.

    Raises:
        ValueError: no record.
    """
    if not records:
        raise ValueError("expected training panoramas for the mean light, got none")
    total, count = torch.zeros(ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3), 0
    for record in records:
        for sample in samples_of(record, canonical):
            total += sample.environment
            count += 1
    return total / count


def photo_mean_light(sample: EvaluationSample) -> Float[Tensor, "height width 3"]:
    """Constant light of the photo's mean linear colour."""
    return mean_linear_colour(sample.photo[None])[0].expand(ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3)


def oracle_light(
    sample: EvaluationSample, separation: str = "top_fraction", fraction: float = 0.05
) -> Float[Tensor, "height width 3"]:
    """The true environment through its own fitted parameters: the ceiling of the representation."""
    lighting = fit(sample.environment, separation=separation, fraction=fraction)
    return lighting.environment(ENVIRONMENT_HEIGHT)
