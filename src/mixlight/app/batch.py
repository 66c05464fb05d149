"""Many inputs, one folder each: names that never collide, failures that stop nobody else, one exit status."""

import argparse
import contextlib
import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mixlight.app.report import UsageError, complain, describe, print_json

__all__ = ["Job", "add_batch_arguments", "output_folder", "plan", "run_batch"]

DEFAULT_OUT = "mixlight-out"
PHOTO_MEGAPIXELS = 120.0
PANORAMA_MEGAPIXELS = 140.0
"""16384 x 8192 fits."""


@dataclass(frozen=True)
class Job:
    """One input and the folder that its results go to."""

    source: str
    """The path as the user wrote it, for messages."""
    folder: Path
    """Where the results of this input lie when it is done."""


def plan(sources: Sequence[str], out: Path) -> list[Job]:
    """Gives each input a folder of its own under `out`, named by its stem.

    Convention: inputs are numbered in the order given. The second input of one stem gets `<stem>-2`, the
    third `<stem>-3`, or the next number that no earlier input holds. Stems that differ only in case count as
    one, because some file systems see them so. The names depend on the call alone, not on what lies in `out`.

    >>> [job.folder.name for job in plan(["a/x.jpg", "b/x.png", "x-2.jpg", "c/X.jpg"], Path("out"))]
    ['x', 'x-2', 'x-2-2', 'X-3']
    """
    taken: set[str] = set()
    jobs = []
    for source in sources:
        # A name such as ".." is no folder to write to; it is refused when it is read.
        stem = Path(source).stem.strip(".") or "input"
        name, number = stem, 1
        while name.casefold() in taken:
            number += 1
            name = f"{stem}-{number}"
        taken.add(name.casefold())
        jobs.append(Job(source, out / name))
    return jobs


@contextlib.contextmanager
def output_folder(out: Path) -> Iterator[Path]:
    """Makes the folder `out`, proves that it can be written to, and removes it again if it stays empty.

    Raises:
        UsageError: `out` is a file, or cannot be made or written to.
    """
    missing = [folder for folder in (out, *out.parents) if not folder.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / f".mixlight.{os.getpid()}.probe"
        probe.mkdir()
        probe.rmdir()
    except OSError as error:
        _remove_if_empty(missing)
        raise UsageError(
            f"--out {out}: expected a folder that can be made and written to, received: {error.strerror}"
        ) from error
    try:
        yield out
    finally:
        _remove_if_empty(missing)


def _remove_if_empty(folders: Sequence[Path]) -> None:
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


def run_batch(jobs: Sequence[Job], work: Callable[[Job], dict[str, Any]], *, as_json: bool) -> int:
    """Does `work` for each job; returns 0 if all went well, else 1.

    `work` returns what is to be said about the result: with `as_json` one JSON line (`{"input", "ok", "out",
    "seconds", ...}`), else the value of its key `summary`. A job that fails gives one line on stderr and,
    with `as_json`, the line `{"input", "ok": false, "error"}`; the others are still done.
    """
    failed = 0
    for job in jobs:
        start = time.perf_counter()
        try:
            said = work(job)
        except (ValueError, OSError, MemoryError) as error:
            if isinstance(error, BrokenPipeError):
                raise
            failed += 1
            message = describe(error, job.source)
            complain(message)
            if as_json:
                print_json({"input": job.source, "ok": False, "error": message})
            continue
        summary = said.pop("summary")
        if as_json:
            seconds = round(time.perf_counter() - start, 3)
            print_json({"input": job.source, "ok": True, "out": str(job.folder), **said, "seconds": seconds})
        else:
            print(f"{job.source} -> {job.folder}{os.sep}  {summary}", flush=True)
    if failed and len(jobs) > 1:
        complain(f"{failed} of {len(jobs)} inputs failed")
    return 1 if failed else 0


def add_batch_arguments(parser: argparse.ArgumentParser, *, what: str, max_megapixels: float) -> None:
    """The options that `estimate` and `fit` share."""
    parser.add_argument(
        "--out", type=Path, default=Path(DEFAULT_OUT), metavar="DIR",
        help=f"where the results go: DIR/<name of the {what}>/ (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--height", type=height, default=128, metavar="ROWS",
        help="rows of the environment map, which is twice as wide (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--max-megapixels", type=megapixels, default=max_megapixels, metavar="M",
        help=f"refuse a larger {what} before it is decoded (default: %(default)g)",
    )  # fmt: skip
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help=f"print one line of JSON for each {what}"
    )


def height(text: str) -> int:
    """A map height from the command line."""
    value = int(text) if text.isdecimal() else 0
    if not 16 <= value <= 4096:
        raise argparse.ArgumentTypeError(f"expected a whole number from 16 to 4096, received {text!r}")
    return value


def megapixels(text: str) -> float:
    """A cap on image size from the command line."""
    value = number(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, received {text!r}")
    return value


def number(text: str) -> float:
    """A number from the command line; NaN where there is none, so that every range check refuses it."""
    try:
        return float(text)
    except ValueError:
        return math.nan
