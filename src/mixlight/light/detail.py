"""The photo's own pixels in the map: what the camera saw as it saw it, the predicted light elsewhere.

A lighting is smooth but for its lobes, so a mirror shows fog. Where the photo looks, its pixels are the true
radiance (both are in the photo's exposure), up to white; behind white there is light that only the prediction
knows of. `Detail` puts the two together and keeps the energy of both parts:

- **Ambient part.** ``B = P + (1 - w) g A`` with the photo P (times its weight w), the predicted ambient light
  A >= 0, and a gain g for each channel that makes the integral of B that of A. Where the photo clips and A is
  brighter than white, A stays.
- **Sources.** Each lobe keeps its energy, but part of it moves to where the photo clips: the share
  ``m = k / (k + GATHER_AREA)``, where k is the clipped solid angle seen through ``exp((d.u - 1) / GATHER)``
  from the lobe's axis u, spread in proportion to just that. What is left of the lobe inside the picture where
  the photo does not clip cannot be there, and goes to the nearest places outside the picture.

Both parts are computed apart and the sources' part is linear in the lobes' energies. So the map without some
lobes, to go beside lights made of them, is `Detail.environment` of `Lighting.without` those lobes: nothing is
counted twice.
"""

import math
from dataclasses import dataclass
from functools import partial

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.image.ldr import WHITE
from mixlight.light import gaussians
from mixlight.light.lighting import Lighting
from mixlight.sphere import equirect
from mixlight.sphere.backprojection import lay_on_sphere

__all__ = ["FEATHER", "GATHER", "GATHER_AREA", "Detail"]

FEATHER = 0.1
"""Width of the photo's soft edge, as a share of its shorter half-side."""

GATHER = 0.1
"""How far a lobe's light moves to clipped pixels, as a lobe's sharpness: by half at 21 degrees. Chosen on
validation panoramas with `GATHER_AREA` (experiments/detail.py)."""

GATHER_AREA = 0.01
"""Clipped solid angle, right at a lobe's axis, that draws half of its energy (steradian; a disc of 6.5
degrees)."""

_ASIDE = 0.02
"""How far light that cannot be inside the picture moves out of it: to the rim and little further."""

_DIMMEST = 0.25
"""The ambient light outside the picture is dimmed to no less than this; before, the photo fades."""


