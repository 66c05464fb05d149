"""glTF 2.0: lights as KHR_lights_punctual, the map beside them, and the harmonics in `extras`.

glTF has no place for an environment map, so the map stands beside the scene and the scene's `extras` say what
it holds.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jaxtyping import Float
from torch import Tensor

from mixlight import __version__
from mixlight.export.maps import read_map, write_exr
from mixlight.export.reading import check_words, coefficients, make_light
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light import entries
from mixlight.light.document import dumps
from mixlight.light.lights import Light

__all__ = ["light_rotation", "read", "to_gltf", "write"]

FORMAT = "mixlight/gltf"
VERSION = 1
EXTENSION = "KHR_lights_punctual"


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `lights.gltf`, `environment.exr` and `README.txt`.

    Convention: glTF's axes are ours, so the map is in our own frame (image centre -Z) and says so.

    Raises:
        OSError: a file cannot be made.
    """
    (folder / "lights.gltf").write_text(dumps(to_gltf(rig)), encoding="utf-8")
    write_exr(folder / "environment.exr", rig, "mixlight")
    write_readme(
        folder,
        rig,
        "Load lights.gltf beside your own scene with any loader that knows KHR_lights_punctual, and "
        "environment.exr as the environment map (latlong, image centre -Z).",
        "Passes Khronos's glTF validator without errors or warnings, and was loaded with three.js r187; in "
        "Blender import with Lighting Mode = Unitless, or better take the export for blender.",
    )
    return [folder / name for name in ("lights.gltf", "environment.exr", "README.txt")]


def to_gltf(rig: Rig) -> dict[str, Any]:
    """The rig without its map as a glTF document.

    Lights that are on have a node each. Lights that are off, because the map holds them, are listed without a
    node, since a node that no scene shows is not off everywhere (Blender's import takes it in all the same);
    `extras` hold their direction.

    Convention: `intensity` (lux) times `color` is the irradiance, and the node's -Z the way of its rays.

    >>> import torch
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light.lighting import Lighting
    >>> energy = torch.eye(128)[:, :1] * torch.tensor([4.0, 2.0, 1.0])
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), energy), height=16)
    >>> to_gltf(rig)["extensions"]["KHR_lights_punctual"]["lights"][0]["color"]
    [1.0, 0.5, 0.25]
    >>> [round(part, 3) for part in to_gltf(rig)["nodes"][0]["rotation"]]
    [-0.75, 0.0, 0.0, 0.662]
    """
    about = rig.document("mixlight")
    listed = about.pop("lights")
    scene: dict[str, Any] = {"name": rig.name}
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": f"MixLight {__version__}"},
        "scene": 0,
        "scenes": [scene],
    }
    if listed:
        document["extensionsUsed"] = [EXTENSION]
        document["extensions"] = {EXTENSION: {"lights": [_punctual(light) for light in listed]}}
    nodes = [
        {
            "name": light["name"],
            "rotation": light_rotation(light["direction"]),
            "extensions": {EXTENSION: {"light": place}},
        }
        for place, light in enumerate(listed)
        if light["enabled"]
    ]
    if nodes:
        document["nodes"] = nodes
        scene["nodes"] = list(range(len(nodes)))
    scene["extras"] = {"mixlight": about | {"format": FORMAT, "version": VERSION}}
    return document


def _punctual(light: Mapping[str, Any]) -> dict[str, Any]:
    irradiance: list[float] = light["irradiance"]
    brightest = max(irradiance)
    extras = {key: light[key] for key in ("direction", "angular_diameter_deg", "enabled")}
    return {
        "name": light["name"],
        "type": "directional",
        "color": [part / brightest for part in irradiance] if brightest else [1.0, 1.0, 1.0],
        "intensity": brightest,
        "extras": extras,
    }


def light_rotation(towards: Sequence[float]) -> list[float]:
    """The unit quaternion (x, y, z, w) that turns a node's +Z towards a light, and its -Z along the rays.

    The shortest turn: about the axis z x d by the angle between them.

    Convention: a light straight ahead, at -Z, takes half a turn about +Y.

    >>> [round(part, 3) for part in light_rotation([0.0, 1.0, 0.0])], light_rotation([0.0, 0.0, -1.0])[1]
    ([-0.707, 0.0, 0.0, 0.707], 1.0)
    """
    x, y, z = towards
    aside = math.hypot(x, y)
    half = math.atan2(aside, z) / 2
    if not aside:
        return [0.0, math.sin(half), 0.0, math.cos(half)]
    return [-y / aside * math.sin(half), x / aside * math.sin(half), 0.0, math.cos(half)]


