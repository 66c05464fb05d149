"""Separation of a panorama into sources and ambient light by luminance, weighted by solid angle.

Two rules, both with their fraction as a parameter:

- ``top_fraction``: the brightest texels that together cover a fraction of the sphere (the paper's prose).
- ``max_fraction``: the texels above a fraction of the brightest one's luminance (the lineage the paper cites:
  Gardner 2019, EMLight).

Either is a threshold on luminance, so that equal texels share their fate and a turned panorama gives the
turned mask. A texel at the panorama's lowest luminance is never a source: an even panorama is all ambient,
and so is the dark surround of a few small lamps that do not fill the fraction.
"""

from typing import Literal, get_args

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mixlight.light import _level_set
from mixlight.sphere.equirect import check

Method = Literal["top_fraction", "max_fraction"]


def luminance(rgb: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch"]:
    """Luminance of linear Rec.709 colours, .2126 R + .7152 G + .0722 B.

    Convention: white (1, 1, 1) has the luminance 1.

    Raises:
        ValueError: the last axis is not 3.

    >>> luminance(torch.tensor([0.0, 1.0, 0.0]))
    tensor(0.7152)
    """
    if rgb.shape[-1] != 3:
        raise ValueError(f"rgb: expected a last axis of 3, received shape {tuple(rgb.shape)}")
    return _level_set.luminance(rgb)


def threshold(
    panorama: Float[Tensor, "*batch height width 3"],
    method: Method = "top_fraction",
    fraction: float = 0.05,
) -> Float[Tensor, "*batch"]:
    """Luminance from which on a texel is a source, in single precision (at least).

    For ``top_fraction`` it is the highest luminance t such that the texels with luminance >= t cover at least
    the fraction of the sphere. For ``max_fraction`` it is that fraction of the largest luminance. Always
    above the lowest luminance. Exact, and found without a sort of the whole.

    Args:
        panorama: radiance, 2:1, finite, >= 0.
        method: the rule.
        fraction: of the sphere's solid angle, or of the largest luminance; above 0 and below 1.

    Raises:
        ValueError: no such panorama, method or fraction.

    >>> panorama = torch.ones(8, 16, 3)
    >>> panorama[3, 4] = 50.0
    >>> threshold(panorama, "max_fraction", 0.1)
    tensor(5.0000)
    """
    check(panorama)
    check_rule(method, fraction)
    height, width = panorama.shape[-3:-1]
    flat = panorama.reshape(-1, height, width, 3)
    found = [threshold_of(_level_set.Bands(one), method, fraction) for one in flat]
    return torch.tensor(found, dtype=torch.float32, device=panorama.device).reshape(panorama.shape[:-3])


def source_mask(
    panorama: Float[Tensor, "*batch height width 3"],
    method: Method = "top_fraction",
    fraction: float = 0.05,
) -> Bool[Tensor, "*batch height width"]:
    """Which texels are light sources: those with a luminance of at least `threshold`.

    Raises:
        ValueError: no such panorama, method or fraction.

    >>> panorama = torch.ones(8, 16, 3)
    >>> panorama[3, 4] = 50.0
    >>> source_mask(panorama).nonzero().tolist()
    [[3, 4]]
    """
    limits = threshold(panorama, method, fraction)
    return _level_set.level(panorama) >= limits[..., None, None]


def separate(
    panorama: Float[Tensor, "*batch height width 3"],
    method: Method = "top_fraction",
    fraction: float = 0.05,
) -> tuple[Float[Tensor, "*batch height width 3"], Float[Tensor, "*batch height width 3"]]:
    """Sources and ambient part of a panorama, each 0 where the other is not; their sum is the panorama
    exactly.

    The removed sources leave holes of 0 in the ambient part: with them SH(ambient) + SG(sources) holds the
    total energy; an inpainted ambient part would not.

    Raises:
        ValueError: no such panorama, method or fraction.

    >>> panorama = torch.ones(8, 16, 3)
    >>> panorama[3, 4] = 50.0
    >>> sources, ambient = separate(panorama)
    >>> float(sources.sum()), float(ambient.sum())
    (150.0, 381.0)
    """
    mask = source_mask(panorama, method, fraction)[..., None]
    zero = torch.zeros((), dtype=panorama.dtype, device=panorama.device)
    return torch.where(mask, panorama, zero), torch.where(mask, zero, panorama)


def threshold_of(bands: _level_set.Bands, method: Method, fraction: float) -> float:
    """`threshold` of one panorama that the caller goes through in bands; nothing is checked.

    >>> threshold_of(_level_set.Bands(torch.rand(8, 16, 3).clamp_max(0.5)), "max_fraction", 0.5)
    0.25
    """
    if method == "top_fraction":
        return _level_set.top_threshold(bands, fraction)
    return _level_set.max_threshold(bands, fraction)


def check_rule(method: str, fraction: float) -> None:
    """Refuse what is no rule of separation.

    Raises:
        ValueError: an unknown method, or a fraction that is not above 0 and below 1.

    >>> check_rule("top_fraction", 5)
    Traceback (most recent call last):
    ValueError: fraction: expected a number above 0 and below 1, received 5
    """
    if method not in get_args(Method):
        raise ValueError(f"separation: expected one of {', '.join(get_args(Method))}, received {method!r}")
    if not 0 < fraction < 1:
        raise ValueError(f"fraction: expected a number above 0 and below 1, received {fraction!r}")
