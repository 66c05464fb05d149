"""The camera's pose, fitted anew when the light is done.

A run keeps the weights of the step at which the light is best on val, which may come long before the
camera's pose has been learnt. The last layer is linear, so its two rows for pitch and roll have a best value
for the hidden layer of those very weights: ridge regression, in closed form, which leaves every other output
as it is.
"""

from __future__ import annotations

from collections.abc import Iterable

import torch
from torch import nn

from mixlight.data.training_set import Batch
from mixlight.network.heads import CAMERA
from mixlight.network.methods import AnyNet
from mixlight.network.model import mean_linear_colour
from mixlight.training.features import FeatureBatch

_RIDGE = 0.1
"""Weight of the rows' squares, in mean variances of a hidden unit times views."""


@torch.no_grad()
def fit_camera(model: AnyNet, batches: Iterable[Batch | FeatureBatch]) -> None:
    """Sets the last two rows of a network's last layer, pitch and roll, to the ridge regression on views.

    Args:
        model: the network; left in evaluation mode.
        batches: training views, with the camera's pose in radians.

    Raises:
        ValueError: no view.
    """
    model.eval()
    device = next(model.parameters()).device
    layers, poses = [], []
    for batch in batches:
        if isinstance(batch, FeatureBatch):
            features, mean = batch.features.to(device), batch.mean.to(device)
        else:
            photo = batch.photo.to(device)
            features, mean = model.backbone(photo), mean_linear_colour(photo)
        layers.append(model.heads.hidden(features, mean).double().cpu())
        poses.append(batch.camera.double())
    if not layers:
        raise ValueError("expected views to fit the camera's pose to, got none")
    hidden, pose = torch.cat(layers), torch.cat(poses)
    # Centred, so that the offsets stay free.
    centre, level = hidden.mean(0), pose.mean(0)
    spread = hidden - centre
    normal = spread.T @ spread
    normal += _RIDGE * normal.diagonal().mean().clamp(min=1e-12) * torch.eye(len(normal), dtype=torch.float64)
    rows = torch.linalg.solve(normal, spread.T @ (pose - level))
    last: nn.Linear = model.heads.outputs
    last.weight[-CAMERA:] = rows.T.to(last.weight)
    last.bias[-CAMERA:] = (level - centre @ rows).to(last.bias)
