"""What reading pixels must not cost: torch, and codecs before they are needed."""

import subprocess
import sys

import mixlight.image


def test_importing_loads_neither_torch_nor_a_codec() -> None:
    code = (
        "import sys, mixlight.image, mixlight.image.exr, mixlight.image.radiance\n"
        "print(*(m for m in ('torch', 'PIL', 'cv2', 'OpenEXR', 'scipy') if m in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_the_public_names_exist() -> None:
    assert all(hasattr(mixlight.image, name) for name in mixlight.image.__all__)
