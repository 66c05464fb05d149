"""Learning-rate schedule, the split of parameters into groups, and what is not trained."""

from __future__ import annotations

import math

from torch import nn, optim

from mixlight.network.methods import AnyNet
from mixlight.training.config import OptimiserSettings


def rate_share(step: int, steps: int, settings: OptimiserSettings) -> float:
    """Share of the peak rate at a step: linear warm-up, then half a cosine down to `final_share`.

    Args:
        step: number of steps done before this one.
        steps: number of steps of the run.
        settings: warm-up and final share.

    >>> settings = OptimiserSettings(warmup_steps=10, final_share=0.0)
    >>> [round(rate_share(step, 110, settings), 3) for step in (0, 9, 10, 60, 110)]
    [0.1, 1.0, 1.0, 0.5, 0.0]
    """
    if step < settings.warmup_steps:
        return (step + 1) / settings.warmup_steps
    progress = (step - settings.warmup_steps) / max(1, steps - settings.warmup_steps)
    cosine = 0.5 * (1 + math.cos(math.pi * min(1.0, progress)))
    return settings.final_share + (1 - settings.final_share) * cosine


def freeze(model: AnyNet, settings: OptimiserSettings) -> None:
    """Takes the first `frozen_share` of the backbone's parameter tensors, from the input on, out of
    training.
    """
    tensors = list(model.backbone.parameters())
    for tensor in tensors[: round(settings.frozen_share * len(tensors))]:
        tensor.requires_grad_(False)


def make_optimiser(model: AnyNet, settings: OptimiserSettings) -> optim.Optimizer:
    """Adam or AdamW over four groups: backbone and heads, with and without decay.

    Each group carries its peak rate as `peak`; vectors (biases, norms) have no weight decay.
    """
    groups = []
    for module, peak in (
        (model.backbone, settings.backbone_rate),
        (model.heads, settings.learning_rate),
    ):
        trained = [p for p in module.parameters() if p.requires_grad]
        matrices = [p for p in trained if p.ndim > 1]
        vectors = [p for p in trained if p.ndim <= 1]
        for tensors, decay in ((matrices, settings.weight_decay), (vectors, 0.0)):
            if tensors:
                groups.append({"params": tensors, "lr": peak, "peak": peak, "weight_decay": decay})
    kind = optim.AdamW if settings.name == "adamw" else optim.Adam
    # Fused: one pass over each tensor instead of a dozen.
    return kind(groups, betas=(0.9, 0.99), fused=True)


def set_rate(optimiser: optim.Optimizer, share: float) -> None:
    """Sets every group's rate to a share of its peak."""
    for group in optimiser.param_groups:
        group["lr"] = share * group["peak"]


def set_training_mode(model: AnyNet, settings: OptimiserSettings) -> None:
    """Training mode; batch norms of the backbone keep their statistics where the settings say so.

    Their scales and offsets are trained all the same.
    """
    model.train()
    if settings.freeze_norms:
        for module in model.backbone.modules():
            if isinstance(module, nn.BatchNorm2d):
                module.eval()
