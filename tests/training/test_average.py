"""The running average of weights."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from mixlight.training.average import follow


def test_golden() -> None:
    average = {"weight": torch.tensor([0.0, 4.0]), "count": torch.tensor(3)}
    follow(average, {"weight": torch.tensor([1.0, 0.0]), "count": torch.tensor(7)}, 0.75, 1000)
    assert average["weight"].tolist() == [0.25, 3.0]
    assert average["count"] == 7


def test_the_start_averages_over_what_there_is() -> None:
    average = {"weight": torch.zeros(1)}
    follow(average, {"weight": torch.ones(1)}, 0.999, 0)
    assert average["weight"].item() == pytest.approx(0.9)
    follow(average, {"weight": torch.ones(1)}, 0.999, 2)
    assert average["weight"].item() == pytest.approx(1 - 0.1 * 3 / 12)


@pytest.mark.parametrize("decay", [0.0, 0.5, 0.99])
def test_against_a_weighted_sum(decay: float) -> None:
    values = torch.randn(40, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    average: dict[str, Tensor] = {"weight": values[0].clone()}
    for step, value in enumerate(values[1:]):
        follow(average, {"weight": value}, decay, step)
    expected, left = torch.zeros(3, dtype=torch.float64), 1.0
    for step in reversed(range(39)):
        kept = min(decay, (1 + step) / (10 + step))
        expected += left * (1 - kept) * values[step + 1]
        left *= kept
    torch.testing.assert_close(average["weight"], expected + left * values[0])


def test_what_is_not_in_the_average_is_left_out() -> None:
    average = {"head": torch.zeros(2)}
    follow(average, {"head": torch.ones(2), "backbone": torch.ones(2)}, 0.5, 100)
    assert list(average) == ["head"]
    assert average["head"].tolist() == [0.5, 0.5]
