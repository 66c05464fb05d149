"""The error that counts: how wrong the three test spheres look under the predicted light."""

from __future__ import annotations

from functools import lru_cache

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mixlight.light.compare import rmse_and_si_rmse
from mixlight.light.transport import MATERIALS, sphere_matrix


class SphereLoss(nn.Module):
    """RMSE and si-RMSE of small diffuse, matte and mirror spheres under predicted and true light.

    A picture is the product of a dense transport matrix with the map. The matrix commutes with mirroring
    left to right and top to bottom, so maps and pictures are first split, orthonormally, into the four
    parts that are even or odd under both mirrorings. Each part has a matrix of a quarter of the rows and
    columns: a quarter of the work, nothing approximated. RMSE and si-RMSE are made of inner products, which
    the split keeps, so pictures need not be put together again.

    Agreement with `SphereRenderer` on the same small maps, relative RMS over six panoramas: diffuse below
    6e-4, matte .6e-2 to 2e-2, mirror 1e-2 to 5e-2. Against protocol M on full maps (64x128 texels and up,
    128² pixels) the errors between two panoramas come out at 1.00 (diffuse), .91 (matte) and .61
    (mirror) of their value in the median: small maps and pictures blur what a mirror shows.

    Under autocast it computes in float32 all the same: HDR light does not fit into bfloat16.

    Convention: frame, camera and materials of `mixlight.light.transport`; order of the spheres:
    diffuse, matte, mirror. Truth 1 everywhere against prediction .9 everywhere: the diffuse sphere
    shows .8 against .72, RMSE .08 and si-RMSE 0.
    """

    transport: Tensor
    """[4 symmetries, 3 * pixels / 4, texels / 4]: transport of a quarter picture from a quarter map."""

    def __init__(self, height: int = 32, resolution: int = 32) -> None:
        """Build the matrices, or take them from this process's cache; the first time takes two seconds.

        Args:
            height: Rows of the environment maps, even; their width is twice that.
            resolution: Width and height of each sphere's picture, even.

        Raises:
            ValueError: If a size is odd or below 2.
        """
        super().__init__()
        if height < 2 or resolution < 2 or height % 2 or resolution % 2:
            raise ValueError(
                f"expected even sizes of at least 2, got height {height}, resolution {resolution}"
            )
        self.height = height
        self.register_buffer("transport", _symmetric_transport(height, resolution).clone(), persistent=False)

    def encode(
        self, environment: Float[Tensor, "*batch height width channels"]
    ) -> Float[Tensor, "*batch 3 pixels channels"]:
        """The pictures of the three spheres, as their parts of each symmetry behind one another.

        Any inner product of two such codes is that of the pictures. Linear, so that what is known can be
        computed in advance: the code of a truth never changes, and for a light that is a sum of fixed maps
        (maps: [height, width, K], one channel a parameter; parameters: [*batch, K, 3])

            loss.encode(maps) @ parameters[..., None, :, :]

        is the code of `maps @ parameters`.

        Raises:
            ValueError: If the map has not the size the loss was built for.
        """
        height, width = self.height, 2 * self.height
        if environment.ndim < 3 or tuple(environment.shape[-3:-1]) != (height, width):
            raise ValueError(
                f"expected an environment of shape [..., {height}, {width}, channels],"
                f" got {tuple(environment.shape)}"
            )
        batch, channels = environment.shape[:-3], environment.shape[-1]
        # Batch and channels side by side: few wide products instead of many narrow ones.
        columns = environment.reshape(-1, height, width, channels).movedim(0, 2).flatten(2)
        with torch.autocast(environment.device.type, enabled=False):
            rows = self.transport @ _split(columns.to(self.transport.dtype)).flatten(1, 2)
        rows = rows.reshape(4, len(MATERIALS), -1, rows.shape[-1]).transpose(0, 1).flatten(1, 2)
        return (
            rows.reshape(*rows.shape[:2], -1, channels)
            .movedim(2, 0)
            .reshape(*batch, *rows.shape[:2], channels)
        )

    def compare(
        self,
        predicted: Float[Tensor, "*batch 3 pixels channels"],
        true: Float[Tensor, "*batch 3 pixels channels"],
    ) -> tuple[Float[Tensor, "*batch 3"], Float[Tensor, "*batch 3"]]:
        """RMSE and si-RMSE of each sphere, from what `encode` gives."""
        return rmse_and_si_rmse(predicted, true)

    def forward(
        self,
        predicted: Float[Tensor, "*batch height width 3"],
        true: Float[Tensor, "*batch height width 3"],
    ) -> tuple[Float[Tensor, "*batch 3"], Float[Tensor, "*batch 3"]]:
        """RMSE and si-RMSE of each sphere between two environment maps, in their units."""
        return self.compare(self.encode(predicted), self.encode(true))


def _split(image: Tensor) -> Tensor:
    """Orthonormal parts [4, height / 2, width / 2, ...] of an image: even-even, even-odd, odd-even, odd-odd.

    The first word is on mirroring top to bottom, the second on left to right.
    """
    top, bottom = image.chunk(2, 0)
    bottom = bottom.flip(0)
    parts = []
    for half in (top + bottom, top - bottom):
        left, right = half.chunk(2, 1)
        right = right.flip(1)
        parts += [left + right, left - right]
    return torch.stack(parts) / 2


@lru_cache(maxsize=2)
def _symmetric_transport(height: int, resolution: int) -> Tensor:
    """The matrices of the four symmetries, float32 (read-only)."""
    parts = []
    for material in MATERIALS:
        # The maps are energy-resized: their texels are means over areas, so the mirror sees areas too.
        matrix, mask = sphere_matrix(
            material,
            resolution,
            height,
            pixel_supersample=16 if material.kind == "mirror" else 2,
            interpolation="nearest",
            dtype=torch.float64,
        )
        first_quarter = torch.zeros_like(mask)
        first_quarter[: resolution // 2, : resolution // 2] = True
        rows = matrix[first_quarter[mask]].reshape(-1, height, 2 * height)
        # A map of one symmetry is its first quarter and three mirror images: the matrix's columns add up.
        folded = 2 * _split(rows.permute(1, 2, 0))
        parts.append(folded.flatten(1, 2).transpose(1, 2))
    return torch.cat(parts, 1).float().contiguous()
