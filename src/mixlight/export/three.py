"""three.js: a map for its loaders, lights as Object JSON, and the code that uses both.

`lights.json` is what three's `ObjectLoader` reads: a group of a `LightProbe` and a `DirectionalLight` for
each light. The probe holds the same light as the map and stands in for it where no map is wanted; `light.js`
turns it off beside the map.
"""

import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_URL, uuid5

import numpy as np
from jaxtyping import Float
from torch import Tensor

from mixlight.export.maps import read_map, write_exr, write_hdr
from mixlight.export.reading import check_words, coefficients, make_light
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.image.color import srgb_to_linear
from mixlight.light import entries
from mixlight.light.document import dumps
from mixlight.light.lights import Light

__all__ = ["colour_and_intensity", "read", "to_object", "write"]

FORMAT = "mixlight/three"
VERSION = 1

_DISTANCE = 10.0
"""Metres from the origin to a light: its direction alone shades; a shadow's camera stands here."""


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `environment.exr`, `environment.hdr`, `lights.json`, `light.js`, `index.html` and `README.txt`.

    Convention: three's loaders put the centre of an image at +X, so columns are rolled left by a quarter; no
        rotation is needed. Light counts once: use the map and the directional lights, or the probe and the
        directional lights.

    Raises:
        OSError: a file cannot be made.
    """
    write_exr(folder / "environment.exr", rig, "three")
    write_hdr(folder / "environment.hdr", rig, "three")
    (folder / "lights.json").write_text(dumps(to_object(rig)), encoding="utf-8")
    for name in ("light.js", "index.html"):
        source = files("mixlight.export").joinpath("three_files", name)
        (folder / name).write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    write_readme(
        folder,
        rig,
        "In your code: `import { loadLight } from './light.js'; await loadLight(scene);`. To look at it: "
        "`npm install three`, serve this folder and open index.html.",
        "Run with three.js r187 in Chromium (background, materials, lights, probe). The probe in lights.json "
        "is the map in another form: switch it off beside the map, as light.js does.",
    )
    names = ("environment.exr", "environment.hdr", "lights.json", "light.js", "index.html", "README.txt")
    return [folder / name for name in names]


def to_object(rig: Rig) -> dict[str, Any]:
    """The rig without its map as three's Object JSON (format 4).

    Convention: a light's colour times its intensity is its irradiance, and its position the direction towards
        it; the target stays at the origin. `LightProbe.sh` takes radiance coefficients in our own order and
        signs. Colours are 8-bit sRGB, as Object JSON has them: `colour_and_intensity` says how exact that is.

    >>> import torch
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light.lighting import Lighting
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), 2 * torch.eye(128)[:, :1].expand(-1, 3)), height=16)
    >>> probe, light = to_object(rig)["object"]["children"]
    >>> light["type"], hex(light["color"]), light["intensity"], light["visible"]
    ('DirectionalLight', '0xffffff', 2.0, True)
    >>> [round(part, 3) for part in light["position"]]
    [0.0, 9.922, -1.247]
    """
    about = rig.document("three")
    lights = about.pop("lights")
    labels = about["harmonics"]
    ambient = labels.pop("ambient")
    probe = {
        "uuid": _uuid(rig, "ambient"),
        "type": "LightProbe",
        "name": "ambient",
        "sh": [value for row in ambient for value in row],
        "intensity": 1,
        "userData": {key: labels[key] for key in ("kind", "basis", "order", "degree", "frame")},
    }
    children = [probe]
    for light in lights:
        colour, intensity = colour_and_intensity(light["irradiance"])
        children.append(
            {
                "uuid": _uuid(rig, light["name"]),
                "type": "DirectionalLight",
                "name": light["name"],
                "color": colour,
                "intensity": intensity,
                "position": [_DISTANCE * part for part in light["direction"]],
                "visible": light["enabled"],
                "userData": {"angular_diameter_deg": light["angular_diameter_deg"]},
            }
        )
    return {
        "metadata": {"version": 4.6, "type": "Object", "generator": "MixLight"},
        "object": {
            "uuid": _uuid(rig, ""),
            "type": "Group",
            "name": rig.name,
            "userData": about | {"format": FORMAT, "version": VERSION},
            "children": children,
        },
    }


def colour_and_intensity(irradiance: list[float]) -> tuple[int, float]:
    """The 8-bit sRGB colour 0xRRGGBB and the intensity whose product comes nearest to a light's irradiance.

    Brightness is the intensity's business, so each of the 128 brightest codes may stand for the brightest
    channel, and the one at which the other two are met best is taken: the error of an 8-bit colour, up to 1 %
    of the brightest channel, becomes .03 % on average.

    Convention: linear Rec.709 irradiance. The brightest channel is met exactly, the others within .45 % of it
        (near gray, where all three share a code; black gets the intensity 0).

    >>> colour, intensity = colour_and_intensity([3.0, 2.0, 1.0])
    >>> hex(colour), round(intensity, 4)
    ('0xfad199', 3.1382)
    """
    wanted = np.asarray(irradiance, dtype=np.float64)
    brightest = float(wanted.max())
    if brightest <= 0:
        return 0xFFFFFF, 0.0
    linear = srgb_to_linear(np.arange(256) / 255)
    tops = linear[:127:-1]  # ties go to the brightest code
    share = wanted / brightest * tops[:, None]
    codes = np.searchsorted((linear[1:] + linear[:-1]) / 2, share)
    error = np.abs(linear[codes] / tops[:, None] - wanted / brightest).max(axis=1)
    best = int(error.argmin())
    red, green, blue = (int(code) for code in codes[best])
    return red << 16 | green << 8 | blue, brightest / float(tops[best])


def read(folder: Path) -> Rig:
    """Read back what `write` has made: the map of `environment.exr` and the lights of `lights.json`.

    Convention: the map is exact to half floats, a light's irradiance to the 8-bit colours of Object JSON, all
        else to float32.

    Raises:
        ValueError: not such files; the message names the file and the entry.
        OSError: a file cannot be read.
    """
    environment, header = read_map(folder / "environment.exr")
    path = folder / "lights.json"
    document = entries.load(path)
    try:
        return _from_object(document, environment, header)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _from_object(
    document: object, environment: Float[Tensor, "height width 3"], header: Mapping[str, str]
) -> Rig:
    top = entries.mapping(entries.mapping(document, "the document").get("object"), "object")
    entries.equal(top.get("type"), "object.type", "Group")
    about = check_words(top.get("userData"), "object.userData", FORMAT, header)
    harmonics = entries.mapping(about.get("harmonics"), "object.userData.harmonics")
    lights, ambient = [], None
    for place, entry in enumerate(entries.entries(top.get("children"), "object.children")):
        where = f"object.children[{place}]"
        child = entries.mapping(entry, where)
        if child.get("type") == "LightProbe":
            values = entries.entries(child.get("sh"), f"{where}.sh", 27)
            ambient = coefficients([values[i : i + 3] for i in range(0, 27, 3)], f"{where}.sh")
        elif child.get("type") == "DirectionalLight":
            lights.append(_light(child, where))
        else:
            entries.fail(f"{where}.type", "'LightProbe' or 'DirectionalLight'", child.get("type"))
    if ambient is None:
        entries.fail("object.children", "a LightProbe among them", [light.name for light in lights])
    return Rig(
        environment=environment,
        lights=tuple(lights),
        residual=about["map"] == "residual",
        ambient=ambient,
        sh=coefficients(harmonics.get("all_light"), "object.userData.harmonics.all_light"),
        exposure_gain=float(about["exposure_gain"]),
        name=entries.text(top.get("name"), "object.name"),
    )


def _light(child: Mapping[str, Any], where: str) -> Light:
    colour = entries.whole(child.get("color"), f"{where}.color", 0, 0xFFFFFF)
    codes = np.array([colour >> 16, colour >> 8 & 255, colour & 255])
    intensity = entries.number(child.get("intensity"), f"{where}.intensity", minimum=0)
    about = entries.mapping(child.get("userData"), f"{where}.userData")
    return make_light(
        child.get("name"),
        entries.rgb(child.get("position"), f"{where}.position"),
        (srgb_to_linear(codes / 255) * intensity).tolist(),
        about.get("angular_diameter_deg"),
        where,
    )


def _uuid(rig: Rig, name: str) -> str:
    """The same for the same rig's name and light, so that the same input gives the same bytes."""
    return str(uuid5(NAMESPACE_URL, json.dumps(["mixlight", rig.name, name])))
