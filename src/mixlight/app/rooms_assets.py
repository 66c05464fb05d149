"""Get furniture for rooms: Debian's package sweethome3d-furniture, converted into the user's data folder.

Rooms can do without it: then all furniture is MixLight's own.
"""

import argparse
from collections import Counter
from pathlib import Path

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
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Make the library; returns the exit status."""
    from mixlight.blender.program import BlenderError, find_blender
    from mixlight.data.rooms.assets import install

    try:
        find_blender()  # before a download of 120 MB
        catalogue = install(arguments.deb, arguments.library)
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
