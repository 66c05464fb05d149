"""Tell what is installed, what is missing and how to get it, and test the weights.

Exit status 0 when MixLight itself works, whatever extras and other programs are missing; 1 when it does not.
"""

import argparse
import platform
import sys
from itertools import groupby
from typing import TYPE_CHECKING

from mixlight import __version__
from mixlight.app.report import print_json

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mixlight.app.health import Check

HELP = "what is installed, what is missing, and does it work"

_TITLES = {
    "core": "MixLight",
    "weights": "Weights",
    "extra": "Extras",
    "program": "Other programs",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight doctor`."""
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help="print one line of JSON instead of the table"
    )


def run(arguments: argparse.Namespace) -> int:
    """Look at everything; returns the exit status."""
    checks = _checks()
    if arguments.as_json:
        found = list(checks)
        print_json(
            {
                "ok": not any(check.fatal for check in found),
                "mixlight": __version__,
                "python": platform.python_version(),
                "platform": platform.platform(),
                "checks": [check.as_json() for check in found],
            }
        )
        return int(any(check.fatal for check in found))
    print(f"mixlight {__version__}, Python {platform.python_version()}, {platform.platform()}")
    fatal = []
    for group, members in groupby(checks, key=lambda check: check.group):
        print(f"\n{_TITLES[group]}", flush=True)
        for check in members:
            print(f"  {check.state:7s}  {check.name:24s}  {check.detail}", flush=True)
            if check.command:
                print(f"           {'':24s}  $ {check.command}", flush=True)
            if check.fatal:
                fatal.append(check.name)
    print(f"\nMixLight does not work: {', '.join(fatal)}." if fatal else "\nMixLight works.")
    return int(bool(fatal))


def _checks() -> "Iterator[Check]":
    """All checks, in the order of `_TITLES`, each made when it is asked for."""
    from importlib.metadata import PackageNotFoundError
    from pathlib import Path

    from mixlight.app import health, self_test

    home = Path(__file__).resolve().parents[1]
    wanted: list[health.Requirement] = []
    yield health.Check("core", "mixlight", "ok", f"{__version__}, {home}")
    try:
        wanted = health.requirements()
        known = None
    except PackageNotFoundError:
        text = "mixlight runs without being installed: what it needs is not known"
        known = health.Check("extra", "metadata", "missing", text, "pip install --editable .")
    yield health.Check("core", "Python", "ok", f"{platform.python_version()}, {sys.executable}")
    core = list(health.packages(wanted))
    yield from core
    if not any(check.fatal for check in core):
        yield from self_test.weights(home / "assets")
    if known is not None:
        yield known
    yield from health.extras(wanted)
    yield from health.programs()
