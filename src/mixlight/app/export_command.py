"""Write a light for other programs.

For each target writes DIR/<target>/ with native files and a README.txt of three lines: how to load it, where
the light is, how far it was checked. The lights are taken out of the map that goes with them, so that nothing
is lit twice.
"""

import argparse
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.batch import output_folder
from mixlight.app.exports import add_target_arguments, chosen_targets, write_targets
from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from mixlight.export.registry import Target
    from mixlight.export.rig import Rig

HELP = "a light for Blender, three.js, glTF, USD, game engines, phones"

DEFAULT_OUT = "mixlight-export"

PRECISIONS = ("float32", "float16", "int8")
"""Those of `mixlight.export.onnx_precision`, which is not imported for a list: it needs NumPy."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight export`."""
    parser.add_argument(
        "lighting", nargs="?", metavar="LIGHTING", help="lighting.json of `estimate` or `fit`; not for onnx"
    )
    add_target_arguments(parser, required=True)
    parser.add_argument(
        "--out", type=Path, default=Path(DEFAULT_OUT), metavar="DIR",
        help="where the results go: DIR/<target>/ (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--height", type=_height, default=256, metavar="ROWS",
        help="rows of the environment map, which is twice as wide (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--model", default="default", metavar="NAME_OR_PATH",
        help="for onnx: a shipped model, or a .safetensors file (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--precision", choices=PRECISIONS, default=PRECISIONS[0],
        help="for onnx: how the file stores weights; what the smaller ones cost in accuracy is in "
        "docs/consumers/onnx.md (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Export the light; returns the exit status."""
    start = time.perf_counter()
    targets = chosen_targets(arguments)
    of_light = [target for target in targets if target.of == "light"]
    of_model = [target for target in targets if target.of == "model"]
    source = arguments.lighting
    if of_light and source is None:
        raise UsageError(f"expected a lighting.json to export for {of_light[0].name}, received none")
    with output_folder(arguments.out) as out:
        rig: Rig | None = None
        if of_light:
            try:
                rig = _rig(source, arguments)
            except (ValueError, OSError, MemoryError) as error:
                message = describe(error, source)
                complain(message)
                if arguments.as_json:
                    print_json({"input": source, "ok": False, "error": message})
                return 1
        written: list[str] = []

        def done(target: "Target") -> None:
            written.append(target.name)
            if not arguments.as_json:
                shown = source if target.of == "light" else arguments.model
                about = _summary(rig) if rig is not None and target.of == "light" else target.summary
                print(f"{shown} -> {out / target.name}{os.sep}  ({about})", flush=True)

        failed = {} if rig is None else write_targets(of_light, rig, out, done=done)
        failed |= write_targets(of_model, arguments.model, out, done=done, precision=arguments.precision)
    if arguments.as_json:
        line: dict[str, Any] = {"input": source, "ok": not failed, "out": str(arguments.out)}
        line |= {"targets": written, "failed": failed}
        if rig is not None:
            line |= {"map": rig.map_kind, "lights": len(rig.lights)}
        print_json(line | {"seconds": round(time.perf_counter() - start, 3)})
    return 1 if failed else 0


def _rig(source: str, arguments: argparse.Namespace) -> "Rig":
    from mixlight.export.rig import make_rig
    from mixlight.light import document

    return make_rig(
        document.load(source), lights=arguments.lights, residual=arguments.residual, height=arguments.height
    )


def _summary(rig: "Rig") -> str:
    count = len(rig.lights)
    if not count:
        return "full map, no lights"
    return f"{rig.map_kind} map, {count} light{'' if count == 1 else 's'} {'on' if rig.lights_on else 'off'}"


def _height(text: str) -> int:
    value = int(text) if text.isdecimal() else 0
    if not 16 <= value <= 4096 or value % 2:
        raise argparse.ArgumentTypeError(f"expected an even number from 16 to 4096, received {text!r}")
    return value
