"""Takes the noise of a path tracer off a smooth field, guided by the noise that several runs show.

The light on a ground is smooth but for the rim of its shadows. A pixel is averaged with those neighbours that
differ from it by no more than their noise explains, over steps that double (an a-trous wavelet).

Source: C. Schied et al., Spatiotemporal variance-guided filtering, 2017, section 4.3.
"""

import numpy as np
from jaxtyping import Bool, Float

__all__ = ["denoise", "robust_mean"]

_KERNEL = (1 / 16, 1 / 4, 3 / 8, 1 / 4, 1 / 16)


def robust_mean(
    runs: Float[np.ndarray, "runs *shape channels"],
) -> tuple[Float[np.ndarray, "*shape channels"], Float[np.ndarray, "*shape"]]:
    """The mean of independent runs without the outliers of path tracing, and its variance.

    Of five runs or more the largest and the smallest value of each pixel are left out: a light path of little
    probability and great energy, a firefly, is in one run only. The variance of that mean is
    s^2 / ((1 - 2 / n)^2 n), where s^2 is the variance of the n runs with the two extremes moved to their
    neighbours.

    Convention: the variance is averaged over the channels; of a single run it is 0.

    Source: J. Tukey and D. McLaughlin, Less vulnerable confidence and significance procedures, 1963.

    >>> mean, variance = robust_mean(np.array([1.0, 1.0, 1.2, 0.8, 1.0, 90.0])[:, None])
    >>> mean.round(3), float(variance.round(4))
    (array([1.05]), 0.0040)
    """
    count = len(runs)
    if count < 2:
        return np.asarray(runs.mean(0)), np.zeros(runs.shape[1:-1])
    if count < 5:
        return np.asarray(runs.mean(0)), np.asarray(runs.var(0, ddof=1).mean(-1) / count)
    ranked = np.sort(runs, axis=0)
    mean = ranked[1:-1].mean(0)
    ranked[0], ranked[-1] = ranked[1], ranked[-2]
    variance = ranked.var(0, ddof=1).mean(-1) / ((1 - 2 / count) ** 2 * count)
    return np.asarray(mean), np.asarray(variance)


def denoise(
    value: Float[np.ndarray, "rows columns channels"],
    variance: Float[np.ndarray, "rows columns"],
    valid: Bool[np.ndarray, "rows columns"],
    *,
    levels: int = 4,
    tolerance: float = 2.0,
) -> Float[np.ndarray, "rows columns channels"]:
    """A noisy picture, smoothed as far as its noise allows.

    Args:
        value: the picture.
        variance: of each pixel's noise, mean over the channels.
        valid: the pixels that count; the others neither give nor take.
        levels: doublings of the reach, 2^levels pixels in all.
        tolerance: differences up to about this many standard deviations are taken for noise.

    Convention: without noise the picture comes back as it is.

    >>> noise = 0.1 * np.indices((8, 8, 1)).sum(0) % 0.2 - 0.05
    >>> clean = denoise(1 + noise, np.full((8, 8), 0.05**2), np.ones((8, 8), bool))
    >>> float(clean[4, 4, 0].round(3))
    1.0
    """
    # Few runs tell little about one pixel's noise: it is taken from a neighbourhood.
    share = _blur(valid.astype(float), 3)
    variance = np.where(valid, _blur(variance * valid, 3) / np.maximum(share, 1e-3), 0.0)
    value = _without_speckles(value, variance, valid)
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


def _without_speckles(
    value: Float[np.ndarray, "rows columns channels"],
    variance: Float[np.ndarray, "rows columns"],
    valid: Bool[np.ndarray, "rows columns"],
) -> Float[np.ndarray, "rows columns channels"]:
    """Pixels that stand out of all their eight neighbours by more than noise does are brought down to them.

    The wavelet would keep such a pixel for a detail, as it is too different to be averaged.
    """
    low, high = np.full_like(value, np.inf), np.full_like(value, -np.inf)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            if dy or dx:
                other, there = _at(value, dy, dx), _at(valid, dy, dx)[..., None]
                low = np.where(there, np.minimum(low, other), low)
                high = np.where(there, np.maximum(high, other), high)
    slack = np.sqrt(variance)[..., None]
    kept = ~(valid[..., None] & np.isfinite(low))
    return np.asarray(np.where(kept, value, np.clip(value, low - slack, high + slack)))


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
    sums = summed[side:, side:] - summed[:-side, side:] - summed[side:, :-side] + summed[:-side, :-side]
    return np.asarray(np.maximum(sums, 0.0) / side**2)  # rounding may leave a sum just below 0
