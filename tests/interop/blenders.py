"""The Blenders that the tests run in, each in an environment of its own."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
VERSIONS = tuple(os.environ.get("MIXLIGHT_BLENDER_VERSIONS", "4.5 5.0").split())
"""Environments .interop/blender-VERSION; the variable names others to try by hand."""


def blender_python(version: str) -> Path:
    """The Python with bpy of this version; a failure that says how to get it if there is none."""
    path = ROOT / ".interop" / f"blender-{version}" / "bin" / "python"
    if not path.exists():
        pytest.fail(f"expected Blender {version} in .interop, found none: run scripts/make_blender_env.sh")
    return path
