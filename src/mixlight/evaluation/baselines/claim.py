"""What a paper says of its own method, as something that results can confirm or deny."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from mixlight.evaluation.ablation_report import decided

__all__ = ["Baseline", "Claim", "Verdict", "verdict"]

Verdict = Literal["confirmed", "contradicted", "open"]


@dataclass(frozen=True)
class Claim:
    """One comparison of two rows of an ablation's table."""

    says: str
    """The paper's claim, in our words."""
    experiment: str
    """Name of the experiment that has both rows."""
    better: str
    """The variant that the paper says is better."""
    worse: str
    """The other; one of the two is the experiment's reference."""
    cells: tuple[str, ...]
    """The errors in which that should be seen."""


@dataclass(frozen=True)
class Baseline:
    """A method that ours is compared with."""

    name: str
    """As a config's `method` calls it."""
    title: str
    """As tables call it."""
    paper: str
    """Where it comes from."""
    differs: tuple[str, ...]
    """What ours does otherwise than the paper, and why."""
    claims: tuple[Claim, ...]
    """What the paper says of it that can be checked on our data."""


def verdict(result: Mapping[str, Any], claim: Claim, cell: str) -> Verdict:
    """What an experiment's results say of a claim in one cell.

    `confirmed` and `contradicted` want an interval over places that leaves out 1, and seeds that agree;
    anything else is `open`.

    Raises:
        ValueError: neither variant is the reference of the results, or one is missing.

    >>> sure = {"ratio_to_reference": {"rmse": {"ratio": 1.2, "interval_95": [1.1, 1.3]}}}
    >>> rows = {"theirs": {"parts": {"whole": {}}}, "other": {"parts": {"whole": sure}}}
    >>> claim = Claim("", "", better="theirs", worse="other", cells=("rmse",))
    >>> verdict({"reference": "theirs", "variants": rows}, claim, "rmse")
    'confirmed'
    """
    reference, rows = result["reference"], result["variants"]
    if reference not in (claim.better, claim.worse) or not {claim.better, claim.worse} <= rows.keys():
        raise ValueError(
            f"expected {claim.better!r} and {claim.worse!r} in the results, one of them as the reference, "
            f"got {', '.join(rows)} with {reference!r}"
        )
    other = claim.worse if reference == claim.better else claim.better
    side = decided(rows[other]["parts"]["whole"], cell)
    if side == 0:
        return "open"
    # 1: the other row is worse than the reference.
    return "confirmed" if (side == 1) == (other == claim.worse) else "contradicted"
