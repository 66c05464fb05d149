"""What any method has to beat: constant guesses, and the photo's own pixels carried on."""

from __future__ import annotations

import math
from collections.abc import Iterable

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, EvaluationSample
from mixlight.light.separate import luminance
from mixlight.network import srgb
from mixlight.network.model import mean_linear_colour
from mixlight.sphere import equirect
from mixlight.sphere.backprojection import lay_on_sphere

__all__ = ["REACH", "photo_extended_light", "photo_mean_light", "training_mean_light"]

REACH = 0.2
"""How far a pixel is carried beyond the photo: by exp((cosine - 1) / REACH), half at 30 degrees."""

_COARSE = 32
"""Rows of the map whose texels inside the photo are carried on."""


def training_mean_light(
    samples: Iterable[EvaluationSample], geometric: bool = False
) -> Float[Tensor, "height width 3"]:
    """The mean environment over views of training panoramas, each in its photo's exposure.

    The constant prediction of somebody who knows the data but never looks at the photo. The plain mean is
    ruled by the few brightest scenes; `geometric` averages the shape of the light (each environment divided
    by its mean luminance) and takes the geometric mean of the luminances, which is the stronger floor in the
    median.

    Raises:
        ValueError: no sample.
    """
    total, log_scale, count = torch.zeros(ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3), 0.0, 0
    for sample in samples:
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


def photo_extended_light(sample: EvaluationSample, reach: float = REACH) -> Float[Tensor, "height width 3"]:
    """The photo's pixels where it looks, and their smooth continuation everywhere else.

    What somebody without a model would do: inside the photo its linear pixels; outside, each direction d
    shows the mean of the pixels' colours c_p, those near to it most:

        sum_p c_p w_p exp((d . d_p - 1) / reach) / sum_p w_p exp((d . d_p - 1) / reach)

    with solid angles w_p. Beside the photo that goes on with its rim's colours, behind the camera it is
    nearly the mean. The camera's pitch is taken as known.

    Args:
        sample: its photo alone is looked at, and how it was taken.
        reach: of the pixels.

    Convention: a photo of one colour gives a map of that colour.

    Raises:
        ValueError: a reach that is not above 0.

    >>> gray, black = torch.full((3, 48, 64), 0.5), torch.zeros(128, 256, 3)
    >>> photo_extended_light(EvaluationSample("a", 0.0, 0.0, 1.0, gray, black))[0, 0]
    tensor([0.2140, 0.2140, 0.2140])
    """
    if not reach > 0:
        raise ValueError(f"reach: expected a number above 0, got {reach}")
    linear = srgb.decode(sample.photo).permute(1, 2, 0)
    laid, weight = lay_on_sphere(linear, sample.fov, _COARSE, pitch=sample.pitch)
    seen = weight > 0.5
    if not bool(seen.any()):
        raise ValueError(
            f"expected a photo that covers a texel of a map of {_COARSE} rows, got one of "
            f"{math.degrees(sample.fov):g} degrees"
        )
    colours = laid[seen] / weight[seen][:, None]
    rays, areas = equirect.pixel_directions(_COARSE)[seen], equirect.solid_angle(_COARSE)[seen]
    out = equirect.pixel_directions(ENVIRONMENT_HEIGHT).view(-1, 3)
    share = torch.softmax((out @ rays.T - 1) / reach + areas.log(), -1)
    around = (share @ colours).view(ENVIRONMENT_HEIGHT, 2 * ENVIRONMENT_HEIGHT, 3)
    laid, weight = lay_on_sphere(linear, sample.fov, ENVIRONMENT_HEIGHT, pitch=sample.pitch)
    return laid + (1 - weight)[..., None] * around
