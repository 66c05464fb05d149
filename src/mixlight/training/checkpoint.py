"""Checkpoints of a training run: safetensors, written atomically, never pickled."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import Tensor, optim

from mixlight.image.atomic import atomic_path

FILE_NAME = "checkpoint.safetensors"


@dataclass
class Checkpoint:
    """All that a run needs to go on as if it had never stopped."""

    step: int
    """Number of steps done."""
    model: dict[str, Tensor]
    """The trained weights."""
    average: dict[str, Tensor]
    """Their moving average."""
    best: dict[str, Tensor]
    """The averaged weights with the best validation score so far; empty before the first validation."""
    optimiser: dict[str, Tensor]
    """The optimiser's state, flattened to `<parameter index>.<name>`."""
    notes: dict[str, Any]
    """JSON values: config, best score and metrics, log length."""


def save(path: Path, checkpoint: Checkpoint) -> None:
    """Writes a checkpoint in one piece: a killed run leaves the old one or the new one."""
    tensors = {}
    for part in ("model", "average", "best", "optimiser"):
        for key, value in getattr(checkpoint, part).items():
            # clone: safetensors refuses tensors that share memory
            tensors[f"{part}/{key}"] = value.detach().clone(memory_format=torch.contiguous_format)
    metadata = {"step": str(checkpoint.step), "notes": json.dumps(checkpoint.notes)}
    with atomic_path(path) as temporary:
        save_file(tensors, temporary, metadata=metadata)


def load(path: Path) -> Checkpoint:
    """Reads a checkpoint.

    Raises:
        ValueError: the file is not a checkpoint of this program.
    """
    parts: dict[str, dict[str, Tensor]] = {"model": {}, "average": {}, "best": {}, "optimiser": {}}
    try:
        with safe_open(path, "pt") as stored:
            metadata = stored.metadata() or {}
            for key in stored.keys():  # noqa: SIM118 - not a dict
                part, _, name = key.partition("/")
                parts[part][name] = stored.get_tensor(key)
        step, notes = int(metadata["step"]), json.loads(metadata["notes"])
    except (SafetensorError, KeyError, ValueError) as error:
        raise ValueError(f"{path}: expected a training checkpoint, {error}") from error
    return Checkpoint(step, notes=notes, **parts)


def flatten_optimiser(optimiser: optim.Optimizer) -> dict[str, Tensor]:
    """The optimiser's per-parameter tensors under `<parameter index>.<name>`."""
    state = optimiser.state_dict()["state"]
    return {f"{index}.{name}": torch.as_tensor(v) for index, slot in state.items() for name, v in slot.items()}


def restore_optimiser(optimiser: optim.Optimizer, flat: dict[str, Tensor]) -> None:
    """Puts flattened state back into an optimiser over the same parameters."""
    state: dict[int, dict[str, Tensor]] = {}
    for key, value in flat.items():
        index, _, name = key.partition(".")
        state.setdefault(int(index), {})[name] = value
    optimiser.load_state_dict({"state": state, "param_groups": optimiser.state_dict()["param_groups"]})
