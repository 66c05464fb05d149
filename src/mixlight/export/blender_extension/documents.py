"""What can be loaded: an exported folder with `rig.json`, or any `lighting.json`. No Blender in here."""

import json
import math
from pathlib import Path


def resolve(path):
    """Which document a path means.

    A document may be named itself, or the folder it is in. A folder that `mixlight estimate --for blender`
    made has the export in its subfolder `blender`, which goes before its `lighting.json`.

    Returns:
        The path of a `rig.json` or of a `lighting.json` (under whatever name).

    Raises:
        ValueError: nothing of the kind is there.
    """
    path = Path(path)
    if not path.is_dir():
        return path
    for name in ("rig.json", "blender/rig.json", "lighting.json"):
        if (path / name).is_file():
            return path / name
    raise ValueError(f"{path}: expected a folder with rig.json or lighting.json, received one without")


def is_rig(path):
    """Whether a document is of the format mixlight/rig, by what it says itself.

    Raises:
        ValueError: no JSON, or neither a rig nor a lighting; OSError: it cannot be read.
    """
    return _read(path).get("format") == "mixlight/rig"


def read_lighting(path):
    """Read a `lighting.json` and check all that is used of it.

    Raises:
        ValueError: no such document, with the entry and what was expected; OSError: it cannot be read.
    """
    document = _read(path)
    try:
        _check(document)
    except (KeyError, TypeError, IndexError) as error:
        raise ValueError(f"{path}: expected a lighting document, received one without {error}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return document


def to_rig(document, separate):
    """The rig in Blender's axes that a lighting document stands for.

    Args:
        document: as `read_lighting` returns it.
        separate: True: the lights are on and the map has to be the residual one; False: the map holds all.
    """
    return {
        "format": "mixlight/rig",
        "version": 1,
        "frame": "blender",
        "map": "residual" if separate and document["lights"] else "full",
        "lights": [
            {
                "name": light["name"],
                "direction": _blender_axes(light["direction"]),
                "irradiance": light["irradiance"],
                "angular_diameter_deg": light["angular_diameter_deg"],
                "enabled": bool(separate),
            }
            for light in document["lights"]
        ],
    }


def _blender_axes(direction):
    x, y, z = direction
    return [x, -z, y]


def _read(path):
    try:
        document = json.loads(Path(path).read_bytes())
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path}: expected a JSON document, received {error}") from None
    if not isinstance(document, dict) or document.get("format") not in ("mixlight/rig", "mixlight/lighting"):
        raise ValueError(f"{path}: expected a document of the format mixlight/rig or mixlight/lighting")
    return document


def _check(document):
    if (
        document["format"] != "mixlight/lighting"
        or document["version"] not in (1, 2)
        or document["frame"] != "mixlight"
    ):
        raise ValueError("expected the format mixlight/lighting, version 1 or 2, frame mixlight")
    ambient, sources = document["ambient"], document["sources"]
    if (ambient["kind"], ambient["basis"], ambient["order"]) != ("radiance", "real-sh", "l*l+l+m"):
        raise ValueError("ambient: expected radiance in real harmonics of the order l*l+l+m")
    degree = ambient["degree"]
    if (
        not isinstance(degree, int)
        or degree not in range(7)
        or len(ambient["coefficients"]) != (degree + 1) ** 2
    ):
        raise ValueError("ambient: expected a degree from 0 to 6 and (degree + 1)^2 coefficients")
    if sources["anchors"] != "vogel" or not _finite([sources["sharpness"]], above=0):
        raise ValueError("sources: expected vogel anchors and a sharpness above 0")
    if document["version"] == 2:
        if not _finite([sources["turn_deg"]]):
            raise ValueError("sources.turn_deg: expected an angle")
        for group in sources["groups"]:
            if not all(anchor in range(sources["count"]) for anchor in group["anchors"]):
                raise ValueError("sources.groups: expected anchors")
    for rgb in ambient["coefficients"]:
        if len(rgb) != 3 or not _finite(rgb):
            raise ValueError("ambient.coefficients: expected three numbers each")
    for index, *rgb in sources["energy"]:
        if (
            not isinstance(index, int)
            or index not in range(sources["count"])
            or len(rgb) != 3
            or not _finite(rgb, least=0)
        ):
            raise ValueError("sources.energy: expected an anchor and three numbers of at least 0 each")
    for light in document["lights"]:
        direction, irradiance = light["direction"], light["irradiance"]
        if not isinstance(light["name"], str) or not _finite([light["angular_diameter_deg"]], above=0):
            raise ValueError("lights: expected a name and an angular diameter above 0")
        if len(direction) != 3 or not _finite(direction) or abs(math.hypot(*direction) - 1) > 1e-2:
            raise ValueError("lights: expected directions of length 1")
        if len(irradiance) != 3 or not _finite(irradiance, least=0):
            raise ValueError("lights: expected an irradiance of three numbers of at least 0")


def _finite(values, least=-math.inf, above=-math.inf):
    return all(
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and math.isfinite(value)
        and value >= least
        and value > above
        for value in values
    )
