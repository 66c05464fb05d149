"""Say what the light of a set of rooms is like, beside that of real interiors."""

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from mixlight.data.panoramas import PanoramaRecord
    from mixlight.data.rooms.stats import Comparison, Reference, RoomStatistics

HELP = "compare the light of a set of rooms with real interiors"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight rooms stats`."""
    parser.add_argument("rooms", metavar="DIR", help="folder with a rooms.csv, or such a table")
    parser.add_argument(
        "--against", metavar="CSV",
        help="table of panoramas to compare with: its indoor ones of the split train (default: 25 real "
        "interiors, measured, that come with mixlight)",
    )  # fmt: skip
    parser.add_argument(
        "--recipes", type=_count, default=1, metavar="N",
        help="random relightings of each panorama with light groups (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=int, default=0, metavar="S", help="of the relightings (default: %(default)s)"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE.png", help="also draw the comparison")
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Measure and compare; returns the exit status."""
    from mixlight.data.rooms.collection import read_set
    from mixlight.data.rooms.stats import compare, read_reference

    if arguments.plot is not None:
        _check_plot(arguments.plot)
    try:
        records = read_set(arguments.rooms)
        reference = read_reference() if arguments.against is None else _measured(arguments.against)
    except (ValueError, OSError) as error:
        complain(describe(error))
        if arguments.as_json:
            print_json({"input": arguments.rooms, "ok": False, "error": describe(error)})
        return 1
    measured, rooms, failed = _measure_all(records, arguments.recipes, arguments.seed)
    if not measured:
        message = f"{arguments.rooms}: expected rooms that can be measured, got none"
        complain(message)
        if arguments.as_json:
            print_json({"input": arguments.rooms, "ok": False, "error": message})
        return 1
    rows = compare(measured, reference)
    if arguments.plot is not None:
        from mixlight.data.rooms.stats_plot import draw

        try:
            draw(measured, reference, arguments.plot)
        except OSError as error:
            complain(describe(error, str(arguments.plot)))
            failed += 1
    if arguments.as_json:
        line = {"input": arguments.rooms, "ok": not failed, "rooms": rooms, "panoramas": len(measured)}
        print_json(line | _document(rows, reference))
    else:
        print(_text(rows, reference, rooms, len(measured)))
    return 1 if failed else 0


def _check_plot(path: Path) -> None:
    """Before any work: nobody wants to learn after minutes that there is nothing to draw with."""
    if path.suffix.lower() != ".png":
        raise UsageError(f"--plot {path}: expected a name that ends in .png")
    from mixlight.data.rooms.stats_plot import require

    try:
        require()
    except ImportError as error:
        raise UsageError(f"--plot: {error}") from None


def _measured(table: str) -> "Reference":
    from mixlight.data.panoramas import read_radiance, read_table, select
    from mixlight.data.rooms.stats import Reference, measure

    records = select(read_table(table), "train", ("indoor",))
    if not records:
        raise ValueError(f"{table}: expected panoramas of the split train and the category indoor, got none")
    measured = {}
    for record in _progress(records, "reference"):
        try:
            measured[record.scene] = measure(read_radiance(record.path))
        except ValueError as error:
            raise ValueError(describe(error, str(record.path))) from error
    return Reference(f"{len(measured)} panoramas of {Path(table).name} (train, indoor)", measured)


def _measure_all(
    records: "Sequence[PanoramaRecord]", recipes: int, seed: int
) -> "tuple[list[RoomStatistics], int, int]":
    """What could be measured, of how many rooms, and how many files could not."""
    from mixlight.data.rooms.collection import relit
    from mixlight.data.rooms.stats import measure

    measured: list[RoomStatistics] = []
    rooms, failed = set(), 0
    for record in _progress(records, "rooms"):
        try:
            measured += [measure(panorama) for panorama in relit(record, recipes, seed)]
            rooms.add(record.group)
        except (ValueError, OSError) as error:
            complain(describe(error, str(record.path)))
            failed += 1
    return measured, len(rooms), failed


def _progress(records: "Sequence[PanoramaRecord]", what: str) -> "Iterable[PanoramaRecord]":
    from tqdm import tqdm

    return tqdm(records, desc=what, unit="file", disable=None, leave=False)


def _text(rows: "Sequence[Comparison]", reference: "Reference", rooms: int, panoramas: int) -> str:
    from mixlight.data.rooms.stats import LABELS

    width = max(len(label) for label in LABELS.values())
    levels = "".join(f"{level:>8}" for level in ("p10", "p25", "p50", "p75", "p90"))
    lines = [
        f"{panoramas} panoramas of {rooms} rooms, beside {reference.name}",
        f"{'':{width}}  {'':5}{levels}  median",
    ]
    for row in rows:
        verdict = {"inside": "inside the quartiles", "low": "LOW", "high": "HIGH"}[row.verdict]
        for name, values, said in (("rooms", row.rooms, verdict), ("real", row.reference, "")):
            numbers = "".join(f"{value:8.2f}" for value in values)
            label = LABELS[row.name] if name == "rooms" else ""
            lines.append(f"{label:{width}}  {name:5}{numbers}  {said}".rstrip())
    inside = sum(row.verdict == "inside" for row in rows)
    lines.append(f"{inside} of {len(rows)} medians lie between the quartiles of the real interiors.")
    return "\n".join(lines)


def _document(rows: "Sequence[Comparison]", reference: "Reference") -> dict[str, Any]:
    from mixlight.data.rooms.stats import QUANTILES

    return {
        "reference": {"name": reference.name, "panoramas": sorted(reference.measured)},
        "quantiles": list(QUANTILES),
        "statistics": {
            row.name: {
                "rooms": [round(value, 4) for value in row.rooms],
                "reference": [round(value, 4) for value in row.reference],
                "median": row.verdict,
            }
            for row in rows
        },
        "inside": sum(row.verdict == "inside" for row in rows),
    }


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, received {text!r}")
    return int(text)
