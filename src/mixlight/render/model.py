"""Models to set into photos: triangles with normals and a plain metallic-roughness material.

Of a glTF the base colour, metallic and roughness are taken over, each with its texture; what else a material
may have (normal maps, glass, emission) is left out, and `Model.notes` says so.
"""

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8

from mixlight.image import container, stored
from mixlight.image.color import srgb_to_linear
from mixlight.image.errors import one_line
from mixlight.render.gltf import MAX_DEPTH, Gltf, ModelError

__all__ = ["Material", "Model", "ModelError", "Part", "demo_objects", "load_model"]

MAX_TRIANGLES = 5_000_000
MAX_TEXTURE_PIXELS = 8192 * 8192
_FOLDER = Path(__file__).parent.parent / "assets" / "objects"


@dataclass(frozen=True, eq=False)
class Material:
    """What a surface is made of."""

    base_color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Linear, in [0, 1]; multiplies the texture."""
    metallic: float = 1.0
    roughness: float = 1.0
    base_texture: Float[np.ndarray, "rows columns 3"] | None = None
    """Linear; row 0 is v = 0, as glTF counts."""
    surface_texture: Float[np.ndarray, "surface_rows surface_columns 2"] | None = None
    """Metallic and roughness, which multiply the factors."""


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one material, in the model's coordinates."""

    positions: Float[np.ndarray, "vertices 3"]
    normals: Float[np.ndarray, "vertices 3"]
    triangles: Int[np.ndarray, "triangles 3"]
    uv: Float[np.ndarray, "vertices 2"] | None
    material: Material


@dataclass(frozen=True, eq=False)
class _Surface:
    """A material, and how its textures lie on the vertices' coordinates: uv' = (u, v, 1) matrix."""

    material: Material
    uv_set: int
    uv_matrix: Float[np.ndarray, "3 2"]


_SAME_UV = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
_TEXTURES = ("baseColorTexture", "metallicRoughnessTexture")


@dataclass(frozen=True, eq=False)
class Model:
    """An object: what glTF shows of its scene, +Y up, metres."""

    name: str
    parts: tuple[Part, ...]
    notes: tuple[str, ...] = ()
    """What was left out."""

    @property
    def bounds(self) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
        """Smallest and largest coordinates."""
        used = [part.positions[part.triangles.ravel()] for part in self.parts]
        return (
            np.min([points.min(0) for points in used], axis=0),
            np.max([points.max(0) for points in used], axis=0),
        )


def demo_objects() -> list[str]:
    """Names of the objects that ship with the package.

    >>> demo_objects()
    ['chair', 'spheres', 'teapot']
    """
    return sorted(path.stem for path in _FOLDER.glob("*.glb"))


def load_model(name_or_path: str | os.PathLike[str]) -> Model:
    """Read a model: one of `demo_objects` by its name, or a .glb or .gltf file.

    Raises:
        ModelError: (a ValueError) the file is no glTF 2.0, damaged, hostile (it wants files outside its
            folder, or the network), too large, or holds no triangles.
        OSError: the file cannot be read.

    >>> model = load_model("spheres")
    >>> len(model.parts), model.bounds[1].round(3)
    (3, array([0.33, 0.2 , 0.1 ]))
    """
    path = Path(name_or_path)
    if os.fspath(name_or_path) in demo_objects():
        path = _FOLDER / f"{name_or_path}.glb"
    gltf = Gltf(path)
    notes: dict[str, None] = {}
    materials: dict[object, _Surface] = {}
    parts = []
    for matrix, mesh_index in _placed_meshes(gltf):
        mesh = gltf.entry("meshes", mesh_index)
        primitives = mesh.get("primitives", [])
        for primitive in primitives if isinstance(primitives, list) else []:
            if not isinstance(primitive, dict):
                raise gltf.error("primitives that are objects", one_line(primitive, 60))
            part = _part(gltf, primitive, matrix, materials, notes)
            if part is not None:
                parts.append(part)
            if sum(len(p.triangles) for p in parts) > MAX_TRIANGLES:
                raise gltf.error(f"at most {MAX_TRIANGLES} triangles", "more")
    if not parts:
        raise gltf.error("an object with triangles", "a model without geometry")
    if gltf.document.get("animations") or gltf.document.get("skins"):
        notes["animation and skins (the model stands as it is stored)"] = None
    return Model(path.stem, tuple(parts), tuple(notes))


