"""Lay random rooms of a set out in one picture: tone-mapped panoramas, or photos taken in them."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from mixlight.data.rooms.sheet import Tile

HELP = "a contact sheet of a set of rooms"

_COUNTS = {"panoramas": (48, 6), "crops": (96, 12)}
"""Pictures of a sheet, and columns."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight rooms sheet`."""
    parser.add_argument("rooms", metavar="DIR", help="folder with a rooms.csv, or such a table")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.jpg", help="the picture to write")
    parser.add_argument(
        "--crops", action="store_true",
        help="photos through the camera model of training instead of whole panoramas",
    )  # fmt: skip
    parser.add_argument(
        "--count", type=_count, metavar="N", help="pictures (default: 48 panoramas or 96 crops)"
    )
    parser.add_argument(
        "--columns", type=_count, metavar="N", help="pictures in a row (default: 6 panoramas or 12 crops)"
    )
    parser.add_argument(
        "--seed", type=_seed, default=0, metavar="S",
        help="decides which rooms, how they are lit and where the camera looks (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Make the sheet; returns the exit status."""
    if arguments.out.suffix.lower() not in (".jpg", ".jpeg"):
        raise UsageError(f"--out {arguments.out}: expected a name that ends in .jpg")
    try:
        said, failed = _make(arguments)
    except (ValueError, OSError) as error:
        complain(describe(error))
        if arguments.as_json:
            print_json({"input": arguments.rooms, "ok": False, "error": describe(error)})
        return 1
    if arguments.as_json:
        print_json({"input": arguments.rooms, "ok": not failed, "out": str(arguments.out), **said})
    else:
        size = f"{said['width']} x {said['height']}"
        print(f"{arguments.rooms} -> {arguments.out}  ({len(said['scenes'])} {said['kind']}, {size})")
    return 1 if failed else 0


def _make(arguments: argparse.Namespace) -> tuple[dict[str, Any], int]:
    """What was made, and how many rooms could not be shown."""
    from tqdm import tqdm

    from mixlight.data.rooms.collection import read_set
    from mixlight.data.rooms.sheet import TILES, choose, lay_out, write_jpeg

    kind = "crops" if arguments.crops else "panoramas"
    count, columns = arguments.count or _COUNTS[kind][0], arguments.columns or _COUNTS[kind][1]
    records = read_set(arguments.rooms)
    scenes: list[str] = []
    tiles: list[Tile] = []
    bad: set[Path] = set()
    with tqdm(total=count, desc=kind, unit="room", disable=None, leave=False) as bar:
        # Enough in reserve that every room but one may be bad.
        for k, record in enumerate(choose(records, count * len(records), arguments.seed)):
            if len(tiles) == count:
                break
            if record.path in bad:
                continue
            try:
                # A room that comes twice is lit and seen anew.
                tiles.append(TILES[kind](record, arguments.seed + 1000 * k))
            except (ValueError, OSError) as error:
                complain(describe(error, str(record.path)))
                bad.add(record.path)
                continue
            scenes.append(record.scene)
            bar.update()
    if not tiles:
        raise ValueError(f"{arguments.rooms}: expected rooms that can be shown, got none")
    sheet = lay_out(tiles, columns)
    quality = write_jpeg(sheet, arguments.out)
    height, width, _ = sheet.shape
    said = {"kind": kind, "width": width, "height": height, "quality": quality, "scenes": scenes}
    return said, len(bad)


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, received {text!r}")
    return int(text)


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0 on, received {text!r}")
    return int(text)
