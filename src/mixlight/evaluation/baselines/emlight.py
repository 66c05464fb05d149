"""EMLight: light on 128 anchors without sparsity, in constant light; its regression stage, without the
generator.
"""

from mixlight.evaluation.baselines.claim import Baseline, Claim

__all__ = ["EMLIGHT"]

_LIT = ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse", "matte_si_rmse")

EMLIGHT = Baseline(
    name="emlight",
    title="EMLight",
    paper=(
        "Zhan, Zhang, Yu, Chang, Lu, Ma, Xie: EMLight: Lighting Estimation via Spherical Distribution "
        "Approximation, AAAI 2021"
    ),
    differs=(
        "the regression stage alone: what its generator paints over the Gaussian map is not part of it",
        "the gain of the photo is linear and applied to the light too; EMLight's is worked out after gamma",
        "outputs are relative to the photo's mean colour, and E is regressed on a log scale, as ours are",
        "lobes are normalised, so that the map's energy is E",
        "the backbone is that of all methods in a table",
    ),
    claims=(
        Claim(
            "64 anchors are worse than 128",
            "counts_anchors", better="128 anchors", worse="64 anchors", cells=_LIT,
        ),
        Claim(
            "196 anchors are not better than 128",
            "counts_anchors", better="128 anchors", worse="196 anchors", cells=_LIT,
        ),
        Claim(
            "a loss that knows how far light has to move is better than a squared error",
            "tuning_emlight",
            better="EMLight, transport as its paper describes",
            worse="EMLight, as published",
            cells=_LIT,
        ),
    ),
)  # fmt: skip
"""What `method = "emlight"` stands for."""
