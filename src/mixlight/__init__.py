"""MixLight: one indoor photo in, the scene's HDR light out.

The light is ambient light in spherical harmonics plus sparse spherical Gaussians for the sources, in the
photo's own exposure (`docs/conventions.md`). The names below are the whole public surface; the folders under
them are public too and as stable as their version says. Nothing is imported before it is used, so `import
mixlight` is instant.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mixlight.app.photos import estimate as estimate
    from mixlight.image.ldr import Photo as Photo
    from mixlight.image.ldr import read_photo as read_photo
    from mixlight.light.document import load as load
    from mixlight.light.document import save as save
    from mixlight.light.fit import fit as fit
    from mixlight.light.lighting import Lighting as Lighting
    from mixlight.light.lights import Light as Light
    from mixlight.network.estimator import Estimate as Estimate
    from mixlight.network.estimator import Estimator as Estimator
    from mixlight.network.sparsemax import slsparsemax as slsparsemax
    from mixlight.network.sparsemax import sparsemax as sparsemax
    from mixlight.render.spheres import render_spheres as render_spheres
    from mixlight.sphere.frames import convert_panorama as convert_panorama

__version__ = "0.1.0"

_HOME = {
    "Estimate": "mixlight.network.estimator",
    "Estimator": "mixlight.network.estimator",
    "Light": "mixlight.light.lights",
    "Lighting": "mixlight.light.lighting",
    "Photo": "mixlight.image.ldr",
    "convert_panorama": "mixlight.sphere.frames",
    "estimate": "mixlight.app.photos",
    "fit": "mixlight.light.fit",
    "load": "mixlight.light.document",
    "read_photo": "mixlight.image.ldr",
    "render_spheres": "mixlight.render.spheres",
    "save": "mixlight.light.document",
    "slsparsemax": "mixlight.network.sparsemax",
    "sparsemax": "mixlight.network.sparsemax",
}

__all__ = [
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
]


def __getattr__(name: str) -> object:
    """Import a public name when it is first asked for (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module 'mixlight' has no attribute {name!r}")
    value: object = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, whether imported yet or not."""
    return sorted(__all__)
