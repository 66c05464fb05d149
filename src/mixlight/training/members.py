"""Several trainings from one start, averaged to one network.

Networks that start at the same weights and see other views may end in one valley of the loss, where their
mean is better than each of them and costs no more to run. The best on val is the first; each of the others,
in the order of their scores, joins the mean if val is better for it (the greedy soup of Wortsman et al.,
"Model soups", ICML 2022), so that the mean is never worse on val than its best member.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch
from torch import Tensor

from mixlight.network import weights
from mixlight.training import checkpoint as checkpoints
from mixlight.training.config import TrainingConfig
from mixlight.training.log import FILE_NAME
from mixlight.training.validation import ValidationSet

if TYPE_CHECKING:
    from mixlight.training.loop import Run


def prepare(out: Path, resume: bool, *, single: bool = False) -> None:
    """Makes sure that a folder can take members, or a single run.

    Args:
        out: the folder of the run.
        resume: keep what was begun; else none of it stays.
        single: a single run is to come, no members.

    Raises:
        ValueError: the folder holds the other kind.
    """
    lone, members = out / checkpoints.FILE_NAME, list(out.glob(f"member-*/{checkpoints.FILE_NAME}"))
    if not resume:
        for old in (lone, *members):
            old.unlink(missing_ok=True)
    elif members if single else lone.is_file():
        held, wanted = "a single run", "several members are"
        if single:
            held, wanted = "a run of several members", "a single one is"
        raise ValueError(
            f"{out}: holds {held}, and {wanted} asked for; choose another folder, or start anew (--fresh)"
        )


def train_members(
    config: TrainingConfig,
    out: Path,
    start: Callable[[TrainingConfig, Path, ValidationSet | None], Run],
) -> Path:
    """Trains every member in a folder of its own, and writes the mean of those that make it better.

    Args:
        config: of the whole; its `split_members` are trained one after the other, each resumable.
        out: the folder of the whole; member k's is `member-k` in it.
        start: makes the run of a member in a folder, with the validation set of the one before.

    Returns:
        The path of the model, in float16; its card says what it is on val, and of each member what it is
        there, which commit began to train it, and whether it is part of the mean.
    """
    states: list[dict[str, Tensor]] = []
    members: list[dict[str, Any]] = []
    run: Run | None = None
    for member in config.split_members():
        validation = run.validation if run else None
        run = None  # its panoramas leave memory before the next one's come
        run = start(member, out / f"member-{member.member}", validation)
        state, card = weights.load(run.finish())
        states.append(state)
        members.append(
            {
                "views_seed": member.views_seed,
                "commit": begun_by(run.out),
                "validation": card["validation"],
            }
        )
    assert run is not None
    whole = run

    def validate(state: Mapping[str, Tensor]) -> dict[str, float]:
        weights.load_into(whole.model, state, out)
        return whole.validation.evaluate(whole.model)

    chosen, metrics = choose(states, validate)
    for number, row in enumerate(members):
        row["averaged"] = number in chosen
    whole.config, whole.out = config, out
    whole.write_config()
    return whole.write(average([states[number] for number in chosen]), metrics, {"members": members})


def begun_by(folder: Path) -> str:
    """The commit that began a run, by its log; `unknown` where the log does not say."""
    lines = (folder / FILE_NAME).read_text(encoding="utf-8").splitlines()
    starts = [record for record in map(json.loads, lines) if record["kind"] == "start"]
    return str(starts[0]["commit"]) if starts else "unknown"


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
