"""Rendered rooms on disk: one OpenEXR file a camera position, one JSON file a room.

The OpenEXR file has many parts. The first, `panorama`, is the room as its plan switches it, so that any
program shows it; then one part a light group, whose name it bears; at last `depth`. Colours are half floats,
exposed so that the mean luminance of the first part is 1; OpenEXR's attribute `whiteLuminance` says how many
cd/m² that is.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.rooms.plan import Camera, Plan, Point3
from mixlight.data.rooms.plan_json import from_document, to_document
from mixlight.data.rooms.sky import LUMENS_PER_UNIT
from mixlight.image.atomic import atomic_path
from mixlight.image.color import LUMINANCE_WEIGHTS, REC709
from mixlight.image.errors import file_error
from mixlight.image.exr import MAX_HALF
from mixlight.image.temperature import COOLEST, WARMEST, black_body

__all__ = [
    "CODECS",
    "DEPTH",
    "FORMAT",
    "PANORAMA",
    "SKY",
    "SUN",
    "VERSION",
    "RoomRender",
    "direction_from",
    "document_of",
    "group_names",
    "is_room",
    "read_document",
    "read_room",
    "room_document",
    "write_camera",
    "write_document",
]

FORMAT, VERSION = "mixlight-room", 1
SKY, SUN = "sky", "sun"
"""Light groups of what is outside."""
PANORAMA, DEPTH = "panorama", "depth"
"""Parts of the file that are no light group."""
CODECS = ("dwab", "zip")
"""How colours are compressed: lossy or lossless."""

_PEAK = MAX_HALF / 2
"""Brightest light that half floats hold once lossy compression has rung around it; parts with brighter ones,
such as the sun behind a pane, are lossless floats."""
_DOCUMENT = "mixlightRoom"
_CAMERA = "mixlightCamera"


@dataclass(frozen=True)
class RoomRender:
    """One camera position of a rendered room.

    Convention: radiance 1 is 683 cd/m²; the panoramas are in the canonical frame, their centre looks along
        the camera's `turn`.
    """

    groups: dict[str, Float[Tensor, "height width 3"]]
    """Radiance that each light group gives, fully on, in the order of the file."""
    depth: Float[Tensor, "height width"]
    """Metres to what is seen; infinity in the sky."""
    document: dict[str, Any]
    """The room's JSON."""
    camera: int
    """Place of this position among the document's cameras."""

    @property
    def plan(self) -> Plan:
        """The plan in the document."""
        return from_document(self.document["plan"])


def direction_from(camera: Camera, point: Point3) -> tuple[Point3, float]:
    """Where a point of the room frame is seen from a camera: unit direction in the canonical frame, metres.

    Convention: a camera that is not turned looks along the room's +Y, which is the canonical -Z; the room's
        +X is +X, its +Z is +Y.

    Raises:
        ValueError: the point is the camera's own place.

    >>> direction_from(Camera(0, (1.0, 1.0, 1.5), 0.0), (1.0, 3.0, 1.5))
    ((0.0, 0.0, -1.0), 2.0)
    """
    x, y, z = (p - c for p, c in zip(point, camera.position, strict=True))
    distance = math.sqrt(x * x + y * y + z * z)
    if distance == 0:
        raise ValueError(f"expected a point away from the camera, got its own place {point}")
    right, forward = _level_axes(camera.turn)
    along = x * forward[0] + y * forward[1]
    aside = x * right[0] + y * right[1]
    return (aside / distance, z / distance, 0.0 - along / distance), distance


def _level_axes(turn: float) -> tuple[tuple[float, float], tuple[float, float]]:
    c, s = math.cos(turn), math.sin(turn)
    return (c, s), (-s, c)


def room_document(
    plan: Plan,
    files: Sequence[str],
    *,
    render: Mapping[str, Any] | None = None,
    **further: Any,
) -> dict[str, Any]:
    """What is known of a room beside its pictures, as plain values for JSON.

    Args:
        plan: the room.
        files: name of each camera's OpenEXR file, in the order of the plan's cameras.
        render: settings of the renderer.
        further: more entries (versions, seconds ...).

    Raises:
        ValueError: not as many files as cameras.
    """
    if len(files) != len(plan.cameras):
        raise ValueError(f"expected {len(plan.cameras)} files, one a camera, got {len(files)}")
    lights: list[dict[str, Any]] = []
    for name in group_names(plan):
        members = [f for f in plan.fixtures if f.group == name]
        entry: dict[str, Any] = {"group": name, "on": all(f.on for f in members) if members else True}
        if name == SKY:
            entry |= {"kind": SKY, "illuminance_lx": plan.sky.illuminance, "time": plan.sky.time}
            entry |= {"panorama": plan.sky.file}
        elif name == SUN:
            entry |= {"kind": SUN, "illuminance_lx": plan.sky.sun_illuminance}
            entry |= {"temperature_k": plan.sky.sun_temperature, "from_cameras": _sun_directions(plan)}
        else:
            entry |= {"kind": members[0].kind, "fixtures": [_fixture(plan, f) for f in members]}
        lights.append(entry)
    return {
        "format": FORMAT,
        "version": VERSION,
        "unit_cd_per_m2": LUMENS_PER_UNIT,
        "directions": "mixlight: +X right, +Y up, -Z the centre of the camera's panorama",
        "cameras": [
            {"file": file, "space": c.space, "position": list(c.position), "turn": c.turn}
            for file, c in zip(files, plan.cameras, strict=True)
        ],
        "lights": lights,
        "render": dict(render or {}),
        **further,
        "plan": to_document(plan),
    }


