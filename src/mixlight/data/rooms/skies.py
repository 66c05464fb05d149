"""Outdoor panoramas as skies for rendered rooms: the sun taken out, the rest on one scale.

Paths through a window hardly ever find a sun of half a degree in a panorama, and a panorama's own scale is
anyone's. So each becomes a map without its sun, whose light on open ground is 1, and a few numbers on that
sun.
"""

from __future__ import annotations

import hashlib
import json
import logging
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.panoramas import PanoramaRecord, load_panorama, read_table, select
from mixlight.image import exr
from mixlight.image.atomic import atomic_path
from mixlight.image.color import LUMINANCE_WEIGHTS
from mixlight.image.temperature import COOLEST, WARMEST, black_body
from mixlight.sphere import equirect

__all__ = ["OutdoorSky", "analyse", "horizontal_illuminance", "read_skies"]

Time = Literal["day", "dusk", "night"]

_VERSION = 2
"""Raised whenever prepared skies change."""
_LOG = logging.getLogger(__name__)
_SUN_RADIUS = math.radians(6.0)
_CAP = 8.0
"""Light above this many times the mean of the upper half is the sun's (or a lamp's)."""
_ROUNDS = 6
_ONE_SOURCE = 0.9
_MANY_SOURCES = 0.65
_LAMP = 2000.0
"""Lamps are at least so many times brighter than the mean."""
_DARK = 0.35
"""The median of a sky at night lies below this share of the mean, which is the lamps'."""
_FAINT_SUN = 0.02
"""A sun that gives less than this share of the sky's light stays in the map."""
_LOW_SUN = math.radians(10.0)
_NIGHT = re.compile("night|moon|midnight")
_DUSK = re.compile("dusk|dawn|sunset|sunrise|evening|twilight")


@dataclass(frozen=True)
class OutdoorSky:
    """What is known of one outdoor panorama.

    Convention: directions are in the room frame of a sky that is not turned: the panorama's centre is +Y,
        what is right of it +X, up +Z.
    """

    name: str
    """The scene."""
    file: Path
    """The prepared map: linear Rec.709 without the sun, its illuminance on open ground 1."""
    time: Time
    sun_direction: tuple[float, float, float] | None = None
    """Towards the sun; None where no single source stands out."""
    sun_ratio: float = 0.0
    """Illuminance by the sun, facing it, over that by the rest on open ground."""
    sun_temperature: float = 5500.0
    """Colour temperature of the sun as the panorama shows it, in kelvins."""


def horizontal_illuminance(panorama: Float[Tensor, "height width 3"]) -> float:
    """Light on open, level ground: the integral of luminance times the cosine to the zenith.

    >>> round(horizontal_illuminance(torch.ones(32, 64, 3)), 2)  # pi
    3.14
    """
    height = panorama.shape[0]
    up = equirect.pixel_directions(height)[..., 1].clamp(min=0) * equirect.solid_angle(height)
    return float(((panorama @ torch.tensor(LUMINANCE_WEIGHTS)) * up).double().sum())


