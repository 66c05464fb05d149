"""Strict check of a lighting document, entry by entry, with complaints that name the entry."""

import math
from collections.abc import Mapping
from typing import Any

from mixlight.light.entries import entries, equal, fail, keys, mapping, number, rgb, text, whole
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
    top = mapping(document, "the document")
    equal(top.get("format"), "format", FORMAT)
    equal(top.get("version"), "version", VERSION)
    keys(
        top,
        "the document",
        ("format", "version", "frame", "exposure_gain", "ambient", "sources", "lights", "photo", "model"),
    )
    equal(top["frame"], "frame", FRAME)
    number(top["exposure_gain"], "exposure_gain", above=0)
    _ambient(top["ambient"])
    _sources(top["sources"])
    for place, light in enumerate(entries(top["lights"], "lights")):
        _light(light, f"lights[{place}]")
    if top["photo"] is not None:
        _photo(mapping(top["photo"], "photo"))
    if top["model"] is not None:
        model = mapping(top["model"], "model")
        if "name" in model:
            text(model["name"], "model.name")


def _ambient(value: object) -> None:
    ambient = mapping(value, "ambient")
    keys(ambient, "ambient", ("kind", "basis", "order", "degree", "coefficients"))
    equal(ambient["kind"], "ambient.kind", "radiance")
    equal(ambient["basis"], "ambient.basis", "real-sh")
    equal(ambient["order"], "ambient.order", "l*l+l+m")
    degree = whole(ambient["degree"], "ambient.degree", 0, MAX_DEGREE)
    rows = entries(ambient["coefficients"], "ambient.coefficients", (degree + 1) ** 2)
    for place, row in enumerate(rows):
        rgb(row, f"ambient.coefficients[{place}]")


def _sources(value: object) -> None:
    sources = mapping(value, "sources")
    keys(sources, "sources", ("anchors", "count", "sharpness", "energy"))
    equal(sources["anchors"], "sources.anchors", "vogel")
    count = whole(sources["count"], "sources.count", 1, 1 << 20)
    number(sources["sharpness"], "sources.sharpness", above=0)
    seen = set()
    for place, entry in enumerate(entries(sources["energy"], "sources.energy")):
        where = f"sources.energy[{place}]"
        index, *energy = entries(entry, where, 4)
        seen_before = whole(index, f"{where}[0]", 0, count - 1) in seen
        if seen_before:
            fail(f"{where}[0]", "every anchor at most once", index)
        seen.add(index)
        rgb(energy, where, minimum=0)


def _light(value: object, where: str) -> None:
    light = mapping(value, where)
    keys(light, where, ("name", "direction", "irradiance", "angular_diameter_deg"))
    if not text(light["name"], f"{where}.name"):
        fail(f"{where}.name", "a name", light["name"])
    direction = rgb(light["direction"], f"{where}.direction")
    if not math.isclose(math.hypot(*direction), 1, abs_tol=1e-3):
        fail(f"{where}.direction", "a vector of length 1", light["direction"])
    rgb(light["irradiance"], f"{where}.irradiance", minimum=0)
    number(light["angular_diameter_deg"], f"{where}.angular_diameter_deg", above=0, maximum=360)


def _photo(photo: Mapping[str, Any]) -> None:
    if "name" in photo:
        text(photo["name"], "photo.name")
    for key in ("width", "height"):
        if key in photo:
            whole(photo[key], f"photo.{key}", 1, 1 << 31)
    if "camera" not in photo:
        return
    camera = mapping(photo["camera"], "photo.camera")
    for key, limit in (("pitch_deg", 90.0), ("roll_deg", 180.0)):
        if key in camera:
            number(camera[key], f"photo.camera.{key}", minimum=-limit, maximum=limit)
    if "fov_deg" in camera:
        number(camera["fov_deg"], "photo.camera.fov_deg", above=0, below=180)
    if "fov_source" in camera:
        text(camera["fov_source"], "photo.camera.fov_source")