@dataclass(frozen=True, eq=False)
class Detail:
    """What one photo shows, laid on the sphere.

    Convention: our frame, level, with the photo's azimuth at -Z; radiance 1.0 is the photo's linear white.
    """

    radiance: Float[Tensor, "height width 3"]
    """The photo, cut at white, times `weight`."""
    weight: Float[Tensor, "height width"]
    """1 inside the photo, falling to 0 at its edge, 0 where it does not look."""
    clipped: Float[Tensor, "height width"]
    """`weight` times the share of clipped pixels (a channel at white)."""
    gather: float = GATHER
    """How far lobes reach for clipped pixels."""
    gather_area: float = GATHER_AREA
    """Clipped solid angle that draws half of a lobe; infinite: lobes keep their light."""

    @classmethod
    def of_photo(
        cls,
        photo: Float[Tensor, "photo_height photo_width 3"],
        fov_x: float,
        height: int = 128,
        *,
        pitch: float = 0.0,
        roll: float = 0.0,
        feather: float = FEATHER,
    ) -> "Detail":
        """Lay a photo on the sphere.

        Args:
            photo: linear light; 1.0 is white, and what is above counts as white, as it does for the network.
            fov_x: horizontal field of view in radians.
            height: rows of the maps to be made.
            pitch: elevation of the camera in radians; negative looks down.
            roll: its clockwise turn in radians.
            feather: width of the soft edge, a share of the photo's shorter half-side, 0 to 1.

        Raises:
            ValueError: a photo with NaN, infinite or negative values, a field of view outside (0, pi), height
                below 1, feather outside [0, 1].

        >>> detail = Detail.of_photo(torch.full((60, 80, 3), 0.5), math.radians(60), 64)
        >>> detail.radiance[32, 64], round(float(equirect.integrate(detail.weight[..., None])), 2)
        (tensor([0.5000, 0.5000, 0.5000]), 0.74)
        """
        low, high = (float(bound) for bound in photo.aminmax())  # NaN goes through both
        if not (low >= 0 and high < math.inf):
            raise ValueError(
                f"photo: expected finite values of at least 0, received values from {low:g} to {high:g}"
            )
        at_white = (photo >= WHITE).any(-1, keepdim=True).to(photo)
        lay = partial(lay_on_sphere, fov_x=fov_x, height=height, pitch=pitch, roll=roll, feather=feather)
        radiance, weight = lay(photo.clamp(max=1))
        clipped, _ = lay(at_white)
        return cls(radiance, weight, torch.minimum(clipped[..., 0], weight))

    @property
    def share(self) -> float:
        """Part of the sphere that the photo covers, soft edges by their weight.

        >>> round(Detail.of_photo(torch.ones(60, 80, 3), math.radians(60), 64).share, 3)
        0.059
        """
        return float(equirect.integrate(self.weight[..., None].double())) / (4 * math.pi)

    def environment(self, lighting: Lighting) -> Float[Tensor, "height width 3"]:
        """The map of a lighting with the photo in it.

        Its energy is that of ``lighting.environment(height)``: the ambient part's and each lobe's are kept
        one by one, in each channel.

        Convention: `Lighting.without` some lobes gives the map without just their light.

        Raises:
            ValueError: a batch of lightings.

        >>> detail = Detail.of_photo(torch.full((60, 80, 3), 0.5), math.radians(60), 64)
        >>> ambient = torch.zeros(9, 3)
        >>> ambient[0] = 1.0
        >>> lighting = Lighting(ambient, torch.eye(128)[:, :3])
        >>> equirect.integrate(detail.environment(lighting)), equirect.integrate(lighting.environment(64))
        (tensor([4.5449, 4.5449, 4.5449]), tensor([4.5449, 4.5449, 4.5449]))
        """
        return self.ambient_map(lighting) + self.sources_map(lighting)

    def opacity(self, lighting: Lighting) -> float:
        """How much of the photo goes into the lighting's map: 1, or less where the photo is so much brighter
        than the predicted ambient light that the rest would have to be dimmed below a quarter of it.

        >>> bright = Detail.of_photo(torch.ones(60, 80, 3), math.radians(60), 64)
        >>> ambient = torch.zeros(9, 3)
        >>> ambient[0] = 0.1
        >>> round(bright.opacity(Lighting(ambient, torch.zeros(128, 3))), 2)
        0.36
        """
        return _opacity(*self._parts(lighting)[2:])

    def ambient_map(self, lighting: Lighting) -> Float[Tensor, "height width 3"]:
        """The ambient light with the photo in it, B of this module's text."""
        ambient, photo, visible, covered, total = self._parts(lighting)
        opacity = _opacity(visible, covered, total)
        hidden = total - opacity * covered
        gain = (total - opacity * visible) / torch.where(hidden > 0, hidden, 1)
        rest = (1 - opacity * self.weight)[..., None] * ambient
        return opacity * photo + rest * gain.to(rest)

    def sources_map(self, lighting: Lighting) -> Float[Tensor, "height width 3"]:
        """The lobes with their light where the photo allows it; linear in their energies, each of which is
        kept.
        """
        if lighting.ambient.ndim != 2:
            raise ValueError(
                f"lighting: expected a single one, received a batch of {list(lighting.ambient.shape[:-2])}"
            )
        height = len(self.weight)
        total = lighting.energy.new_zeros(height, 2 * height, 3)
        bright = self.clipped.reshape(-1).nonzero()[:, 0]
        solid_angle = equirect.solid_angle(height, dtype=total.dtype, device=total.device)
        directions = equirect.pixel_directions(height, dtype=total.dtype, device=total.device).view(-1, 3)
        lit = (lighting.energy != 0).any(-1).nonzero()[:, 0].tolist()
        for index in lit:
            axis, energy = lighting.axes[index], lighting.energy[index]
            lobe = self._lobe(axis, lighting.sharpness, directions, solid_angle)
            drawn = self.clipped.view(-1)[bright] * _falloff(directions[bright], axis, self.gather)
            drawn = drawn * solid_angle.view(-1)[bright]
            area = float(drawn.sum())
            if area <= 0:
                total += lobe[..., None] * energy
                continue
            share = area / (area + self.gather_area)
            total += lobe[..., None] * (energy * (1 - share))
            radiance = drawn / solid_angle.view(-1)[bright] * (share / area)
            total.view(-1, 3)[bright] += radiance[:, None] * energy
        return total

    def _lobe(self, axis: Tensor, sharpness: float, directions: Tensor, solid_angle: Tensor) -> Tensor:
        """[height, width]: a lobe of energy 1, moved out of the picture where the photo does not clip."""
        height = len(self.weight)
        lobe = gaussians.evaluate_map(axis[None], axis.new_ones(1, 1), sharpness, height)[..., 0]
        denied = lobe * (self.weight - self.clipped)
        energy = float((denied * solid_angle).double().sum())
        if energy < 1e-6:
            return lobe
        outside = (1 - self.weight).view(-1)
        # Relative to the nearest place outside, so that a picture of almost the whole sphere underflows not.
        exponent = (directions @ axis - 1) / _ASIDE
        nearest = exponent[outside > 0.5].amax()
        aside = (outside * (exponent - nearest).clamp(max=50).exp()).view_as(lobe)
        return lobe - denied + aside * (energy / float((aside * solid_angle).double().sum()))

    def _parts(self, lighting: Lighting) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
        """The ambient light, the photo's part of the map, and the energies of the latter, of the ambient
        light that it covers, and of all ambient light, [3] in float64.
        """
        ambient = lighting.ambient_map(len(self.weight))
        photo = self.radiance + self.clipped[..., None] * (ambient - 1).clamp_min(0)
        visible, covered, total = (
            equirect.integrate(part.double()) for part in (photo, ambient * self.weight[..., None], ambient)
        )
        return ambient, photo, visible, covered, total


def _opacity(visible: Tensor, covered: Tensor, total: Tensor) -> float:
    """The largest opacity o <= 1 that leaves total - o visible >= _DIMMEST (total - o covered)."""
    room, need = total * (1 - _DIMMEST), visible - _DIMMEST * covered
    limit = torch.where(need > 0, room / torch.where(need > 0, need, 1), math.inf)
    return min(1.0, float(limit.min()))


def _falloff(directions: Tensor, axis: Tensor, width: float) -> Tensor:
    return ((directions @ axis - 1) / width).exp()
