import re

import pytest
import torch
from torch import Tensor

from mixlight.network import backbones
from mixlight.network.backbones import DenseNet121, from_torchvision
from tests.network.backbones.picture import waves


def norm(name: str, channels: int) -> dict[str, tuple[int, ...]]:
    leaves = ("weight", "bias", "running_mean", "running_var")
    return {f"{name}.{leaf}": (channels,) for leaf in leaves} | {f"{name}.num_batches_tracked": ()}


def expected_shapes() -> dict[str, tuple[int, ...]]:
    """Names and shapes that the published architecture has under torchvision's names."""
    shapes: dict[str, tuple[int, ...]] = {"features.conv0.weight": (64, 3, 7, 7)} | norm("features.norm0", 64)
    channels = 64
    for block, layers in enumerate((6, 12, 24, 16), start=1):
        for layer in range(1, layers + 1):
            name = f"features.denseblock{block}.denselayer{layer}"
            shapes |= norm(f"{name}.norm1", channels) | {f"{name}.conv1.weight": (128, channels, 1, 1)}
            shapes |= norm(f"{name}.norm2", 128) | {f"{name}.conv2.weight": (32, 128, 3, 3)}
            channels += 32
        if block < 4:
            name = f"features.transition{block}"
            shapes |= norm(f"{name}.norm", channels) | {
                f"{name}.conv.weight": (channels // 2, channels, 1, 1)
            }
            channels //= 2
    return shapes | norm("features.norm5", channels)


def sine_state(module: DenseNet121) -> dict[str, Tensor]:
    """Weights that a formula gives, so that golden values need no file."""
    state = {}
    for index, (name, value) in enumerate(sorted(module.state_dict().items())):
        wave = torch.sin(torch.arange(value.numel(), dtype=torch.float64) * 0.7 + index).view(value.shape)
        if value.ndim == 4:
            wave = wave * (0.5 / value[0].numel()) ** 0.5
        elif name.endswith("running_var"):
            wave = 1 + 0.5 * wave
        elif name.endswith("weight"):
            wave = 1 + 0.2 * wave
        elif name.endswith("num_batches_tracked"):
            wave = torch.tensor(0)
        else:
            wave = 0.1 * wave
        state[name] = wave.to(value.dtype)
    return state


@pytest.fixture(scope="module")
def sine() -> DenseNet121:
    backbone = DenseNet121().eval()
    backbone.load_state_dict(sine_state(backbone))
    return backbone


def test_names_and_shapes_are_torchvisions():
    backbone = DenseNet121()
    assert {name: tuple(value.shape) for name, value in backbone.state_dict().items()} == expected_shapes()
    assert sum(parameter.numel() for parameter in backbone.parameters()) == 6_953_856


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        (
            (96, 128),
            [
                [0.9861, 1.25281, 1.23631, 0.97027],
                [0.48223, 0.60032, 0.59916, 0.48147],
                [0.9688, 1.23862, 1.25799, 0.98817],
            ],
        ),
        ((75, 90), [[1.01743, 1.05713], [0.98059, 1.02075]]),
    ],
)
def test_golden(sine, size, expected):
    # Means over channels from torchvision 0.29's network with the same weights.
    with torch.no_grad():
        features = sine(waves(*size))
    assert features.shape[:2] == (1, 1024)
    torch.testing.assert_close(features[0].mean(0), torch.tensor(expected), rtol=0, atol=2e-5)


def test_published_state_dicts_of_both_releases_load(sine):
    state = sine.state_dict()
    classifier = {"classifier.weight": torch.zeros(1000, 1024), "classifier.bias": torch.zeros(1000)}
    first = {
        re.sub(r"(denselayer\d+\.(?:norm|relu|conv))([12])\.", r"\1.\2.", name): value
        for name, value in state.items()
        if not name.endswith("num_batches_tracked")
    }
    assert "features.denseblock1.denselayer1.norm.1.weight" in first
    for published in (state, first):
        backbone = DenseNet121()
        backbone.load_state_dict(from_torchvision({**published, **classifier}))
        for name, value in backbone.state_dict().items():
            assert torch.equal(value, state[name])


def test_every_parameter_learns_and_dropout_acts_in_training_only(sine):
    backbone = DenseNet121(drop_rate=0.5)
    backbone.load_state_dict(sine.state_dict())
    picture = waves(64, 64).expand(2, -1, -1, -1)
    with torch.no_grad():
        torch.testing.assert_close(backbone.eval()(picture), sine(picture))
    features = backbone.train()(picture)
    assert not torch.allclose(features[0], features[1])
    features.square().mean().backward()
    for name, parameter in backbone.named_parameters():
        assert parameter.grad is not None, name
        assert parameter.grad.abs().sum() > 0, name


def test_bad_input(sine):
    with pytest.raises(ValueError, match="expected drop_rate in"):
        DenseNet121(drop_rate=1.0)
    with pytest.raises(ValueError, match=r"received \[3, 32, 32\]"):
        DenseNet121.forward.__wrapped__(sine, torch.zeros(3, 32, 32))
    with pytest.raises(ValueError, match="no ImageNet weights ship"):
        backbones.create("densenet121")
