"""The network as one self-contained ONNX file: a canonical view in, light out.

The graph holds everything from the sRGB photo to the numbers of the light, SLSparsemax included. Two things
stay outside, on purpose: bringing a photo of any shape into the network's canonical view, and drawing the
environment map. `onnx_web.mjs`, which is written beside the model, does both for JavaScript.
"""

from __future__ import annotations

import copy
import json
import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mixlight import __version__
from mixlight.export.onnx_precision import PRECISIONS, Precision, store
from mixlight.image.atomic import atomic_path
from mixlight.network.estimator import Estimator, kept_energy
from mixlight.network.model import MixLightNet

if TYPE_CHECKING:
    from onnx import ModelProto

__all__ = ["INPUT", "MODEL_FILE", "OPSET", "OUTPUTS", "PRECISIONS", "SCRIPT_FILE", "to_onnx", "write"]

INPUT = "photo"
"""Name of the graph's input, [batch, 3, height, width]."""

OUTPUTS = ("ambient", "anchor_energy", "camera")
"""Names of the graph's outputs: [batch, 9, 3], [batch, anchors, 3] and [batch, 2]."""

OPSET = 18
"""Version of ONNX's operators; every runtime since the beginning of 2023 knows it."""

FORMAT = "mixlight/onnx"
VERSION = 1

MODEL_FILE = "mixlight.onnx"
SCRIPT_FILE = "mixlight.mjs"

_TEMPLATE = Path(__file__).with_name("onnx_web.mjs")
_CONSTANTS = re.compile(r"^export const MODEL = .*;$", re.MULTILINE)
"""The one line of the script that an export writes anew."""


class _PhotoToLight(nn.Module):
    """What the graph computes: the numbers of `Estimator.estimate`, as plain tensors."""

    def __init__(self, model: MixLightNet) -> None:
        super().__init__()
        self.model = model

    def forward(self, photo: Float[Tensor, "batch 3 height width"]) -> tuple[Tensor, Tensor, Tensor]:
        prediction = self.model(photo)
        return prediction.ambient, kept_energy(prediction), prediction.camera


def to_onnx(estimator: Estimator, precision: Precision = "float32") -> ModelProto:
    """Return a trained network as an ONNX model whose batch size is free.

    Input `photo` [batch, 3, height, width]: canonical views (`Estimator.view`), RGB, sRGB-encoded, in [0, 1].
    Outputs, as `Estimator.estimate` gives them: `ambient` [batch, 9, 3], radiance SH; `anchor_energy`
    [batch, anchors, 3], integrated radiance of the lobe on each anchor, most of them 0; `camera` [batch, 2],
    pitch (up) and roll (clockwise) in radians. All are float32, whatever the weights are stored in.

    Frame, units, the canonical view and the model's name and commit stand in the model's metadata; nothing
    there tells of the machine that exported. The same weights give the same bytes with the same versions.

    Args:
        estimator: the trained network; it is not changed.
        precision: how weights are stored, one of `PRECISIONS`.

    Convention: +X right, +Y up, -Z forward, where -Z is the photo's azimuth; radiance 1.0 is the photo's
        linear white. Light in `anchor_energy[b, 0]` comes from (0, .992, -.125), nearly overhead: anchors go
        from the zenith to the nadir (`mixlight.sphere.points.vogel`).

    Raises:
        ImportError: the packages of the extra `onnx` are missing.
        ValueError: unknown precision.
    """
    if precision not in PRECISIONS:
        raise ValueError(f"expected a precision out of {', '.join(PRECISIONS)}, received {precision!r}")
    _require()
    settings = estimator.model.settings
    graph = _PhotoToLight(copy.deepcopy(estimator.model).cpu().float()).eval()
    # Two photos, because the exporter takes a batch of one for a constant.
    example = torch.full((2, 3, settings.height, settings.width), 0.5)
    with _quiet(), torch.no_grad():
        program = torch.onnx.export(
            graph,
            (example,),
            dynamo=True,
            opset_version=OPSET,
            external_data=False,
            input_names=[INPUT],
            output_names=list(OUTPUTS),
            dynamic_shapes={INPUT: {0: torch.export.Dim("batch")}},
            verbose=False,
        )
    assert program is not None  # with `dynamo` there is always a program
    proto: ModelProto = program.model_proto
    _clean(proto)
    store(proto, precision)
    proto.producer_name, proto.producer_version = "mixlight", __version__
    for key, value in sorted(metadata(estimator, precision).items()):
        proto.metadata_props.add(key=key, value=value)
    return proto


