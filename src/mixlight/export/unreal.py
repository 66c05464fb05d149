"""Unreal: a long-lat map, lights and harmonics in Unreal's axes, and an editor script that builds them."""

import math
from importlib.resources import files
from pathlib import Path

from mixlight.export.engine import engine_document, read_engine
from mixlight.export.maps import write_exr, write_hdr
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light.document import dumps

__all__ = ["FILE", "SCRIPT", "read", "rotator", "write"]

FILE = "unreal.json"
SCRIPT = "open_in_unreal.py"


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `unreal.json`, `environment.hdr`, `environment.exr`, `open_in_unreal.py` and `README.txt`.

    Convention: Unreal's axes, X = -z, Y = x, Z = y: the photo looks along +X. `lights[].rotation_deg` turns a
        Directional Light, which shines along its own +X, so that it travels away from `direction`; its colour
        times intensity in lux is the irradiance, and a texel of the map its radiance in cd/m^2, both times
        one unknown exposure.

    Raises:
        OSError: a file cannot be made.
    """
    document = engine_document(rig, "unreal")
    for entry in document["lights"]:
        entry["rotation_deg"] = rotator(entry["direction"])
    names = (FILE, "environment.hdr", "environment.exr", SCRIPT)
    paths = [folder / name for name in names]
    paths[0].write_text(dumps(document), encoding="utf-8")
    write_hdr(paths[1], rig, "unreal")
    write_exr(paths[2], rig, "unreal")
    source = files("mixlight.export").joinpath("unreal_files", SCRIPT)
    paths[3].write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    readme = write_readme(
        folder,
        rig,
        f"In the Unreal Editor with its Python plugin: Tools > Execute Python Script..., {SCRIPT}; it "
        "imports environment.hdr and adds a Sky Light and Directional Lights to the open level.",
        "Derived from Unreal's documentation and never run in Unreal: load the calibration card first, where "
        "yellow must lie ahead along +X and red along +Y; set a manual exposure.",
    )
    return [*paths, readme]


def read(folder: Path) -> Rig:
    """Read back what `write` has made (`mixlight.export.engine.read_engine`)."""
    return read_engine(folder, "unreal")


def rotator(direction: list[float]) -> dict[str, float]:
    """Pitch and yaw in degrees that turn Unreal's +X to where light from `direction` travels.

    Convention: Unreal's axes and signs: the rotated +X is (cos p cos y, cos p sin y, sin p). Light from
        straight above has the pitch -90.

    >>> rotator([0.0, 0.0, 1.0])["pitch"], rotator([1.0, 0.0, 0.0])["yaw"]
    (-90.0, 180.0)
    """
    x, y, z = (0.0 - part for part in direction)
    level = math.hypot(x, y)
    yaw = math.degrees(math.atan2(y, x)) if level > 0 else 0.0
    return {"pitch": round(math.degrees(math.atan2(z, level)), 4), "yaw": round(yaw, 4), "roll": 0.0}
