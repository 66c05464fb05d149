"""Rendered rooms seen under other lights, as training panoramas."""

from __future__ import annotations

import dataclasses
import hashlib
import logging
import random
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.rooms.remix import random_recipe, remix
from mixlight.data.rooms.store import document_of, is_room, read_room
from mixlight.image.atomic import atomic_path
from mixlight.image.color import LUMINANCE_WEIGHTS
from mixlight.sphere import equirect

__all__ = ["has_groups", "relightings"]

_VERSION = 3
"""Raised whenever a remix of the same number becomes another one."""
_BRIGHTEST = 6e4
"""Half floats end at 65504; what would be brighter makes the whole darker instead."""
_LOG = logging.getLogger(__name__)


def has_groups(record: PanoramaRecord) -> bool:
    """Whether a panorama was stored with its light groups, so that it can be relit."""
    return record.path.suffix.lower() == ".exr" and is_room(record.path)


def relightings(
    record: PanoramaRecord, count: int, cache: Path, max_height: int = 512
) -> Iterator[tuple[str, Float[Tensor, "height width 3"]]]:
    """A room's panorama under `count` random lights, each exact, of a mean luminance of 1 or less.

    The k-th is a function of the scene's name, the room's files and k alone: the same in every run, however
    many there are. They are not white-balanced. Each is kept in the cache as plain half floats and mapped
    into memory, so that memory holds what is in use; where the cache cannot be written they stay in memory.

    Args:
        record: a room with light groups (`has_groups`).
        count: how many.
        cache: folder in which they are kept between runs.
        max_height: rows; a taller panorama is made smaller, keeping its energy.

    Yields:
        A name of the relighting that differs wherever its pixels may, and the panorama in half precision.

    Raises:
        ValueError: the files are no rendered room.
        OSError: they cannot be read.
    """
    digest = hashlib.sha256(repr((_VERSION, record.scene, max_height)).encode())
    for path in (record.path, document_of(record.path)):
        with path.open("rb") as content:
            digest.update(hashlib.file_digest(content, "sha256").digest())
    key = digest.hexdigest()[:16]
    room = None
    for k in range(count):
        name = f"remix {key} {k}"
        entry = cache / f"{record.path.stem}-{key}-{k}.npy"
        kept = _mapped(entry)
        if kept is None:
            if room is None:
                room = read_room(record.path)
                small = {n: _resized(pixels, max_height) for n, pixels in room.groups.items()}
            chance = random.Random(f"mixlight relighting {record.scene} {k}")
            recipe = random_recipe(small, room.plan, chance)
            # The camera that photographs it balances the white, another time each time.
            kept = _normalised(remix(small, dataclasses.replace(recipe, white_balance=0.0)))
            kept = _keep(entry, kept)
        yield name, kept


def _resized(panorama: Float[Tensor, "rows columns 3"], max_height: int) -> Float[Tensor, "height width 3"]:
    return equirect.resize(panorama, max_height) if panorama.shape[0] > max_height else panorama


def _normalised(panorama: Float[Tensor, "height width 3"]) -> Float[Tensor, "height width 3"]:
    mean = float(equirect.integrate(panorama) @ torch.tensor(LUMINANCE_WEIGHTS)) / (4 * torch.pi)
    return (panorama / max(mean, float(panorama.max()) / _BRIGHTEST)).half()


def _mapped(entry: Path) -> Tensor | None:
    try:
        # Copy on write, as torch warns of arrays that it may not write to.
        return torch.from_numpy(np.load(entry, mmap_mode="c"))
    except FileNotFoundError:
        return None
    except (ValueError, OSError) as error:
        _LOG.warning("%s: damaged, made anew (%s)", entry, error)
        return None


def _keep(entry: Path, panorama: Tensor) -> Tensor:
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(entry) as temporary, temporary.open("wb") as file:
            np.save(file, panorama.numpy())
    except OSError as error:
        _LOG.warning("%s: relightings are not kept (%s)", entry.parent, error)
        return panorama
    mapped = _mapped(entry)
    return panorama if mapped is None else mapped
