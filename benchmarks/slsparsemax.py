"""(c) SLSparsemax forward and backward against entmax's sparsemax, 4096 rows of 128 scores in float32.

Half of the rows are like an untrained network's (noise at probability scale, wide supports), half like a
trained one's (a few patches over little noise, small supports). Both sides read the same scores and
gradients.
"""

from collections.abc import Callable

import entmax
import torch
from torch import Tensor

from benchmarks.timing import Result, side_by_side
from mixlight.network.sparsemax import SLSparsemax
from mixlight.sphere.points import vogel

ROWS, COUNT = 4096, 128
REPEATS = 10


def measure() -> Result:
    generator = torch.Generator().manual_seed(0)
    noise = torch.randn(ROWS, COUNT, generator=generator)
    centres = vogel(COUNT)[torch.randint(COUNT, (ROWS, 3), generator=generator)]
    patches = ((centres @ vogel(COUNT).T - 1) / 0.02).exp().sum(1)
    trained = 1.5 * patches / patches.sum(-1, keepdim=True) + 0.02 * noise
    scores = torch.where(torch.arange(ROWS)[:, None] < ROWS // 2, trained, 0.02 * noise).requires_grad_()
    direction = torch.randn(ROWS, COUNT, generator=generator)
    layer = SLSparsemax(COUNT)

    def work(function: Callable[[Tensor], Tensor]) -> Callable[[], None]:
        def run() -> None:
            for _ in range(REPEATS):
                scores.grad = None
                function(scores).backward(direction)

        return run

    return side_by_side(
        "c",
        1.5,
        (f"SLSparsemax, {REPEATS} times", work(layer)),
        (f"entmax's sparsemax, {REPEATS} times", work(lambda x: entmax.sparsemax(x, dim=-1))),
    )
