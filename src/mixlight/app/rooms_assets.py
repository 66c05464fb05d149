"""Get furniture for rooms: Debian's package sweethome3d-furniture, converted into the user's data folder,
and what infinigen makes where it is installed.

Rooms can do without it: then all furniture is MixLight's own.
"""

import argparse
from collections import Counter
from functools import partial
from pathlib import Path

from mixlight.app.arguments import whole
from mixlight.app.report import complain, describe, print_json

HELP = "get more furniture for the rooms"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight rooms assets`."""
    parser.add_argument(
        "--deb", type=Path, metavar="FILE",
        help="the package, or a folder with its .sh3f files (default: the system's, else apt-get's)",
    )  # fmt: skip
    parser.add_argument(
        "--out", dest="library", type=Path, metavar="DIR",
        help="folder of the library (default: mixlight/rooms in the user's data folder)",
    )  # fmt: skip
    parser.add_argument(
        "--infinigen", type=whole(1, 100), metavar="N",
        help="pieces of each of infinigen's factories as well (default: 3 where MIXLIGHT_INFINIGEN_PYTHON "
        "names a Python that has it, else none)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Make the library; returns the exit status."""
    from mixlight.blender.program import BlenderError, find_blender
    from mixlight.data.rooms import infinigen
    from mixlight.data.rooms.assets import install

    try:
        find_blender()  # before a download of 120 MB
        count = arguments.infinigen or (3 if infinigen.infinigen_python() else 0)
        if count:
            infinigen.check()
        more = partial(infinigen.make, count) if count else None
        catalogue = install(arguments.deb, arguments.library, more=more)
    except (ValueError, OSError, BlenderError) as error:
        complain(describe(error))
        if arguments.as_json:
            print_json({"ok": False, "error": describe(error)})
        return 1
    folder = catalogue.blend.parent
    if arguments.as_json:
        kinds = Counter(entry.kind for entry in catalogue.entries)
        print_json(
            {"ok": True, "library": str(folder), "objects": len(catalogue.entries), "kinds": dict(kinds)}
        )
    else:
        print(f"{len(catalogue.entries)} pieces of furniture -> {folder}")
        print(f"Their makers are named in {folder / 'ATTRIBUTION.txt'}, and beside every set that uses them.")
    return 0
