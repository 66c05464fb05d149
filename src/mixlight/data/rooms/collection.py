"""The panoramas of a set of rooms, whatever it is made of: light groups to be remixed, or plain files."""

from __future__ import annotations

from pathlib import Path

from jaxtyping import Float
from torch import Tensor

from mixlight.data.panoramas import PanoramaRecord, read_radiance, read_table
from mixlight.light.separate import luminance
from mixlight.sphere import equirect

__all__ = ["TABLE", "partly_balanced", "read_set", "relit"]

TABLE = "rooms.csv"
"""Name of the table in a set's folder."""

BALANCE = 0.8
"""Share of its mean colour cast that a plain panorama loses before it is looked at, as cameras do it."""


def read_set(source: str | Path) -> list[PanoramaRecord]:
    """The records of a set: a folder with a `rooms.csv`, or such a table.

    Raises:
        ValueError: a table that `read_table` refuses, or one without a row.
        FileNotFoundError: neither is there, or a file of the table is missing.
    """
    table = Path(source)
    if table.is_dir():
        table = table / TABLE
        if not table.is_file():
            raise FileNotFoundError(f"{source}: expected a folder of rooms with a {TABLE}, found none in it")
    records = read_table(table)
    if not records:
        raise ValueError(f"{table}: expected rooms, got a table without a row")
    return records


def partly_balanced(
    panorama: Float[Tensor, "height width 3"], share: float = BALANCE
) -> Float[Tensor, "height width 3"]:
    """Takes a share of the mean colour cast out, by channel gains that keep the mean's luminance.

    A gain is (Y / c) ** share, c the mean of the channel and Y the luminance of the mean; all three are then
    scaled alike.

    Convention: share 0 leaves the panorama alone, share 1 makes its mean grey.

    Raises:
        ValueError: no panorama, a channel without any light, or a share outside [0, 1].

    >>> import torch
    >>> warm = torch.ones(4, 8, 3) * torch.tensor([4.0, 2.0, 1.0])
    >>> partly_balanced(warm, 1.0)[0, 0]
    tensor([2.3530, 2.3530, 2.3530])
    """
    if not 0 <= share <= 1:
        raise ValueError(f"expected a share from 0 to 1, got {share}")
    equirect.check(panorama)
    mean = equirect.integrate(panorama)
    if not bool((mean > 0).all()):
        raise ValueError(f"expected light in every channel, got a mean of {mean.tolist()}")
    target = luminance(mean)
    gains = (target / mean) ** share
    return panorama * (gains * target / luminance(mean * gains))


def relit(record: PanoramaRecord, recipes: int, seed: int) -> list[Float[Tensor, "height width 3"]]:
    """A room's panorama as a camera would balance it; with light groups, in `recipes` random relightings.

    A plain panorama has one light only. The same arguments give the same panoramas; a room's lights do not
    depend on which others are in the set.

    Raises:
        ValueError: the file is no room and no panorama.
        OSError: it cannot be read.
    """
    return [partly_balanced(read_radiance(record.path))]
