"""What light is, without networks: harmonics, Gaussians, separation, `Lighting`, fit, documents."""

from mixlight.light.lighting import Lighting

__all__ = ["Lighting"]
