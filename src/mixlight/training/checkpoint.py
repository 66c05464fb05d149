"""Checkpoints of a training run: safetensors, written in one piece, never pickled."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as to_bytes
from torch import Tensor, optim

from mixlight.image.atomic import atomic_path

FILE_NAME = "checkpoint.safetensors"
_PARTS = ("model", "average", "best", "optimiser")


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
    """JSON values: at least the config and the metrics of the best weights."""


def save(path: Path, checkpoint: Checkpoint) -> None:
    """Writes a checkpoint in one piece and to the disk: a run that is killed, or loses its power, leaves the
    old one or the new one.

    Raises:
        OSError: the folder is missing or full, or may not be written to.
    """
    tensors = {}
    for part in _PARTS:
        for key, value in getattr(checkpoint, part).items():
            # clone: safetensors refuses tensors that share memory
            tensors[f"{part}/{key}"] = value.detach().clone(memory_format=torch.contiguous_format)
    metadata = {"step": str(checkpoint.step), "notes": json.dumps(checkpoint.notes)}
    with atomic_path(path, durable=True) as temporary:
        temporary.write_bytes(to_bytes(tensors, metadata=metadata))


def load(path: Path) -> Checkpoint:
    """Reads a checkpoint, onto the CPU.

    Raises:
        ValueError: the file is not a checkpoint of this program; the message names it.
        OSError: the file is missing or may not be read.
    """
    parts: dict[str, dict[str, Tensor]] = {part: {} for part in _PARTS}
    try:
        with safe_open(path, "pt") as stored:
            metadata = stored.metadata() or {}
            for key in stored.keys():  # noqa: SIM118 - not a dict
                part, _, name = key.partition("/")
                if part not in parts:
                    raise ValueError(f"a tensor {key!r}")
                parts[part][name] = stored.get_tensor(key)
        missing = sorted({"step", "notes"} - metadata.keys())
        if missing:
            raise ValueError(f"a file without {' and '.join(missing)}")
        step, notes = int(metadata["step"]), json.loads(metadata["notes"])
        if not parts["model"] or not isinstance(notes, dict):
            raise ValueError("a file without weights or notes")
    except (SafetensorError, ValueError) as error:
        raise ValueError(f"{path}: expected a training checkpoint, got {error}") from error
    return Checkpoint(step, notes=notes, **parts)


def remove_leftovers(path: Path) -> None:
    """Deletes what a run that was killed while it wrote this checkpoint has left beside it."""
    for leftover in path.parent.glob(f".{path.stem}.*.part{path.suffix}"):
        leftover.unlink(missing_ok=True)


def flatten_optimiser(optimiser: optim.Optimizer) -> dict[str, Tensor]:
    """The optimiser's per-parameter tensors under `<parameter index>.<name>`."""
    state = optimiser.state_dict()["state"]
    return {
        f"{index}.{name}": torch.as_tensor(value)
        for index, slot in state.items()
        for name, value in slot.items()
    }


@torch.no_grad()
def restore_optimiser(optimiser: optim.Optimizer, flat: dict[str, Tensor]) -> None:
    """Puts flattened state back into an optimiser over the same parameters."""
    state: dict[int, dict[str, Tensor]] = {}
    parameters = [p for group in optimiser.param_groups for p in group["params"]]
    for key, value in flat.items():
        index, _, name = key.partition(".")
        parameter = parameters[int(index)]
        if value.shape == parameter.shape:
            # Files hold rows after rows; a fused optimiser needs the parameter's own order in memory.
            value = torch.empty_like(parameter).copy_(value)
        state.setdefault(int(index), {})[name] = value
    optimiser.load_state_dict({"state": state, "param_groups": optimiser.state_dict()["param_groups"]})
