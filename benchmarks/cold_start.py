"""(b) A cold `mixlight estimate one.jpg` against importing torch."""

import subprocess
import sys
import tempfile
from pathlib import Path

import mixlight
from benchmarks.timing import Result, side_by_side

PHOTO = Path(mixlight.__file__).parent / "assets" / "examples" / "comfy_cafe.jpg"


def measure() -> Result:
    with tempfile.TemporaryDirectory() as folder:

        def ours() -> None:
            command = [sys.executable, "-m", "mixlight.app.cli", "estimate", str(PHOTO), "--out", folder]
            subprocess.run(command, check=True, capture_output=True)

        def bare() -> None:
            subprocess.run([sys.executable, "-c", "import torch"], check=True, capture_output=True)

        return side_by_side(
            "b",
            2.0,
            ("mixlight estimate one.jpg, whole process", ours),
            ("python -c 'import torch'", bare),
            7,
            1,
        )
