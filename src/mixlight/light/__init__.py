"""What light is, without networks: harmonics, Gaussians, separation, `Lighting`, fit, documents."""

from mixlight.light.lighting import Lighting
from mixlight.light.lights import Light

__all__ = ["Light", "Lighting"]
