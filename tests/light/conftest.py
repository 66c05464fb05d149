"""What the tests of light/ share."""

import pytest
import torch
from torch import Tensor


@pytest.fixture
def room(generator: torch.Generator) -> Tensor:
    """[64, 128, 3] float32: an uneven surround, a window and two lamps, with a range of about 1 to 3000."""
    panorama = 0.1 + torch.rand(64, 128, 3, generator=generator)
    panorama[20:30, 30:40] *= 40
    panorama[8:10, 90:93] *= torch.tensor([900.0, 700.0, 400.0])
    panorama[40, 5] *= 3000
    return panorama
