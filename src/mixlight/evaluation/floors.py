"""What any method has to beat, and what the representation could reach at best."""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, EvaluationSample, samples_of
from mixlight.data.panoramas import PanoramaRecord
from mixlight.light.fit import fit
from mixlight.light.separate import Method, luminance
from mixlight.network.canonical import CanonicalView
from mixlight.network.model import mean_linear_colour
from mixlight.sphere import equirect


def training_mean_light(
    records: Sequence[PanoramaRecord], canonical: CanonicalView, geometric: bool = False
) -> Float[Tensor, "height width 3"]:
    """The mean environment over the evaluation views of training panoramas, each in its photo's exposure.

    The constant prediction of somebody who knows the data but never looks at the photo. The plain mean is
    ruled by the few brightest scenes; `geometric` averages the shape of the light (each environment divided
    by its mean luminance) and takes the geometric mean of the luminances, which is the stronger floor in the
    median.

    Raises:
        ValueError: no record, or only black views.
    """
    total, log_scale, count = torch.zeros(ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3), 0.0, 0
    for record in records:
        for sample in samples_of(record, canonical):
            scale = float(luminance(equirect.integrate(sample.environment))) / (4 * math.pi)
            total += sample.environment / scale if geometric else sample.environment
            log_scale += math.log(scale)
            count += 1
    if not count:
        raise ValueError("expected training panoramas with light in them for the mean light, got none")
    return total / count * (math.exp(log_scale / count) if geometric else 1.0)


def photo_mean_light(sample: EvaluationSample) -> Float[Tensor, "height width 3"]:
    """Constant light of the photo's mean linear colour, in the photo's exposure."""
    return mean_linear_colour(sample.photo[None])[0].expand(ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3)


def oracle_light(
    sample: EvaluationSample, separation: Method = "top_fraction", fraction: float = 0.05
) -> Float[Tensor, "height width 3"]:
    """The true environment through its own fitted parameters: the ceiling of the representation.

    Raises:
        ValueError: no such separation or fraction.
    """
    lighting = fit(sample.environment, separation=separation, fraction=fraction)
    return lighting.environment(ENVIRONMENT_HEIGHT)
