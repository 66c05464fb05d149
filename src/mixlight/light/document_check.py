"""Strict check of a lighting document, entry by entry, with complaints that name the entry."""

import math
from collections.abc import Mapping
from typing import Any

from mixlight.light.entries import entries, equal, fail, keys, mapping, number, rgb, text, whole
from mixlight.light.harmonics import MAX_DEGREE
from mixlight.light.lighting import FRAME

FORMAT = "mixlight/lighting"
VERSION = 1
"""Of a document that any reader understands."""
EDITED_VERSION = 2
"""Of a document with turned anchors or lasting names: ``sources`` has ``turn_deg`` and ``groups`` too."""


def check(document: object) -> None:
    """Refuse what is no lighting document of version 1 or 2.

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
    edited = whole(top.get("version"), "version", VERSION, EDITED_VERSION) == EDITED_VERSION
    keys(
        top,
        "the document",
        ("format", "version", "frame", "exposure_gain", "ambient", "sources", "lights", "photo", "model"),
    )
    equal(top["frame"], "frame", FRAME)
    number(top["exposure_gain"], "exposure_gain", above=0)
    _ambient(top["ambient"])
    _sources(top["sources"], edited)
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


def _sources(value: object, edited: bool) -> None:
    sources = mapping(value, "sources")
    names = ("anchors", "count", "sharpness", "energy")
    keys(sources, "sources", (*names, "turn_deg", "groups") if edited else names)
    equal(sources["anchors"], "sources.anchors", "vogel")
    count = whole(sources["count"], "sources.count", 1, 1 << 20)
    number(sources["sharpness"], "sources.sharpness", above=0)
    lit = _energy(sources["energy"], "sources.energy", count, set())
    if edited:
        number(sources["turn_deg"], "sources.turn_deg", minimum=-180, maximum=180)
        _groups(sources["groups"], count, lit)


def _energy(value: object, where: str, count: int, taken: set[int]) -> set[int]:
    """Rows of an anchor and its energy; the anchors are none of those taken."""
    seen = set[int]()
    for place, entry in enumerate(entries(value, where)):
        here = f"{where}[{place}]"
        index, *energy = entries(entry, here, 4)
        if whole(index, f"{here}[0]", 0, count - 1) in seen | taken:
            fail(f"{here}[0]", "every anchor at most once", index)
        seen.add(index)
        rgb(energy, here, minimum=0)
    return seen


def _groups(value: object, count: int, lit: set[int]) -> None:
    names, grouped = set[str](), set[int]()
    for place, entry in enumerate(entries(value, "sources.groups")):
        where = f"sources.groups[{place}]"
        group = mapping(entry, where)
        keys(group, where, ("name", "anchors", "off") if "off" in group else ("name", "anchors"))
        name = text(group["name"], f"{where}.name")
        if not name or name in names:
            fail(f"{where}.name", "a name of its own", name)
        names.add(name)
        anchors = [
            whole(anchor, f"{where}.anchors[{k}]", 0, count - 1)
            for k, anchor in enumerate(entries(group["anchors"], f"{where}.anchors"))
        ]
        if not anchors or anchors != sorted(set(anchors)) or grouped & set(anchors):
            fail(f"{where}.anchors", "ascending anchors, one at least, that are in no other group", anchors)
        grouped |= set(anchors)
        if "off" in group and not _energy(group["off"], f"{where}.off", count, lit) <= set(anchors):
            fail(f"{where}.off", "energy on the group's anchors", group["off"])


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
