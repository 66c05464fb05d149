"""Change a light: turn it, make it brighter, warmer, switch its lights.

Reads a lighting.json and writes a new one; with a folder for --out also its environment.exr and
environment.hdr. The file that was read is never changed.
"""

import argparse
import math
import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.batch import height, number
from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from mixlight.light.lighting import Lighting

HELP = "a light turned, dimmed, tinted, its lights on or off"

WARMEST, COOLEST = 2000.0, 15000.0
"""Kelvin, as `mixlight.image.temperature` has them; named here because that module needs NumPy."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight edit`."""
    parser.add_argument("lighting", metavar="LIGHTING", help="a lighting.json, which stays as it is")
    parser.add_argument(
        "--rotate-deg", type=_angle, metavar="D",
        help="turn the light to the right by so many degrees; the photo stays ahead",
    )  # fmt: skip
    parser.add_argument(
        "--exposure-ev", type=_exposure, metavar="EV", help="make all light 2^EV times as bright"
    )
    parser.add_argument(
        "--temperature", type=_temperature, metavar="KELVIN",
        help=f"give white light this colour temperature, {WARMEST:g} (warm) to {COOLEST:g}; 6504 is neutral",
    )  # fmt: skip
    parser.add_argument(
        "--light", type=_light, action="append", default=[], dest="lights",
        metavar="NAME=on|off|xSTRENGTH",
        help="switch a light, or make it so many times as strong; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE_OR_DIR",
        help="the new light: a .json file, or a folder for lighting.json and its maps",
    )  # fmt: skip
    parser.add_argument(
        "--height", type=height, default=128, metavar="ROWS",
        help="rows of the environment map in the folder (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Edit the light; returns the exit status."""
    start = time.perf_counter()
    changes = (arguments.rotate_deg, arguments.exposure_ev, arguments.temperature)
    if not arguments.lights and all(change is None for change in changes):
        raise UsageError(
            "expected something to change (--rotate-deg, --exposure-ev, --temperature, --light), received "
            "nothing"
        )
    _check_out(arguments.lighting, arguments.out)
    try:
        said = _edit(arguments)
    except (ValueError, OSError, MemoryError) as error:
        message = describe(error, arguments.lighting)
        complain(message)
        if arguments.as_json:
            print_json({"input": arguments.lighting, "ok": False, "error": message})
        return 1
    summary = said.pop("summary")
    if arguments.as_json:
        line = {"input": arguments.lighting, "ok": True, "out": str(arguments.out), **said}
        print_json(line | {"seconds": round(time.perf_counter() - start, 3)})
    else:
        print(f"{arguments.lighting} -> {arguments.out}  ({summary})")
    return 0


def _check_out(source: str, out: Path) -> None:
    """Refuse to write over what is read, and into what is neither a .json nor a folder."""
    target = out if _is_file(out) else out / "lighting.json"
    if target.exists() and Path(source).exists() and target.samefile(source):
        raise UsageError(f"--out {out}: expected another place than that of {source}, which stays as it is")
    if not _is_file(out) and out.suffix and not out.is_dir():
        raise UsageError(f"--out {out}: expected a name that ends in .json, or a folder")
    if out.exists() and _is_file(out) == out.is_dir():
        kind = "folder" if out.is_dir() else "file"
        raise UsageError(f"--out {out}: expected a .json file or a folder, received a {kind} of that name")


def _is_file(out: Path) -> bool:
    return out.suffix.lower() == ".json"


def _edit(arguments: argparse.Namespace) -> dict[str, Any]:
    from mixlight.light import document, edit

    found = document.read(arguments.lighting)
    lighting = document.from_document(found)
    for name, change in arguments.lights:
        if isinstance(change, bool):
            lighting = edit.switch(lighting, name, change)
        else:
            lighting = edit.strengthen(lighting, name, change)
    if arguments.rotate_deg is not None:
        lighting = edit.turn(lighting, math.radians(arguments.rotate_deg))
    if arguments.temperature is not None:
        lighting = edit.tint(lighting, arguments.temperature)
    if arguments.exposure_ev is not None:
        lighting = edit.expose(lighting, arguments.exposure_ev)

    photo = found["photo"]
    detailed = photo is not None and photo.get("detail") is not None
    if detailed:  # the map of the new light is made from its numbers, and says so
        photo = {key: value for key, value in photo.items() if key != "detail"}
    _write(arguments, lighting, photo, found["model"])
    off = [group.name for group in lighting.groups if group.off is not None]
    on = [name for name in edit.light_names(lighting) if name not in off]
    summary = f"on: {', '.join(on) or 'none'}" + (f"; off: {', '.join(off)}" if off else "")
    if detailed:
        summary += "; without the photo's own pixels"
    return {"summary": summary, "lights": on, "off": off}


def _write(
    arguments: argparse.Namespace,
    lighting: "Lighting",
    photo: dict[str, Any] | None,
    model: dict[str, Any] | None,
) -> None:
    from mixlight.light import document

    if _is_file(arguments.out):
        document.save(document.to_document(lighting, photo, model), arguments.out)
        return
    from mixlight.app.batch import output_folder
    from mixlight.app.outputs import write_result

    with output_folder(arguments.out.parent):
        write_result(
            arguments.out, lighting, lighting.environment(arguments.height), None, photo=photo, model=model
        )


def _angle(text: str) -> float:
    value = number(text)
    if not abs(value) <= 36000.0:
        raise argparse.ArgumentTypeError(f"expected an angle in degrees, received {text!r}")
    return value


def _exposure(text: str) -> float:
    value = number(text)
    if not abs(value) <= 40.0:
        raise argparse.ArgumentTypeError(f"expected a number of stops from -40 to 40, received {text!r}")
    return value


def _temperature(text: str) -> float:
    value = number(text)
    if not WARMEST <= value <= COOLEST:
        raise argparse.ArgumentTypeError(
            f"expected a colour temperature from {WARMEST:g} to {COOLEST:g} kelvin, received {text!r}"
        )
    return value


def _light(text: str) -> tuple[str, bool | float]:
    name, _, change = text.rpartition("=")
    if name and change in ("on", "off"):
        return name, change == "on"
    strength = number(change[1:]) if re.fullmatch(r"x[\d.eE+-]+", change) else math.nan
    if not name or not 0 < strength < math.inf:
        raise argparse.ArgumentTypeError(
            f"expected NAME=on, NAME=off or NAME=xSTRENGTH with a strength above 0, received {text!r}"
        )
    return name, strength
