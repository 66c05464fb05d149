"""Rounding of weights, and where it is stored."""

from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from mixlight.export.onnx_precision import PRECISIONS, quantise, store

onnx = pytest.importorskip("onnx")


def model() -> "onnx.ModelProto":
    """photo -> Conv -> Gemm (transB) -> MatMul, with a bias and one kernel too small to be worth it."""
    from onnx import TensorProto, helper, numpy_helper

    rng = np.random.default_rng(0)
    arrays = {
        "kernel": rng.normal(size=(16, 3, 3, 3)),
        "bias": rng.normal(size=16),
        "tiny": rng.normal(size=(16, 1, 1, 1)),
        "gemm": rng.normal(size=(3200, 16)) * 10.0 ** rng.uniform(-3, 3, size=(3200, 1)),
        "product": rng.normal(size=(3200, 20)) * 10.0 ** rng.uniform(-3, 3, size=20),
    }
    nodes = [
        helper.make_node("Conv", ["photo", "kernel", "bias"], ["a"], pads=[1, 1, 1, 1]),
        helper.make_node("Conv", ["a", "tiny"], ["b"], group=16),
        helper.make_node("GlobalAveragePool", ["b"], ["c"]),
        helper.make_node("Flatten", ["c"], ["d"]),
        helper.make_node("Gemm", ["d", "gemm"], ["e"], transB=1),
        helper.make_node("MatMul", ["e", "product"], ["out"]),
    ]
    graph = helper.make_graph(
        nodes,
        "test",
        [helper.make_tensor_value_info("photo", TensorProto.FLOAT, ["batch", 3, 8, 8])],
        [helper.make_tensor_value_info("out", TensorProto.FLOAT, ["batch", 20])],
        [numpy_helper.from_array(array.astype(np.float32), name) for name, array in arrays.items()],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)


def run(proto: "onnx.ModelProto") -> np.ndarray:
    from onnx.reference import ReferenceEvaluator

    photo = np.random.default_rng(1).normal(size=(2, 3, 8, 8)).astype(np.float32)
    (found,) = ReferenceEvaluator(proto).run(None, {"photo": photo})
    return found


@given(
    rows=st.integers(1, 5),
    columns=st.integers(1, 7),
    exponents=st.lists(st.floats(-6, 6), min_size=5, max_size=5),
    axis=st.sampled_from([0, 1, -1, -2]),
    seed=st.integers(0, 2**16),
)
def test_no_weight_moves_by_more_than_half_a_step(
    rows: int, columns: int, exponents: list[float], axis: int, seed: int
) -> None:
    weights = np.random.default_rng(seed).normal(size=(rows, columns)).astype(np.float32)
    weights *= 10.0 ** np.array(exponents[:rows], dtype=np.float32)[:, None]
    q, step = quantise(weights, axis)
    assert np.abs(q.astype(int)).max() <= 127
    assert step.size == weights.shape[axis]
    assert (np.abs(q * step - weights) <= step * 0.5 * (1 + 1e-5)).all()


def test_zeros_stay_zeros_and_the_largest_weight_stays_itself() -> None:
    weights = np.array([[0.0, 0.0, 0.0], [0.0, -3.0, 1.0]], dtype=np.float32)
    q, step = quantise(weights, 0)
    assert q.tolist() == [[0, 0, 0], [0, -127, 42]]
    assert (q * step)[1, 1] == pytest.approx(-3.0, rel=1e-6)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="expected finite weights"):
        quantise(np.array([[1.0, value]], dtype=np.float32), 0)


@pytest.mark.parametrize(
    ("precision", "narrowed", "tolerance"),
    [
        ("float16", ["kernel.half", "gemm.half", "product.half"], 1e-2),
        ("int8", ["kernel.half", "gemm.bytes", "product.bytes"], 0.15),
    ],
)
def test_weights_are_narrowed_in_the_file_and_widened_in_the_graph(
    precision: Any, narrowed: list[str], tolerance: float
) -> None:
    narrow = model()
    store(narrow, precision)
    onnx.checker.check_model(narrow, full_check=True)
    kinds = {tensor.name: tensor.data_type for tensor in narrow.graph.initializer}
    expected = {"half": onnx.TensorProto.FLOAT16, "bytes": onnx.TensorProto.INT8}
    held = {name: kind for name, kind in kinds.items() if kind != onnx.TensorProto.FLOAT}
    assert held == {name: expected[name.partition(".")[2]] for name in narrowed}
    assert kinds["bias"] == kinds["tiny"] == onnx.TensorProto.FLOAT
    whole = run(model())
    # Channels of these weights differ by a factor of 10^6, which one step for all of them would not survive;
    # the room is for sums in which large terms cancel.
    assert (np.abs(run(narrow) - whole).max(0) <= tolerance * np.abs(whole).max(0)).all()


def test_float32_is_left_alone() -> None:
    untouched = model()
    store(untouched, PRECISIONS[0])  # type: ignore[arg-type]
    assert untouched == model()


def test_weights_beyond_float16_are_refused() -> None:
    from onnx import numpy_helper

    large = model()
    large.graph.initializer[0].CopyFrom(
        numpy_helper.from_array(np.full((16, 3, 3, 3), 1e6, dtype=np.float32), "kernel")
    )
    with pytest.raises(ValueError, match="kernel: expected weights in float16's range, received 1e"):
        store(large, "float16")