def metadata(estimator: Estimator, precision: Precision) -> dict[str, str]:
    """What the file says of itself, as ONNX holds it: text under text; structures are JSON.

    >>> from mixlight.network.estimator import Estimator
    >>> said = metadata(Estimator.load(), "float32")
    >>> said["units"], json.loads(said["photo"])["fov_deg"]
    ("radiance 1.0 is the photo's linear white", 60.0)
    """
    settings, card = estimator.model.settings, estimator.card
    photo = {
        "layout": "NCHW",
        "channels": "RGB",
        "encoding": "sRGB",
        "range": [0, 1],
        "height": settings.height,
        "width": settings.width,
        "fov_deg": settings.fov_deg,
        "projection": "pinhole around the photo's optical axis",
        "outside": "mean linear colour of the part that the photo covers",
    }
    ambient = {
        "kind": "radiance",
        "basis": "real orthonormal spherical harmonics, no Condon-Shortley sign",
        "order": "l*l+l+m",
        "degree": 2,
        "channels": "RGB, linear Rec.709",
    }
    energy = {
        "kind": "integrated radiance of each lobe (radiance times steradian)",
        "anchors": settings.anchors,
        "directions": "d = (r sin a, y, -r cos a), y = 1 - (2 i + 1) / anchors, r = sqrt(1 - y y), "
        "a = i pi (3 - sqrt 5)",
        "lobe": "energy q exp((d.u - 1) / s), q = 1 / (2 pi s (1 - exp(-2 / s)))",
        "sharpness": settings.sharpness,
        "channels": "RGB, linear Rec.709",
    }
    camera = {"order": ["pitch", "roll"], "unit": "radian", "sign": "pitch up, roll clockwise"}
    model = {key: card[key] for key in ("name", "commit", "versions") if key in card}
    structures = {
        "photo": photo,
        "ambient": ambient,
        "anchor_energy": energy,
        "camera": camera,
        "model": model,
    }
    return {
        "format": FORMAT,
        "version": str(VERSION),
        "software": f"mixlight {__version__}",
        "frame": str(card.get("frame", "mixlight: +X right, +Y up, -Z forward")),
        "units": str(card.get("units", "radiance 1.0 is the photo's linear white")),
        "licence": str(card.get("licence", "unknown")),
        "precision": precision,
        **{key: json.dumps(value, sort_keys=True, default=str) for key, value in structures.items()},
    }


def write(source: str | Path | Estimator, folder: Path, precision: Precision = "float32") -> list[Path]:
    """Write the model, the script that decodes its light in JavaScript, and README.txt.

    Args:
        source: a shipped model's name, a weights file, or a loaded estimator.
        folder: existing folder.
        precision: how weights are stored, one of `PRECISIONS`.

    Returns:
        `mixlight.onnx`, `mixlight.mjs` and `README.txt` in the folder.

    Raises:
        WeightsError: unknown, missing or corrupt weights.
        ImportError: the packages of the extra `onnx` are missing.
        ValueError: unknown precision.
        OSError: the folder cannot be written to.
    """
    estimator = source if isinstance(source, Estimator) else Estimator.load(source)
    settings = estimator.model.settings
    shape = f"[batch,3,{settings.height},{settings.width}]"
    data = to_onnx(estimator, precision).SerializeToString(deterministic=True)
    texts = {
        SCRIPT_FILE: _script(estimator, precision),
        "README.txt": (
            f"Load {MODEL_FILE} with onnxruntime (Python, C++, C#, Java) or, beside {SCRIPT_FILE}, with "
            "onnxruntime-web (JavaScript); it is one file and needs no other.\n"
            f"Input {INPUT} {shape} is the canonical view, sRGB in [0,1]; "
            f"outputs {', '.join(OUTPUTS)}; frame, units and layout stand in the model's metadata.\n"
            "Checked against PyTorch in onnxruntime and in onnxruntime-web (WebAssembly, Node); maps of the "
            f"light are drawn by {SCRIPT_FILE} or by the mixlight package.\n"
        ),
    }
    with atomic_path(folder / MODEL_FILE) as temporary:
        temporary.write_bytes(data)
    for name, text in texts.items():
        with atomic_path(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return [folder / name for name in (MODEL_FILE, *texts)]


def _script(estimator: Estimator, precision: Precision) -> str:
    """The JavaScript module with this model's constants in it."""
    settings = estimator.model.settings
    constants = {
        "name": str(estimator.card.get("name", "unknown")),
        "precision": precision,
        "height": settings.height,
        "width": settings.width,
        "fovDeg": settings.fov_deg,
        "anchors": settings.anchors,
        "sharpness": settings.sharpness,
    }
    line = f"export const MODEL = {json.dumps(constants)};"
    text, count = _CONSTANTS.subn(lambda _: line, _TEMPLATE.read_text(encoding="utf-8"))
    assert count == 1, f"expected one line of constants in {_TEMPLATE.name}, found {count}"
    return text


def _clean(proto: ModelProto) -> None:
    """Take out what the exporter says of itself: stack traces with the paths of this machine, for one."""
    for owner in (proto, proto.graph, *proto.graph.node, *proto.graph.value_info, *proto.graph.input):
        owner.ClearField("metadata_props")
        owner.ClearField("doc_string")
    for owner in (*proto.graph.output, *proto.graph.initializer):
        owner.ClearField("metadata_props")
        owner.ClearField("doc_string")
    proto.graph.name = "mixlight"
    del proto.graph.value_info[:]  # shapes between the nodes: runtimes infer them


@contextmanager
def _quiet() -> Iterator[None]:
    """Silences what the exporter says of packages that it looks for and we do not need."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            # From torch's own use of its deprecated parts.
            warnings.filterwarnings("ignore", category=FutureWarning)
            warnings.filterwarnings("ignore", category=DeprecationWarning)
            yield
    finally:
        logger.setLevel(level)


def _require() -> None:
    """Raise an error that names the extra unless its packages are there."""
    try:
        import onnx  # noqa: F401
        import onnxscript  # noqa: F401
    except ImportError as error:
        raise ImportError(
            f'the ONNX export needs onnx and onnxscript ({error}): pip install "mixlight[onnx]"'
        ) from error
