"""Makes the demo objects of `mixlight insert`: src/mixlight/assets/objects/*.glb.

    python scripts/make_objects.py

All three are designed here and nowhere else, in metres, standing on y = 0 and facing +Z, as glTF wants it.
"""

import json
import math
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

OUT = Path("src/mixlight/assets/objects")

Material = dict[str, Any]
"""As glTF writes it."""


class Shape:
    """Triangles with normals."""

    def __init__(self, positions: ArrayLike, normals: ArrayLike, triangles: ArrayLike) -> None:
        self.positions = np.asarray(positions, np.float32).reshape(-1, 3)
        self.normals = np.asarray(normals, np.float32).reshape(-1, 3)
        self.normals /= np.maximum(np.linalg.norm(self.normals, axis=1, keepdims=True), 1e-12)
        self.triangles = np.asarray(triangles, np.uint32).reshape(-1, 3)

    def moved(self, offset: Sequence[float]) -> "Shape":
        """Set off by [x, y, z]."""
        return Shape(self.positions + np.asarray(offset, np.float32), self.normals, self.triangles)

    def turned(self, axis: int, angle: float) -> "Shape":
        """Rotated about one of the axes through the origin."""
        c, s = math.cos(angle), math.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3, dtype=np.float32)
        matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
        return Shape(self.positions @ matrix.T, self.normals @ matrix.T, self.triangles)


Part = tuple[str, Shape, tuple[float, float, float], Material]
"""Name, triangles, where they stand, what they are made of."""


def joined(*shapes: Shape) -> Shape:
    offsets = np.cumsum([0] + [len(s.positions) for s in shapes[:-1]])
    return Shape(
        np.concatenate([s.positions for s in shapes]),
        np.concatenate([s.normals for s in shapes]),
        np.concatenate([s.triangles + o for s, o in zip(shapes, offsets, strict=True)]),
    )


