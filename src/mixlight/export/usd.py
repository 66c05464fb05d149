"""USD: a `.usda` layer with a DomeLight for the map and a DistantLight for each named light.

Text, written without USD; `mixlight.export._usda` reads it back.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight import __version__
from mixlight.export import _usda
from mixlight.export.maps import read_map, write_exr
from mixlight.export.reading import check_words, coefficients, make_light
from mixlight.export.readme import accounting, write_readme
from mixlight.export.rig import Rig
from mixlight.light import entries
from mixlight.light.lights import Light

__all__ = ["BLENDER_FILE_NAME", "FILE_NAME", "read", "to_blender_usda", "to_usda", "write"]

FILE_NAME = "lighting.usda"
"""The layer in the written folder."""

BLENDER_FILE_NAME = "lighting_for_blender_import.usda"
"""The same light for Blender's USD import, which departs from UsdLux."""

FORMAT = "mixlight/usd"
VERSION = 1


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `README.txt`, `lighting.usda`, `lighting_for_blender_import.usda` and `environment.exr`.

    Args:
        rig: the light.
        folder: an existing folder.

    Returns:
        The files.

    Convention: a Y-up stage in metres, in our own axes. The map's columns are rolled by half the width, which
        is how a DomeLight looks a latlong texture up: no rotation is needed.

    Raises:
        OSError: the disk refuses.
    """
    layer = folder / FILE_NAME
    layer.write_text(to_usda(rig), encoding="utf-8")
    blender = folder / BLENDER_FILE_NAME
    blender.write_text(to_blender_usda(rig), encoding="utf-8")
    panorama = folder / "environment.exr"
    write_exr(panorama, rig, "usd")
    readme = write_readme(
        folder,
        rig,
        f"Reference or sublayer {FILE_NAME} into your stage, with environment.exr beside it. Blender alone: "
        f"import {BLENDER_FILE_NAME}.",
        "Checked with usd-core 26.11 (schema and values) and through the USD import of Blender 4.5.15 and "
        "5.0.1 (pixels); other renderers of USD were not run.",
    )
    return [readme, layer, blender, panorama]


def to_usda(rig: Rig) -> str:
    """The layer as text.

    Convention: a DistantLight shines along its own -Z, so the third row of its matrix points towards the
        light. With `inputs:normalize` its intensity times colour is its irradiance, whatever its angle.
        Lights whose light is in the map are invisible.

    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), 2 * torch.eye(128)[:, :1].expand(-1, 3)), height=16)
    >>> for line in to_usda(rig).splitlines():
    ...     if "intensity" in line or "angle" in line:
    ...         print(line.strip())
    float inputs:intensity = 1
    float inputs:angle = 8.1045
    float inputs:intensity = 2.0
    """
    about = rig.document("usd")
    harmonics = about["harmonics"]
    lines = [
        "#usda 1.0",
        "(",
        f"    doc = {_usda.quoted('MixLight: the light of a photo. ' + accounting(rig))}",
        "    customLayerData = {",
        "        dictionary mixlight = {",
        f"            string format = {_usda.quoted(FORMAT)}",
        f"            int version = {VERSION}",
        f"            string software = {_usda.quoted(f'mixlight {__version__}')}",
        f"            string name = {_usda.quoted(rig.name)}",
        f"            string frame = {_usda.quoted(about['frame'])}",
        f"            string map = {_usda.quoted(about['map'])}",
        f"            double exposure_gain = {about['exposure_gain']!r}",
        "            dictionary harmonics = {",
        *(f"                string {key} = {_usda.quoted(harmonics[key])}" for key in ("kind", "basis")),
        *(f"                string {key} = {_usda.quoted(harmonics[key])}" for key in ("order", "frame")),
        f"                int degree = {harmonics['degree']}",
        f"                float3[] ambient = {_rows(harmonics['ambient'])}",
        f"                float3[] all_light = {_rows(harmonics['all_light'])}",
        "            }",
        "        }",
        "    }",
        f"    defaultPrim = {_usda.quoted(_usda.identifier(rig.name))}",
        "    metersPerUnit = 1",
        '    upAxis = "Y"',
        ")",
        "",
        f'def Xform "{_usda.identifier(rig.name)}"',
        "{",
        '    def DomeLight "environment"',
        "    {",
        "        color3f inputs:color = (1, 1, 1)",
        "        float inputs:exposure = 0",
        "        float inputs:intensity = 1",
        "        asset inputs:texture:file = @./environment.exr@",
        '        token inputs:texture:format = "latlong"',
        "    }",
    ]
    taken = {"environment"}
    for light in about["lights"]:
        lines += ["", *_distant_light(light, taken)]
    lines.append("}")
    return "\n".join(lines) + "\n"


def to_blender_usda(rig: Rig) -> str:
    """A layer over `lighting.usda` with the numbers that make Blender's USD import show the same light.

    Blender (measured in 4.5.15 and 5.0.1, and the inverse of its own export) makes of a DistantLight a Sun of
    four times the intensity and twice the angle.

    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), 2 * torch.eye(128)[:, :1].expand(-1, 3)), height=16)
    >>> print(to_blender_usda(rig).splitlines()[-3].strip())
    float inputs:intensity = 0.5
    """
    lines = [
        "#usda 1.0",
        "(",
        '    doc = "For the USD import of Blender alone: a quarter of the intensities, half of the angles."',
        f"    defaultPrim = {_usda.quoted(_usda.identifier(rig.name))}",
        "    metersPerUnit = 1",
        f"    subLayers = [@./{FILE_NAME}@]",
        '    upAxis = "Y"',
        ")",
        "",
        f'over "{_usda.identifier(rig.name)}"',
        "{",
    ]
    taken = {"environment"}
    for light in rig.document("usd")["lights"]:
        lines += [
            f'    over "{_prim_name(light["name"], taken)}"',
            "    {",
            f"        float inputs:angle = {light['angular_diameter_deg'] / 2!r}",
            f"        float inputs:intensity = {max(light['irradiance']) / 4!r}",
            "    }",
        ]
    return "\n".join([*lines, "}"]) + "\n"


def _prim_name(name: str, taken: set[str]) -> str:
    prim = _usda.identifier(name)
    while prim in taken:  # names may differ in signs alone that USD does not allow
        prim += "_"
    taken.add(prim)
    return prim


def _distant_light(light: Mapping[str, Any], taken: set[str]) -> list[str]:
    intensity = max(light["irradiance"])
    colour = [value / intensity if intensity else 1.0 for value in light["irradiance"]]
    lines = [
        f'    def DistantLight "{_prim_name(light["name"], taken)}" (',
        f"        displayName = {_usda.quoted(light['name'])}",
        "    )",
        "    {",
        f"        float inputs:angle = {light['angular_diameter_deg']!r}",
        f"        color3f inputs:color = {_row(colour)}",
        "        float inputs:exposure = 0",
        f"        float inputs:intensity = {intensity!r}",
        "        bool inputs:normalize = true",
        f"        matrix4d xformOp:transform = {_matrix(light['direction'])}",
        '        uniform token[] xformOpOrder = ["xformOp:transform"]',
    ]
    if not light["enabled"]:
        lines.append('        token visibility = "invisible"')
    return [*lines, "    }"]


def _matrix(towards: list[float]) -> str:
    """Rows: the light's own X, Y, Z in the stage, and its place; the third points towards the light."""
    outward = torch.tensor(towards, dtype=torch.float64)
    # Any right angle will do; the one to the axis that is least along the light is the safest.
    least = torch.eye(3, dtype=torch.float64)[int(outward.abs().argmin())]
    right = torch.linalg.cross(least, outward)
    right = right / torch.linalg.vector_norm(right)
    up = torch.linalg.cross(outward, right)
    up = up / torch.linalg.vector_norm(up)
    rows = [[*row.tolist(), 0] for row in (right, up)] + [[*towards, 0], [0, 0, 0, 1]]
    return f"( {', '.join(_row(row) for row in rows)} )"


