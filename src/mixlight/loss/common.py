"""What the objectives of all methods share: units, ambient light, the spheres and the camera."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mixlight.light import functions
from mixlight.light.separate import luminance
from mixlight.loss.ambient import coefficient_loss, reconstruction_loss, rendering_loss
from mixlight.loss.spheres import SphereLoss
from mixlight.sphere import equirect

TransportForm = Literal["sinkhorn", "mse"]

_NO_TERMS = ("sphere_offset", "transport_form")
"""Fields of the weights that weigh no term."""

AMBIENT_TERMS = ("coefficients", "reconstruction", "rendering")
"""The three losses on an expansion."""


@dataclass(frozen=True)
class LossWeights:
    """Weight of each term; 0 leaves a term out and costs nothing."""

    distribution: float = 0.5
    """Squared error of P, after the sparse layer."""
    scores: float = 0.5
    """The same before the sparse layer, so that anchors outside its support learn too."""
    transport: float = 1.0
    """Sinkhorn divergence of P (geodesic cost, radians)."""
    masked_l1: float = 0.1
    """|P| where the true P is 0."""
    concentration: float = 0.5
    """How much further P is spread than the true one."""
    intensity: float = 0.05
    """Squared error of log E."""
    colour: float = 0.5
    """Squared error of R."""
    coefficients: float = 0.1
    """SH coefficients, each degree by 1 / (2 l + 1)."""
    reconstruction: float = 0.5
    """SH map."""
    rendering: float = 2.0
    """SH irradiance map."""
    spheres: tuple[float, float, float] = (3.0, 0.5, 0.1)
    """RMSE of the rendered diffuse, matte and mirror spheres."""
    spheres_si: tuple[float, float, float] = (3.0, 0.5, 0.1)
    """The same after the best single scale."""
    camera: float = 2.0
    """Squared error of pitch and roll in radians."""
    sphere_offset: float = 0.05
    """Sphere errors x count as log(1 + x / offset): a scene twice as wrong costs log 2 more, not twice as
    much."""
    transport_form: TransportForm = "sinkhorn"
    """What `transport` weighs: `sinkhorn`, or `mse`, .05 times the mean squared error of P, which is what the
    code that EMLight released computes (a weight of 1000 there)."""

    def __post_init__(self) -> None:
        if not self.sphere_offset > 0:
            raise ValueError(f"expected a sphere_offset above 0, got {self.sphere_offset}")
        if self.transport_form not in get_args(TransportForm):
            raise ValueError(f"expected a transport_form sinkhorn or mse, got {self.transport_form!r}")
        total = 0.0
        for field in fields(self):
            if field.name in _NO_TERMS:
                continue
            value = getattr(self, field.name)
            values = value if isinstance(value, tuple) else (value,)
            if not all(number >= 0 for number in values):
                raise ValueError(f"expected {field.name} of at least 0, got {value}")
            total += sum(values)
        if total == 0:
            raise ValueError("expected at least one weight above 0, got none")


class LightLoss(nn.Module):
    """Weighs predicted light against true light, both divided by one unit for each sample.

    Intensities span decades between scenes and a single bright one must not rule a step: all terms are in
    units of the sample's own brightness (the photo's, or the true light's), and those on intensities are
    logarithmic or bounded by Huber's function. So the loss does not change when photo, prediction and truth
    are all made k times as bright.

    Convention: light in the photo's exposure and our frame, as in a `Batch`. A perfect prediction does not
        cost nothing: what the representation cannot hold of the true map remains in the spheres.
    """

    ambient_maps: Tensor
    """[texels, k]: value of each ambient function at each texel."""

    def __init__(
        self, weights: LossWeights, map_height: int = 32, ambient: functions.Functions = "sh2"
    ) -> None:
        """Build the tables for ambient light in the named functions and maps of `map_height` rows."""
        super().__init__()
        self.weights = weights
        self.ambient = ambient
        self.map_height = map_height
        table = functions.maps(ambient, map_height).flatten(0, 1)
        self.register_buffer("ambient_maps", table, persistent=False)
        spheres = any(weights.spheres) or any(weights.spheres_si)
        self.sphere_loss = SphereLoss(map_height) if spheres else None

    def unit_of(self, true_map: Float[Tensor, "batch height width 3"], unit: Tensor | None) -> Tensor:
        """What radiance is divided by: `unit`, by default the true mean luminance of each sample."""
        if unit is None:
            unit = luminance(equirect.integrate(true_map)) / (4 * torch.pi)
        return unit.clamp(min=1e-6)

    def expansion_terms(
        self,
        predicted: Float[Tensor, "batch k 3"],
        true: Float[Tensor, "batch k 3"],
        name: functions.Functions,
        prefix: str = "",
    ) -> dict[str, Tensor]:
        """The losses on coefficients that have a weight."""
        return {
            prefix + term: huber(expansion_loss(predicted, true, name, term))
            for term in AMBIENT_TERMS
            if getattr(self.weights, term)
        }

    def shared_terms(
        self,
        light_map: Tensor | None,
        camera: Tensor,
        true_map: Tensor,
        true_camera: Tensor,
    ) -> dict[str, Tensor]:
        """Spheres and camera; `light_map` is the predicted small map in the same units as the true one."""
        weights = self.weights
        terms = {}
        if self.sphere_loss is not None and light_map is not None:
            rmse, si_rmse = self.sphere_loss(light_map, true_map)
            terms["spheres"] = (self._robust(rmse) * rmse.new_tensor(weights.spheres)).sum(-1)
            terms["spheres_si"] = (self._robust(si_rmse) * rmse.new_tensor(weights.spheres_si)).sum(-1)
        if weights.camera:
            terms["camera"] = (camera - true_camera).square().sum(-1)
        return terms

    def weigh(self, terms: dict[str, Tensor]) -> tuple[Float[Tensor, ""], dict[str, Tensor]]:
        """The weighted sum, and each term as the mean over the batch (detached)."""
        loss = torch.stack([self.weight_of(name) * value.mean() for name, value in terms.items()]).sum()
        return loss, {name: value.detach().mean() for name, value in terms.items()}

    def weight_of(self, name: str) -> float:
        """Weight of a term by its name; the terms of the sources' expansion have those of the ambient one."""
        if name.startswith("spheres"):
            return 1.0
        return float(getattr(self.weights, name.removeprefix("source_")))

    def picture(self, flat: Float[Tensor, "batch texels 3"]) -> Float[Tensor, "batch height width 3"]:
        """Texels as a panorama."""
        return flat.reshape(-1, self.map_height, 2 * self.map_height, 3)

    def _robust(self, error: Tensor) -> Tensor:
        """Logarithmic from `sphere_offset` on, so that hopeless scenes do not outweigh the others."""
        return torch.log1p(error / self.weights.sphere_offset)


