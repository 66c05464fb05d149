"""`lighting.json`: the whole light on one page of text, from which the environment map can be made again.

The shape is that of ``lighting.schema.json`` (JSON Schema 2020-12), which ships beside this file.
`from_document` checks the same and more by hand, so that nothing but the standard library is needed to read a
file safely and every complaint names the entry.
"""

import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from mixlight.image.atomic import atomic_path
from mixlight.light import entries
from mixlight.light.document_check import EDITED_VERSION, FORMAT, VERSION, check
from mixlight.light.lighting import Group, Lighting
from mixlight.light.lights import merge


def to_document(
    lighting: Lighting, photo: Mapping[str, Any] | None = None, model: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """The lighting as a document of lists and numbers, in the shape of the schema.

    Every lobe that is not 0 is listed (call `Lighting.pruned` first for the strong ones alone). A number is
    the shortest one that reads back as the same float32, so that the map rebuilt from the document equals the
    lighting's.

    Args:
        lighting: a single one, not a batch.
        photo: what is known of the photo: name, width, height, camera {pitch_deg, roll_deg, fov_deg,
            fov_source}...
        model: the network's card.

    Convention: the document's frame is the lighting's, +X right, +Y up, -Z forward. ``lights`` says again
        what ``sources`` says, for readers without environment maps. The document is of version 1, or of
        version 2 where the lighting has a turn or groups.

    Raises:
        ValueError: a batch of lightings, or a photo or model that is no JSON or not of the schema's shape.

    >>> lighting = Lighting(torch.zeros(9, 3), torch.eye(128)[:, :3] * 0.1)
    >>> to_document(lighting)["sources"]["energy"]
    [[0, 0.1, 0.0, 0.0], [1, 0.0, 0.1, 0.0], [2, 0.0, 0.0, 0.1]]
    """
    lights = merge(lighting)  # refuses a batch
    energy = lighting.energy.detach()
    edited = bool(lighting.turn or lighting.groups)
    document = {
        "format": FORMAT,
        "version": EDITED_VERSION if edited else VERSION,
        "frame": lighting.frame,
        "exposure_gain": float(lighting.exposure_gain),
        "ambient": {
            "kind": "radiance",
            "basis": "real-sh",
            "order": "l*l+l+m",
            "degree": lighting.degree,
            "coefficients": numbers(lighting.ambient),
        },
        "sources": {
            "anchors": "vogel",
            "count": len(energy),
            "sharpness": float(lighting.sharpness),
            "energy": _rows(range(len(energy)), energy),
        }
        | (_edits(lighting) if edited else {}),
        "lights": [
            {
                "name": light.name,
                "direction": numbers(light.direction),
                "irradiance": numbers(light.irradiance),
                "angular_diameter_deg": round(math.degrees(light.angular_diameter), 4),
            }
            for light in lights
        ],
        "photo": _plain(photo, "photo"),
        "model": _plain(model, "model"),
    }
    check(document)
    return document


def from_document(document: Mapping[str, Any], dtype: torch.dtype = torch.float32) -> Lighting:
    """The lighting that a document holds.

    Raises:
        ValueError: the document is not of the schema's shape, naming the entry, what was expected and
            received.

    >>> lighting = Lighting(torch.ones(9, 3), torch.eye(128)[:, :3])
    >>> again = from_document(to_document(lighting))
    >>> bool((again.environment(32) == lighting.environment(32)).all())
    True
    """
    check(document)
    sources = document["sources"]
    return Lighting(
        torch.tensor(document["ambient"]["coefficients"], dtype=dtype),
        _energy(sources["energy"], sources["count"], dtype),
        sharpness=float(sources["sharpness"]),
        exposure_gain=float(document["exposure_gain"]),
        turn=math.radians(sources.get("turn_deg", 0.0)),
        groups=tuple(
            Group(
                group["name"],
                tuple(group["anchors"]),
                _energy(group["off"], sources["count"], dtype)[group["anchors"]] if "off" in group else None,
            )
            for group in sources.get("groups", ())
        ),
    )


def dumps(document: Mapping[str, Any]) -> str:
    """The document as text, indented, with each row of numbers on one line.

    Raises:
        ValueError: the document holds what is no JSON (NaN, for instance).

    >>> print(dumps({"a": [[1, 2.5], [3, 4]], "b": None}), end="")
    {
      "a": [
        [1, 2.5],
        [3, 4]
      ],
      "b": null
    }
    """
    return _text(document, "") + "\n"


def save(light: Lighting | Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    """Write a lighting, or a document made by `to_document`, to a file; the file appears whole or not at all.

    Raises:
        ValueError: a batch of lightings, or a document that is not of the schema's shape.
        OSError: the folder is missing or cannot be written to.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save(Lighting(torch.ones(9, 3), torch.ones(128, 3)), f"{folder}/lighting.json")
    ...     load(f"{folder}/lighting.json").total_energy()
    tensor([131.5449, 131.5449, 131.5449])
    """
    if isinstance(light, Lighting):
        document: Mapping[str, Any] = to_document(light)
    else:
        document = light
        check(document)
    text = dumps(document)
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def load(path: str | os.PathLike[str]) -> Lighting:
    """Read the lighting from a file.

    Raises:
        ValueError: the file holds no such document; the message names the file and the entry.
        OSError: the file cannot be read.
    """
    return from_document(read(path))


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the whole document from a file, with photo, model and lights, and check it.

    Raises:
        ValueError: the file holds no such document; the message names the file and the entry.
        OSError: the file cannot be read.
    """
    document = entries.load(path)
    try:
        check(document)
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)}: {error}") from error
    checked: dict[str, Any] = document
    return checked


def schema() -> dict[str, Any]:
    """The JSON Schema of the document.

    >>> schema()["title"]
    'MixLight lighting, versions 1 and 2'
    """
    from importlib.resources import files  # only wanted here, and slow to import

    text = files("mixlight.light").joinpath("lighting.schema.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def _edits(lighting: Lighting) -> dict[str, Any]:
    """What version 2 says of the sources beyond version 1."""
    return {
        "turn_deg": math.degrees(lighting.turn),
        "groups": [
            {"name": group.name, "anchors": list(group.anchors)}
            | ({} if group.off is None else {"off": _rows(group.anchors, group.off)})
            for group in lighting.groups
        ],
    }


def _rows(anchors: Iterable[int], energy: Tensor) -> list[list[float]]:
    """[anchor, r, g, b] of each lobe that is not dark."""
    lit = (energy != 0).any(-1).tolist()
    return [
        [anchor, *numbers(rgb)] for anchor, rgb, is_lit in zip(anchors, energy, lit, strict=True) if is_lit
    ]


def _energy(rows: Iterable[Sequence[float]], count: int, dtype: torch.dtype) -> Tensor:
    energy = torch.zeros(count, 3, dtype=dtype)
    for index, *rgb in rows:
        energy[int(index)] = torch.tensor(rgb, dtype=dtype)
    return energy


def numbers(tensor: Tensor) -> Any:
    """Nested lists of the shortest decimals that read back as the same number, for JSON.

    >>> numbers(torch.tensor([0.1, 1 / 3]))
    [0.1, 0.33333334]
    """
    if tensor.ndim:
        return [numbers(row) for row in tensor.detach().cpu()]
    if tensor.dtype == torch.float64:
        return tensor.item()
    return float(str(np.float32(tensor.item())))


def _plain(value: Mapping[str, Any] | None, what: str) -> dict[str, Any] | None:
    """A copy that shares nothing with the caller's."""
    if value is None:
        return None
    try:
        copy: dict[str, Any] = json.loads(json.dumps(dict(value), allow_nan=False))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{what}: expected what JSON can hold, received {error}") from error
    return copy


def _text(value: Any, indent: str) -> str:
    inner = indent + "  "
    if isinstance(value, Mapping) and value:
        rows = [f"{inner}{json.dumps(str(key))}: {_text(entry, inner)}" for key, entry in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"
    if isinstance(value, list | tuple) and any(isinstance(entry, Mapping | list | tuple) for entry in value):
        return "[\n" + ",\n".join(inner + _text(entry, inner) for entry in value) + f"\n{indent}]"
    try:
        return json.dumps(value, allow_nan=False)
    except TypeError as error:
        raise ValueError(f"expected what JSON can hold, received {error}") from error
