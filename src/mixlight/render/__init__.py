"""Objects lit by an environment map."""

from mixlight.render.spheres import SphereRenderer, render_spheres

__all__ = ["SphereRenderer", "render_spheres"]
