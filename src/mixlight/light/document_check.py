"""Strict check of a lighting document, entry by entry, with complaints that name the entry."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from mixlight.light.harmonics import MAX_DEGREE
from mixlight.light.lighting import FRAME

FORMAT = "mixlight/lighting"
VERSION = 1


def check(document: object) -> None:
    """Refuse what is no lighting document of version 1.

    All that ``lighting.schema.json`` says holds, and what no schema can say: numbers are finite, an anchor's
    index is below their count and appears once, directions have the length 1.

    Args:
        document: as `json.loads` gives it; keys of ``photo`` and ``model`` that are not ours are let through.

    Raises:
        ValueError: with the entry, what was expected and what was received.

    >>> check({"format": "other"})
    Traceback (most recent call last):
    ValueError: format: expected 'mixlight/lighting', received 'other'
    """
    top = _mapping(document, "the document")
    _equal(top.get("format"), "format", FORMAT)
    _equal(top.get("version"), "version", VERSION)
    _keys(
        top,
        "the document",
        ("format", "version", "frame", "exposure_gain", "ambient", "sources", "lights", "photo", "model"),
    )
    _equal(top["frame"], "frame", FRAME)
    _number(top["exposure_gain"], "exposure_gain", above=0)
    _ambient(top["ambient"])
    _sources(top["sources"])
    for place, light in enumerate(_list(top["lights"], "lights")):
        _light(light, f"lights[{place}]")
    if top["photo"] is not None:
        _photo(_mapping(top["photo"], "photo"))
    if top["model"] is not None:
        model = _mapping(top["model"], "model")
        if "name" in model:
            _string(model["name"], "model.name")


def _ambient(value: object) -> None:
    ambient = _mapping(value, "ambient")
    _keys(ambient, "ambient", ("kind", "basis", "order", "degree", "coefficients"))
    _equal(ambient["kind"], "ambient.kind", "radiance")
    _equal(ambient["basis"], "ambient.basis", "real-sh")
    _equal(ambient["order"], "ambient.order", "l*l+l+m")
    degree = _whole(ambient["degree"], "ambient.degree", 0, MAX_DEGREE)
    rows = _list(ambient["coefficients"], "ambient.coefficients", (degree + 1) ** 2)
    for place, row in enumerate(rows):
        _rgb(row, f"ambient.coefficients[{place}]")


def _sources(value: object) -> None:
    sources = _mapping(value, "sources")
    _keys(sources, "sources", ("anchors", "count", "sharpness", "energy"))
    _equal(sources["anchors"], "sources.anchors", "vogel")
    count = _whole(sources["count"], "sources.count", 1, 1 << 20)
    _number(sources["sharpness"], "sources.sharpness", above=0)
    seen = set()
    for place, entry in enumerate(_list(sources["energy"], "sources.energy")):
        where = f"sources.energy[{place}]"
        index, *rgb = _list(entry, where, 4)
        seen_before = _whole(index, f"{where}[0]", 0, count - 1) in seen
        if seen_before:
            _fail(f"{where}[0]", "every anchor at most once", index)
        seen.add(index)
        _rgb(rgb, where, minimum=0)


def _light(value: object, where: str) -> None:
    light = _mapping(value, where)
    _keys(light, where, ("name", "direction", "irradiance", "angular_diameter_deg"))
    if not _string(light["name"], f"{where}.name"):
        _fail(f"{where}.name", "a name", light["name"])
    direction = _rgb(light["direction"], f"{where}.direction")
    if not math.isclose(math.hypot(*direction), 1, abs_tol=1e-3):
        _fail(f"{where}.direction", "a vector of length 1", light["direction"])
    _rgb(light["irradiance"], f"{where}.irradiance", minimum=0)
    _number(light["angular_diameter_deg"], f"{where}.angular_diameter_deg", above=0, maximum=360)


def _photo(photo: Mapping[str, Any]) -> None:
    if "name" in photo:
        _string(photo["name"], "photo.name")
    for key in ("width", "height"):
        if key in photo:
            _whole(photo[key], f"photo.{key}", 1, 1 << 31)
    if "camera" not in photo:
        return
    camera = _mapping(photo["camera"], "photo.camera")
    for key, limit in (("pitch_deg", 90.0), ("roll_deg", 180.0)):
        if key in camera:
            _number(camera[key], f"photo.camera.{key}", minimum=-limit, maximum=limit)
    if "fov_deg" in camera:
        _number(camera["fov_deg"], "photo.camera.fov_deg", above=0, below=180)
    if "fov_source" in camera:
        _string(camera["fov_source"], "photo.camera.fov_source")


def _fail(where: str, expected: str, received: object) -> NoReturn:
    text = repr(received)
    raise ValueError(
        f"{where}: expected {expected}, received {text if len(text) <= 60 else text[:57] + '...'}"
    )


def _equal(value: object, where: str, expected: str | int) -> None:
    if value != expected or isinstance(value, bool):
        _fail(where, repr(expected), value)


def _mapping(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        _fail(where, "an object", value)
    return value


def _keys(value: Mapping[str, Any], where: str, expected: Sequence[str]) -> None:
    missing = [key for key in expected if key not in value]
    unknown = [key for key in value if key not in expected]
    if missing or unknown:
        _fail(where, f"the entries {', '.join(expected)}", sorted(map(str, value)))


def _list(value: object, where: str, length: int | None = None) -> Sequence[Any]:
    if not isinstance(value, list | tuple):
        _fail(where, "a list", value)
    if length is not None and len(value) != length:
        raise ValueError(f"{where}: expected a list of {length} entries, received {len(value)}")
    return value


def _string(value: object, where: str) -> str:
    if not isinstance(value, str):
        _fail(where, "a text", value)
    return value


def _whole(value: object, where: str, minimum: int, maximum: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not minimum <= value <= maximum:
        _fail(where, f"a whole number from {minimum} to {maximum}", value)
    return value


def _rgb(value: object, where: str, minimum: float | None = None) -> list[float]:
    return [
        _number(number, f"{where}[{place}]", minimum=minimum)
        for place, number in enumerate(_list(value, where, 3))
    ]


def _number(
    value: object,
    where: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
    below: float | None = None,
) -> float:
    limits = [
        f"{words} {limit:g}"
        for words, limit in (
            ("of at least", minimum),
            ("above", above),
            ("of at most", maximum),
            ("below", below),
        )
        if limit is not None
    ]
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not math.isfinite(value)
        or (minimum is not None and value < minimum)
        or (above is not None and value <= above)
        or (maximum is not None and value > maximum)
        or (below is not None and value >= below)
    ):
        _fail(where, " ".join(["a finite number", " and ".join(limits)]).rstrip(), value)
    return value