def grid(positions: NDArray[Any], normals: NDArray[Any]) -> Shape:
    """A surface from [rows, columns, 3] points."""
    rows, columns = positions.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3)
    corners = positions.reshape(-1, 3)[triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return Shape(positions, normals, triangles[area > 1e-12])


def lathe(outline: ArrayLike, around: int = 96) -> Shape:
    """Turn a profile [(radius, height), ...] about +Y; the outside is on its right, going upwards."""
    profile = np.asarray(outline, float)
    tangent = np.gradient(profile, axis=0)
    outward = np.stack([tangent[:, 1], -tangent[:, 0]], -1)
    angle = np.linspace(0, 2 * math.pi, around + 1)
    ring = np.stack([np.sin(angle), np.cos(angle)], -1)  # counter-clockwise as seen from above

    def turned(values: NDArray[Any]) -> NDArray[Any]:
        radial = values[:, None, :1] * ring
        return np.stack(
            [radial[..., 0], np.broadcast_to(values[:, 1:], radial.shape[:2]), radial[..., 1]], -1
        )

    surface = grid(turned(profile), turned(outward))
    surface.triangles = surface.triangles[:, [0, 2, 1]]
    return surface


def spline(knots: ArrayLike, count: int) -> NDArray[np.float64]:
    """A Catmull-Rom curve through the points."""
    points = np.asarray(knots, float)
    padded = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
    t = np.linspace(0, len(points) - 1 - 1e-9, count)
    k, f = t.astype(int), (t % 1)[:, None]
    a, b, c, d = (padded[k + i] for i in range(4))
    curve: NDArray[np.float64] = 0.5 * (
        2 * b + (c - a) * f + (2 * a - 5 * b + 4 * c - d) * f**2 + (3 * (b - c) + d - a) * f**3
    )
    return curve


def tube(
    points: ArrayLike, radii: Sequence[float], count: int = 48, around: int = 32, flatten: float = 1.0
) -> Shape:
    """A round tube along a curve in the plane z = 0, with the radius following along."""
    path = spline(points, count)
    radius = np.interp(np.linspace(0, 1, count), np.linspace(0, 1, len(radii)), radii)[:, None, None]
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.array([0.0, 0.0, 1.0])
    normal = np.cross(side, tangent)
    angle = np.linspace(0, 2 * math.pi, around + 1)[None, :, None]
    out = np.cos(angle) * normal[:, None] + np.sin(angle) * side * flatten
    faces_out = np.cos(angle) * normal[:, None] * flatten + np.sin(angle) * side
    surface = grid(path[:, None] + radius * out, faces_out)
    surface.triangles = surface.triangles[:, [0, 2, 1]]
    return surface


def sphere(radius: float, rows: int = 48) -> Shape:
    v = np.linspace(-math.pi / 2, math.pi / 2, rows + 1)
    profile = np.stack([np.cos(v).clip(0), np.sin(v)], -1) * radius
    ball = lathe(profile, 2 * rows)
    ball.normals = ball.positions / radius
    return ball.moved((0, radius, 0))


def box(size: Sequence[float], bevel: float = 0.006, steps: int = 4) -> Shape:
    """A box with rounded edges, centred at the origin."""
    half = np.asarray(size, float) / 2
    shapes = []
    core = half - bevel
    for axis in range(3):
        for sign in (-1.0, 1.0):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            t = np.concatenate([-1 - np.linspace(1, 0, steps + 1), 1 + np.linspace(0, 1, steps + 1)])
            # A face of the unit sphere's cube, pushed out to the rounded box: flat in the middle.
            inner = np.sign(t)
            bend = np.tan((np.abs(t) - 1) * math.pi / 4) * np.sign(t)
            direction = np.zeros((len(t), len(t), 3))
            direction[..., axis] = sign
            direction[..., i], direction[..., j] = bend[:, None], bend[None, :]
            direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
            corner = np.zeros_like(direction)
            corner[..., axis] = sign * core[axis]
            corner[..., i], corner[..., j] = inner[:, None] * core[i], inner[None, :] * core[j]
            face = grid(corner + bevel * direction, direction)
            if sign < 0:
                face.triangles = face.triangles[:, [0, 2, 1]]
            shapes.append(face)
    return joined(*shapes)


def write(path: Path, parts: list[Part]) -> None:
    """A .glb of parts [(name, Shape, offset, material)]; shapes used twice are stored once."""
    blob = b""
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    meshes: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = []
    materials: list[Material] = []
    stored: dict[int, tuple[dict[str, int], int]] = {}

    def store(array: NDArray[Any], target: int, kind: str, component: int) -> int:
        nonlocal blob
        blob += b"\0" * (-len(blob) % 4)
        data = np.ascontiguousarray(array).tobytes()
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data), "target": target})
        blob += data
        entry: dict[str, Any] = {
            "bufferView": len(views) - 1,
            "componentType": component,
            "count": array.size,
            "type": kind,
        }
        if kind == "VEC3":
            entry |= {"count": len(array), "min": array.min(0).tolist(), "max": array.max(0).tolist()}
        accessors.append(entry)
        return len(accessors) - 1

    for name, shape, offset, material in parts:
        if id(shape) not in stored:
            small = len(shape.positions) <= 65535
            corners = shape.triangles.astype(np.uint16 if small else np.uint32).reshape(-1)
            stored[id(shape)] = (
                {
                    "POSITION": store(shape.positions, 34962, "VEC3", 5126),
                    "NORMAL": store(shape.normals, 34962, "VEC3", 5126),
                },
                store(corners, 34963, "SCALAR", 5123 if small else 5125),
            )
        attributes, indices = stored[id(shape)]
        if material not in materials:
            materials.append(material)
        primitive = {"attributes": attributes, "indices": indices, "material": materials.index(material)}
        meshes.append({"name": name, "primitives": [primitive]})
        nodes.append({"name": name, "mesh": len(meshes) - 1, "translation": list(offset)})
    document = {
        "asset": {"version": "2.0", "generator": "MixLight scripts/make_objects.py"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    size = 12 + 8 + len(text) + 8 + len(blob)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, size))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(blob), b"BIN\0") + blob)
    print(f"{path}  {len(parts)} parts, {size / 1e3:.0f} kB")


def material(name: str, colour: tuple[float, float, float], metallic: float, roughness: float) -> Material:
    """A glTF material; `colour` is linear."""
    return {
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*colour, 1.0],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        },
    }