def _row(values: list[float]) -> str:
    return f"({', '.join(repr(value) for value in values)})"


def _rows(rows: list[list[float]]) -> str:
    return f"[{', '.join(_row(row) for row in rows)}]"


def read(folder: Path) -> Rig:
    """Read back what `write` has made: the lights of `lighting.usda` and the map of `environment.exr`.

    Convention: the map is exact to half floats, all else to float32. A layer that another program has saved
        anew may use more of USD than is understood here, and is refused then.

    Raises:
        ValueError: not such files; the message names the file and the entry.
        OSError: a file cannot be read.

    >>> import tempfile
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), 2 * torch.eye(128)[:, :1].expand(-1, 3)), height=16)
    >>> with tempfile.TemporaryDirectory() as name:
    ...     _ = write(rig, Path(name))
    ...     [light.irradiance for light in read(Path(name)).lights]
    [tensor([2., 2., 2.])]
    """
    environment, header = read_map(folder / "environment.exr")
    path = folder / FILE_NAME
    try:
        layer = _usda.parse(path.read_text(encoding="utf-8"))
        return _from_layer(layer, environment, header)
    except ValueError as error:  # also of the decoder
        raise ValueError(f"{path}: {error}") from error


def _from_layer(
    layer: _usda.Layer, environment: Float[Tensor, "height width 3"], header: Mapping[str, str]
) -> Rig:
    data = entries.mapping(layer.metadata.get("customLayerData"), "customLayerData")
    about = check_words(data.get("mixlight"), "customLayerData.mixlight", FORMAT, header)
    entries.equal(about.get("frame"), "customLayerData.mixlight.frame", "usd")
    entries.equal(layer.metadata.get("upAxis"), "upAxis", "Y")
    harmonics = entries.mapping(about.get("harmonics"), "customLayerData.mixlight.harmonics")
    if len(layer.prims) != 1:
        entries.fail("the layer", "one root prim", [prim.name for prim in layer.prims])
    root = layer.prims[0]
    lights = [
        _light(prim, f"/{root.name}/{prim.name}") for prim in root.children if prim.kind == "DistantLight"
    ]
    others = sorted({prim.kind for prim in root.children} - {"DomeLight", "DistantLight"})
    if others:
        entries.fail(f"/{root.name}", "DomeLight and DistantLights alone", others)
    return Rig(
        environment=environment,
        lights=tuple(lights),
        residual=about["map"] == "residual",
        ambient=coefficients(harmonics.get("ambient"), "customLayerData.mixlight.harmonics.ambient"),
        sh=coefficients(harmonics.get("all_light"), "customLayerData.mixlight.harmonics.all_light"),
        exposure_gain=float(about["exposure_gain"]),
        name=entries.text(about.get("name"), "customLayerData.mixlight.name"),
    )


