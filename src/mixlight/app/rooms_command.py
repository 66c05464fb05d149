"""Render rooms that never were: HDR panoramas with every light apart, for training.

Needs Blender in an environment of its own (`mixlight doctor` says how to get it). The same seed gives the
same room. A call that was stopped, killed or ran out of disk is simply repeated: rooms that are done stay.
"""

import argparse
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app import rooms_assets, rooms_preview, rooms_sheet, rooms_stats
from mixlight.app.arguments import whole
from mixlight.app.report import UsageError, complain, describe, print_json
from mixlight.app.rooms_library import add_library_options, check_library_options, chosen_library

if TYPE_CHECKING:
    from mixlight.data.rooms.render import Outcome
    from mixlight.data.rooms.skies import OutdoorSky

HELP = "render rooms for training, with every light apart"

ACTIONS = {"assets": rooms_assets, "preview": rooms_preview, "sheet": rooms_sheet, "stats": rooms_stats}
"""What else can be done with rooms: modules as verbs have them."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight rooms`."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", title="other actions")
    for name, module in ACTIONS.items():
        module.add_arguments(
            actions.add_parser(name, help=module.HELP, description=module.__doc__, allow_abbrev=False)
        )
    parser.add_argument(
        "--count", type=whole(1, 10**6), metavar="N", help="how many rooms the set shall have"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the set")
    parser.add_argument(
        "--seed", type=whole(0, 10**9), default=0, metavar="S",
        help="of the first room; the others follow it (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--width", type=whole(64, 8192), default=1024, metavar="PIXELS",
        help="of a panorama, which is half as high (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--samples", type=whole(1, 65536), default=16, metavar="N",
        help="light paths a pixel, before the noise is taken off (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--cameras", type=whole(1, 64), default=3, metavar="K",
        help="panoramas a room, each from another place (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--jobs", type=whole(1, 256), default=1, metavar="J",
        help="Blenders at a time, which share the cores (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--skies", type=Path, metavar="CSV",
        help="table of panoramas: its outdoor ones of the split train stand outside the windows (default: "
        "skies made up)",
    )  # fmt: skip
    add_library_options(parser)
    parser.add_argument(
        "--lossless", action="store_true", help="keep every half float as it is, at three times the size"
    )
    parser.add_argument(
        "--timeout", type=whole(1, 10**6), default=3600, metavar="SECONDS",
        help="give a room up after this long (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help="print one line of JSON for each room"
    )


def run(arguments: argparse.Namespace) -> int:
    """Render, or do what the action says; returns the exit status."""
    if arguments.action is not None:
        status: int = ACTIONS[arguments.action].run(arguments)
        return status
    for option in ("count", "out"):
        if getattr(arguments, option) is None:
            raise UsageError(f"rooms: expected --{option}, or an action: {', '.join(ACTIONS)}")
    check_library_options(arguments)
    from mixlight.blender.program import BlenderError
    from mixlight.data.rooms.render import RenderError

    try:
        return _render(arguments)
    except (ValueError, OSError, BlenderError, RenderError) as error:
        if isinstance(error, BrokenPipeError):
            raise
        complain(describe(error))
        if arguments.as_json:
            print_json({"out": str(arguments.out), "ok": False, "error": describe(error)})
        return 1


def _render(arguments: argparse.Namespace) -> int:
    from tqdm import tqdm

    from mixlight.blender.program import find_blender
    from mixlight.data.rooms.job import Settings
    from mixlight.data.rooms.render import Rooms, render_rooms
    from mixlight.data.rooms.room_set import RoomSet

    find_blender()
    rooms = Rooms(
        Settings(width=arguments.width, samples=arguments.samples),
        arguments.cameras,
        chosen_library(arguments),
        _skies(arguments.skies),
        arguments.timeout,
        arguments.lossless,
    )
    seeds = range(arguments.seed, arguments.seed + arguments.count)
    there = len(RoomSet(arguments.out).rooms().keys() & set(seeds))
    start = time.monotonic()
    with tqdm(total=len(seeds), initial=there, unit="room", disable=None) as bar:

        def report(outcome: "Outcome") -> None:
            if outcome.error is None:
                bar.update()
                made = bar.n - there
                bar.set_postfix_str(f"{made * 3600 / (time.monotonic() - start):.0f} rooms/h")
            else:
                with bar.external_write_mode():
                    complain(f"room {outcome.seed}: {outcome.error}")
            if arguments.as_json:
                with bar.external_write_mode():
                    _say(arguments.out, outcome)

        outcomes = render_rooms(seeds, arguments.out, rooms, jobs=arguments.jobs, report=report)
    bad = [outcome.seed for outcome in outcomes if outcome.error is not None]
    if not arguments.as_json:
        made = len(outcomes) - len(bad)
        hours = (time.monotonic() - start) / 3600
        rate = f", {made / hours:.0f} an hour" if made else ""
        kept = f", {there} were there already" if there else ""
        print(f"{made} rooms -> {arguments.out}{os.sep}{rate}{kept}")
    if bad:
        complain(f"{len(bad)} of {len(seeds)} rooms failed and are left out: {', '.join(map(str, bad))}")
    return 1 if bad else 0


def _say(out: Path, outcome: "Outcome") -> None:
    line: dict[str, Any] = {"seed": outcome.seed, "ok": outcome.error is None}
    if outcome.error is None:
        line |= {"out": str(out), "panoramas": outcome.panoramas}
        line |= {"seconds": {name: round(value, 3) for name, value in outcome.seconds.items()}}
    else:
        line["error"] = outcome.error
    print_json(line)


def _skies(table: Path | None) -> "tuple[OutdoorSky, ...]":
    from mixlight.data.rooms.skies import read_skies

    if table is None:
        return ()
    cache = os.environ.get("XDG_CACHE_HOME", "")
    base = Path(cache) if os.path.isabs(cache) else Path.home() / ".cache"
    return tuple(read_skies(table, base / "mixlight" / "skies"))
