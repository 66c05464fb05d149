"""What test spheres are made of, and how the three materials of protocol M reflect light."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from jaxtyping import Float
from torch import Tensor


@dataclass(frozen=True)
class Material:
    """One of the materials a test sphere is made of; the same in every channel."""

    name: str
    """Name used in results and pictures."""
    kind: Literal["diffuse", "ggx", "mirror", "paint", "metal"]
    """How it reflects: the plain three of this module, or the two of `mixlight.light.principled`."""
    reflectance: float
    """Albedo of `diffuse` and of what lies under the coat of `paint`; of the others the reflectance at normal
    incidence (and, for `ggx` and `mirror`, at every other)."""
    alpha: float = 0.0
    """GGX roughness alpha (the square of the artist's roughness) of `ggx`, `metal` and the coat of `paint`.
    A metal of alpha 0 is a mirror."""
    ior: float = 1.5
    """Index of refraction of the coat of `paint`."""

    @property
    def is_mirror(self) -> bool:
        """Whether it shows the world itself, unblurred."""
        return self.kind == "mirror" or (self.kind == "metal" and self.alpha == 0)


MATERIALS: tuple[Material, ...] = (
    Material("diffuse", "diffuse", 0.8),
    Material("matte", "ggx", 0.8, alpha=0.3271**2),
    Material("mirror", "mirror", 0.8),
)
"""The three spheres of protocol M: gray diffuse, matte silver, mirror silver, in this order.

Reflectance and roughness are those that protocol S names (base colour .8, roughness .3271), so that
the two protocols differ in exposure and tone-mapping alone.
"""

VIEW: tuple[float, float, float] = (0.0, 0.0, 1.0)
"""Direction from a test sphere to its camera: +Z, for the camera looks along -Z like the photo's."""


def diffuse_kernel(
    cos_light: Float[Tensor, "*shape"], albedo: float = MATERIALS[0].reflectance
) -> Float[Tensor, "*shape"]:
    """Radiance that a Lambertian surface sends out per incident radiance and steradian [1/sr].

    k = albedo / pi * max(n.l, 0)

    Convention: the foreshortening n.l is part of the kernel: under radiance 1 from everywhere the
    surface shows exactly `albedo`. Albedo .8, light along the normal: k = .8 / pi = .2546.

    >>> import torch
    >>> round(diffuse_kernel(torch.tensor(1.0)).item(), 4)
    0.2546
    """
    return cos_light.clamp(min=0) * (albedo / math.pi)


def ggx_kernel(
    cos_light: Float[Tensor, "*#shape"],
    cos_view: Float[Tensor, "*#shape"],
    light_dot_view: Float[Tensor, "*#shape"],
    alpha: float = MATERIALS[1].alpha,
    colour: float = MATERIALS[1].reflectance,
) -> Float[Tensor, "*shape"]:
    """Radiance that a rough metal sends out per incident radiance and steradian [1/sr].

    With c_l = n.l, c_v = n.v, c_h = n.h the cosines of light, view and half vector:

        k = colour * D / (2 (c_v s(c_l) + c_l s(c_v))) * max(c_l, 0)
        D = alpha² / (pi (1 - (1 - alpha²) c_h²)²)
        s(c) = sqrt(alpha² + (1 - alpha²) c²)

    which is D G2 / (4 c_l c_v) * c_l with Smith's height-correlated masking and shadowing G2; one
    bounce, and no Fresnel term (`colour` at every angle).

    Convention: n.l is part of the kernel. Light, view and normal in one line, alpha .25, colour .8:
    D = 1 / (pi alpha²) = 5.093, k = .8 D / 4 = 1.0186.

    Source: Heitz, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, 2014.

    >>> import torch
    >>> one = torch.tensor(1.0)
    >>> round(ggx_kernel(one, one, one, alpha=0.25, colour=0.8).item(), 4)
    1.0186
    """
    alpha2 = alpha * alpha
    light = cos_light.clamp(min=0)
    view = cos_view.clamp(min=0)
    # (l + v)/|l + v| . n, squared, without forming the half vector. Where l + v vanishes, so does n.l.
    cos_half2 = (cos_light + cos_view) ** 2 / (2 + 2 * light_dot_view).clamp(min=1e-12)
    spread = (1 - (1 - alpha2) * cos_half2.clamp(max=1)) ** 2
    smith = (
        view * (alpha2 + (1 - alpha2) * light**2).sqrt() + light * (alpha2 + (1 - alpha2) * view**2).sqrt()
    )
    return light * (colour * alpha2 / (2 * math.pi)) / (spread * smith).clamp(min=1e-30)


def reflect(normals: Float[Tensor, "*#n 3"], view: Float[Tensor, "*#n 3"]) -> Float[Tensor, "*n 3"]:
    """Direction from which a mirror shows light to the viewer: 2 (n.v) n - v.

    Convention: all directions point away from the surface. Seen along +Z, the normal that leans by
    45° to the right shows what lies at +X.

    >>> import torch
    >>> half = math.sqrt(0.5)
    >>> d = reflect(torch.tensor([half, 0.0, half]), torch.tensor([0.0, 0.0, 1.0]))
    >>> [round(x, 4) for x in d.tolist()]
    [1.0, 0.0, 0.0]
    """
    return 2 * (normals * view).sum(-1, keepdim=True) * normals - view