def group_names(plan: Plan) -> list[str]:
    """Every light group of a plan: the fixtures' in their order, the sky, and the sun where there is one."""
    names = list(dict.fromkeys(fixture.group for fixture in plan.fixtures))
    sun = plan.sky.sun_direction is not None and plan.sky.sun_illuminance > 0
    return [*names, SKY, *([SUN] if sun else [])]


def _fixture(plan: Plan, fixture: Any) -> dict[str, Any]:
    colour = black_body(min(max(fixture.temperature, WARMEST), COOLEST))
    seen = []
    for camera in plan.cameras:
        direction, distance = direction_from(camera, fixture.position)
        seen.append({"direction": list(direction), "distance_m": distance})
    return {
        "name": fixture.name,
        "kind": fixture.kind,
        "space": fixture.space,
        "position": list(fixture.position),
        "size": list(fixture.size),
        "power_lm": fixture.power,
        "temperature_k": fixture.temperature,
        "colour": [round(float(c), 5) for c in colour],
        "from_cameras": seen,
    }


def _sun_directions(plan: Plan) -> list[dict[str, Any]]:
    directions = []
    for camera in plan.cameras:
        x, y, z = plan.sky.sun_direction or (0.0, 0.0, 1.0)
        right, forward = _level_axes(camera.turn)
        aside, along = x * right[0] + y * right[1], x * forward[0] + y * forward[1]
        directions.append({"direction": [aside, z, 0.0 - along]})
    return directions


