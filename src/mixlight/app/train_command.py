"""Train a network from a TOML config; a run that was stopped goes on where it was."""

import argparse
import tomllib
from pathlib import Path
from typing import Any

from mixlight.app.report import UsageError, complain, describe, print_json

HELP = "train a network from a config"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight train`."""
    parser.add_argument("config", type=Path, metavar="CONFIG.toml", help="see experiments/ for examples")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the run (default: runs/ and the config's name)"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides",
        help="override one value of the config, in TOML (optimiser.learning_rate=5e-4); may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--fresh", action="store_true", help="start anew instead of going on from the checkpoint in DIR"
    )
    parser.add_argument("--cache", type=Path, metavar="DIR", help="where labels are kept between runs")
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help="print one line of JSON at the end"
    )


def run(arguments: argparse.Namespace) -> int:
    """Train; returns the exit status."""
    from mixlight.training.config import read_config
    from mixlight.training.loop import train

    overrides = _overrides(arguments.overrides)
    try:
        config = read_config(arguments.config, overrides)
        out = arguments.out or Path("runs") / arguments.config.stem
        model = train(config, out, resume=not arguments.fresh, cache=arguments.cache)
    except (ValueError, OSError, ImportError, FloatingPointError) as error:
        message = describe(error)
        complain(message)
        if arguments.as_json:
            print_json({"input": str(arguments.config), "ok": False, "error": message})
        return 1
    if arguments.as_json:
        print_json({"input": str(arguments.config), "ok": True, "out": str(model)})
    else:
        print(f"{arguments.config} -> {model}")
    return 0


def _overrides(pairs: list[str]) -> dict[str, Any]:
    """`KEY=VALUE` with the value in TOML; a bare word counts as a string."""
    values: dict[str, Any] = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        key = name.strip()
        if not key or not equals:
            raise UsageError(f"--set {pair}: expected KEY=VALUE")
        try:
            values[key] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            values[key] = text
    return values
