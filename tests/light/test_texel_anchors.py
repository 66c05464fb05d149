import pytest
import torch

from mixlight.light.texel_anchors import TexelAnchors
from mixlight.sphere.equirect import pixel_directions
from mixlight.sphere.points import nearest, vogel


@pytest.mark.parametrize("anchors", [1, 2, 3, 17, 128, 500])
@pytest.mark.parametrize("height", [1, 5, 100, 128, 300])
def test_is_the_nearest(anchors: int, height: int) -> None:
    texels = torch.arange(2 * height * height)
    expected = nearest(
        vogel(anchors, dtype=torch.float64), pixel_directions(height, dtype=torch.float64).reshape(-1, 3)
    )
    assert torch.equal(TexelAnchors(anchors, height, 2 * height)(texels), expected)


def test_no_texels() -> None:
    assert TexelAnchors(128, 64, 128)(torch.zeros(0, dtype=torch.int64)).shape == (0,)


def test_the_shared_table_is_left_alone() -> None:
    texels = torch.arange(64 * 128)
    first = TexelAnchors(128, 64, 128)(texels)
    first.zero_()
    assert TexelAnchors(128, 64, 128)(texels).max() == 127
