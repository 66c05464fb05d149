"""What the tests of training/ share."""

from collections.abc import Iterator

import pytest
from torch import Tensor, nn

from mixlight.network import backbones
from mixlight.render.spheres import SphereRenderer


class TinyBackbone(backbones.Backbone):
    """Three convolutions, so that a run takes less than a second."""

    channels = 12

    def __init__(self) -> None:
        super().__init__()
        widths = (3, 6, 8, self.channels)
        self.layers = nn.Sequential()
        for k, stride in enumerate((4, 4, 2)):
            self.layers.append(nn.Conv2d(widths[k], widths[k + 1], 3, stride, 1, bias=False))
            self.layers.append(nn.BatchNorm2d(widths[k + 1]))
            self.layers.append(nn.ReLU())

    def forward(self, picture: Tensor) -> Tensor:
        features: Tensor = self.layers(2 * picture - 1)
        return features


@pytest.fixture(scope="session")
def renderer() -> SphereRenderer:
    """Small spheres, built once."""
    return SphereRenderer(resolution=16, height=32)


@pytest.fixture(scope="module")
def quick(renderer: SphereRenderer) -> Iterator[None]:
    """Runs know a tiny backbone and validate with small spheres."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mixlight.training.validation.SphereRenderer", lambda resolution: renderer)
        patch.setitem(backbones._BACKBONES, "tiny", TinyBackbone)
        yield
