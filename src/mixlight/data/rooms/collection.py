"""The panoramas of a set of rooms, whatever it is made of: light groups to be remixed, or plain files."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from pathlib import Path

from jaxtyping import Float
from torch import Tensor

from mixlight.data.panoramas import PanoramaRecord, read_radiance, read_table
from mixlight.data.rooms.remix import random_recipe, remix, white_balance_gain
from mixlight.data.rooms.store import is_room, read_room
from mixlight.light.separate import luminance
from mixlight.sphere import equirect

__all__ = ["TABLE", "read_set", "relit"]

TABLE = "rooms.csv"
"""Name of the table in a set's folder."""

BALANCE = 0.8
"""Share of its mean colour cast that a plain panorama loses before it is looked at, as cameras do it."""


def read_set(source: str | Path) -> list[PanoramaRecord]:
    """The records of a set: of a folder with a `rooms.csv`, or of such a table.

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


def relit(
    record: PanoramaRecord, recipes: int = 1, seed: int = 0
) -> Iterator[Float[Tensor, "height width 3"]]:
    """A room as a camera would balance it: `recipes` random relightings of its light groups.

    A plain panorama holds one light; it comes once, with a fixed share of its colour cast taken out
    (`BALANCE`). All have a mean luminance of 1, as in training. The same arguments give the same panoramas:
    the recipes depend on the seed and the scene's name, not on what else is in the set.

    Convention: every panorama is a draw of its own from `mixlight.data.rooms.remix.random_recipe`.

    Raises:
        ValueError: fewer than one recipe, or the file is neither a room nor a panorama.
        OSError: it cannot be read.
    """
    if recipes < 1:
        raise ValueError(f"expected at least one recipe, got {recipes}")
    if not is_room(record.path):
        panorama = read_radiance(record.path)
        yield _exposed(panorama * white_balance_gain(equirect.integrate(panorama), BALANCE))
        return
    render = read_room(record.path)
    rng = random.Random(f"{seed} {record.scene}")
    for _ in range(recipes):
        yield _exposed(remix(render.groups, random_recipe(render.groups, render.plan, rng)))


def _exposed(panorama: Float[Tensor, "height width 3"]) -> Float[Tensor, "height width 3"]:
    """A night by candles is .001, a noon is 1: both are a photo's job. Black stays black."""
    mean = float(luminance(equirect.integrate(panorama))) / (4 * math.pi)
    return panorama / mean if mean > 0 else panorama