def _placed_meshes(gltf: Gltf) -> Iterator[tuple[Float[np.ndarray, "4 4"], object]]:
    """Each mesh of the scene with its matrix."""
    if "scenes" in gltf.document:
        roots = gltf.entry("scenes", gltf.document.get("scene", 0)).get("nodes", [])
    else:  # a library of nodes: all that nobody is the parent of
        nodes = gltf.document.get("nodes", [])
        nodes = nodes if isinstance(nodes, list) else []
        children = {
            c for n in nodes if isinstance(n, dict) for c in _list(gltf, n, "children") if isinstance(c, int)
        }
        roots = [i for i in range(len(nodes)) if i not in children]
    if not isinstance(roots, list):
        raise gltf.error("a list of the scene's nodes", one_line(roots, 60))
    stack: list[tuple[object, Any, int]] = [(root, np.eye(4), 0) for root in reversed(roots)]
    seen: set[object] = set()
    while stack:
        index, parent, depth = stack.pop()
        node = gltf.entry("nodes", index)
        if index in seen or depth > MAX_DEPTH:
            raise gltf.error("nodes that form a tree", f"node {index} twice, or too deep")
        seen.add(index)
        matrix = parent @ _matrix(gltf, node)
        if "mesh" in node:
            yield matrix, node["mesh"]
        stack += [(child, matrix, depth + 1) for child in reversed(_list(gltf, node, "children"))]


def _list(gltf: Gltf, entry: dict[str, Any], name: str) -> list[Any]:
    value = entry.get(name, [])
    if not isinstance(value, list):
        raise gltf.error(f"a list of {name}", one_line(value, 60))
    return value


def _numbers(gltf: Gltf, entry: dict[str, Any], name: str, default: list[float]) -> Float[np.ndarray, " n"]:
    value = entry.get(name, default)
    good = isinstance(value, list) and len(value) == len(default)
    if not (good and all(type(v) in (int, float) and math.isfinite(v) and abs(v) < 1e30 for v in value)):
        raise gltf.error(f"{len(default)} finite numbers for {name}", one_line(value, 80))
    return np.array(value, float)


def _matrix(gltf: Gltf, node: dict[str, Any]) -> Float[np.ndarray, "4 4"]:
    if "matrix" in node:
        return _numbers(gltf, node, "matrix", [0.0] * 16).reshape(4, 4).T  # stored column by column
    x, y, z, w = _numbers(gltf, node, "rotation", [0.0, 0.0, 0.0, 1.0])
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if norm < 1e-6:
        raise gltf.error("a rotation of length 1", f"length {norm:g}")
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * _numbers(gltf, node, "scale", [1.0, 1.0, 1.0])
    matrix[:3, 3] = _numbers(gltf, node, "translation", [0.0, 0.0, 0.0])
    return matrix


def _part(
    gltf: Gltf,
    primitive: dict[str, Any],
    matrix: Float[np.ndarray, "4 4"],
    materials: dict[object, _Surface],
    notes: dict[str, None],
) -> Part | None:
    mode = primitive.get("mode", 4)
    attributes = primitive.get("attributes")
    if mode not in (4, 5, 6):
        notes["points and lines"] = None
        return None
    if not isinstance(attributes, dict) or "POSITION" not in attributes:
        return None
    stored_points = gltf.accessor(attributes["POSITION"], ("VEC3",)).astype(float)
    positions = stored_points @ matrix[:3, :3].T + matrix[:3, 3]
    if not np.isfinite(positions).all():
        raise gltf.error("finite positions", "NaN or infinity")
    count = len(positions)
    if "indices" in primitive:
        index = gltf.accessor(primitive["indices"], ("SCALAR",))[:, 0]
        if index.dtype.kind != "u" or int(index.max()) >= count:
            raise gltf.error(f"indices of vertices below {count}", int(index.max()))
        index = index.astype(np.int64)
    else:
        index = np.arange(count)
    triangles = _triangles(index, mode)
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    if mirrored:
        triangles = triangles[:, ::-1]
    corners = positions[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    triangles = triangles[area > 0]
    if len(triangles) == 0:
        return None
    surface = _material(gltf, primitive.get("material"), materials, notes)
    material = surface.material
    if "COLOR_0" in attributes:
        notes["colours of vertices"] = None
    uv = None
    if material.base_texture is not None or material.surface_texture is not None:
        name = f"TEXCOORD_{surface.uv_set}"
        if name in attributes:
            uv = gltf.accessor(attributes[name], ("VEC2",)).astype(float)
            if len(uv) != count or not np.isfinite(uv).all():
                raise gltf.error(f"{count} finite texture coordinates", f"{len(uv)}")
            uv = uv @ surface.uv_matrix[:2] + surface.uv_matrix[2]
        else:
            material = replace(material, base_texture=None, surface_texture=None)
    if "NORMAL" in attributes:
        normals = gltf.accessor(attributes["NORMAL"], ("VEC3",)).astype(float)
        if len(normals) != count or not np.isfinite(normals).all():
            raise gltf.error(f"{count} finite normals", f"{len(normals)}")
        cofactor = np.linalg.det(matrix[:3, :3]) * np.linalg.pinv(matrix[:3, :3])
        normals = normals @ cofactor * (-1.0 if mirrored else 1.0)
    else:  # flat, as glTF wants it: each triangle gets vertices of its own
        corners = positions[triangles]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        positions, normals = corners.reshape(-1, 3), np.repeat(flat, 3, axis=0)
        uv = None if uv is None else uv[triangles.ravel()]
        triangles = np.arange(len(positions)).reshape(-1, 3)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-30)
    return Part(positions, normals, triangles, uv, material)


