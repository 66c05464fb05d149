"""Score methods on photos with known light, by a named protocol.

Takes the protocol's photos from HDR panoramas, asks each method for their light, and writes to DIR:
samples.csv and samples.json (a line for each photo and method), results.json (means and medians with 95 %
intervals, and all that they depend on), table.md and table.tex. Floors and ceilings stand in every table.
What is finished is kept in DIR/scores.jsonl, and a run that was stopped goes on.
"""

import argparse
import json
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.batch import output_folder
from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from mixlight.data.panoramas import PanoramaRecord
    from mixlight.evaluation.methods import Method
    from mixlight.evaluation.protocols import Protocol
    from mixlight.evaluation.report import Report
    from mixlight.evaluation.runner import Outcome

HELP = "score methods on photos with known light"

FILES = ("samples.csv", "samples.json", "results.json", "table.md", "table.tex")
"""What a finished evaluation writes, beside the log of its scores."""

LOG = "scores.jsonl"

VERSION = 1
"""Of results.json and samples.json."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight evaluate`."""
    parser.add_argument(
        "--panoramas", action="append", required=True, type=Path, metavar="CSV_OR_DIR",
        help="a table of HDR panoramas (columns file and split), or a folder of them; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--split",
        default="test",
        choices=("train", "val", "test"),
        help="of the tables (default: %(default)s)",
    )
    parser.add_argument(
        "--category", action="append", default=[], metavar="NAME", dest="categories",
        help="score only panoramas of this category; may be repeated (default: all, a table each)",
    )  # fmt: skip
    parser.add_argument(
        "--protocol", default="M", choices=("M", "S", "L"),
        help="M: linear spheres, S: spheres as StyleLight renders them, L: light sources "
        "(default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--method", action="append", default=[], metavar="NAME", dest="methods",
        help="mixlight, mixlight+detail, a weights file, a floor, oracle:NAME or predictions:DIR, with a "
        "label before it if wanted (LABEL=NAME); may be repeated (default: mixlight)",
    )  # fmt: skip
    parser.add_argument(
        "--predictions", action="append", default=[], metavar="DIR",
        help="score the maps in this folder, <scene>_az<azimuth>.exr or .hdr; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--frame", default="mixlight", metavar="NAME",
        help="whose layout predicted maps have: mixlight (photo's azimuth at the centre), blender, three, "
        "... (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--horizon", default="level", choices=("level", "camera"),
        help="whether predicted maps stand upright, or are tilted as the camera was (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--without-floors", action="store_true", help="score no floors and ceilings beside the methods"
    )
    parser.add_argument(
        "--renderer", default="matrix", choices=("matrix", "blender"),
        help="of the spheres: exact light transport, or Blender's Cycles (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--samples", type=_count, default=1024, metavar="N",
        help="paths a pixel of --renderer blender (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path("mixlight-evaluation"), metavar="DIR",
        help="where the results go; one protocol and renderer a folder (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--fresh", action="store_true", help="score everything anew, whatever DIR/scores.jsonl holds"
    )
    parser.add_argument(
        "--photos", type=Path, metavar="DIR",
        help="only write the protocol's photos to this folder, for other systems to predict from",
    )  # fmt: skip
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help="print one line of JSON at the end"
    )


def run(arguments: argparse.Namespace) -> int:
    """Evaluate; returns the exit status."""
    from mixlight.evaluation import protocols

    protocol = protocols.find(arguments.protocol)
    if protocol.scene is None and arguments.renderer != "matrix":
        raise UsageError(
            f"--renderer {arguments.renderer}: protocol {protocol.letter} has no spheres to render"
        )
    try:
        records = _records(arguments.panoramas)
        chosen = _chosen(records, arguments)
    except (ValueError, OSError) as error:
        raise UsageError(describe(error)) from error
    if arguments.photos is not None:
        return _write_photos(protocol, chosen, arguments)
    try:
        methods = _methods(protocol, records, arguments)
    except (ValueError, OSError) as error:
        raise UsageError(describe(error)) from error
    with output_folder(arguments.out) as out:
        _check_folder(out, protocol.letter, arguments.renderer)
        return _evaluate(protocol, chosen, methods, out, arguments)


def _evaluate(
    protocol: "Protocol",
    records: "Sequence[PanoramaRecord]",
    methods: "Sequence[Method]",
    out: Path,
    arguments: argparse.Namespace,
) -> int:
    from tqdm import tqdm

    from mixlight.evaluation import renderers
    from mixlight.evaluation.log import ScoreLog
    from mixlight.evaluation.report import report_of
    from mixlight.evaluation.runner import run as score_all

    try:
        renderer = None
        if protocol.scene is not None:
            renderer = (
                renderers.matrix(protocol.scene)
                if arguments.renderer == "matrix"
                else renderers.blender(protocol.scene, arguments.samples)
            )
        total = len(records) * protocol.azimuths * len(methods)
        with tqdm(total=total, unit="score", disable=None, desc=f"protocol {protocol.letter}") as bar:
            if arguments.fresh:
                (out / LOG).unlink(missing_ok=True)
            log = ScoreLog(out / LOG)
            outcome = score_all(protocol, records, methods, log, renderer, bar.update)
    except (ValueError, OSError, RuntimeError, ImportError) as error:
        return _failed(describe(error), arguments)
    for failure in outcome.failures:
        complain(describe(failure.error, failure.source))
    if outcome.failures or not outcome.rows:
        kept = f"{len(outcome.rows)} scores are kept in {out / LOG}, and no table was written"
        what = f"{len(outcome.failures)} failures" if outcome.failures else "every photo is black"
        return _failed(f"{what}: {kept}", arguments)
    oracles = {method.name for method in methods if method.kind == "oracle"}
    report = report_of(protocol, outcome.rows, oracles)
    about = None if renderer is None else renderer.about
    _write(out, report, outcome, methods, about, arguments)
    if arguments.as_json:
        print_json(
            {
                "ok": True,
                "out": str(out),
                "protocol": protocol.letter,
                "counts": report.counts,
                "scored": outcome.scored,
                "left_out": outcome.left_out,
            }
        )
    else:
        photos = sum(count["photos"] for count in report.counts.values())
        print(f"protocol {protocol.letter}, {photos} photos, {len(methods)} methods -> {out}{os.sep}")
    return 0