def expansion_loss(
    predicted: Float[Tensor, "*batch k channels"],
    true: Float[Tensor, "*batch k channels"],
    name: functions.Functions,
    term: str,
) -> Float[Tensor, "*batch"]:
    """`coefficient_loss`, `reconstruction_loss` or `rendering_loss` for any set of functions.

    For the smooth Gaussians the two map losses are quadratic forms of their inner products, and squared
    errors of coefficients count 9 / (4 pi), so that light that is wrong by 1 everywhere costs about 4 pi a
    channel, as with harmonics.

    >>> from mixlight.light.functions import project
    >>> one = project(torch.ones(16, 32, 3), "sg9")
    >>> round(expansion_loss(one, 0 * one, "sg9", "reconstruction").item(), 2)  # about 2 / pi
    0.63
    """
    if name != "sg9":
        return _HARMONIC[term](predicted, true)
    error = predicted - true
    if term == "coefficients":
        return error.square().sum((-2, -1)) * functions.SMOOTH_COUNT / (4 * torch.pi)
    matrix = functions.products(name, cosine=term == "rendering").to(error)
    scale = 2 * torch.pi**2 * error.shape[-1]
    return (error * (matrix @ error)).sum((-2, -1)) / scale


def synthesised(
    maps: Float[Tensor, "texels k"], coefficients: Float[Tensor, "batch k 3"]
) -> Float[Tensor, "batch texels 3"]:
    """`maps @ coefficients` as one wide product instead of one for each sample, which takes ten times as
    long.

    >>> synthesised(torch.eye(2), torch.tensor([[[1.0, 2, 3], [4, 5, 6]]]))[0, 1]
    tensor([4., 5., 6.])
    """
    batch, count, channels = coefficients.shape
    wide = maps @ coefficients.transpose(0, 1).reshape(count, batch * channels)
    return wide.view(len(maps), batch, channels).transpose(0, 1)


def huber(squared: Tensor) -> Tensor:
    """Pseudo-Huber: quadratic near 0, linear where a scene is far off."""
    return (squared + 1).sqrt() - 1


_HARMONIC = {
    "coefficients": coefficient_loss,
    "reconstruction": reconstruction_loss,
    "rendering": rendering_loss,
}
