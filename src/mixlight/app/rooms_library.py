"""The options that say where a room's furniture comes from, alike in all commands that make rooms."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from mixlight.app.report import UsageError

if TYPE_CHECKING:
    from mixlight.data.rooms.catalogue import Catalogue

__all__ = ["add_library_options", "check_library_options", "chosen_library"]


def add_library_options(parser: argparse.ArgumentParser) -> None:
    """Add `--library` and `--no-library`."""
    parser.add_argument(
        "--library", type=Path, metavar="DIR",
        help="furniture, as `mixlight rooms assets` makes it (default: where that puts it, if it is there)",
    )  # fmt: skip
    parser.add_argument(
        "--no-library", action="store_true", help="only furniture that MixLight makes up itself"
    )


def check_library_options(arguments: argparse.Namespace) -> None:
    """Refuse both at once.

    Raises:
        UsageError: both were given.
    """
    if arguments.no_library and arguments.library is not None:
        raise UsageError("rooms: expected --library or --no-library, received both")


def chosen_library(arguments: argparse.Namespace) -> "Catalogue | None":
    """The library that the options name; None for our own pieces only.

    Raises:
        ValueError: the library that was named is damaged.
        OSError: it is not there or cannot be read.
    """
    from mixlight.data.rooms.catalogue import Catalogue

    if arguments.no_library:
        return None
    return Catalogue.find() if arguments.library is None else Catalogue.load(arguments.library)
