"""Where tables end up: they are computed in float64 on the CPU, and cast and moved last."""

import torch
from torch import Tensor


def place(table: Tensor, dtype: torch.dtype, device: torch.device | str | None) -> Tensor:
    """Cast a table and move it to a device; None means the default device, as for `torch.zeros`."""
    return table.to(device=torch.get_default_device() if device is None else device, dtype=dtype)
