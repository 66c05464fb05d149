"""The outside of a glTF 2.0 file: container, structure, buffers and accessors, every byte of it checked.

Models come from anywhere. Nothing outside the model's own folder is opened and nothing is fetched, whatever
the file says; every offset, count and index is held against what is really there before it is used.

Source: Khronos Group, glTF 2.0 specification, sections 3.6 (binary data), 4 (GLB).
"""

import base64
import binascii
import json
import os
import re
import struct
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np
from jaxtyping import Num

from mixlight.image.errors import one_line

__all__ = ["MAX_BYTES", "Gltf", "ModelError"]

MAX_BYTES = 512 * 2**20
"""Larger files, and files beside the model that are larger, are refused."""

MAX_DEPTH = 256
"""Nodes nested deeper are refused."""

_COMPONENTS = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_KINDS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_UNDERSTOOD = {"KHR_mesh_quantization", "KHR_texture_transform"}
"""Extensions that a model may require; those that it merely uses do not change its shape."""


class ModelError(ValueError):
    """A file cannot serve as a model; the message names the file, what was expected and what was received."""


class Gltf:
    """A .glb or .gltf file that was read, with its entries and its binary data.

    Raises:
        ModelError: no glTF 2.0, truncated, too large, or in need of an extension that is not understood.
        OSError: the file cannot be read.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        data = self._read_file(self.path)
        text, self._binary = self._split(data)
        try:
            document = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise self.error("JSON", one_line(error)) from None
        version = document.get("asset", {}) if isinstance(document, dict) else None
        version = version.get("version") if isinstance(version, dict) else None
        if not (isinstance(version, str) and version.startswith("2.")):
            raise self.error("a glTF of version 2", f"version {version!r}")
        self.document: dict[str, Any] = document
        required = document.get("extensionsRequired", [])
        if not isinstance(required, list):
            raise self.error("a list extensionsRequired", one_line(required))
        unknown = [name for name in required if name not in _UNDERSTOOD]
        if unknown:
            raise self.error(
                "a model that needs no extension but " + ", ".join(sorted(_UNDERSTOOD)),
                ", ".join(one_line(name, 60) for name in unknown),
            )
        self._buffers: dict[int, bytes] = {}

    def error(self, expected: str, received: object) -> ModelError:
        """The error of this file; the caller raises it."""
        return ModelError(f"{one_line(self.path, 4096)}: expected {expected}, received {one_line(received)}")

    def entry(self, kind: str, index: object) -> dict[str, Any]:
        """The object number `index` of the top-level list `kind`.

        Raises:
            ModelError: there is no such object.
        """
        entries = self.document.get(kind, [])
        if not isinstance(entries, list):
            raise self.error(f"a list of {kind}", one_line(entries, 60))
        if not (isinstance(index, int) and not isinstance(index, bool) and 0 <= index < len(entries)):
            raise self.error(f"an index below {len(entries)} into {kind}", index)
        found = entries[index]
        if not isinstance(found, dict):
            raise self.error(f"an object in {kind}", one_line(found, 60))
        return found

    def whole(self, entry: dict[str, Any], name: str, default: int | None = None) -> int:
        """A whole number of at least 0 in an entry.

        Raises:
            ModelError: it is absent and has no default, or is something else.
        """
        value = entry.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**40:
            raise self.error(f"a whole number {name} of at least 0", value)
        return value

    def view(self, index: object) -> memoryview:
        """The bytes of a buffer view.

        Raises:
            ModelError: it reaches beyond its buffer.
        """
        view = self.entry("bufferViews", index)
        data = self._buffer(view.get("buffer"))
        start, size = self.whole(view, "byteOffset", 0), self.whole(view, "byteLength")
        if start + size > len(data):
            raise self.error(f"buffer view {index} within {len(data)} bytes", f"{start} + {size}")
        return memoryview(data)[start : start + size]

    def accessor(self, index: object, kinds: tuple[str, ...]) -> Num[np.ndarray, "count components"]:
        """The elements of an accessor, sparse ones filled in, normalised integers as floats.

        Args:
            index: its number.
            kinds: the types that are expected, such as ("VEC3",).

        Raises:
            ModelError: it is of another type, or reaches beyond its buffer view.
        """
        entry = self.entry("accessors", index)
        kind, code = entry.get("type"), entry.get("componentType")
        if kind not in kinds or not isinstance(code, int) or code not in _COMPONENTS:
            raise self.error(f"accessor {index} of type {' or '.join(kinds)}", f"{kind!r} of {code!r}")
        dtype, width = np.dtype(_COMPONENTS[code]).newbyteorder("<"), _KINDS[kind]
        count = self.whole(entry, "count")
        if not 1 <= count <= MAX_BYTES:
            raise self.error(f"accessor {index} of 1 to {MAX_BYTES} elements", count)
        if "bufferView" in entry:
            values = self._elements(entry, entry["bufferView"], count, dtype, width).copy()
        elif count * width * dtype.itemsize > MAX_BYTES:
            raise self.error(f"accessor {index} of at most {MAX_BYTES} bytes", f"{count} elements")
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in entry:
            self._fill(values, entry["sparse"], dtype, width)
        if entry.get("normalized") is True and dtype.kind in "iu":
            largest = 2 ** (8 * dtype.itemsize - (dtype.kind == "i")) - 1
            return np.asarray(np.maximum(values.astype(np.float32) / largest, -1.0))
        return np.asarray(values)

    def image(self, index: object) -> bytes:
        """The encoded bytes of an image.

        Raises:
            ModelError: it is not in the file nor beside it.
        """
        entry = self.entry("images", index)
        if "bufferView" in entry:
            return bytes(self.view(entry["bufferView"]))
        return self._load(entry.get("uri"), f"image {index}")

    def _elements(
        self, entry: dict[str, Any], view: object, count: int, dtype: "np.dtype[Any]", width: int
    ) -> Num[np.ndarray, "count components"]:
        data = self.view(view)
        size = dtype.itemsize * width
        stride = self.whole(self.entry("bufferViews", view), "byteStride", size) or size
        start = self.whole(entry, "byteOffset", 0)
        needed = start + stride * (count - 1) + size
        if stride < size or needed > len(data):
            raise self.error(
                f"{count} elements of {size} bytes within {len(data)}", f"{needed} bytes (stride {stride})"
            )
        return np.ndarray((count, width), dtype, data, start, (stride, dtype.itemsize))

    def _fill(self, values: Num[np.ndarray, "count components"], sparse: Any, dtype: Any, width: int) -> None:
        try:
            where, what = sparse["indices"], sparse["values"]
            code = _COMPONENTS[where["componentType"]]
            count = self.whole(sparse, "count")
            index_type = np.dtype(code).newbyteorder("<")
            index = self._elements(where, where["bufferView"], count, index_type, 1)[:, 0]
            filled = self._elements(what, what["bufferView"], count, dtype, width)
        except (TypeError, KeyError, AttributeError) as error:
            raise self.error("a sparse accessor with indices and values", repr(error)) from None
        if index.dtype.kind != "u" or (len(index) and int(index.max()) >= len(values)):
            raise self.error(f"sparse indices below {len(values)}", int(index.max()))
        values[index] = filled

    def _buffer(self, index: object) -> bytes:
        entry = self.entry("buffers", index)
        assert isinstance(index, int)
        if index not in self._buffers:
            if "uri" in entry:
                data = self._load(entry["uri"], f"buffer {index}")
            elif index == 0 and self._binary is not None:
                data = self._binary
            else:
                raise self.error(f"buffer {index} with a uri or in the file", "neither")
            size = self.whole(entry, "byteLength")
            if size > len(data):
                raise self.error(f"buffer {index} of {size} bytes", f"{len(data)} bytes")
            self._buffers[index] = data[:size]
        return self._buffers[index]

    def _load(self, uri: object, what: str) -> bytes:
        """The bytes that a URI stands for: base64 in the file, or a file in the model's folder, no more."""
        if not isinstance(uri, str) or not uri:
            raise self.error(f"{what} with a uri", repr(uri))
        if uri[:5].lower() == "data:":
            head, comma, body = uri.partition(",")
            if not comma or not head.endswith(";base64"):
                raise self.error(f"{what} as base64 data", one_line(head, 60))
            try:
                return base64.b64decode(body, validate=True)
            except binascii.Error as error:
                raise self.error(f"{what} as base64 data", error) from None
        plain = unquote(uri)
        parts = PurePosixPath(plain).parts
        hostile = (
            re.match(r"[A-Za-z][A-Za-z0-9+.-]*:", plain)
            or plain.startswith(("/", "~"))
            or ".." in parts
            or any(c in plain for c in "\\:?#")
            or not plain.isprintable()
        )
        folder = Path(os.path.realpath(self.path.parent))
        target = Path(os.path.realpath(folder / plain)) if not hostile else folder
        if hostile or not target.is_relative_to(folder):
            raise self.error(f"{what} in the model's own folder", f"the uri {one_line(uri, 80)!r}")
        if not target.is_file():
            raise self.error(
                f"{what} in the model's own folder", f"{one_line(uri, 80)!r}, which is no file there"
            )
        return self._read_file(target)

    def _read_file(self, path: Path) -> bytes:
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > MAX_BYTES:
                raise self.error(f"files of at most {MAX_BYTES} bytes", f"{path.name} of {size}")
            return file.read(MAX_BYTES)

    def _split(self, data: bytes) -> tuple[bytes, bytes | None]:
        """JSON text and binary chunk."""
        if data[:4] != b"glTF":
            if data.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] != b"{":
                raise self.error("a glTF model (.glb or .gltf)", f"a file that starts with {data[:8]!r}")
            return data, None
        version, size = struct.unpack("<II", data[4:12]) if len(data) >= 12 else (0, 0)
        if version != 2 or size > len(data) or len(data) < 20:
            raise self.error(
                f"a complete GLB of version 2 and {size} bytes", f"version {version}, {len(data)} bytes"
            )
        chunks: dict[bytes, bytes] = {}
        position = 12
        while position + 8 <= size:
            length, kind = struct.unpack_from("<I4s", data, position)
            if position + 8 + length > size:
                raise self.error("GLB chunks within the file", f"one of {length} bytes at {position}")
            chunks.setdefault(kind, data[position + 8 : position + 8 + length])
            position += 8 + length
        if b"JSON" not in chunks:
            raise self.error("a GLB with a JSON chunk", "none")
        return chunks[b"JSON"], chunks.get(b"BIN\0")