def _triangles(index: Int[np.ndarray, " n"], mode: int) -> Int[np.ndarray, "triangles 3"]:
    """Lists, strips and fans as lists."""
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if len(index) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == 6:
        return np.stack([np.broadcast_to(index[:1], len(index) - 2), index[1:-1], index[2:]], -1)
    strip = np.stack([index[:-2], index[1:-1], index[2:]], -1)
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _material(
    gltf: Gltf, index: object, materials: dict[object, _Surface], notes: dict[str, None]
) -> _Surface:
    if index is None:
        return _Surface(Material(), 0, _SAME_UV)
    if index in materials:
        return materials[index]
    entry = gltf.entry("materials", index)
    pbr = entry.get("pbrMetallicRoughness", {})
    if not isinstance(pbr, dict):
        raise gltf.error("an object pbrMetallicRoughness", one_line(pbr, 60))
    factor = _numbers(gltf, pbr, "baseColorFactor", [1.0] * 4).clip(0, 1)
    metallic = float(_numbers(gltf, {"n": [pbr.get("metallicFactor", 1.0)]}, "n", [1.0]).clip(0, 1)[0])
    roughness = float(_numbers(gltf, {"n": [pbr.get("roughnessFactor", 1.0)]}, "n", [1.0]).clip(0, 1)[0])
    base = _texture(gltf, pbr.get(_TEXTURES[0]), notes)
    surface = _texture(gltf, pbr.get(_TEXTURES[1]), notes)
    for name, what in (
        ("normalTexture", "normal maps"),
        ("emissiveTexture", "emission"),
        ("occlusionTexture", "baked occlusion"),
    ):
        if name in entry:
            notes[what] = None
    if entry.get("alphaMode", "OPAQUE") != "OPAQUE":
        notes["transparency (the surface is taken as opaque)"] = None
    extensions = entry.get("extensions", {})
    for name in extensions if isinstance(extensions, dict) else ():
        notes[f"the material extension {one_line(name, 40)}"] = None
    layouts = [_layout(gltf, pbr[name]) for name in _TEXTURES if name in pbr]
    uv_set, uv_matrix = layouts[0] if layouts else (0, _SAME_UV)
    if any(other != uv_set or not np.array_equal(matrix, uv_matrix) for other, matrix in layouts[1:]):
        notes["a second layout of textures on one surface"] = None
    material = Material(
        (float(factor[0]), float(factor[1]), float(factor[2])),
        metallic,
        roughness,
        None if base is None else srgb_to_linear(base.astype(np.float32) / 255.0),
        None if surface is None else surface[..., [2, 1]].astype(np.float32) / 255.0,
    )
    materials[index] = _Surface(material, uv_set, uv_matrix)
    return materials[index]


def _layout(gltf: Gltf, reference: dict[str, Any]) -> tuple[int, Float[np.ndarray, "3 2"]]:
    """Which texture coordinates a texture lies on, and what is done to them (KHR_texture_transform)."""
    extensions = reference.get("extensions", {})
    given = extensions.get("KHR_texture_transform", {}) if isinstance(extensions, dict) else {}
    if not isinstance(given, dict):
        raise gltf.error("an object KHR_texture_transform", one_line(given, 60))
    angle = float(_numbers(gltf, {"n": [given.get("rotation", 0.0)]}, "n", [0.0])[0])
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])  # of row vectors: counter-clockwise where v points down
    scale = _numbers(gltf, given, "scale", [1.0, 1.0])
    offset = _numbers(gltf, given, "offset", [0.0, 0.0])
    uv_set = gltf.whole(given if "texCoord" in given else reference, "texCoord", 0)
    return uv_set, np.concatenate([scale[:, None] * turn, offset[None]])


def _texture(
    gltf: Gltf, reference: object, notes: dict[str, None]
) -> UInt8[np.ndarray, "rows columns 3"] | None:
    if reference is None:
        return None
    if not isinstance(reference, dict):
        raise gltf.error("a texture reference that is an object", one_line(reference, 60))
    texture = gltf.entry("textures", reference.get("index"))
    if "source" not in texture:
        notes["textures in a format of an extension"] = None
        return None
    data = gltf.image(texture["source"])
    kind, received = container.kind(data[:64])
    if kind not in ("PNG", "JPEG", "WebP"):
        raise gltf.error("textures as PNG or JPEG", received)
    try:
        width, height = container.announced_size(kind, data)
        if width * height > MAX_TEXTURE_PIXELS:
            raise gltf.error(f"textures of at most {MAX_TEXTURE_PIXELS} pixels", f"{width} x {height}")
        samples = stored.load(kind, data).samples
    except ModelError:
        raise
    except Exception as error:  # decoders of foreign data raise whatever they stumble over
        raise gltf.error(f"a complete {kind} texture", error) from None
    if samples.dtype == np.uint16:
        samples = (samples >> 8).astype(np.uint8)
    if samples.ndim == 2:
        samples = samples[..., None]
    colour = samples[..., :3] if samples.shape[2] >= 3 else np.repeat(samples[..., :1], 3, axis=-1)
    return np.ascontiguousarray(colour)
