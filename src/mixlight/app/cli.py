"""`mixlight`: one command with verbs.

Each verb is a module with `HELP`, `add_arguments(parser)` and `run(arguments)`.
"""

import argparse
import contextlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from mixlight import __version__
from mixlight.app import (
    ablate_command,
    doctor_command,
    edit_command,
    estimate_command,
    evaluate_command,
    export_command,
    fit_command,
    insert_command,
    render_command,
    rooms_command,
    train_command,
)
from mixlight.app.report import UsageError, complain

VERBS = {
    "estimate": estimate_command,
    "fit": fit_command,
    "edit": edit_command,
    "render": render_command,
    "insert": insert_command,
    "export": export_command,
    "rooms": rooms_command,
    "train": train_command,
    "evaluate": evaluate_command,
    "ablate": ablate_command,
    "doctor": doctor_command,
}

EXIT_USAGE = 2
"""Exit status for a call that is wrong as a whole; 1 says that some input failed, 130 an interrupt."""


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, and where to read on, instead of printing the usage first."""

    def error(self, message: str) -> NoReturn:
        complain(f"{message} (see `{self.prog} --help`)")
        sys.exit(EXIT_USAGE)


def parser() -> argparse.ArgumentParser:
    """The whole command line."""
    top = _Parser(
        prog="mixlight", description="One indoor photo in, the scene's HDR light out.", allow_abbrev=False
    )
    top.add_argument("--version", action="version", version=f"mixlight {__version__}")
    verbs = top.add_subparsers(dest="verb", required=True, metavar="VERB")
    for name, module in VERBS.items():
        module.add_arguments(
            verbs.add_parser(name, help=module.HELP, description=module.__doc__, allow_abbrev=False)
        )
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; returns the exit status."""
    for stream in (sys.stdout, sys.stderr):
        # A file name may hold bytes that the terminal's encoding cannot show.
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    parsed = parser().parse_args(arguments)
    try:
        status: int = VERBS[parsed.verb].run(parsed)
        sys.stdout.flush()
    except UsageError as error:
        complain(error)
        return EXIT_USAGE
    except BrokenPipeError:
        # The reader went away (`| head`); keep Python from complaining once more when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        complain("interrupted")
        return 130
    return status


if __name__ == "__main__":
    sys.exit(main())
