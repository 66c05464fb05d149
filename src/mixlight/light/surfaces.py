"""Every material of a test sphere behind one function, and the materials of protocol S."""

from __future__ import annotations

from jaxtyping import Float
from torch import Tensor

from mixlight.light.principled import metal_kernel, paint_kernel, schlick
from mixlight.light.reflection import Material, diffuse_kernel, ggx_kernel

PRINCIPLED: tuple[Material, ...] = (
    Material("diffuse", "paint", 0.8, alpha=0.364**2, ior=1.5),
    Material("matte", "metal", 0.8, alpha=0.3271**2),
    Material("mirror", "metal", 0.8),
)
"""The three spheres of protocol S, each Blender's Principled surface of base colour .8: diffuse (metallic 0,
roughness .364, specular .5, which is an index of 1.5), matte (metallic 1, roughness .3271) and mirror
(metallic 1, roughness 0)."""


def kernel(
    material: Material,
    cos_light: Float[Tensor, "*#shape"],
    cos_view: Float[Tensor, "*#shape"],
    light_dot_view: Float[Tensor, "*#shape"],
) -> Float[Tensor, "*shape"]:
    """Radiance that a material sends to the viewer per incident radiance and steradian [1/sr].

    Convention: all directions point away from the surface; the foreshortening n.l is part of the kernel.
    White paper of albedo .8 with the light along its normal: .8 / pi = .2546.

    Raises:
        ValueError: For a mirror, which has no such number: see `mirror_reflectance`.

    >>> import torch
    >>> one = torch.tensor(1.0)
    >>> round(kernel(Material("paper", "diffuse", 0.8), one, one, one).item(), 4)
    0.2546
    """
    if material.is_mirror:
        raise ValueError(f"expected a diffuse or rough material, got {material}")
    if material.kind == "diffuse":
        return diffuse_kernel(cos_light, material.reflectance)
    if material.kind == "ggx":
        return ggx_kernel(cos_light, cos_view, light_dot_view, material.alpha, material.reflectance)
    if material.kind == "metal":
        return metal_kernel(cos_light, cos_view, light_dot_view, material.alpha, material.reflectance)
    return paint_kernel(
        cos_light, cos_view, light_dot_view, material.alpha, material.reflectance, material.ior
    )


def mirror_reflectance(material: Material, cos_view: Float[Tensor, "*shape"]) -> Float[Tensor, "*shape"]:
    """Share of the light that a mirror shows, by the cosine between its normal and the view.

    Convention: constant for `mirror`; for `metal` Schlick's, which is 1 at the rim.

    Raises:
        ValueError: If the material is no mirror.

    >>> import torch
    >>> round(mirror_reflectance(PRINCIPLED[2], torch.tensor(0.0)).item(), 4)
    1.0
    """
    if not material.is_mirror:
        raise ValueError(f"expected a mirror, got {material}")
    if material.kind == "mirror":
        return cos_view.new_full(cos_view.shape, material.reflectance)
    return schlick(cos_view, material.reflectance)
