"""Compare variants of the method from a TOML file; a run that was stopped goes on where it was."""

import argparse
import sys
from pathlib import Path

from mixlight.app.report import complain, describe, print_json

HELP = "compare variants of the method"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight ablate`."""
    parser.add_argument(
        "experiment", type=Path, metavar="EXPERIMENT.toml", help="see experiments/ablations for examples"
    )
    parser.add_argument(
        "--out", type=Path, metavar="FILE",
        help="the results, in JSON (default: runs/ablations/ and the experiment's name)",
    )  # fmt: skip
    parser.add_argument(
        "--store", type=Path, metavar="DIR", default=Path("runs") / "ablations" / "pieces",
        help="where finished runs are kept, for this experiment and others (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="where labels and features are kept between runs"
    )
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help="print one line of JSON at the end"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the table; returns the exit status."""
    from tqdm import tqdm

    from mixlight.evaluation.ablation import Piece, ablate, pieces
    from mixlight.evaluation.ablation_report import markdown
    from mixlight.evaluation.experiment import read_experiment

    out = arguments.out or Path("runs") / "ablations" / f"{arguments.experiment.stem}.json"
    cache = arguments.cache / "labels" if arguments.cache else None
    try:
        experiment = read_experiment(arguments.experiment)
        with tqdm(total=len(pieces(experiment)), unit="run", disable=None, file=sys.stderr) as bar:

            def one_more(piece: Piece) -> None:
                bar.update()

            result = ablate(experiment, out, arguments.store, cache, one_more)
    except (ValueError, OSError, ImportError, FloatingPointError) as error:
        message = describe(error)
        complain(message)
        if arguments.as_json:
            print_json({"input": str(arguments.experiment), "ok": False, "error": message})
        return 1
    if arguments.as_json:
        print_json({"input": str(arguments.experiment), "ok": True, "out": str(out)})
    else:
        print(markdown(result))
    return 0
