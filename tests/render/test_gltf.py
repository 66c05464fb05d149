"""Models that want more than they may, or that are not what they say."""

import base64
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mixlight.render.gltf import Gltf, ModelError
from mixlight.render.model import load_model
from tests.render.glb import document, write_glb, write_gltf


def test_base64_and_a_file_in_the_folder_are_read(tmp_path: Path) -> None:
    found, blob = document()
    inline = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a b.bin").write_bytes(blob)
    for name, uri in (("inline.gltf", inline), ("beside.gltf", "deep/a%20b.bin")):
        model = load_model(write_gltf(tmp_path / name, found, uri))
        np.testing.assert_allclose(model.bounds[1], [1, 1, 0])


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin", "deep/../../secret.bin", "%2e%2e/secret.bin", "..%2fsecret.bin", "..\\secret.bin",
        "/etc/passwd", "%2Fetc%2Fpasswd", "~/secret.bin", "file:///etc/passwd", "FILE:secret.bin",
        "http://example.org/a.bin", "https://example.org/a.bin", "//example.org/a.bin", "ftp://a/b",
        "c:/a.bin",
        "a.bin?x", "a.bin#x", "a\0.bin", "a%00.bin", "a%0a.bin", "link.bin", "pipe", "deep", "missing.bin",
        "",
        "data:text/plain,hello", "data:;base64,@@@@",
    ],
)  # fmt: skip
def test_nothing_outside_the_folder_is_opened(
    tmp_path: Path, uri: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, blob = document()
    folder = tmp_path / "model"
    (folder / "deep").mkdir(parents=True)
    (tmp_path / "secret.bin").write_bytes(blob)
    (folder / "link.bin").symlink_to(tmp_path / "secret.bin")
    os.mkfifo(folder / "pipe")
    path = write_gltf(folder / "model.gltf", found, uri)
    opened: list[str] = []
    real = open

    def watched(file: Any, *arguments: Any, **more: Any) -> Any:
        opened.append(os.fspath(file))
        return real(file, *arguments, **more)

    monkeypatch.setattr("builtins.open", watched)
    with pytest.raises(ModelError, match=r"model\.gltf: expected .*, received ") as caught:
        load_model(path)
    assert opened == [str(path)]
    assert "\n" not in str(caught.value)


def _broken(found: dict[str, Any], where: tuple[Any, ...], value: Any) -> dict[str, Any]:
    copy: Any = json.loads(json.dumps(found))
    place = copy
    for key in where[:-1]:
        place = place[key]
    place[where[-1]] = value
    broken: dict[str, Any] = copy
    return broken


@pytest.mark.parametrize(
    ("where", "value", "says"),
    [
        (("asset", "version"), "1.0", "version 2"),
        (("asset",), [], "version 2"),
        (("scenes",), {}, "scenes"),
        (("scenes", 0, "nodes"), 3, "list of the scene's nodes"),
        (("scenes", 0, "nodes"), [7], "index below 1 into nodes"),
        (("scenes", 0, "nodes"), [True], "index below 1 into nodes"),
        (("scenes", 0, "nodes"), [0, 0], "a tree"),
        (("nodes", 0, "children"), [0], "a tree"),
        (("nodes", 0, "scale"), [1, 1], "3 finite numbers for scale"),
        (("nodes", 0, "matrix"), [float("nan")] * 16, "16 finite numbers"),
        (("nodes", 0, "rotation"), [0, 0, 0, 0], "rotation of length 1"),
        (("nodes", 0, "mesh"), 1, "index below 1 into meshes"),
        (("meshes", 0, "primitives", 0, "attributes", "POSITION"), -1, "into accessors"),
        (("meshes", 0, "primitives", 0, "indices"), 0, "type SCALAR"),
        (("meshes", 0, "primitives", 0, "material"), 0, "into materials"),
        (("meshes", 0, "primitives", 0, "mode"), 1, "without geometry"),
        (("meshes", 0, "primitives"), [], "without geometry"),
        (("accessors", 0, "count"), 4, "within 36"),
        (("accessors", 0, "count"), 2**33, "elements"),
        (("accessors", 0, "count"), 0, "1 to"),
        (("accessors", 0, "count"), "3", "whole number count"),
        (("accessors", 0, "byteOffset"), 4, "within 36"),
        (("accessors", 0, "componentType"), 5130, "type VEC3"),
        (("accessors", 1, "componentType"), 5126, "vertices below 3"),
        (("bufferViews", 0, "byteLength"), 4000, "within"),
        (("bufferViews", 0, "byteStride"), 4, "stride 4"),
        (("bufferViews", 0, "buffer"), 1, "into buffers"),
        (("buffers", 0, "byteLength"), 4000, "buffer 0 of 4000 bytes"),
        (("extensionsRequired",), ["KHR_draco_mesh_compression"], "KHR_draco_mesh_compression"),
    ],
)
def test_what_does_not_hold_together_is_refused(
    tmp_path: Path, where: tuple[Any, ...], value: Any, says: str
) -> None:
    found, blob = document()
    path = write_glb(tmp_path / "model.glb", _broken(found, where, value), blob)
    with pytest.raises(ModelError, match=says):
        load_model(path)


@pytest.mark.parametrize("indices", [[0, 1, 3], [0, 1, 2**32 - 1]])
def test_indices_beyond_the_vertices_are_refused(tmp_path: Path, indices: list[int]) -> None:
    with pytest.raises(ModelError, match="vertices below 3"):
        load_model(write_glb(tmp_path / "m.glb", *document(indices=indices)))


@pytest.mark.parametrize("positions", [[[0, 0, 0], [1, 0, 0], [np.nan, 1, 0]], [[0, 0, 0]] * 3])
def test_no_positions_or_no_area_is_refused(tmp_path: Path, positions: Any) -> None:
    with pytest.raises(ModelError, match=r"finite positions|without geometry"):
        load_model(write_glb(tmp_path / "m.glb", *document(positions=positions)))


@pytest.mark.parametrize(
    "data", [b"", b"glTF", b"{", b"[]", b"\xff\xd8\xff", b"hello", b"[" * 10**5, b"null"]
)
def test_other_files_are_refused_in_one_line(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "model.glb"
    path.write_bytes(data)
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert str(caught.value).startswith(str(path))
    assert len(str(caught.value).splitlines()) == 1


@given(cut=st.integers(0, 1000), at=st.integers(0, 10**6), byte=st.integers(0, 255))
def test_damage_is_refused_or_harmless(cut: int, at: int, byte: int, tmp_path_factory: Any) -> None:
    """Whatever byte is wrong and wherever the file ends: a model or a ModelError, never another error."""
    found, blob = document()
    path = write_glb(tmp_path_factory.mktemp("glb") / "m.glb", found, blob)
    data = bytearray(path.read_bytes())
    data[at % len(data)] = byte
    path.write_bytes(data[: len(data) - cut % 40 if cut > 500 else len(data)])
    try:
        with np.errstate(all="ignore"):
            assert load_model(path).parts
    except ModelError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017 (there need be none)


def test_sparse_accessors_and_normalised_integers(tmp_path: Path) -> None:
    found, blob = document()
    extra = np.array([1], np.uint8).tobytes() + b"\0\0\0" + np.array([[5, 6, 7]], np.float32).tobytes()
    start = len(blob)
    found["buffers"][0]["byteLength"] = start + len(extra) + 3
    found["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": 1},
        {"buffer": 0, "byteOffset": start + 4, "byteLength": 12},
        {"buffer": 0, "byteOffset": start + 16, "byteLength": 3},
    ]
    found["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3},
    }
    found["accessors"].append(
        {"bufferView": 4, "componentType": 5120, "count": 1, "type": "VEC3", "normalized": True}
    )
    gltf = Gltf(write_glb(tmp_path / "m.glb", found, blob + extra + bytes([127, 128, 0])))
    np.testing.assert_array_equal(gltf.accessor(0, ("VEC3",))[1], [5, 6, 7])
    np.testing.assert_allclose(gltf.accessor(2, ("VEC3",)), [[1, -1, 0]])
