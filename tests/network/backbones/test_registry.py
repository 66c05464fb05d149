import pytest
import torch

from mixlight.network import backbones


@pytest.mark.parametrize("name", backbones.names())
def test_one_interface(name):
    backbone = backbones.create(name, pretrained=False).eval()
    with torch.no_grad():
        features = backbone(torch.full((2, 3, 64, 96), 0.5))
    assert features.shape == (2, backbone.channels, 2, 3)
    assert features.isfinite().all()
    folded = backbone.train().folded()
    assert not folded.training
    torch.testing.assert_close(folded(torch.full((2, 3, 64, 96), 0.5)), features, rtol=1e-4, atol=1e-4)


def test_options_reach_the_backbone():
    assert backbones.create("efficientnet_lite0", pretrained=False, drop_path=0.2).blocks[-2].drop > 0


def test_unknown_name():
    with pytest.raises(
        ValueError, match="expected a backbone out of densenet121, efficientnet_lite0, received 'vgg'"
    ):
        backbones.create("vgg")
