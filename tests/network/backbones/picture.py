"""The picture that golden values were computed from."""

import torch
from torch import Tensor


def waves(height: int, width: int) -> Tensor:
    """[1, 3, height, width] in [0, 1]: plane waves, another one in each channel."""
    row = torch.arange(height, dtype=torch.float64)[:, None]
    column = torch.arange(width, dtype=torch.float64)
    phase = [0.05 * (channel + 1) * row + 0.08 * column + channel for channel in range(3)]
    return (0.5 + 0.5 * torch.sin(torch.stack(phase)))[None].float()
