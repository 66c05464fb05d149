"""The objective for sources that are an expansion in harmonics: what the method's has, where it applies."""

from __future__ import annotations

from jaxtyping import Float
from torch import Tensor
from torch.nn import functional

from mixlight.light import functions
from mixlight.loss.common import LightLoss, LossWeights, synthesised
from mixlight.loss.sources import colour_loss


class ExpandedLoss(LightLoss):
    """Sources and ambient light as coefficients, weighed as `LightLoss` says.

    Terms on anchors (P, transport, masked L1, concentration) have no counterpart. The sources' coefficients
    have the three losses that ambient coefficients have, under the same weights; intensity and colour are
    those of their constant term.
    """

    source_maps: Tensor
    """[texels, k]: value of each source function at each texel."""

    def __init__(
        self,
        weights: LossWeights,
        map_height: int = 32,
        ambient: functions.Functions = "sh2",
        sources: functions.Functions = "sh6",
    ) -> None:
        """Build the tables for the named functions."""
        super().__init__(weights, map_height, ambient)
        self.sources = sources
        table = functions.maps(sources, map_height).flatten(0, 1)
        self.register_buffer("source_maps", table, persistent=False)

    def forward(
        self,
        sources: Float[Tensor, "batch functions 3"],
        ambient: Float[Tensor, "batch k 3"],
        camera: Float[Tensor, "batch 2"],
        true_sources: Float[Tensor, "batch functions 3"],
        true_ambient: Float[Tensor, "batch k 3"],
        true_map: Float[Tensor, "batch height width 3"],
        true_camera: Float[Tensor, "batch 2"],
        unit: Float[Tensor, " batch"] | None = None,
    ) -> tuple[Float[Tensor, ""], dict[str, Tensor]]:
        """The weighted sum, and each term as the mean over the batch (detached), as `TotalLoss`."""
        scale = self.unit_of(true_map, unit)[:, None, None]
        sources, ambient = sources / scale, ambient / scale
        true_sources, true_ambient = true_sources / scale, true_ambient / scale
        terms: dict[str, Tensor] = {}
        level, true_level = sources[:, 0], true_sources[:, 0].clamp(min=1e-6)
        if self.weights.intensity:
            terms["intensity"] = functional.smooth_l1_loss(
                level.norm(dim=-1).log(), true_level.norm(dim=-1).log(), reduction="none"
            )
        if self.weights.colour:
            terms["colour"] = colour_loss(
                functional.normalize(level, dim=-1), functional.normalize(true_level, dim=-1)
            )
        terms |= self.expansion_terms(sources, true_sources, self.sources, "source_")
        terms |= self.expansion_terms(ambient, true_ambient, self.ambient)
        light_map = None
        if self.sphere_loss is not None:
            # The sum is clamped, not each: harmonics of sharp lamps ring below 0.
            flat = synthesised(self.source_maps, sources) + synthesised(self.ambient_maps, ambient)
            light_map = self.picture(flat.clamp(min=0))
        terms |= self.shared_terms(light_map, camera, true_map / scale[..., None], true_camera)
        return self.weigh(terms)
