"""What the exported file is, without running it; tests/interop/test_onnx.py runs it."""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mixlight.export import onnx as export
from mixlight.export.onnx_precision import store
from mixlight.network.estimator import Estimator
from mixlight.network.weights import WeightsError
from tests.export.small_network import small_estimator

onnx = pytest.importorskip("onnx")

FRAME = "mixlight: +X right, +Y up, -Z forward; the photo's azimuth is the map's centre"


@pytest.fixture(scope="module")
def estimator() -> Estimator:
    return small_estimator(gain=6.0, commit="abc1234", frame=FRAME, licence="Apache-2.0")


@pytest.fixture(scope="module")
def proto(estimator: Estimator) -> Any:
    return export.to_onnx(estimator)


def shape(value: Any) -> list[str | int]:
    return [dim.dim_param or dim.dim_value for dim in value.type.tensor_type.shape.dim]


def test_the_file_is_valid_and_holds_everything(proto: Any) -> None:
    onnx.checker.check_model(proto, full_check=True)
    assert not any(tensor.external_data for tensor in proto.graph.initializer)
    assert [(entry.domain, entry.version) for entry in proto.opset_import] == [("", export.OPSET)]
    assert not proto.functions


def test_inputs_and_outputs_are_named_and_the_batch_is_free(proto: Any) -> None:
    assert {value.name: shape(value) for value in proto.graph.input} == {"photo": ["batch", 3, 24, 32]}
    assert {value.name: shape(value) for value in proto.graph.output} == {
        "ambient": ["batch", 9, 3],
        "anchor_energy": ["batch", 128, 3],
        "camera": ["batch", 2],
    }
    kinds = {value.type.tensor_type.elem_type for value in (*proto.graph.input, *proto.graph.output)}
    assert kinds == {onnx.TensorProto.FLOAT}


def test_the_metadata_say_what_the_numbers_are(proto: Any) -> None:
    said = {entry.key: entry.value for entry in proto.metadata_props}
    assert said["frame"] == FRAME
    assert said["units"] == "radiance 1.0 is the photo's linear white"
    assert said["precision"] == "float32"
    assert json.loads(said["model"]) == {"name": "small", "commit": "abc1234"}
    photo = json.loads(said["photo"])
    assert (photo["height"], photo["width"], photo["fov_deg"], photo["encoding"]) == (24, 32, 60.0, "sRGB")
    assert json.loads(said["anchor_energy"])["sharpness"] == 0.0025
    assert json.loads(said["ambient"])["order"] == "l*l+l+m"
    assert (proto.producer_name, said["format"]) == ("mixlight", "mixlight/onnx")


def test_nothing_tells_of_the_machine_that_exported(proto: Any) -> None:
    data = proto.SerializeToString()
    home = Path(export.__file__).resolve().parents[3]
    for text in (str(home), str(Path(torch.__file__).parent), "site-packages", "stack_trace", ".py"):
        assert text.encode() not in data, text


def test_the_same_weights_give_the_same_bytes_and_the_network_stays_as_it_is(
    estimator: Estimator, proto: Any
) -> None:
    before = {name: tensor.clone() for name, tensor in estimator.model.state_dict().items()}
    again = export.to_onnx(estimator).SerializeToString(deterministic=True)
    assert again == proto.SerializeToString(deterministic=True)
    after = estimator.model.state_dict()
    assert all(torch.equal(before[name], after[name]) for name in before)


@pytest.mark.filterwarnings("ignore:divide by zero:RuntimeWarning")  # log(0) = -inf is meant: first in rank
@pytest.mark.parametrize("precision", export.PRECISIONS)
def test_onnxs_own_reference_gives_pytorchs_light(estimator: Estimator, proto: Any, precision: Any) -> None:
    """An evaluator in plain NumPy, written by nobody who wrote a runtime."""
    from onnx.reference import ReferenceEvaluator

    model = onnx.ModelProto.FromString(proto.SerializeToString())
    store(model, precision)
    photos = torch.rand(3, 3, 24, 32, generator=torch.Generator().manual_seed(1))
    found = ReferenceEvaluator(model).run(None, {"photo": photos.numpy()})
    with torch.inference_mode():
        prediction = estimator.model(photos)
    tolerance = {"float32": 1e-5, "float16": 1e-2, "int8": 1e-2}[precision]
    for value, expected in zip(found, (prediction.ambient, prediction.anchor_energy), strict=False):
        scale = expected.abs().max()
        assert np.abs(value - expected.numpy()).max() <= tolerance * scale


def test_the_folder_is_complete_and_explains_itself(tmp_path: Path) -> None:
    paths = export.write(small_estimator(), tmp_path, "int8")
    assert [path.name for path in paths] == ["mixlight.onnx", "mixlight.mjs", "README.txt"]
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in paths}
    readme = (tmp_path / "README.txt").read_text()
    assert len(readme.splitlines()) == 3
    assert readme.startswith("Load mixlight.onnx with onnxruntime")
    assert "[batch,3,24,32]" in readme
    script = (tmp_path / "mixlight.mjs").read_text()
    (line,) = [line for line in script.splitlines() if line.startswith("export const MODEL = ")]
    model = json.loads(line.removeprefix("export const MODEL = ").rstrip(";"))
    assert model == {
        "name": "small", "precision": "int8", "height": 24, "width": 32, "fovDeg": 60.0, "anchors": 128,
        "sharpness": 0.0025,
    }  # fmt: skip


def test_a_name_with_quotes_and_backslashes_stays_a_name(tmp_path: Path) -> None:
    estimator = small_estimator()
    estimator.card = {"name": 'a"; throw 1; //\\1\n'}
    script = export._script(estimator, "float32")
    (line,) = [line for line in script.splitlines() if line.startswith("export const MODEL = ")]
    assert (
        json.loads(line.removeprefix("export const MODEL = ").rstrip(";"))["name"] == 'a"; throw 1; //\\1\n'
    )


def test_bad_calls_are_told_and_leave_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(WeightsError, match="unknown model 'nothing'"):
        export.write("nothing", tmp_path)
    monkeypatch.setitem(sys.modules, "onnxscript", None)
    with pytest.raises(ImportError, match=r'pip install "mixlight\[onnx\]"'):
        export.write(small_estimator(), tmp_path)
    assert not list(tmp_path.iterdir())
