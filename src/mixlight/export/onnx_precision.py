"""How an ONNX file holds its weights: whole, as half floats, or as bytes with a step for each channel.

Weights are narrowed in the file alone. Nodes at the head of the graph widen them back, and runtimes do so
once, when they load the model (constant folding): it computes in float32 everywhere, as fast as before, and
needs no operators that a browser lacks. What that costs in accuracy is measured by
`experiments/onnx_variants.py`, beside the variants that compute in low precision and are not offered.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from jaxtyping import Float, Int8

if TYPE_CHECKING:
    from onnx import ModelProto, NodeProto, TensorProto

__all__ = ["PRECISIONS", "Precision", "quantise", "store"]

Precision = Literal["float32", "float16", "int8"]

PRECISIONS: tuple[str, ...] = get_args(Precision)
"""What `store` knows; the first is the default."""

_SMALLEST = 256
"""Tensors of fewer numbers stay as they are: narrowing them saves nothing."""

_LARGE = 50_000
"""Tensors of fewer numbers are held as half floats with `int8` too: the kernels that filter each channel
alone, and the last layer, are a tenth of the file and most of the error."""


def quantise(
    weights: Float[np.ndarray, "*shape"], axis: int
) -> tuple[Int8[np.ndarray, "*shape"], Float[np.ndarray, "*scales"]]:
    """Round weights to whole multiples, -127 to 127, of a step that each slice along one axis has for itself.

        step = max |w| / 127 over the slice,  q = round(w / step)

    The error of a weight is at most half a step; 0 stays 0.

    Args:
        weights: any shape, finite.
        axis: the axis of the slices: a kernel's output channels.

    Returns:
        q as int8 and the steps, float32, of a shape that broadcasts against it. A slice of zeros has step 1.

    Raises:
        ValueError: weights that are not finite.

    >>> q, step = quantise(np.array([[1.27, -0.5], [0.0, 0.0]], dtype=np.float32), axis=0)
    >>> q.tolist(), step[:, 0].round(4).tolist()
    ([[127, -50], [0, 0]], [0.0100, 1.0])
    """
    if not np.isfinite(weights).all():
        raise ValueError("expected finite weights, received NaN or infinity")
    others = tuple(other for other in range(weights.ndim) if other != axis % weights.ndim)
    largest = np.abs(weights).max(axis=others, keepdims=True)
    step = np.where(largest > 0, largest / 127, 1).astype(np.float32)
    return np.rint(weights / step).astype(np.int8), step


def store(model: ModelProto, precision: Precision) -> None:
    """Narrow the weights of a model in place: tensors of two or more axes that convolutions and matrix
    products read.

    `float16` halves them. `int8` holds the large ones as bytes (`quantise`) and the rest as half floats.
    Biases and all else keep float32. The model's inputs and outputs do not change.

    Raises:
        ValueError: unknown precision, or weights beyond float16's range.
    """
    if precision not in PRECISIONS:
        raise ValueError(f"expected a precision out of {', '.join(PRECISIONS)}, received {precision!r}")
    if precision == "float32":
        return
    from onnx import numpy_helper

    held = {tensor.name: tensor for tensor in model.graph.initializer}
    head: list[NodeProto] = []
    kept: list[TensorProto] = []
    for name, axis in _weights(model).items():
        weights = numpy_helper.to_array(held[name])
        if weights.dtype != np.float32 or weights.ndim < 2 or weights.size < _SMALLEST:
            continue
        del held[name]
        coarse = precision == "int8" and weights.size >= _LARGE
        tensors, nodes = _as_bytes(name, weights, axis) if coarse else _as_half(name, weights)
        kept += tensors
        head += nodes
    nodes = [*head, *model.graph.node]
    kept += held.values()
    del model.graph.node[:], model.graph.initializer[:]
    model.graph.node.extend(nodes)
    model.graph.initializer.extend(kept)


def _weights(model: ModelProto) -> dict[str, int]:
    """Name of each weight and the axis of its output channels."""
    axes: dict[str, int] = {}
    for node in model.graph.node:
        if node.op_type in ("Conv", "Gemm", "MatMul"):
            transposed = any(entry.name == "transB" and entry.i for entry in node.attribute)
            axes[node.input[1]] = 0 if node.op_type == "Conv" or transposed else -1
    held = {tensor.name for tensor in model.graph.initializer}
    return {name: axis for name, axis in axes.items() if name in held}


def _as_half(name: str, weights: np.ndarray) -> tuple[list[TensorProto], list[NodeProto]]:
    from onnx import TensorProto, helper, numpy_helper

    if np.abs(weights).max() > np.finfo(np.float16).max:
        raise ValueError(f"{name}: expected weights in float16's range, received {np.abs(weights).max():g}")
    narrow = numpy_helper.from_array(weights.astype(np.float16), f"{name}.half")
    return [narrow], [helper.make_node("Cast", [narrow.name], [name], to=TensorProto.FLOAT)]


def _as_bytes(name: str, weights: np.ndarray, axis: int) -> tuple[list[TensorProto], list[NodeProto]]:
    from onnx import TensorProto, helper, numpy_helper

    q, step = quantise(weights, axis)
    narrow, steps = numpy_helper.from_array(q, f"{name}.bytes"), numpy_helper.from_array(step, f"{name}.step")
    wide = f"{name}.wide"
    # Not DequantizeLinear: runtimes keep that at run time, where they hope to fuse it.
    nodes = [
        helper.make_node("Cast", [narrow.name], [wide], to=TensorProto.FLOAT),
        helper.make_node("Mul", [wide, steps.name], [name]),
    ]
    return [narrow, steps], nodes
