"""The inventory of the public names: a name comes or goes only together with this list."""

import subprocess
import sys

import pytest

import mixlight

INVENTORY = {
    "Estimate",
    "Estimator",
    "Light",
    "Lighting",
    "Photo",
    "__version__",
    "convert_panorama",
    "estimate",
    "fit",
    "load",
    "read_photo",
    "render_spheres",
    "save",
    "slsparsemax",
    "sparsemax",
}


def test_the_public_names_are_these_and_at_most_twenty() -> None:
    assert set(mixlight.__all__) == INVENTORY
    assert set(dir(mixlight)) == INVENTORY
    assert len(INVENTORY) <= 20


@pytest.mark.parametrize("name", sorted(INVENTORY))
def test_each_public_name_is_there_and_documented(name: str) -> None:
    value = getattr(mixlight, name)
    assert isinstance(value, str) or value.__doc__


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = mixlight.no_such_name  # type: ignore[attr-defined]


@pytest.mark.parametrize("module", ["mixlight", "mixlight.app.cli", "mixlight.image"])
def test_these_imports_do_not_pull_torch(module: str) -> None:
    code = f"import sys, {module}; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
