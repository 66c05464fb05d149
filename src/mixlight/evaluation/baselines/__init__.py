"""The methods that ours is compared with, one module each: what each is, and what its own paper says of it.

Their networks and losses live in `network` and `loss`, where training can reach them
(`mixlight.training.presets`): a config with `method = "gardner19"` trains one by `mixlight train`, and
`mixlight evaluate --method WEIGHTS.safetensors` scores it.
"""

from mixlight.evaluation.baselines.claim import Baseline, Claim, Verdict, verdict
from mixlight.evaluation.baselines.emlight import EMLIGHT
from mixlight.evaluation.baselines.gardner19 import GARDNER19

__all__ = ["BASELINES", "Baseline", "Claim", "Verdict", "verdict"]

BASELINES = {baseline.name: baseline for baseline in (GARDNER19, EMLIGHT)}
"""By the name that a config's `method` has."""
