"""Several trainings from one start, averaged to one network.

Networks that start at the same weights and see other views end in one valley of the loss, where their mean
is about as good as their ensemble, and costs no more to run than one (Wortsman et al., "Model soups", ICML
2022).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import torch
from torch import Tensor

from mixlight.network import weights
from mixlight.training.card import make_card
from mixlight.training.config import TrainingConfig

if TYPE_CHECKING:
    from mixlight.training.loop import Run


def train_members(
    config: TrainingConfig, out: Path, start: Callable[[TrainingConfig, Path], Run], model_file: str
) -> Path:
    """Trains every member in a folder of its own, and writes their average.

    Args:
        config: of the whole; its `split_members` are trained one after the other, each resumable.
        out: the folder of the whole; member k's is `member-k` in it.
        start: makes the run of a member in its folder.
        model_file: name of the file of weights.

    Returns:
        The path of the average, in float16; its card says what it is on val, and what each member is.
    """
    states, members = [], []
    for member in config.split_members():
        run = start(member, out / f"member-{member.member}")
        state, card = weights.load(run.finish())
        states.append(state)
        members.append({"views_seed": member.views_seed, "validation": card["validation"]})
    weights.load_into(run.model, average(states), out)
    found = run.validation.evaluate(run.model)
    path = out / model_file
    card = make_card(config, run.training_set.records, found)
    weights.save(path, run.model.state_dict(), card | {"members": members}, half=True)
    return path


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