def _write(
    out: Path,
    report: "Report",
    outcome: "Outcome",
    methods: "Sequence[Method]",
    renderer: object,
    arguments: argparse.Namespace,
) -> None:
    from mixlight.evaluation.report import latex, markdown, samples_csv
    from mixlight.image.atomic import atomic_path

    protocol = report.protocol
    results = {
        "format": "mixlight/evaluation",
        "version": VERSION,
        "protocol": protocol.to_json(),
        "renderer": renderer,
        "panoramas": [path.name for path in arguments.panoramas],
        "split": arguments.split,
        "counts": report.counts,
        "left_out": outcome.left_out,
        "provenance": _provenance(),
        "methods": {method.name: {"kind": method.kind, **method.about} for method in methods},
        "tables": report.tables,
    }
    rows = [
        asdict(row) | {"cells": {k: v if v == v else None for k, v in row.cells.items()}}
        for row in outcome.rows
    ]
    samples = {"format": "mixlight/evaluation-samples", "version": VERSION, "rows": rows}
    texts = {
        "samples.csv": samples_csv(protocol, outcome.rows),
        "samples.json": json.dumps(samples, allow_nan=False) + "\n",
        "results.json": json.dumps(results, indent=1, allow_nan=False) + "\n",
        "table.md": markdown(report),
        "table.tex": latex(report),
    }
    for name in FILES:
        with atomic_path(out / name) as temporary:
            Path(temporary).write_text(texts[name], encoding="utf-8")


def _provenance() -> dict[str, object]:
    """Which code ran on what; `seed` is that of the intervals' draws, the only chance there is."""
    import torch

    from mixlight import __version__
    from mixlight.training.card import commit

    return {
        "mixlight": __version__,
        "commit": commit(),
        "seed": 0,
        "machine": f"{platform.system()} {platform.machine()}, {torch.get_num_threads()} threads",
        "python": platform.python_version(),
        "torch": torch.__version__,
    }


def _records(sources: Sequence[Path]) -> "list[PanoramaRecord]":
    """All panoramas of the tables and folders; no group stands on two sides of the split."""
    from mixlight.data.panoramas import check_split, read_folder, read_table

    records: list[PanoramaRecord] = []
    for source in sources:
        records += read_folder(source) if source.is_dir() else read_table(source)
    check_split(records)
    return records


def _chosen(records: "Sequence[PanoramaRecord]", arguments: argparse.Namespace) -> "list[PanoramaRecord]":
    from mixlight.data.panoramas import select

    chosen = select(records, arguments.split, arguments.categories or None)
    if not chosen:
        there = sorted({f"{record.split}/{record.category}" for record in records})
        wanted = "/".join((arguments.split, ",".join(arguments.categories) or "any category"))
        raise ValueError(f"expected panoramas of {wanted}, found only {', '.join(there)}")
    # Indoor first, then as listed: a table for each category, in this order.
    return sorted(chosen, key=lambda record: record.category != "indoor")


def _methods(
    protocol: "Protocol", records: "Sequence[PanoramaRecord]", arguments: argparse.Namespace
) -> "list[Method]":
    from mixlight.evaluation.methods import Methods

    known = Methods(protocol, records, arguments.frame, arguments.horizon)
    names = list(arguments.methods)
    for folder in arguments.predictions:
        label, equals, path = folder.partition("=")
        names.append(f"{label}=predictions:{path}" if equals else f"predictions:{folder}")
    names = names or ["mixlight"]
    if not arguments.without_floors:
        names = [*(name for name in known.standard if name not in names), *names]
    return [known.open(name) for name in names]


def _check_folder(out: Path, letter: str, renderer: str) -> None:
    """Refuses to write over the results of another protocol or renderer."""
    try:
        before: dict[str, Any] = json.loads((out / "results.json").read_text(encoding="utf-8"))
        found = before["protocol"]["letter"], (before["renderer"] or {}).get("kind", renderer)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return
    if found != (letter, renderer):
        raise UsageError(
            f"--out {out}: expected a folder for protocol {letter} with the renderer {renderer}, received "
            f"one with results of protocol {found[0]} and {found[1]}"
        )


def _write_photos(
    protocol: "Protocol", records: "Sequence[PanoramaRecord]", arguments: argparse.Namespace
) -> int:
    """The protocol's photos as PNG, and a table of where each looks."""
    from mixlight.app.photo_set import write_photos

    try:
        count = write_photos(protocol, records, arguments.photos, quiet=not sys.stderr.isatty())
    except (ValueError, OSError) as error:
        return _failed(describe(error), arguments)
    if arguments.as_json:
        print_json({"ok": True, "photos": str(arguments.photos), "count": count})
    else:
        print(f"protocol {protocol.letter}, {count} photos -> {arguments.photos}{os.sep}")
    return 0


def _failed(message: str, arguments: argparse.Namespace) -> int:
    complain(message)
    if arguments.as_json:
        print_json({"ok": False, "error": message})
    return 1


def _count(text: str) -> int:
    value = int(text) if text.isdecimal() else 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, received {text!r}")
    return value
