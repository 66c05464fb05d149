"""Writes what `mixlight doctor` expects of the shipped weights: run it whenever one of those files changes.

python scripts/write_self_test.py
"""

import json

from mixlight.app.self_test import FILE, measure
from mixlight.image.atomic import atomic_path
from mixlight.network.weights import ASSETS


def main() -> None:
    with atomic_path(ASSETS / FILE) as temporary:
        temporary.write_text(json.dumps(measure(ASSETS), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