def read(folder: Path) -> Rig:
    """Read back what `write` has made.

    Lights are taken from the nodes and the extension, as other programs do it.

    Convention: the map is exact to half floats, all else to float32.

    Raises:
        ValueError: not such files; the message names the file and the entry.
        OSError: a file cannot be read.
    """
    environment, header = read_map(folder / "environment.exr")
    path = folder / "lights.gltf"
    document = entries.load(path)
    try:
        return _from_gltf(document, environment, header)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _from_gltf(
    document: object, environment: Float[Tensor, "height width 3"], header: Mapping[str, str]
) -> Rig:
    top = entries.mapping(document, "the document")
    entries.equal(entries.mapping(top.get("asset"), "asset").get("version"), "asset.version", "2.0")
    scene = entries.mapping(entries.entries(top.get("scenes"), "scenes", 1)[0], "scenes[0]")
    extras = entries.mapping(scene.get("extras"), "scenes[0].extras")
    where = "scenes[0].extras.mixlight"
    about = check_words(extras.get("mixlight"), where, FORMAT, header)
    harmonics = entries.mapping(about.get("harmonics"), f"{where}.harmonics")
    return Rig(
        environment=environment,
        lights=tuple(_lights(top, enabled=about["map"] == "residual")),
        residual=about["map"] == "residual",
        ambient=coefficients(harmonics.get("ambient"), f"{where}.harmonics.ambient"),
        sh=coefficients(harmonics.get("all_light"), f"{where}.harmonics.all_light"),
        exposure_gain=float(about["exposure_gain"]),
        name=entries.text(scene.get("name"), "scenes[0].name"),
    )


def _lights(top: Mapping[str, Any], *, enabled: bool) -> list[Light]:
    extensions = entries.mapping(top.get("extensions", {}), "extensions")
    punctual = entries.mapping(extensions.get(EXTENSION, {}), f"extensions.{EXTENSION}")
    listed = entries.entries(punctual.get("lights", []), f"extensions.{EXTENSION}.lights")
    towards = _towards(top, len(listed))
    if enabled and len(towards) != len(listed):
        entries.fail("nodes", f"one for each of {len(listed)} lights", sorted(towards))
    lights = []
    for place, entry in enumerate(listed):
        where = f"extensions.{EXTENSION}.lights[{place}]"
        light = entries.mapping(entry, where)
        entries.equal(light.get("type"), f"{where}.type", "directional")
        intensity = entries.number(light.get("intensity", 1), f"{where}.intensity", minimum=0)
        colour = entries.rgb(light.get("color", (1, 1, 1)), f"{where}.color", minimum=0)
        extras = entries.mapping(light.get("extras"), f"{where}.extras")
        lights.append(
            make_light(
                light.get("name"),
                towards.get(place) or entries.rgb(extras.get("direction"), f"{where}.extras.direction"),
                [intensity * part for part in colour],
                extras.get("angular_diameter_deg"),
                where,
            )
        )
    return lights


def _towards(top: Mapping[str, Any], count: int) -> dict[int, list[float]]:
    """The direction towards each light that has a node, by the light's place in the list."""
    found = {}
    for place, entry in enumerate(entries.entries(top.get("nodes", []), "nodes")):
        where = f"nodes[{place}]"
        node = entries.mapping(entry, where)
        extensions = entries.mapping(node.get("extensions", {}), f"{where}.extensions")
        light = entries.mapping(extensions.get(EXTENSION, {}), f"{where}.extensions.{EXTENSION}")
        index = entries.whole(light.get("light"), f"{where}.extensions.{EXTENSION}.light", 0, count - 1)
        rotation = entries.entries(node.get("rotation", (0, 0, 0, 1)), f"{where}.rotation", 4)
        x, y, z, w = (entries.number(part, f"{where}.rotation[{axis}]") for axis, part in enumerate(rotation))
        if index in found or not math.isclose(math.hypot(x, y, z, w), 1, abs_tol=1e-3):
            entries.fail(where, "a unit rotation, and one node for each light", dict(node))
        found[index] = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    return found