def _light(prim: _usda.Prim, where: str) -> Light:
    values = prim.attributes
    if values.get("inputs:normalize") not in (True, 1.0):  # USD's own writer says 1
        entries.fail(f"{where}.inputs:normalize", "true", values.get("inputs:normalize"))
    if tuple(entries.entries(values.get("xformOpOrder"), f"{where}.xformOpOrder")) != ("xformOp:transform",):
        entries.fail(f"{where}.xformOpOrder", "xformOp:transform alone", values["xformOpOrder"])
    matrix = entries.entries(values.get("xformOp:transform"), f"{where}.xformOp:transform", 4)
    towards = entries.entries(matrix[2], f"{where}.xformOp:transform[2]", 4)[:3]
    intensity = entries.number(values.get("inputs:intensity"), f"{where}.inputs:intensity", minimum=0)
    exposure = entries.number(values.get("inputs:exposure", 0.0), f"{where}.inputs:exposure")
    colour = entries.rgb(values.get("inputs:color"), f"{where}.inputs:color", minimum=0)
    return make_light(
        prim.metadata.get("displayName", prim.name),
        entries.rgb(towards, f"{where}.xformOp:transform[2]"),
        [value * intensity * math.pow(2.0, exposure) for value in colour],
        values.get("inputs:angle"),
        where,
    )
