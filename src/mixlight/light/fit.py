"""From a panorama to light parameters: separation, ambient harmonics, energies of the sources' anchors."""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.light import harmonics
from mixlight.light._level_set import Bands
from mixlight.light.gaussians import SHARPNESS
from mixlight.light.lighting import Lighting
from mixlight.light.separate import Method, check_rule, luminance, threshold_of
from mixlight.light.texel_anchors import TexelAnchors
from mixlight.sphere.equirect import check, integrate, solid_angle

ANCHORS = 128
"""Default number of anchors; their nearest neighbours are 15.7 to 17.3 degrees apart."""


class Parameters(NamedTuple):
    """What the network learns: a panorama's light in the paper's five quantities."""

    distribution: Float[Tensor, "*batch anchors"]
    """P: luminance share of each anchor, sums to 1 (1 / anchors each where there is no source at all)."""
    intensity: Float[Tensor, "*batch"]
    """E: length of the sources' total energy T (radiance times steradian), the norm itself, not its
    square."""
    colour: Float[Tensor, "*batch 3"]
    """R: T / E, a unit vector ((1, 1, 1) / sqrt 3 where there is no source)."""
    anchor_energy: Float[Tensor, "*batch anchors 3"]
    """Integrated radiance of each anchor in its own colour; sums to T."""
    ambient: Float[Tensor, "*batch k 3"]
    """Radiance coefficients of what is no source."""

    def lobe_energy(self) -> Float[Tensor, "*batch anchors 3"]:
        """Energy of each lobe under one colour for all, v_i = P_i E R; the sum is T.

        >>> panorama = torch.ones(16, 32, 3)
        >>> panorama[5, 5] = torch.tensor([30.0, 20.0, 10.0])
        >>> p = parameters(panorama, anchors=32)
        >>> bool(torch.allclose(p.lobe_energy(), p.anchor_energy))
        True
        """
        return self.distribution[..., None] * (self.intensity[..., None] * self.colour)[..., None, :]


@torch.no_grad()
def parameters(
    panorama: Float[Tensor, "*batch height width 3"],
    *,
    separation: Method = "top_fraction",
    fraction: float = 0.05,
    degree: int = 2,
    anchors: int = ANCHORS,
) -> Parameters:
    """Separate a panorama and reduce it to (distribution, intensity, colour, anchor_energy, ambient).

    Every source texel's energy goes to the nearest anchor; the rest is projected onto the harmonics. So the
    total is held: ambient[0] sqrt(4 pi) plus the sum of anchor_energy is the panorama's energy, to rounding.
    The selection is discrete, so no gradient flows. Three passes over the panorama in bands of rows, with no
    temporary of its size.

    Args:
        panorama: radiance, 2:1, finite, >= 0.
        separation: the rule of `mixlight.light.separate`.
        fraction: of the sphere (``top_fraction``) or of the largest luminance (``max_fraction``).
        degree: of the ambient harmonics, 0 to 6.
        anchors: number of anchors on the golden-angle spiral.

    Convention: T is the sources' energy in rgb, E = |T|, R = T / E; a source of radiance (3, 4, 0) over 0.1
        sr has E = .5 and R = (.6, .8, 0).

    Raises:
        ValueError: no such panorama, or a parameter out of its range.

    Source: MixLight's parametrisation, with P, E and R as EMLight means them (norm, not its square).

    >>> panorama = torch.full((16, 32, 3), 0.25)
    >>> panorama[5, 5] = torch.tensor([3.0, 4.0, 0.0]) * 10
    >>> parameters(panorama, anchors=32).colour
    tensor([0.6000, 0.8000, 0.0000])
    """
    harmonics.count(degree)
    check(panorama)
    check_rule(separation, fraction)
    height, width = panorama.shape[-3:-1]
    batch = panorama.shape[:-3]
    dtype = torch.promote_types(panorama.dtype, torch.float32)
    split = []
    for one in panorama.reshape(-1, height, width, 3):
        passes = Bands(one)
        split.append(_split(passes, threshold_of(passes, separation, fraction), degree, anchors))
    energy = torch.stack([one for one, _ in split]).reshape(*batch, anchors, 3)
    ambient = torch.stack([one for _, one in split]).reshape(*batch, -1, 3)
    total = energy.sum(-2)
    intensity = torch.linalg.vector_norm(total, dim=-1)
    dark = intensity == 0
    colour = torch.where(
        dark[..., None], 1 / math.sqrt(3), total / torch.where(dark, 1, intensity)[..., None]
    )
    share = luminance(energy)
    whole = share.sum(-1, keepdim=True)
    distribution = torch.where(whole == 0, 1 / anchors, share / torch.where(whole == 0, 1, whole))
    return Parameters(
        distribution.to(dtype), intensity.to(dtype), colour.to(dtype), energy.to(dtype), ambient.to(dtype)
    )