def analyse(
    panorama: Float[Tensor, "height width 3"], name: str = ""
) -> tuple[Float[Tensor, "height width 3"], dict[str, Any]]:
    """Takes the sun out of an outdoor panorama and says what it was.

    All light above eight times the mean that the upper half has without it is a source's. Where nine tenths
    of it lie within 6 degrees of the brightest texel, above the horizon, that is the sun: what exceeds the
    limit there goes. The name tells the time (`night`, `moon`; `dusk`, `dawn`, `sunset` ...). Where it does
    not, several strong sources before a sky that is mostly dark are lamps, and it is night; a sun below 10
    degrees makes it dusk. Lamps stay in the map, and so does the moon.

    Returns:
        The map with a horizontal illuminance of 1, and the fields `time`, `sun_direction`, `sun_ratio` and
        `sun_temperature` of `OutdoorSky`.

    Raises:
        ValueError: no panorama of radiance, or one without light in its upper half.
    """
    equirect.check(panorama, name or "panorama")
    height = panorama.shape[0]
    weights = torch.tensor(LUMINANCE_WEIGHTS)
    luminance = panorama @ weights
    directions, solid_angle = equirect.pixel_directions(height), equirect.solid_angle(height)
    upper = directions[..., 1] > 0
    mean = float((luminance * solid_angle)[upper].sum() / (2 * math.pi))
    if not mean > 0:
        raise ValueError(f"{name or 'panorama'}: expected light above the horizon, received none")
    limit = mean
    for _ in range(_ROUNDS):  # the mean of the sky, not of the sun
        capped = luminance.clamp(max=_CAP * limit)
        limit = float((capped * solid_angle)[upper].sum() / (2 * math.pi))
    share = (_CAP * limit / luminance.clamp(min=1e-12)).clamp(max=1.0)[..., None]
    excess = panorama * (1 - share) * solid_angle[..., None]
    total = float((excess @ weights).sum())
    brightest = directions.reshape(-1, 3)[int(luminance.argmax())]
    near = (directions @ brightest) > math.cos(_SUN_RADIUS)
    sun = (excess * near[..., None]).sum((0, 1))
    concentrated = float(sun @ weights) / total if total > 0 else 0.0
    is_sun = concentrated > _ONE_SOURCE and float(brightest[1]) > 0.02
    lamps = concentrated < _MANY_SOURCES and float(luminance.max()) > _LAMP * mean
    time: Time = "day"
    if _NIGHT.search(name):
        time = "night"
    elif _DUSK.search(name):
        time = "dusk"
    elif lamps and float(luminance[upper].median()) < _DARK * mean:
        time = "night"
    elif is_sun and math.asin(float(brightest[1])) < _LOW_SUN:
        time = "dusk"
    facts: dict[str, Any] = {"time": time}
    sky = torch.where(near[..., None], panorama * share, panorama)
    ratio = float(sun @ weights) / horizontal_illuminance(sky)
    if is_sun and time != "night" and ratio > _FAINT_SUN:
        x, y, z = (float(c) for c in brightest)
        facts |= {
            "sun_direction": (x, -z, y),
            "sun_ratio": ratio,
            "sun_temperature": _temperature(sun),
        }
    else:
        sky = panorama
    return sky / horizontal_illuminance(sky), facts


def _temperature(colour: Float[Tensor, 3]) -> float:
    """The black body whose red is to its blue as the colour's."""
    target = math.log(max(float(colour[0]), 1e-9) / max(float(colour[2]), 1e-9))
    low, high = math.log(WARMEST), math.log(COOLEST)
    for _ in range(40):  # red over blue falls with the temperature
        middle = (low + high) / 2
        red, _, blue = black_body(min(max(math.exp(middle), WARMEST), COOLEST))
        if math.log(max(red, 1e-9) / max(blue, 1e-9)) > target:
            low = middle
        else:
            high = middle
    return round(math.exp((low + high) / 2), 0)


def read_skies(table: str | Path, cache: str | Path) -> list[OutdoorSky]:
    """The skies among a table's panoramas: category `outdoor`, split `train`, never another.

    Args:
        table: a CSV as `data.panoramas.read_table` takes.
        cache: folder in which the prepared maps are kept from run to run.

    Returns:
        Sorted by name, so that the order of the table does not change a seed's room.

    Raises:
        ValueError: a bad table, no outdoor training panorama in it, or a file that is none.
        OSError: a file cannot be read, or the cache not be written.
    """
    records = select(read_table(table), "train", ["outdoor"])
    if not records:
        raise ValueError(f"{table}: expected panoramas of category outdoor and split train, received none")
    cache = Path(cache)
    cache.mkdir(parents=True, exist_ok=True)
    return [_prepared(record, cache) for record in sorted(records, key=lambda r: r.scene)]


def _prepared(record: PanoramaRecord, cache: Path) -> OutdoorSky:
    with record.path.open("rb") as content:
        digest = hashlib.file_digest(content, "sha256")
    digest.update(repr((_VERSION, record.scene)).encode())
    stem = cache / f"{re.sub(r'[^A-Za-z0-9_-]', '_', record.scene)}-{digest.hexdigest()[:16]}"
    picture, numbers = stem.with_suffix(".exr"), stem.with_suffix(".json")
    try:
        exr.read_size(picture)
        return _sky(record.scene, picture, json.loads(numbers.read_text(encoding="utf-8")))
    except (OSError, ValueError, KeyError, TypeError):
        sky, facts = analyse(load_panorama(record.path), record.scene)
    exr.write(picture, sky.numpy(), {"scene": record.scene})
    with atomic_path(numbers) as temporary:
        temporary.write_text(json.dumps(facts), encoding="utf-8")
    _LOG.info("%s: prepared as a sky, %s", record.path, facts)
    return _sky(record.scene, picture, facts)


def _sky(name: str, file: Path, facts: dict[str, Any]) -> OutdoorSky:
    if "sun_direction" not in facts:
        return OutdoorSky(name, file, facts["time"])
    x, y, z = (float(c) for c in facts["sun_direction"])
    return OutdoorSky(
        name, file, facts["time"], (x, y, z), float(facts["sun_ratio"]), float(facts["sun_temperature"])
    )
