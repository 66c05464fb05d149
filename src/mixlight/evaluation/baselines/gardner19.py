"""Gardner et al. 2019: three lamps with direction, size and colour, in constant light."""

from mixlight.evaluation.baselines.claim import Baseline, Claim

__all__ = ["GARDNER19"]

_LIT = ("diffuse_rmse", "diffuse_si_rmse", "matte_rmse", "matte_si_rmse")

GARDNER19 = Baseline(
    name="gardner19",
    title="Gardner19",
    paper=(
        "Gardner, Hold-Geoffroy, Sunkavalli, Gagné, Lalonde: Deep Parametric Indoor Lighting Estimation, "
        "ICCV 2019"
    ),
    differs=(
        "no distance of the lamps: none of our panoramas has depth, so nothing could teach it",
        "outputs are relative to the photo's mean colour, as ours are",
        "a lamp's size is the s of a spherical Gaussian, from its region's solid angle; energy is kept",
        "all six assignments of three lamps are tried, which is what Hungarian matching finds",
        "the backbone is that of all methods in a table",
    ),
    claims=(
        Claim(
            "three lamps hold more of the light than one",
            "counts", better="3 lamps", worse="1 lamp", cells=_LIT,
        ),
        Claim(
            "more than three add little (so five should not be better)",
            "counts", better="3 lamps", worse="5 lamps", cells=_LIT,
        ),
        Claim(
            "training in two stages is better than matching lamps from the start",
            "tuning_gardner19", better="Gardner19, as published", worse="Gardner19, one stage", cells=_LIT,
        ),
    ),
)  # fmt: skip
"""What `method = "gardner19"` stands for."""
