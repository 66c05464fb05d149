"""The error that counts: how wrong the three test spheres look under the predicted light."""

from __future__ import annotations

from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mixlight.light.compare import rmse_and_si_rmse
from mixlight.light.transport import MATERIALS, sphere_matrix

_LOST_SHARE = 0.01
"""Directions of picture space are dropped while no texel loses more than this share of the mean
texel's effect. Errors are orthogonal, so an RMSE changes by less than 1e-4 of itself."""


class SphereLoss(nn.Module):
    """RMSE and si-RMSE of small diffuse, matte and mirror spheres under predicted and true light.

    RMSE and si-RMSE are made of inner products of pictures, which an orthonormal change of basis
    keeps: with T = U S V^T the transport matrix of a sphere, |T x| = |U_r^T T x| up to the directions
    that light hardly reaches. So the loss multiplies with U_r^T T (about 100, 350 and all 812 rows of
    the diffuse, matte and mirror sphere) instead of with T, at half the cost; see `encode`.

    Under autocast it computes in float32 all the same: HDR light does not fit into bfloat16.

    Convention: frame, camera and materials of `mixlight.light.transport`; order of the spheres:
    diffuse, matte, mirror. Truth 1 everywhere against prediction .9 everywhere: the diffuse sphere
    shows .8 against .72, RMSE .08 and si-RMSE 0.
    """

    factor: Tensor
    """[rank, texels]: the three spheres' matrices in the reduced basis, stacked."""

    def __init__(self, height: int = 32, resolution: int = 32) -> None:
        """Build (or take from this process's cache) the matrices: a second or two.

        Args:
            height: Rows of the environment maps; their width is twice that.
            resolution: Width and height of each sphere's picture.
        """
        super().__init__()
        factors, self.pixels = _factors(height, resolution)
        self.height = height
        self.ranks = [len(factor) for factor in factors]
        self.register_buffer("factor", torch.cat(factors), persistent=False)

    def encode(
        self, environment: Float[Tensor, "*batch height width channels"]
    ) -> Float[Tensor, "*batch rank channels"]:
        """The spheres' pictures as coordinates in the reduced basis, all three behind one another.

        Linear, and cheap to precompute: the coordinates of a truth never change, and those of a light
        that is a sum of fixed maps are that sum of the maps' coordinates:

            basis = loss.encode(maps)          # maps [height, width, K]: one channel a parameter
            coordinates = basis @ parameters   # parameters [*batch, K, 3]

        Raises:
            ValueError: If the map has not the size the loss was built for.
        """
        shape = (self.height, 2 * self.height)
        if environment.ndim < 3 or tuple(environment.shape[-3:-1]) != shape:
            raise ValueError(
                f"expected an environment of shape [..., {shape[0]}, {shape[1]}, channels],"
                f" got {tuple(environment.shape)}"
            )
        batch, channels = environment.shape[:-3], environment.shape[-1]
        # One wide product instead of many narrow ones: batch and channels side by side.
        columns = environment.reshape(-1, self.factor.shape[1], channels).transpose(0, 1).flatten(1)
        with torch.autocast(environment.device.type, enabled=False):
            rows = self.factor @ columns.to(self.factor.dtype)
        return rows.reshape(len(rows), -1, channels).transpose(0, 1).reshape(*batch, -1, channels)

    def compare(
        self,
        predicted: Float[Tensor, "*batch rank channels"],
        true: Float[Tensor, "*batch rank channels"],
    ) -> tuple[Float[Tensor, "*batch 3"], Float[Tensor, "*batch 3"]]:
        """RMSE and si-RMSE of each sphere, from the coordinates that `encode` gives."""
        count = self.pixels * predicted.shape[-1]
        spheres = zip(torch.split(predicted, self.ranks, -2), torch.split(true, self.ranks, -2), strict=True)
        errors = [rmse_and_si_rmse(p, g, count) for p, g in spheres]
        return torch.stack([e[0] for e in errors], -1), torch.stack([e[1] for e in errors], -1)

    def forward(
        self,
        predicted: Float[Tensor, "*batch height width 3"],
        true: Float[Tensor, "*batch height width 3"],
    ) -> tuple[Float[Tensor, "*batch 3"], Float[Tensor, "*batch 3"]]:
        """RMSE and si-RMSE of each sphere between two environment maps, in their units."""
        return self.compare(self.encode(predicted), self.encode(true))


@lru_cache(maxsize=2)
def _factors(height: int, resolution: int) -> tuple[tuple[Tensor, ...], int]:
    """U_r^T T of each sphere (read-only), and the number of pixels of its picture."""
    factors = []
    pixels = 0
    for material in MATERIALS:
        # The maps are energy-resized: their texels are means over areas, so the mirror sees areas too.
        matrix, mask = sphere_matrix(
            material,
            resolution,
            height,
            pixel_supersample=8 if material.kind == "mirror" else 3,
            interpolation="nearest",
            dtype=torch.float64,
        )
        pixels = int(mask.sum())
        directions = torch.linalg.eigh(matrix @ matrix.T).eigenvectors.flip(1)
        rows = directions.T @ matrix
        # What is lost, for each texel, when only the first r rows are kept.
        power = rows.square()
        lost = (power.sum(0) - power.cumsum(0)).clamp(min=0)
        rank = int((lost.amax(1) > _LOST_SHARE**2 * power.sum(0).mean()).sum()) + 1
        factors.append(rows[:rank].float())
    return tuple(factors), pixels
