"""The training objective: every term of the method on one robust scale."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from mixlight.light import gaussians, harmonics
from mixlight.light.separate import luminance
from mixlight.loss import ambient as ambient_losses
from mixlight.loss import sources as source_losses
from mixlight.loss.spheres import SphereLoss
from mixlight.loss.transport import SphericalSinkhorn
from mixlight.sphere import equirect, points


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

    def __post_init__(self) -> None:
        if not self.sphere_offset > 0:
            raise ValueError(f"expected a sphere_offset above 0, got {self.sphere_offset}")
        total = 0.0
        for field in fields(self):
            value = getattr(self, field.name)
            values = value if isinstance(value, tuple) else (value,)
            if not all(number >= 0 for number in values):
                raise ValueError(f"expected {field.name} of at least 0, got {value}")
            total += 0.0 if field.name == "sphere_offset" else sum(values)
        if total == 0:
            raise ValueError("expected at least one weight above 0, got none")


class TotalLoss(nn.Module):
    """Weighs predicted light against true light, both divided by one unit for each sample.

    Intensities span decades between scenes and a single bright one must not rule a step: all terms are in
    units of the sample's own brightness (the photo's, or the true light's), and those on intensities are
    logarithmic or bounded by Huber's function. So the loss does not change when photo, prediction and truth
    are all made k times as bright.

    Convention: light in the photo's exposure and our frame, as in a `Batch`. A perfect prediction does not
        cost nothing: what the representation cannot hold of the true map remains in the spheres.
    """

    harmonic_maps: Tensor
    """[texels, 9]: each harmonic's value at each texel."""
    lobe_maps: Tensor
    """[texels, anchors]: the map of each lobe of energy 1."""

    def __init__(self, weights: LossWeights, anchors: int, sharpness: float, map_height: int = 32) -> None:
        """Build the tables.

        Args:
            weights: weight of each term.
            anchors: number of source directions.
            sharpness: angular size s of the lobes.
            map_height: rows of the small maps on which spheres are rendered.
        """
        super().__init__()
        self.weights = weights
        axes = points.vogel(anchors)
        directions = equirect.pixel_directions(map_height)
        lobes = gaussians.lobe_maps(axes, sharpness, map_height)
        self.register_buffer("harmonic_maps", harmonics.basis(directions, 2).flatten(0, 1), persistent=False)
        self.register_buffer("lobe_maps", lobes.flatten(1).T.contiguous(), persistent=False)
        self.map_height = map_height
        self.sinkhorn = SphericalSinkhorn(axes)
        spheres = any(weights.spheres) or any(weights.spheres_si)
        self.sphere_loss = SphereLoss(map_height) if spheres else None

    def environment(
        self, ambient: Float[Tensor, "batch 9 3"], anchor_energy: Float[Tensor, "batch anchors 3"]
    ) -> Float[Tensor, "batch height width 3"]:
        """The small map of a light: ambient part clamped at 0, plus the lobes; height is `map_height`."""
        flat = (self.harmonic_maps @ ambient).clamp(min=0) + self.lobe_maps @ anchor_energy
        return flat.view(-1, self.map_height, 2 * self.map_height, 3)

    def forward(
        self,
        scores: Float[Tensor, "batch anchors"],
        distribution: Float[Tensor, "batch anchors"],
        intensity: Float[Tensor, " batch"],
        colour: Float[Tensor, "batch 3"],
        ambient: Float[Tensor, "batch 9 3"],
        camera: Float[Tensor, "batch 2"],
        true_energy: Float[Tensor, "batch anchors 3"],
        true_ambient: Float[Tensor, "batch 9 3"],
        true_map: Float[Tensor, "batch height width 3"],
        true_camera: Float[Tensor, "batch 2"],
        unit: Float[Tensor, " batch"] | None = None,
    ) -> tuple[Float[Tensor, ""], dict[str, Tensor]]:
        """The weighted sum, and each term as the mean over the batch (detached).

        Terms are unweighted, but for `spheres` and `spheres_si`, which are sums over the three spheres by
        their weights. What the arguments are: `mixlight.network.heads.Prediction` and
        `mixlight.data.training_set.Batch`. Radiance errors are in units of `unit`, by default the true mean
        luminance of each sample.

        Raises:
            ValueError: the true map has another size than the loss was built for.
        """
        weights = self.weights
        if unit is None:
            unit = luminance(equirect.integrate(true_map)) / (4 * torch.pi)
        scale = unit.clamp(min=1e-6)
        intensity = intensity / scale
        ambient = ambient / scale[:, None, None]
        true_ambient = true_ambient / scale[:, None, None]
        true_energy = true_energy / scale[:, None, None]
        total = true_energy.sum(1)
        true_intensity = total.norm(dim=-1).clamp(min=1e-6)
        true_colour = total / true_intensity[:, None]
        share = luminance(true_energy)
        true_distribution = share / share.sum(-1, keepdim=True).clamp(min=1e-9)

        terms: dict[str, Tensor] = {}
        if weights.distribution:
            terms["distribution"] = source_losses.distribution_loss(distribution, true_distribution)
        if weights.scores:
            terms["scores"] = source_losses.distribution_loss(scores, true_distribution)
        if weights.transport:
            terms["transport"] = self.sinkhorn(distribution, true_distribution)
        if weights.masked_l1:
            terms["masked_l1"] = source_losses.masked_l1(distribution, true_distribution)
        if weights.concentration:
            terms["concentration"] = source_losses.concentration_loss(distribution, true_distribution)
        if weights.intensity:
            terms["intensity"] = functional.smooth_l1_loss(
                intensity.log(), true_intensity.log(), reduction="none"
            )
        if weights.colour:
            terms["colour"] = source_losses.colour_loss(colour, true_colour)
        for name in ("coefficients", "reconstruction", "rendering"):
            if getattr(weights, name):
                terms[name] = _root(_AMBIENT[name](ambient, true_ambient))
        if self.sphere_loss is not None:
            energy = distribution[..., None] * (intensity[:, None] * colour)[:, None, :]
            rmse, si_rmse = self.sphere_loss(
                self.environment(ambient, energy), true_map / scale[:, None, None, None]
            )
            terms["spheres"] = (self._robust(rmse) * rmse.new_tensor(weights.spheres)).sum(-1)
            terms["spheres_si"] = (self._robust(si_rmse) * rmse.new_tensor(weights.spheres_si)).sum(-1)
        if weights.camera:
            terms["camera"] = (camera - true_camera).square().sum(-1)
        loss = torch.stack([_weight(weights, name) * value.mean() for name, value in terms.items()]).sum()
        return loss, {name: value.detach().mean() for name, value in terms.items()}

    def _robust(self, error: Tensor) -> Tensor:
        """Logarithmic from `sphere_offset` on, so that hopeless scenes do not outweigh the others."""
        return torch.log1p(error / self.weights.sphere_offset)


_AMBIENT = {
    "coefficients": ambient_losses.coefficient_loss,
    "reconstruction": ambient_losses.reconstruction_loss,
    "rendering": ambient_losses.rendering_loss,
}


def _root(squared: Tensor) -> Tensor:
    """Pseudo-Huber: quadratic near 0, linear where a scene is far off."""
    return (squared + 1).sqrt() - 1


def _weight(weights: LossWeights, name: str) -> float:
    return 1.0 if name.startswith("spheres") else float(getattr(weights, name))
