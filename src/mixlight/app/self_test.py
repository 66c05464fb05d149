"""Whether the weights in the box are whole, and give on this machine the light that they gave when shipped.

The expectation lies beside the weights in `self_test.json`, written by `scripts/write_self_test.py` whenever
a shipped file changes: no number in it is typed by hand.
"""

import hashlib
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mixlight.app.health import Check

__all__ = ["FILE", "REINSTALL", "TOLERANCE", "digest", "measure", "weights"]

FILE = "self_test.json"
FORMAT = "mixlight/self-test"
VERSION = 1

MODEL = "default"
PHOTO = "lythwood_room.jpg"

TOLERANCE = 0.01
"""Largest difference of a number from its expectation, relative to the largest of its kind.

Processors, PyTorch's releases and JPEG decoders differ in last bits: in practice by 1e-3 at most. Broken
kernels and swapped channels differ by far more.
"""

REINSTALL = "pip install --force-reinstall --no-deps mixlight"


def digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as name:
    ...     file = Path(name) / "empty"
    ...     _ = file.write_bytes(b"")
    ...     digest(file)[:8]
    'e3b0c442'
    """
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def measure(assets: Path) -> dict[str, Any]:
    """What the test compares: the digest of each weights file, and the light of one shipped photo.

    Args:
        assets: the folder of the weights, with `examples/` in it.

    Raises:
        WeightsError, ImageFileError, OSError: a file is missing or corrupt.
    """
    from mixlight.app.photos import estimate
    from mixlight.network.estimator import Estimator

    found = estimate(assets / "examples" / PHOTO, model=Estimator.load(assets / f"{MODEL}.safetensors"))
    light = found.lighting
    return {
        "format": FORMAT,
        "version": VERSION,
        "weights": {path.name: digest(path) for path in sorted(assets.glob("*.safetensors"))},
        "model": MODEL,
        "photo": PHOTO,
        "light": {
            "ambient": [round(value, 6) for value in light.ambient.flatten().tolist()],
            "energy": [round(value, 6) for value in light.energy.sum(0).tolist()],
            # Where the sources are, as one vector: energies of single anchors may swap between neighbours.
            "sources": [round(v, 6) for v in (light.energy.sum(-1) @ light.axes).tolist()],
            "camera": [round(found.pitch, 6), round(found.roll, 6)],
        },
    }


def weights(assets: Path) -> Iterator[Check]:
    """The checks of the weights: each file's digest, and the light of the shipped photo.

    Args:
        assets: the folder of the weights, with `self_test.json` and `examples/` in it.
    """
    try:
        expected = json.loads((assets / FILE).read_text(encoding="utf-8"))
        digests, light = dict(expected["weights"]), dict(expected["light"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        yield Check("weights", FILE, "missing", f"expected a readable file: {error}", REINSTALL)
        return
    whole = True
    for name, digest_then in digests.items():
        path = assets / name
        if not path.is_file():
            state = Check("weights", name, "missing", f"expected in {assets}", REINSTALL)
        elif (now := digest(path)) != digest_then:
            text = f"expected SHA-256 {digest_then[:12]}…, received {now[:12]}…: not the file that shipped"
            state = Check("weights", name, "broken", text, REINSTALL)
        else:
            state = Check("weights", name, "ok", f"SHA-256 {now[:12]}…")
        whole = whole and state.state == "ok"
        yield state
    if whole:  # what a damaged file computes says nothing of this machine
        yield _light(assets, light)


def _light(assets: Path, expected: dict[str, list[float]]) -> Check:
    name = f"light of {PHOTO}"
    try:
        found = measure(assets)["light"]
        worst = max(_difference(found[kind], expected[kind]) for kind in found)
    except Exception as error:  # whatever goes wrong here is the finding
        return Check("weights", name, "broken", f"{type(error).__name__}: {error}", REINSTALL)
    if not worst <= TOLERANCE:
        text = f"expected the shipped reference within {TOLERANCE:.0%}, received a difference of {worst:.2g}"
        return Check("weights", name, "broken", text, 'pip install --force-reinstall "torch<2.14"')
    return Check("weights", name, "ok", f"as shipped, largest difference {worst:.1g} of the scale")


def _difference(found: list[float], expected: list[float]) -> float:
    """Largest difference relative to the largest expected magnitude; infinite where numbers are missing.

    >>> _difference([1.0, 2.02], [1.0, 2.0])
    0.01
    """
    if len(found) != len(expected) or not all(map(math.isfinite, found)):
        return math.inf
    scale = max(map(abs, expected), default=0.0)
    # Angles of a level camera are near 0; a tenth of a radian is scale enough for them.
    return max((abs(a - b) for a, b in zip(found, expected, strict=True)), default=0.0) / max(scale, 0.1)