def fit(
    panorama: Float[Tensor, "*batch height width 3"],
    *,
    separation: Method = "top_fraction",
    fraction: float = 0.05,
    degree: int = 2,
    anchors: int = ANCHORS,
    sharpness: float = SHARPNESS,
    per_anchor_colour: bool = True,
    prune: float = 1e-4,
) -> Lighting:
    """Fit ambient harmonics and spherical Gaussians to a panorama, keeping its energy.

    Args:
        panorama: radiance, 2:1, finite, >= 0; a leading batch gives a batched `Lighting`.
        separation: ``top_fraction`` or ``max_fraction``: see `mixlight.light.separate`.
        fraction: of the sphere, or of the largest luminance.
        degree: of the ambient harmonics, 0 to 6.
        anchors: number of anchors on the golden-angle spiral.
        sharpness: of the lobes.
        per_anchor_colour: each lobe in its own colour; else all in the sources' common one, P_i E R.
        prune: lobes below this share of the sources' luminance are handed to the ambient light
            (`Lighting.pruned`); 0 keeps them all.

    Convention: the lighting is in the panorama's own units and frame, with an exposure gain of 1.

    Raises:
        ValueError: no such panorama, or a parameter out of its range.

    >>> panorama = torch.ones(32, 64, 3)
    >>> panorama[10, 20] = 500.0
    >>> lighting = fit(panorama)
    >>> lighting.active.tolist(), bool(torch.allclose(lighting.total_energy(), integrate(panorama)))
    ([31], True)
    """
    found = parameters(panorama, separation=separation, fraction=fraction, degree=degree, anchors=anchors)
    energy = found.anchor_energy if per_anchor_colour else found.lobe_energy()
    lighting = Lighting(found.ambient, energy, sharpness=sharpness)
    return lighting.pruned(prune) if prune else lighting


@torch.no_grad()
def energy_report(
    panorama: Float[Tensor, "height width 3"], lighting: Lighting, height: int = 128
) -> dict[str, float | list[float]]:
    """Energy of a panorama beside that of its fitted lighting, and what clamping does to the map, ready for
    JSON.

    ``error`` compares luminance energy, (out - in) / in, before any clamping. A map cannot hold the ambient
    expansion's negative lobes: they are clamped at 0, which adds energy. ``map`` is the clamped map's energy,
    ``clamping`` the luminance energy added as a share of ``in``, ``clamped_sphere`` the share of the sphere
    where at least one channel was negative.

    Raises:
        ValueError: a batched or empty (all-black) panorama.

    >>> panorama = torch.full((32, 64, 3), 0.5)
    >>> report = energy_report(panorama, fit(panorama))
    >>> round(report["in"][0], 4), abs(round(report["error"], 5)), report["clamped_sphere"]
    (6.2832, 0.0, 0.0)
    """
    before = integrate(panorama).double()
    if not float(before.sum()) > 0:
        raise ValueError("panorama: expected some light, received one that is black all over")
    after = lighting.total_energy().double()
    signed = lighting.ambient_map(height, clamp=False)
    negative = signed.clamp(max=0).abs()
    weight = solid_angle(height, dtype=torch.float64, device=signed.device)
    added = (negative.double() * weight[..., None]).sum((0, 1))
    total = float(luminance(before))
    return {
        "in": before.tolist(),
        "out": after.tolist(),
        "error": float(luminance(after)) / total - 1,
        "sources": lighting.energy.double().sum(-2).tolist(),
        "ambient": (after - lighting.energy.double().sum(-2)).tolist(),
        "map": (after + added).tolist(),
        "clamping": float(luminance(added)) / total,
        "clamped_sphere": float(((negative > 0).any(-1) * weight).sum() / (4 * math.pi)),
    }


def _split(bands: Bands, limit: float, degree: int, anchors: int) -> tuple[Tensor, Tensor]:
    """Anchor energies [anchors, 3] and ambient coefficients [k, 3] of one panorama, in float64."""
    height, width, device = bands.height, bands.width, bands.panorama.device
    anchor_of = TexelAnchors(anchors, height, width, device)
    energy = torch.zeros(anchors, 3, dtype=torch.float64, device=device)
    sums = []
    for start, rows, level in bands:
        place = (level >= limit).reshape(-1).nonzero()[:, 0]
        ambient = rows
        if len(place):
            texels = rows.reshape(-1, 3)
            value = texels[place].double() * bands.solid_angle[start + place // width, None]
            energy.index_add_(0, anchor_of(place + start * width), value)
            ambient = texels.index_fill(0, place, 0).reshape(rows.shape)
        sums.append(harmonics.row_sums(ambient, degree))
    return energy, harmonics.project_rows(torch.cat(sums, -3).double(), degree)
