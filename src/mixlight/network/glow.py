"""From an expected distribution to few sources: what cannot be localised glows."""

from __future__ import annotations

from dataclasses import replace

from torch import Tensor, nn

from mixlight.light import gaussians, harmonics
from mixlight.network.heads import Prediction
from mixlight.network.sparsemax import Mode, SLSparsemax
from mixlight.sphere import points


class Glow(nn.Module):
    """Leaves as sources the anchors that the network is sure of; the light of the others joins the ambient.

    A network that is trained on errors predicts the *expected* light. Where a lamp may hang in many places it
    spreads a little source light over all of them, and a sparse layer on top has a choice of two evils: keep
    a hundred faint sources, or put all of the energy into the few likeliest places, where it is mostly wrong.
    Here the sparse layer, at scores times `gain`, only chooses. A chosen anchor keeps its own energy, and the
    harmonics of the lobes of all others are added to the ambient coefficients. So the light's integral stays
    the same to the last bit of rounding, and what it does to matte surfaces nearly so.

    Convention: with scores .5, .3, .2 on three anchors far apart and a gain at which the sparse layer keeps
        the first, that one has half of the sources' energy before and after.
    """

    harmonics: Tensor
    """[anchors, 9]: the radiance coefficients of each lobe of energy 1."""

    def __init__(self, anchors: int, sharpness: float, gain: float, mode: Mode = "masked") -> None:
        """Build the tables.

        Args:
            anchors: number of source directions.
            sharpness: angular size s of the lobes.
            gain: factor on the scores before the sparse layer that chooses, above 0; the larger, the fewer
                sources.
            mode: of that layer.

        Raises:
            ValueError: unknown mode, too few anchors to have neighbours, or a gain that is not above 0.
        """
        super().__init__()
        if not gain > 0:
            raise ValueError(f"expected a gain above 0, got {gain}")
        self.gain = gain
        self.sparse = SLSparsemax(count=anchors, mode=mode)
        axes = points.vogel(anchors)
        factors = gaussians.band_factors(sharpness, 2)[harmonics.degrees(2)].to(axes)
        self.register_buffer("harmonics", harmonics.basis(axes, 2) * factors, persistent=False)

    def forward(self, prediction: Prediction) -> Prediction:
        """The same light with fewer sources; what is left of the distribution is scaled to sum to 1 again.

        >>> import torch
        >>> scores = torch.zeros(1, 128)
        >>> scores[0, [0, 60, 127]] = torch.tensor([0.5, 0.3, 0.2])
        >>> white = torch.full((1, 3), 3**-0.5)
        >>> light = Prediction(scores, scores, torch.ones(1), white, torch.zeros(1, 9, 3), torch.zeros(1, 2))
        >>> sure = Glow(128, 0.0025, gain=10.0)(light)
        >>> sure.distribution[0, [0, 60, 127]], sure.intensity
        (tensor([1., 0., 0.]), tensor([0.5000]))
        """
        chosen = self.sparse(self.gain * prediction.scores) > 0
        energy = prediction.anchor_energy
        rest = energy * ~chosen[..., None]
        ambient = prediction.ambient + self.harmonics.to(rest).T @ rest
        kept = prediction.distribution * chosen
        share = kept.sum(-1)
        return replace(
            prediction,
            distribution=kept / share.clamp(min=1e-12)[:, None],
            intensity=prediction.intensity * share,
            ambient=ambient,
        )