def write_document(path: str | os.PathLike[str], document: Mapping[str, Any]) -> None:
    """Writes a room's JSON, whole or not at all.

    Raises:
        ValueError: a value that JSON cannot hold.
        OSError: the file cannot be made.
    """
    text = json.dumps(document, indent=1, allow_nan=False)
    with atomic_path(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def read_document(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Reads a room's JSON.

    Raises:
        ValueError: no JSON, not a room's, or of another version; the message names the file.
        OSError: the file cannot be read.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except ValueError as error:
        raise file_error(path, "a room's JSON", str(error)) from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise file_error(path, f"a document of format {FORMAT}", "another one")
    if document.get("version") != VERSION:
        raise file_error(path, f"version {VERSION} of {FORMAT}", f"{document.get('version')!r}")
    return document


def write_camera(
    path: str | os.PathLike[str],
    groups: Mapping[str, Float[np.ndarray, "height width 3"]],
    depth: Float[np.ndarray, "height width"],
    *,
    document: str,
    camera: int,
    on: Mapping[str, bool] | None = None,
    codec: str = "dwab",
    level: float = 45.0,
) -> None:
    """Writes the light groups and the depth of one camera position, atomically.

    Args:
        path: the .exr to make.
        groups: radiance of every group, fully on, 2:1, finite and not negative.
        depth: metres; what is not finite is written as infinity.
        document: file name of the room's JSON, which lies in the same folder.
        camera: place of this position in it.
        on: groups that the plan switches off are False; they stay out of the first part only.
        codec: one of `CODECS`.
        level: how much `dwab` may lose; 45 is OpenEXR's own.

    Raises:
        ValueError: shapes that do not fit, values that are no radiance, a name that is taken, another codec.
        OSError: the file cannot be made.
    """
    import OpenEXR

    if codec not in CODECS:
        raise ValueError(f"expected a codec of {', '.join(CODECS)}, got {codec!r}")
    if not groups or {PANORAMA, DEPTH} & set(groups):
        raise ValueError(
            f"{path}: expected groups of other names than {PANORAMA} and {DEPTH}, got {list(groups)}"
        )
    shape = (*depth.shape, 3)
    total = np.zeros(shape, np.float64)
    for name, pixels in groups.items():
        if pixels.shape != shape or shape[1] != 2 * shape[0]:
            raise ValueError(
                f"{path}: expected {name} of the shape {list(shape)}, 2:1, got {list(pixels.shape)}"
            )
        low, high = float(pixels.min()), float(pixels.max())
        if not (low >= 0 and high < math.inf):
            raise ValueError(f"{path}: expected finite radiance from 0 on in {name}, got {low:g} to {high:g}")
        if on is None or on.get(name, True):
            total += pixels
    unit = _mean_luminance(total) or 1.0
    common = {
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC709,
        "envmap": OpenEXR.ENVMAP_LATLONG,
        "whiteLuminance": unit * LUMENS_PER_UNIT,
    }
    colours = dict(common)
    if codec == "dwab":
        colours |= {"compression": OpenEXR.DWAB_COMPRESSION, "dwaCompressionLevel": level}
    else:
        colours |= {"compression": OpenEXR.ZIP_COMPRESSION}
    told = {_DOCUMENT: document, _CAMERA: camera, "frame": "mixlight"}
    parts = []
    for name, pixels in {PANORAMA: total, **groups}.items():
        header = colours | told if name == PANORAMA else dict(colours)
        shown = pixels / unit
        if float(shown.max()) > _PEAK:
            header["compression"] = OpenEXR.ZIP_COMPRESSION
        kind = np.float32 if float(shown.max()) > _PEAK else np.float16
        parts.append(OpenEXR.Part(header, {"RGB": np.asarray(shown, kind)}, name))
    metres = np.where(np.isfinite(depth), depth, np.inf).astype(np.float32)
    parts.append(OpenEXR.Part(common | {"compression": OpenEXR.ZIP_COMPRESSION}, {"Z": metres}, DEPTH))
    with atomic_path(path) as temporary:
        try:
            OpenEXR.File(parts).write(str(temporary))
        except RuntimeError as error:
            reason = str(error).replace(str(temporary), str(path))
            raise OSError(f"{path}: expected to write an OpenEXR file, received: {reason}") from None


def _mean_luminance(panorama: Float[np.ndarray, "height width 3"]) -> float:
    rows = (panorama @ np.array(LUMINANCE_WEIGHTS)).mean(1)
    edges = np.cos(np.linspace(0.0, math.pi, len(rows) + 1))
    return float(rows @ (edges[:-1] - edges[1:]) / 2)


def is_room(path: str | os.PathLike[str]) -> bool:
    """Whether a file is a camera position with light groups, from its header alone."""
    with open(path, "rb") as file:
        return _DOCUMENT.encode() in file.read(4096)


def document_of(path: str | os.PathLike[str]) -> Path:
    """The JSON of the room to which a camera position belongs, from the header alone.

    Raises:
        ValueError: no camera position with light groups.
        OSError: the file cannot be read.
    """
    import OpenEXR

    if not is_room(path):
        raise file_error(path, "a rendered room with light groups", "another file")
    try:
        header = OpenEXR.File(str(Path(path)), header_only=True).parts[0].header
        return Path(path).with_name(str(header[_DOCUMENT]))
    except (RuntimeError, ValueError, LookupError) as error:
        raise file_error(path, "an OpenEXR header", error) from None


def read_room(path: str | os.PathLike[str]) -> RoomRender:
    """Reads one camera position with its light groups, and the JSON of its room.

    Lossy compression rings slightly below 0 beside edges; that becomes 0.

    Raises:
        ValueError: not such a file, or its JSON is not a room's.
        OSError: a file cannot be read.
    """
    import OpenEXR

    if not is_room(path):
        raise file_error(path, "a rendered room with light groups", "another file")
    try:
        file = OpenEXR.File(str(Path(path)))
    except (RuntimeError, ValueError) as error:
        raise file_error(path, "an OpenEXR picture that can be decoded", error) from None
    groups: dict[str, Tensor] = {}
    depth = None
    for part in file.parts:
        name, channels = part.name(), part.channels
        if name == DEPTH and "Z" in channels:
            depth = torch.from_numpy(np.ascontiguousarray(channels["Z"].pixels, np.float32))
        elif name != PANORAMA and "RGB" in channels:
            if not np.isfinite(channels["RGB"].pixels).all():
                raise file_error(path, f"finite light in {name}", "infinite or no numbers")
            unit = float(part.header["whiteLuminance"]) / LUMENS_PER_UNIT
            groups[name] = torch.from_numpy(channels["RGB"].pixels.astype(np.float32)).clamp(min=0) * unit
    if not groups or depth is None:
        raise file_error(path, "light groups and a depth", "corrupt pixel data")
    header = file.parts[0].header
    document = read_document(Path(path).with_name(str(header[_DOCUMENT])))
    return RoomRender(groups, depth, document, int(header[_CAMERA]))