def spheres() -> list[Part]:
    """Diffuse gray, matte silver, mirror silver: the three of the protocol, side by side."""
    ball = sphere(0.1)
    return [
        ("diffuse gray", ball, (-0.23, 0, 0), material("diffuse gray", (0.5, 0.5, 0.5), 0.0, 1.0)),
        ("matte silver", ball, (0.0, 0, 0), material("matte silver", (0.8, 0.8, 0.8), 1.0, 0.33)),
        ("mirror silver", ball, (0.23, 0, 0), material("mirror silver", (0.8, 0.8, 0.8), 1.0, 0.02)),
    ]


def teapot() -> list[Part]:
    """A low, wide pot of glazed stoneware with a lid, a spout that rises in a curve, and a loop handle."""
    body = lathe(
        spline([(0.0, 0.0), (0.052, 0.0), (0.060, 0.004), (0.066, 0.012), (0.092, 0.040), (0.101, 0.068),
                (0.092, 0.098), (0.066, 0.119), (0.050, 0.125), (0.048, 0.130)], 72)
    )  # fmt: skip
    lid = lathe(
        spline([(0.047, 0.127), (0.049, 0.131), (0.046, 0.135), (0.032, 0.143), (0.014, 0.149),
                (0.008, 0.154), (0.009, 0.160), (0.015, 0.166), (0.014, 0.173), (0.006, 0.178),
                (0.0, 0.179)], 56)
    )  # fmt: skip
    spout = tube(
        [
            (0.050, 0.052, 0),
            (0.082, 0.056, 0),
            (0.112, 0.068, 0),
            (0.131, 0.094, 0),
            (0.146, 0.122, 0),
            (0.164, 0.132, 0),
        ],
        [0.022, 0.022, 0.019, 0.0145, 0.0115, 0.0105],
    )
    lip = tube([(0.164, 0.132, 0), (0.160, 0.130, 0), (0.146, 0.122, 0)], [0.0105, 0.008, 0.0075], 12)
    handle = tube(
        [(-0.066, 0.098, 0), (-0.112, 0.114, 0), (-0.142, 0.103, 0), (-0.148, 0.074, 0),
         (-0.130, 0.048, 0), (-0.074, 0.040, 0)],
        [0.008, 0.0085, 0.009, 0.0085, 0.008], 56, 24, flatten=1.35,
    )  # fmt: skip
    glaze = material("celadon glaze", (0.16, 0.34, 0.27), 0.0, 0.12)
    return [("pot", joined(body, spout, lip, handle), (0, 0, 0), glaze), ("lid", lid, (0, 0, 0), glaze)]


def chair() -> list[Part]:
    """A plain wooden chair: four splayed legs, stretchers, a seat with a cushion, three back slats."""
    wood, cloth = (
        material("oiled oak", (0.42, 0.25, 0.12), 0.0, 0.45),
        material("wool", (0.10, 0.16, 0.27), 0.0, 0.95),
    )
    splay = math.radians(3.5)
    parts = []
    for x in (-1, 1):
        front = box((0.036, 0.44, 0.036)).turned(2, x * splay).moved((x * 0.190, 0.2195, 0.185))
        back = (
            box((0.036, 0.44, 0.036)).turned(2, x * splay).turned(0, splay).moved((x * 0.180, 0.2195, -0.20))
        )
        post = box((0.034, 0.46, 0.030)).turned(0, -math.radians(9)).moved((x * 0.168, 0.66, -0.226))
        side = box((0.020, 0.026, 0.37)).moved((x * 0.192, 0.20, -0.008))
        parts += [front, back, post, side]
    parts.append(box((0.40, 0.028, 0.42), 0.010).moved((0, 0.447, 0.0)))
    parts.append(box((0.376, 0.026, 0.020)).moved((0, 0.20, -0.02)))
    for height in (0.62, 0.73, 0.84):
        depth = -0.226 - (height - 0.66) * math.tan(math.radians(9))
        parts.append(box((0.345, 0.062, 0.016)).turned(0, -math.radians(9)).moved((0, height, depth)))
    frame = joined(*parts)
    frame.positions[:, 1] -= frame.positions[:, 1].min()
    cushion = box((0.36, 0.045, 0.37), 0.020, 6).moved((0, 0.482, 0.008))
    return [("frame", frame, (0, 0, 0), wood), ("cushion", cushion, (0, 0, 0), cloth)]


if __name__ == "__main__":
    OUT.mkdir(parents=True, exist_ok=True)
    for make in (spheres, teapot, chair):
        write(OUT / f"{make.__name__}.glb", make())
