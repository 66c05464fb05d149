"""Small glTF files made on the spot, right or wrong."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np


def document(positions: Any = None, indices: Any = None, **more: Any) -> tuple[dict[str, Any], bytes]:
    """A glTF with one node, one mesh and one buffer; `more` replaces top-level entries."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]] if positions is None else positions, np.float32)
    corners = np.array([0, 1, 2] if indices is None else indices, np.uint32)
    blob = points.tobytes() + corners.tobytes()
    found: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": corners.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": corners.nbytes},
        ],
        "buffers": [{"byteLength": len(blob)}],
    }
    return found | more, blob


def write_glb(path: Path, found: dict[str, Any], blob: bytes = b"") -> Path:
    """The binary container."""
    text = json.dumps(found).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    size = 12 + 8 + len(text) + (8 + len(blob) if blob else 0)
    data = struct.pack("<4sII", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON") + text
    if blob:
        data += struct.pack("<I4s", len(blob), b"BIN\0") + blob
    path.write_bytes(data)
    return path


def write_gltf(path: Path, found: dict[str, Any], uri: str) -> Path:
    """The text container, whose buffer lies at a URI."""
    found = found | {"buffers": [{"byteLength": found["buffers"][0]["byteLength"], "uri": uri}]}
    path.write_text(json.dumps(found))
    return path
