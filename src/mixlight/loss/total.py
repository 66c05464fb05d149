"""The method's objective: every term on one robust scale."""

from __future__ import annotations

from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from mixlight.light import functions, gaussians
from mixlight.light.separate import luminance
from mixlight.loss import sources as source_losses
from mixlight.loss.common import LightLoss, LossWeights, synthesised
from mixlight.loss.transport import SphericalSinkhorn
from mixlight.sphere import points

__all__ = ["LossWeights", "TotalLoss"]

_RELEASED = 0.05
"""Times the mean squared error of P: what EMLight's released transport loss comes to."""


class TotalLoss(LightLoss):
    """Sources on anchors and ambient light, weighed as `LightLoss` says."""

    lobe_maps: Tensor
    """[texels, anchors]: the map of each lobe of energy 1."""

    def __init__(
        self,
        weights: LossWeights,
        anchors: int,
        sharpness: float,
        map_height: int = 32,
        ambient: functions.Functions = "sh2",
    ) -> None:
        """Build the tables.

        Args:
            weights: weight of each term.
            anchors: number of source directions.
            sharpness: angular size s of the lobes.
            map_height: rows of the small maps on which spheres are rendered.
            ambient: the functions of the ambient light.
        """
        super().__init__(weights, map_height, ambient)
        axes = points.vogel(anchors)
        lobes = gaussians.lobe_maps(axes, sharpness, map_height)
        self.register_buffer("lobe_maps", lobes.flatten(1).T.contiguous(), persistent=False)
        self.sinkhorn = SphericalSinkhorn(axes)

    def environment(
        self, ambient: Float[Tensor, "batch k 3"], anchor_energy: Float[Tensor, "batch anchors 3"]
    ) -> Float[Tensor, "batch height width 3"]:
        """The small map of a light: ambient part clamped at 0, plus the lobes; height is `map_height`."""
        even = synthesised(self.ambient_maps, ambient).clamp(min=0)
        return self.picture(even + synthesised(self.lobe_maps, anchor_energy))

    def forward(
        self,
        scores: Float[Tensor, "batch anchors"],
        distribution: Float[Tensor, "batch anchors"],
        intensity: Float[Tensor, " batch"],
        colour: Float[Tensor, "batch *lobes 3"],
        ambient: Float[Tensor, "batch k 3"],
        camera: Float[Tensor, "batch 2"],
        true_energy: Float[Tensor, "batch anchors 3"],
        true_ambient: Float[Tensor, "batch k 3"],
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
        scale = self.unit_of(true_map, unit)
        intensity = intensity / scale
        ambient = ambient / scale[:, None, None]
        true_ambient = true_ambient / scale[:, None, None]
        true_energy = true_energy / scale[:, None, None]
        total = true_energy.sum(1)
        true_intensity = total.norm(dim=-1).clamp(min=1e-6)
        share = luminance(true_energy)
        true_distribution = share / share.sum(-1, keepdim=True).clamp(min=1e-9)

        terms: dict[str, Tensor] = {}
        if weights.distribution:
            terms["distribution"] = source_losses.distribution_loss(distribution, true_distribution)
        if weights.scores:
            terms["scores"] = source_losses.distribution_loss(scores, true_distribution)
        if weights.transport and weights.transport_form == "sinkhorn":
            terms["transport"] = self.sinkhorn(distribution, true_distribution)
        elif weights.transport:
            terms["transport"] = _RELEASED * (distribution - true_distribution).square().mean(-1)
        if weights.masked_l1:
            terms["masked_l1"] = source_losses.masked_l1(distribution, true_distribution)
        if weights.concentration:
            terms["concentration"] = source_losses.concentration_loss(distribution, true_distribution)
        if weights.intensity:
            terms["intensity"] = functional.smooth_l1_loss(
                intensity.log(), true_intensity.log(), reduction="none"
            )
        one_colour = colour.ndim == 2
        if weights.colour and one_colour:
            terms["colour"] = source_losses.colour_loss(colour, total / true_intensity[:, None])
        elif weights.colour:
            own = functional.normalize(true_energy, dim=-1)
            terms["colour"] = (source_losses.colour_loss(colour, own) * true_distribution).sum(-1)
        terms |= self.expansion_terms(ambient, true_ambient, self.ambient)
        light_map = None
        if self.sphere_loss is not None:
            if one_colour:
                energy = distribution[..., None] * (intensity[:, None] * colour)[:, None, :]
            else:
                energy = (distribution * intensity[:, None])[..., None] * colour
            light_map = self.environment(ambient, energy)
        terms |= self.shared_terms(light_map, camera, true_map / scale[:, None, None, None], true_camera)
        return self.weigh(terms)
