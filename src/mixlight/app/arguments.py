"""Types of options that several commands have."""

import argparse
from collections.abc import Callable

__all__ = ["whole"]


def whole(low: int, high: int) -> Callable[[str], int]:
    """The type of an option that takes a whole number from `low` to `high`.

    >>> whole(1, 9)("7")
    7
    """

    def parse(text: str) -> int:
        value = int(text) if text.isdecimal() else -1
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(
                f"expected a whole number from {low} to {high}, received {text!r}"
            )
        return value

    return parse
