"""Pictures that consumers rendered, kept for the docs and held by the tests that make them."""

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mixlight.image.ldr import write_png

FOLDER = Path(__file__).resolve().parents[2] / "docs/images/consumers"


def hold(name: str, pixels: NDArray[np.uint8], tolerance: float = 2.0) -> None:
    """Hold a picture against the one that the docs show.

    Args:
        name: its file is docs/images/consumers/<name>.png.
        pixels: [height, width, 3].
        tolerance: the largest mean absolute difference, in codes of 0 to 255.

    With MIXLIGHT_UPDATE_IMAGES=1 the file is written anew. A picture that differs fails the test and is left
    beside the docs' as <name>.new.png, to be looked at.
    """
    path = FOLDER / f"{name}.png"
    if os.environ.get("MIXLIGHT_UPDATE_IMAGES") == "1":
        path.parent.mkdir(parents=True, exist_ok=True)
        write_png(path, pixels)
        return
    fresh = path.with_suffix(".new.png")
    if not path.is_file():
        pytest.fail(f"expected the picture {path.name}, found none: run with MIXLIGHT_UPDATE_IMAGES=1")
    from PIL import Image

    with Image.open(path) as image:
        expected = np.asarray(image.convert("RGB"))
    if pixels.shape == expected.shape:
        difference = float(np.abs(pixels.astype(np.float64) - expected).mean())
        if difference <= tolerance:
            fresh.unlink(missing_ok=True)
            return
        received = f"a mean difference of {difference:.2f}"
    else:
        received = f"{pixels.shape[1]} x {pixels.shape[0]} pixels"
    write_png(fresh, pixels)
    pytest.fail(
        f"expected {path.name} within {tolerance:g} codes, received {received} ({fresh.name}); if the change "
        "is meant, run with MIXLIGHT_UPDATE_IMAGES=1"
    )
