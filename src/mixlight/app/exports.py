"""What the verbs share that write for other programs: the options and the writing of each target."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.report import UsageError, complain, describe
from mixlight.export.registry import TARGETS, Target, select, write_target

if TYPE_CHECKING:
    from mixlight.export.rig import Rig

__all__ = ["add_target_arguments", "chosen_targets", "write_targets"]


def add_target_arguments(parser: argparse.ArgumentParser, *, required: bool) -> None:
    """The options `--for`, `--lights` and `--residual`, as `targets`, `lights` (None: all) and `residual`."""
    parser.add_argument(
        "--for", action="append", dest="targets", default=None, required=required, metavar="TARGET",
        help=f"{', '.join(TARGETS)}; several with commas or by repeating the option; all: every one of light",
    )  # fmt: skip
    parser.add_argument(
        "--lights", type=_lights, default=None, metavar="N",
        help="named lights to write, merged from the lobes, brightest first; 0 for none (default: all)",
    )  # fmt: skip
    parser.add_argument(
        "--residual", action=argparse.BooleanOptionalAction, default=True,
        help="take the lights out of the map that goes with them (default); with --no-residual the map holds "
        "everything and the lights are written switched off",
    )  # fmt: skip


def chosen_targets(arguments: argparse.Namespace) -> list[Target]:
    """The targets that `--for` names, each once.

    Raises:
        UsageError: an unknown name; the message lists the known ones.
    """
    try:
        return select(arguments.targets or ())
    except ValueError as error:
        raise UsageError(f"--for: {error}") from error


def write_targets(
    targets: Sequence[Target],
    source: "Rig | str | Path",
    out: Path,
    *,
    done: Callable[[Target], None],
    **options: Any,
) -> dict[str, str]:
    """Write each target into its folder below `out`; one that fails stops no other and leaves nothing behind.

    Args:
        targets: what to write.
        source: the rig, or the model's name for targets of the model.
        out: an existing folder.
        done: called after each target that went well.
        options: what only these targets' `write` takes (`precision` of onnx).

    Returns:
        For each target that failed, its name and one line on why; the same line goes to stderr.
    """
    failed = {}
    for target in targets:
        try:
            write_target(target, source, out, **options)
        except (ValueError, OSError, MemoryError, ImportError) as error:
            failed[target.name] = describe(error, target.name)
            complain(failed[target.name])
        else:
            done(target)
    return failed


def _lights(text: str) -> int | None:
    if text == "all":
        return None
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 0, or all, received {text!r}")
    return int(text)
