"""Mitsuba 3: a scene file of emitters alone, to be included in a scene or loaded by itself.

Mitsuba need not be installed for this. A scene has room for one environment map, and `directional` emitters
are points in the sky: shadows of the lights are hard there. For soft ones export with `--no-residual`, whose
map holds all light; Mitsuba samples it by its brightness.
"""

from pathlib import Path
from xml.sax.saxutils import quoteattr

from mixlight.export.maps import write_exr
from mixlight.export.readme import accounting, write_readme
from mixlight.export.rig import Rig
from mixlight.light.document import numbers

__all__ = ["FILE_NAME", "to_xml", "write"]

FILE_NAME = "lighting.xml"
"""The scene file in the written folder."""


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `README.txt`, `lighting.xml` and `environment.exr`.

    Args:
        rig: the light.
        folder: an existing folder.

    Returns:
        The files.

    Convention: Mitsuba's axes are ours. The map's columns are rolled by half the width, which is how `envmap`
        looks it up: no `to_world` is needed.

    Raises:
        OSError: the disk refuses.
    """
    scene = folder / FILE_NAME
    scene.write_text(to_xml(rig), encoding="utf-8")
    panorama = folder / "environment.exr"
    write_exr(panorama, rig, "mitsuba")
    readme = write_readme(
        folder,
        rig,
        f"`emitters = mi.load_file('{FILE_NAME}').emitters()`, then put each into the dict of your scene; in "
        f'XML <default name="mixlight" value="FOLDER"/>, then <include filename="FOLDER/{FILE_NAME}"/>.',
        "Checked in Mitsuba 3.9.1 (scalar_rgb): directions, radiance and irradiance.",
    )
    return [readme, scene, panorama]


def to_xml(rig: Rig) -> str:
    """The emitters as a scene file.

    Convention: `direction` of a `directional` emitter is the way the light travels, away from the light.
        Lights whose light is in the map stand in a comment.

    >>> import torch
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), 2 * torch.eye(128)[:, :1].expand(-1, 3)), height=16)
    >>> print(to_xml(rig).splitlines()[-3].strip())
    <rgb name="irradiance" value="2.0, 2.0, 2.0"/>
    """
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        f"<!-- MixLight: the light of a photo. {accounting(rig)}",
        f"     Axes: +X right, +Y up, -Z ahead. exposure_gain: {float(rig.exposure_gain)!r} -->",
        '<scene version="3.0.0">',
        '    <default name="mixlight" value="."/>',
        '    <emitter type="envmap" id="environment">',
        '        <string name="filename" value="$mixlight/environment.exr"/>',
        "    </emitter>",
    ]
    if rig.lights and not rig.lights_on:
        lines.append("    <!-- switched off, since the map holds them")
    for light in rig.lights:
        direction = numbers(-light.direction)
        irradiance = ", ".join(repr(value) for value in numbers(light.irradiance))
        x, y, z = (repr(value) for value in direction)
        lines += [
            f'    <emitter type="directional" id={_attribute(light.name)}>',
            f'        <vector name="direction" x="{x}" y="{y}" z="{z}"/>',
            f'        <rgb name="irradiance" value="{irradiance}"/>',
            "    </emitter>",
        ]
    if rig.lights and not rig.lights_on:
        lines.append("    -->")
    lines.append("</scene>")
    return "\n".join(lines) + "\n"


def _attribute(name: str) -> str:
    """A name as an XML attribute; two hyphens would end a comment."""
    while "--" in name:
        name = name.replace("--", "-")
    return quoteattr(name)
