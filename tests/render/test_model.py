import io
import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mixlight.render.gltf import ModelError
from mixlight.render.model import demo_objects, load_model
from tests.render.glb import document, write_glb


@pytest.mark.parametrize("name", demo_objects())
def test_the_demo_objects_stand_on_the_ground_in_metres_with_outward_normals(name: str) -> None:
    model = load_model(name)
    lower, upper = model.bounds
    assert lower[1] == pytest.approx(0.0, abs=1e-3)
    assert 0.1 < (upper - lower).max() < 1.0
    for part in model.parts:
        corners = part.positions[part.triangles]
        outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert ((outward[:, None] * part.normals[part.triangles]).sum(-1).mean(-1) > 0).mean() > 0.99
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=-1), 1, rtol=1e-5)


def test_the_spheres_are_the_three_of_the_protocol() -> None:
    materials = [part.material for part in load_model("spheres").parts]
    assert [(m.metallic, m.roughness) for m in materials] == [(0.0, 1.0), (1.0, 0.33), (1.0, 0.02)]


def test_nodes_are_placed_by_their_parents(tmp_path: Path) -> None:
    """Golden: a turn by 90 degrees about +Y below a move takes +X to -Z and then moves it."""
    half = math.sqrt(0.5)
    nodes = [
        {"translation": [10, 0, 0], "children": [1]},
        {"rotation": [0, half, 0, half], "scale": [2, 1, 1], "mesh": 0},
    ]
    model = load_model(write_glb(tmp_path / "m.glb", *document(nodes=nodes)))
    np.testing.assert_allclose(model.parts[0].positions[:3], [[10, 0, 0], [10, 0, -2], [10, 1, 0]], atol=1e-6)
    np.testing.assert_allclose(model.parts[0].normals[0], [1, 0, 0], atol=1e-6)


def test_a_mirroring_node_keeps_the_outside_outside(tmp_path: Path) -> None:
    plain = load_model(write_glb(tmp_path / "a.glb", *document())).parts[0]
    nodes = [{"scale": [-1, 1, 1], "mesh": 0}]
    mirrored = load_model(write_glb(tmp_path / "b.glb", *document(nodes=nodes))).parts[0]
    np.testing.assert_allclose(plain.normals[0], [0, 0, 1])
    np.testing.assert_allclose(mirrored.normals[0], [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize(("mode", "expected"), [(4, 1), (5, 2), (6, 2)])
def test_lists_strips_and_fans(tmp_path: Path, mode: int, expected: int) -> None:
    square = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    if mode == 6:
        square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    found, blob = document(positions=square, indices=[0, 1, 2, 3])
    found["meshes"][0]["primitives"][0]["mode"] = mode
    part = load_model(write_glb(tmp_path / "m.glb", found, blob)).parts[0]
    assert len(part.triangles) == expected
    np.testing.assert_allclose(part.normals[:, 2], 1)


def _textured(tmp_path: Path, image: bytes) -> Path:
    found, blob = document()
    uv = np.array([[0, 0], [1, 0], [0, 1]], np.float32).tobytes()
    found["bufferViews"] += [
        {"buffer": 0, "byteOffset": len(blob), "byteLength": len(uv)},
        {"buffer": 0, "byteOffset": len(blob) + len(uv), "byteLength": len(image)},
    ]
    found["buffers"][0]["byteLength"] = len(blob) + len(uv) + len(image)
    found["accessors"].append({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"})
    found["meshes"][0]["primitives"][0] |= {"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "material": 0}
    found["images"] = [{"bufferView": 3, "mimeType": "image/png"}]
    found["textures"] = [{"source": 0}]
    found["materials"] = [
        {
            "normalTexture": {"index": 0},
            "alphaMode": "BLEND",
            "extensions": {"KHR_materials_transmission": {}},
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 1, 1, 1],
                "roughnessFactor": 0.25,
                "baseColorTexture": {"index": 0},
                "metallicRoughnessTexture": {"index": 0},
            },
        }
    ]
    return write_glb(tmp_path / "m.glb", found, blob + uv + image)


def _png(pixels: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, format="PNG")
    return file.getvalue()


def test_colour_metal_and_roughness_are_taken_over_and_the_rest_is_named(tmp_path: Path) -> None:
    pixels = np.zeros((2, 2, 3), np.uint8)
    pixels[0, 1] = 128, 51, 255
    model = load_model(_textured(tmp_path, _png(pixels)))
    material = model.parts[0].material
    assert material.base_color == (0.5, 1.0, 1.0)
    assert (material.metallic, material.roughness) == (1.0, 0.25)
    assert material.base_texture is not None
    assert material.surface_texture is not None
    np.testing.assert_allclose(material.base_texture[0, 1, 0], 0.2159, atol=1e-4)  # colour is sRGB
    np.testing.assert_allclose(material.surface_texture[0, 1], [1.0, 0.2])  # blue: metal, green: roughness
    assert model.parts[0].uv is not None
    assert len(model.notes) == 3, model.notes


@pytest.mark.parametrize("image", [b"", b"GIF89a", _png(np.zeros((8, 8, 3), np.uint8))[:-30]])
def test_bad_textures_are_refused(tmp_path: Path, image: bytes) -> None:
    with pytest.raises(ModelError, match="texture"):
        load_model(_textured(tmp_path, image))


def test_huge_textures_are_refused_before_they_are_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mixlight.render.model.MAX_TEXTURE_PIXELS", 63)
    with pytest.raises(ModelError, match="8 x 8"):
        load_model(_textured(tmp_path, _png(np.zeros((8, 8, 3), np.uint8))))


def test_a_missing_file_is_an_oserror(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        load_model(tmp_path / "none.glb")


def test_texture_transforms(tmp_path: Path) -> None:
    """Golden, from the formula of KHR_texture_transform: T R S with v downwards."""
    path = _textured(tmp_path, _png(np.zeros((8, 8, 3), np.uint8)))
    data = path.read_bytes()
    size = int.from_bytes(data[12:16], "little")
    found = json.loads(data[20 : 20 + size])
    transform = {"offset": [0.5, 0.25], "rotation": math.pi / 2, "scale": [2.0, 1.0]}
    pbr = found["materials"][0]["pbrMetallicRoughness"]
    for name in ("baseColorTexture", "metallicRoughnessTexture"):
        pbr[name]["extensions"] = {"KHR_texture_transform": transform}
    found["extensionsRequired"] = ["KHR_texture_transform"]
    model = load_model(write_glb(tmp_path / "t.glb", found, data[28 + size :]))
    # (1, 0): scaled to (2, 0), rotated by [[cos, sin], [-sin, cos]] to (0, -2), moved.
    np.testing.assert_allclose(model.parts[0].uv, [[0.5, 0.25], [0.5, -1.75], [1.5, 0.25]], atol=1e-7)
