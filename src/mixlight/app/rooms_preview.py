"""Look at one room, small and quick: a tone-mapped panorama from its first camera, lit as it was planned."""

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

from mixlight.app.arguments import whole
from mixlight.app.report import UsageError, complain, describe, print_json
from mixlight.app.rooms_library import add_library_options, check_library_options, chosen_library

HELP = "look at one room, small and quick"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight rooms preview`."""
    parser.add_argument("room", type=whole(0, 10**9), metavar="SEED", help="of the room")
    parser.add_argument("picture", type=Path, metavar="FILE.png", help="the picture to write")
    parser.add_argument(
        "--width", type=whole(16, 8192), default=512, metavar="PIXELS",
        help="of the panorama, which is half as high (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--samples", type=whole(1, 65536), default=4, metavar="N",
        help="light paths a pixel, before the noise is taken off (default: %(default)s)",
    )  # fmt: skip
    add_library_options(parser)
    parser.add_argument("--kind", metavar="KIND", help="make it a kitchen, an office ... (default: drawn)")
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Make the preview; returns the exit status."""
    from mixlight.blender.program import BlenderError

    if arguments.picture.suffix.lower() != ".png":
        raise UsageError(f"{arguments.picture}: expected a name that ends in .png")
    check_library_options(arguments)
    start = time.perf_counter()
    try:
        said = _make(arguments)
    except (ValueError, OSError, BlenderError) as error:
        complain(describe(error))
        if arguments.as_json:
            print_json({"room": arguments.room, "ok": False, "error": describe(error)})
        return 1
    if arguments.as_json:
        seconds = round(time.perf_counter() - start, 3)
        print_json(
            {"room": arguments.room, "ok": True, "out": str(arguments.picture), **said, "seconds": seconds}
        )
    else:
        lights = ", ".join(said["groups"])
        print(f"room {arguments.room} -> {arguments.picture}  ({said['kind']}; light: {lights})")
    return 0


def _make(arguments: argparse.Namespace) -> dict[str, Any]:
    import numpy as np

    from mixlight.blender.program import BlenderError, find_blender
    from mixlight.blender.session import Session
    from mixlight.data.rooms.job import Settings, read_raw, write_job
    from mixlight.data.rooms.make_plan import make_plan
    from mixlight.data.rooms.render import SCRIPT, switched_on, threads_of
    from mixlight.data.rooms.scene import build
    from mixlight.image import ldr, tonemap

    find_blender()
    settings = Settings(width=arguments.width, samples=arguments.samples)
    library = chosen_library(arguments)
    plan = make_plan(arguments.room, library=library, cameras=1, kind=arguments.kind)
    scene = build(plan, catalogue=library)
    with (
        tempfile.TemporaryDirectory(prefix="mixlight-room-") as name,
        Session(SCRIPT, [str(threads_of(1))]) as session,
    ):
        folder = Path(name)
        write_job(scene, settings, folder)
        answer = session.ask(folder, 3600.0)
        if not answer["ok"]:
            raise BlenderError(answer["error"])
        groups, _ = read_raw(folder / "camera-0.exr", scene.groups)
    on = switched_on(plan)
    panorama = np.sum([pixels for name, pixels in groups.items() if on[name]], axis=0)
    ldr.write_png(arguments.picture, tonemap.preview(panorama, tonemap.exposure_for(panorama)))
    return {"kind": plan.spaces[0].kind, "groups": [name for name in groups if on[name]]}
