"""Several trainings from one start, averaged to one network.

Networks that start at the same weights and see other views may end in one valley of the loss, where their
mean is better than each of them and costs no more to run. The best on val is the first; each of the others,
in the order of their scores, joins the mean if val is better for it (the greedy soup of Wortsman et al.,
"Model soups", ICML 2022), so that the mean is never worse on val than its best member.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch
from torch import Tensor

from mixlight.network import weights
from mixlight.training.config import TrainingConfig

if TYPE_CHECKING:
    from mixlight.training.loop import Run


def train_members(config: TrainingConfig, out: Path, start: Callable[[TrainingConfig], Run]) -> Path:
    """Trains every member in a folder of its own, and writes the mean of those that make it better.

    Args:
        config: of the whole; its `split_members` are trained one after the other, each resumable.
        out: the folder of the whole.
        start: makes the run of a member.

    Returns:
        The path of the model, in float16; its card says what it is on val, and what each member is.
    """
    states: list[dict[str, Tensor]] = []
    members: list[dict[str, Any]] = []
    for member in config.split_members():
        run = start(member)
        state, card = weights.load(run.finish())
        states.append(state)
        members.append({"views_seed": member.views_seed, "validation": card["validation"]})

    def validate(state: Mapping[str, Tensor]) -> dict[str, float]:
        weights.load_into(run.model, state, out)
        return run.validation.evaluate(run.model)

    chosen, metrics = choose(states, validate)
    for number, row in enumerate(members):
        row["averaged"] = number in chosen
    run.config, run.out = config, out
    run.write_config()
    return run.write(average([states[number] for number in chosen]), metrics, {"members": members})


def choose(
    states: Sequence[Mapping[str, Tensor]], validate: Callable[[Mapping[str, Tensor]], dict[str, float]]
) -> tuple[list[int], dict[str, float]]:
    """Which networks to average, greedily: the best, then each that makes the mean better.

    Args:
        states: weights of the networks.
        validate: gives the metrics of weights on val; the lower `score`, the better.

    Returns:
        Their numbers, the best first, and the metrics of their mean.
    """
    alone = [validate(state) for state in states]
    first, *rest = sorted(range(len(states)), key=lambda number: alone[number]["score"])
    chosen, best = [first], alone[first]
    for number in rest:
        found = validate(average([states[k] for k in (*chosen, number)]))
        if found["score"] < best["score"]:
            chosen, best = [*chosen, number], found
    return chosen, best


def average(states: Sequence[Mapping[str, Tensor]]) -> dict[str, Tensor]:
    """The mean of every tensor over networks of one shape, in float32; counters are those of the first.

    Args:
        states: `state_dict()` of each network; at least one.

    Raises:
        ValueError: no network, or networks with other tensors.

    >>> average([{"w": torch.tensor([1.0, 2.0])}, {"w": torch.tensor([3.0, 2.0])}])
    {'w': tensor([2., 2.])}
    """
    if not states:
        raise ValueError("expected at least one network to average, got none")
    first = {name: value.shape for name, value in states[0].items()}
    for state in states[1:]:
        if {name: value.shape for name, value in state.items()} != first:
            raise ValueError("expected networks with the same tensors, got networks that differ")
    return {
        name: torch.stack([state[name].float() for state in states]).mean(0)
        if value.is_floating_point()
        else value.clone()
        for name, value in states[0].items()
    }
