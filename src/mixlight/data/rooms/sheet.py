"""Contact sheets: many rooms, or many photos of them, in one picture for people to look at."""

from __future__ import annotations

import io
import random
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from mixlight.data.camera_model import CameraSettings, random_photo
from mixlight.data.crops import CropSettings, frame_mask, random_crop, take_view
from mixlight.data.panoramas import PanoramaRecord
from mixlight.data.rooms.collection import relit
from mixlight.image.atomic import atomic_path
from mixlight.image.tonemap import exposure_for, preview
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

__all__ = ["choose", "crop_tile", "lay_out", "panorama_tile", "write_jpeg"]

Tile = UInt8[np.ndarray, "height width 3"]
Sheet = UInt8[np.ndarray, "sheet_height sheet_width 3"]

PANORAMA_ROWS = 128
CROP_SIZE = (120, 160)
"""Rows, and rows and columns, of one picture of a sheet."""

MAX_BYTES = 700_000
"""A sheet is compressed until it is no larger."""

_GAP = 4
_PAGE = (24, 24, 26)
_QUALITIES = (90, 85, 80, 75, 70, 65, 60, 50, 40, 30)
_AZIMUTHS = 64
_TRIES = 20


def choose(records: Sequence[PanoramaRecord], count: int, seed: int) -> list[PanoramaRecord]:
    """Draws records at random so that no room comes again before every room has come as often.

    A room's cameras follow each other in random order, and start anew when all have been taken.

    Raises:
        ValueError: no records, or a count below 1.

    >>> one = PanoramaRecord("a", Path("a.exr"), "train", "room", "a")
    >>> [record.scene for record in choose([one], 2, 0)]
    ['a', 'a']
    """
    if not records or count < 1:
        raise ValueError(f"expected records and a count of at least 1, got {len(records)} and {count}")
    rng = random.Random(seed)
    rooms: dict[str, list[PanoramaRecord]] = {}
    for record in records:
        rooms.setdefault(record.group, []).append(record)
    cameras = list(rooms.values())
    for room in cameras:
        rng.shuffle(room)
    chosen: list[PanoramaRecord] = []
    turn = 0
    while len(chosen) < count:
        rng.shuffle(cameras)
        chosen += [room[turn % len(room)] for room in cameras]
        turn += 1
    return chosen[:count]


def panorama_tile(record: PanoramaRecord, seed: int, rows: int = PANORAMA_ROWS) -> Tile:
    """A room in one random relighting, tone-mapped with an exposure of its own.

    Raises:
        ValueError: the file is no room and no panorama.
        OSError: it cannot be read.
    """
    (panorama,) = relit(record, 1, seed)
    # Exposed for what is around the camera, not for the poles, which the projection stretches.
    linear = equirect.resize(panorama, rows).numpy()
    return preview(linear, exposure_for(linear[rows // 6 : -rows // 6]))


def crop_tile(
    record: PanoramaRecord,
    seed: int,
    size: tuple[int, int] = CROP_SIZE,
    camera: CameraSettings | None = None,
) -> Tile:
    """A photo of a room as training takes them: a random view through a random camera.

    The photo fills the picture; training's narrower frames are left out.

    Raises:
        ValueError: the file is no room and no panorama, or is too dark to be photographed.
        OSError: it cannot be read.
    """
    generator = np.random.default_rng((seed, *record.scene.encode()))
    canonical = CanonicalView(*size)
    (panorama,) = relit(record, 1, seed)
    settings = CropSettings(frames=False)
    for _ in range(_TRIES):
        crop = random_crop(_AZIMUTHS, settings, generator, canonical.fov)
        view, inside = take_view(panorama, crop, canonical), frame_mask(crop, canonical)
        exposed = random_photo(view, inside, camera or CameraSettings(), generator)
        if exposed is not None:
            return (exposed.photo.numpy() * 255 + 0.5).astype(np.uint8)
    raise ValueError(f"{record.path}: expected a room that can be photographed, got none in {_TRIES} views")


def lay_out(tiles: Sequence[Tile], columns: int) -> Sheet:
    """Lays pictures of one size out in rows, from left to right; the last row may be short.

    Raises:
        ValueError: no pictures, pictures of several sizes, or fewer than one column.

    >>> lay_out([np.full((2, 4, 3), 255, np.uint8)] * 3, 2).shape
    (16, 20, 3)
    """
    shapes = {tile.shape for tile in tiles}
    if len(shapes) != 1 or columns < 1:
        raise ValueError(
            f"expected pictures of one size and at least one column, got {sorted(shapes)}, {columns}"
        )
    height, width, _ = shapes.pop()
    columns = min(columns, len(tiles))
    rows = -(-len(tiles) // columns)
    sheet = np.empty((rows * (height + _GAP) + _GAP, columns * (width + _GAP) + _GAP, 3), np.uint8)
    sheet[:] = _PAGE
    for k, tile in enumerate(tiles):
        top, left = _GAP + k // columns * (height + _GAP), _GAP + k % columns * (width + _GAP)
        sheet[top : top + height, left : left + width] = tile
    return sheet


def write_jpeg(sheet: Sheet, path: Path, max_bytes: int = MAX_BYTES) -> int:
    """Writes a sheet at the best quality that fits, atomically; returns that quality.

    Raises:
        ValueError: even the lowest quality does not fit.
        OSError: the file cannot be made.
    """
    picture = Image.fromarray(sheet)
    for quality in _QUALITIES:
        stream = io.BytesIO()
        picture.save(stream, "JPEG", quality=quality, optimize=True, progressive=True)
        if stream.tell() <= max_bytes:
            with atomic_path(path) as temporary:
                temporary.write_bytes(stream.getvalue())
            return quality
    raise ValueError(f"{path}: expected a sheet of at most {max_bytes} bytes, got more at any quality")


TILES: dict[str, Callable[[PanoramaRecord, int], Tile]] = {"panoramas": panorama_tile, "crops": crop_tile}
"""What a sheet may show."""
