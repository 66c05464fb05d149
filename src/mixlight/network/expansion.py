"""Coefficients of an expansion as a network says them: a level above 0, and multiples of it."""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import functions
from mixlight.network.trunk import LOG_LIMIT

_DARKEST = 1e-4


def expansion_size(name: functions.Functions) -> int:
    """Number of outputs for one expansion in three colours.

    Harmonics need as many as they have coefficients, since the constant one is the level. Smooth Gaussians
    have none that could be it: their level comes beside them.

    >>> [expansion_size(name) for name in ("constant", "sh2", "sg9", "sh6")]
    [3, 27, 30, 147]
    """
    return 3 * functions.count(name) + (3 if name == "sg9" else 0)


def read_expansion(
    raw: Float[Tensor, "batch outputs"], name: functions.Functions
) -> Float[Tensor, "batch coefficients 3"]:
    """Coefficients from outputs: exp of the first three is the level, the others are multiples of it.

    >>> read_expansion(torch.zeros(1, 27), "sh2")[0, :, 0]
    tensor([1., 0., 0., 0., 0., 0., 0., 0., 0.])
    """
    level = raw[:, :3].clamp(-LOG_LIMIT, LOG_LIMIT).exp()[:, None]
    multiples = level * raw[:, 3:].unflatten(1, (-1, 3))
    return multiples if name == "sg9" else torch.cat([level, multiples], 1)


def expansion_bias(
    coefficients: Float[Tensor, "coefficients 3"], name: functions.Functions
) -> Float[Tensor, " outputs"]:
    """The outputs that `read_expansion` turns into given coefficients (whose level is above 0).

    >>> one = torch.full((9, 3), 0.5)
    >>> bool(torch.allclose(read_expansion(expansion_bias(one, "sg9")[None], "sg9")[0], one))
    True
    """
    level = (coefficients.mean(0) if name == "sg9" else coefficients[0]).clamp(min=_DARKEST)
    rest = coefficients if name == "sg9" else coefficients[1:]
    return torch.cat([level.log(), (rest / level).flatten()])
