"""Filament: harmonics as `cmgen` writes them, lights as `LightManager` takes them, a map for `cmgen`."""

import math
from pathlib import Path
from typing import Any

import torch

from mixlight.export import sh
from mixlight.export.engine import engine_document, read_engine
from mixlight.export.maps import write_exr, write_hdr
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light.document import dumps, numbers

__all__ = ["FILE", "harmonics_text", "read", "write"]

FILE = "filament.json"

_INDEX = ("L00", "L1-1", "L10", "L11", "L2-2", "L2-1", "L20", "L21", "L22")


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `filament.json`, `sh.txt`, `environment.hdr`, `environment.exr` and `README.txt`.

    Convention: `lights[].filament` is what `LightManager` takes: the direction in which the light travels,
        a colour of largest channel 1, and an intensity whose product with it is the irradiance.
        `harmonics.ambient.coefficients` and `sh.txt` are what `IndirectLight` takes (`irradiance(3, sh)`,
        intensity 1). A camera of exposure 1 then shows radiance 1 as 1.

    Raises:
        OSError: a file cannot be made.
    """
    document = engine_document(rig, "filament")
    for entry, light in zip(document["lights"], rig.lights, strict=True):
        entry["filament"] = _directional(entry, math.degrees(light.angular_diameter) / 2)
    paths = [folder / name for name in (FILE, "sh.txt", "environment.hdr", "environment.exr")]
    paths[0].write_text(dumps(document), encoding="utf-8")
    paths[1].write_text(harmonics_text(rig), encoding="utf-8")
    write_hdr(paths[2], rig, "filament")
    write_exr(paths[3], rig, "filament")
    readme = write_readme(
        folder,
        rig,
        f"Give harmonics.ambient of {FILE} (or sh.txt) to IndirectLight.irradiance(3, ...) with intensity 1, "
        "lights[].filament to LightManager, and what `cmgen --deploy=. --format=ktx environment.hdr` makes "
        "to IndirectLight.reflections.",
        "Harmonics and lights were run in Filament 1.53 (WebAssembly, in Chromium); the map's roll follows "
        "the source of cmgen and was not run.",
    )
    return [*paths, readme]


def read(folder: Path) -> Rig:
    """Read back what `write` has made (`mixlight.export.engine.read_engine`)."""
    return read_engine(folder, "filament")


def harmonics_text(rig: Rig) -> str:
    """The ambient harmonics in the form of `cmgen --sh-shader`: nine lines of red, green and blue.

    >>> rig = Rig(torch.zeros(4, 8, 3), (), True, torch.ones(9, 3), torch.ones(9, 3))
    >>> harmonics_text(rig).splitlines()[0]
    '( 0.282094806432724,  0.282094806432724,  0.282094806432724); // L00, irradiance, pre-scaled base'
    """
    rows = sh.to_engine(rig.ambient, "filament").tolist()
    return "".join(
        f"({red:18.15f}, {green:18.15f}, {blue:18.15f}); // {index}, irradiance, pre-scaled base\n"
        for index, (red, green, blue) in zip(_INDEX, rows, strict=True)
    )


def _directional(entry: dict[str, Any], radius_deg: float) -> dict[str, Any]:
    irradiance = torch.tensor(entry["irradiance"])
    peak = float(irradiance.max())
    return {
        "type": "SUN",
        "direction": [0.0 - part for part in entry["direction"]],
        "color": numbers(irradiance / peak) if peak > 0 else [1.0, 1.0, 1.0],
        "intensity": peak,
        "sunAngularRadius": round(radius_deg, 4),
    }
