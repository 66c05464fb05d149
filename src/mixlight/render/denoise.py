"""Takes the noise of a path tracer off a smooth field, guided by the noise that several runs show.

The light on a ground is smooth but for the rim of its shadows. A pixel is averaged with those neighbours that
differ from it by no more than their noise explains, over steps that double (an a-trous wavelet).

Source: C. Schied et al., Spatiotemporal variance-guided filtering, 2017, section 4.3.
"""

import numpy as np
from jaxtyping import Bool, Float

__all__ = ["denoise"]

_KERNEL = (1 / 16, 1 / 4, 3 / 8, 1 / 4, 1 / 16)


def denoise(
    runs: Float[np.ndarray, "runs rows columns channels"],
    valid: Bool[np.ndarray, "rows columns"],
    *,
    levels: int = 4,
    tolerance: float = 3.0,
) -> Float[np.ndarray, "rows columns channels"]:
    """The mean of several independent noisy pictures, smoothed as far as their noise allows.

    Args:
        runs: of one and the same field; a single one is returned as it is, since its noise is unknown.
        valid: the pixels that count; the others neither give nor take.
        levels: doublings of the reach, 2^levels pixels in all.
        tolerance: differences up to about this many standard deviations are taken for noise.

    Convention: a field without noise comes back as it is.

    >>> field = np.ones((2, 8, 8, 1)) + np.array([0.1, -0.1]).reshape(2, 1, 1, 1)
    >>> float(denoise(field, np.ones((8, 8), bool)).mean().round(6))
    1.0
    """
    value = np.asarray(runs.mean(0))
    count = len(runs)
    if count < 2:
        return np.asarray(value)
    # Few runs tell little about one pixel's noise: it is taken from a neighbourhood.
    variance = runs.var(0, ddof=1).mean(-1) / count
    share = _blur(valid.astype(float), 3)
    variance = np.where(valid, _blur(variance * valid, 3) / np.maximum(share, 1e-3), 0.0)
    for level in range(levels):
        step = 2**level
        total = np.zeros_like(value)
        weight = np.zeros(value.shape[:2])
        spread = np.zeros_like(weight)
        for i, a in enumerate(_KERNEL):
            for j, b in enumerate(_KERNEL):
                dy, dx = (i - 2) * step, (j - 2) * step
                other, other_variance, other_valid = (
                    _at(field, dy, dx) for field in (value, variance, valid)
                )
                difference = ((other - value) ** 2).mean(-1)
                noise = tolerance**2 * (variance + other_variance) + 1e-12
                w = a * b * np.exp(-difference / noise) * other_valid
                total += w[..., None] * other
                spread += w * w * other_variance
                weight += w
        safe = np.where(valid, weight, 1.0)  # at least the pixel's own weight
        value = np.where(valid[..., None], total / safe[..., None], value)
        variance = np.where(valid, spread / safe**2, 0.0)
    return np.asarray(value)


def _at(field: np.ndarray, dy: int, dx: int) -> np.ndarray:
    """The field seen from (dy, dx) away; what lies outside is 0."""
    rows, columns = field.shape[:2]
    out = np.zeros_like(field)
    if abs(dy) < rows and abs(dx) < columns:
        out[max(-dy, 0) : rows - max(dy, 0), max(-dx, 0) : columns - max(dx, 0)] = field[
            max(dy, 0) : rows - max(-dy, 0), max(dx, 0) : columns - max(-dx, 0)
        ]
    return out


def _blur(field: Float[np.ndarray, "rows columns"], radius: int) -> Float[np.ndarray, "rows columns"]:
    """Box mean over (2 radius + 1)^2 pixels, the outside counting as 0."""
    side = 2 * radius + 1
    padded = np.pad(field, radius)
    summed = np.pad(padded.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    return (
        summed[side:, side:] - summed[:-side, side:] - summed[side:, :-side] + summed[:-side, :-side]
    ) / side**2
