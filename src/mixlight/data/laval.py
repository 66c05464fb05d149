"""The warped Laval indoor set, for people who have it by agreement: names, pairs, a split by panorama,
samples.

The set holds crops of HDR panoramas and, for each, the panorama as seen from where the crop looks:

    <root>/hdrInputs/<panorama>-others-<azimuth>-<theta>-<fov>.exr          the crop, linear
    <root>/warpedHDROutputs/<panorama>-others-<azimuth>-<theta>-<fov>.exr   its light, equirectangular, linear

What the three numbers mean is written nowhere in the set. They are read here in the one way under which
typical values (40, 1.62409, 1.07406) describe a photo: azimuth in degrees, in steps of 40; theta, the angle
between the zenith and the optical axis, in radians (here 3 degrees below the horizon); fov, horizontal, in
radians (61.5 degrees). Numbers that cannot be so are refused, not converted. Two things cannot be told from
the names, and nothing here depends on them: in which sense the azimuth turns, and where its zero is. The
warped panorama is taken as it is: centred on its crop's azimuth, level, in our frame, which is the set's own.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.camera_model import exposure_gain, plain_photo
from mixlight.data.evaluation_set import ENVIRONMENT_HEIGHT, EvaluationSample
from mixlight.data.panoramas import read_radiance
from mixlight.image import exr
from mixlight.network.canonical import CanonicalView
from mixlight.sphere import equirect

PHOTO_FOLDER = "hdrInputs"
LIGHT_FOLDER = "warpedHDROutputs"

_NUMBER = r"(-?\d+(?:\.\d+)?)"
_NAME = re.compile(rf"(.+)-others-{_NUMBER}-{_NUMBER}-{_NUMBER}\.exr")
_PATTERN = "<panorama>-others-<azimuth>-<theta>-<fov>.exr"


@dataclass(frozen=True)
class LavalName:
    """What the name of a file of the set says; see the head of this module for how sure that is."""

    panorama: str
    """Name of the panorama that the crop was cut from."""
    azimuth_deg: float
    """Azimuth of the crop in degrees, in [0, 360); zero and sense unknown."""
    theta: float
    """Angle between the zenith and the optical axis in radians, in (0, pi)."""
    fov: float
    """Horizontal field of view in radians, in (0, pi)."""

    @property
    def pitch(self) -> float:
        """Elevation of the optical axis in radians: pi / 2 - theta; negative looks down."""
        return math.pi / 2 - self.theta


def parse_name(name: str) -> LavalName:
    """Takes a file name of the set apart.

    Raises:
        ValueError: another pattern, an azimuth outside [0, 360), or a theta or fov outside (0, pi), as if it
            were in degrees.

    >>> name = parse_name("AG8A0001-others-40-1.62409-1.07406.exr")
    >>> name.panorama, name.azimuth_deg, round(math.degrees(name.pitch), 2), round(math.degrees(name.fov), 2)
    ('AG8A0001', 40.0, -3.05, 61.54)
    """
    match = _NAME.fullmatch(name)
    if match is None:
        raise ValueError(f"expected a name of the form {_PATTERN}, got {name!r}")
    azimuth, theta, fov = (float(number) for number in match.groups()[1:])
    if not 0 <= azimuth < 360:
        raise ValueError(f"{name}: expected an azimuth in [0, 360) degrees, got {azimuth:g}")
    for key, value in (("theta", theta), ("fov", fov)):
        if not 0 < value < math.pi:
            raise ValueError(f"{name}: expected {key} in radians, in (0, pi), got {value:g}")
    return LavalName(match[1], azimuth, theta, fov)


@dataclass(frozen=True)
class LavalPair:
    """A crop and the light around it."""

    name: LavalName
    """What the file name says."""
    photo: Path
    """The linear crop, in `hdrInputs`."""
    light: Path
    """The warped panorama, in `warpedHDROutputs`."""


def read_laval(root: str | Path, *, allow_unpaired: bool = False) -> list[LavalPair]:
    """Lists the pairs of the set below a folder, in the order of their names.

    Args:
        root: the folder that holds `hdrInputs` and `warpedHDROutputs`.
        allow_unpaired: leave crops without light, and light without a crop, out instead of refusing them.

    Raises:
        FileNotFoundError: one of the two folders is missing, or there is no pair.
        ValueError: an .exr file whose name does not fit, or one without its partner.
    """
    root = Path(root)
    found: list[set[str]] = []
    for part in (PHOTO_FOLDER, LIGHT_FOLDER):
        folder = root / part
        if not folder.is_dir():
            raise FileNotFoundError(
                f"{root}: expected the folders {PHOTO_FOLDER} and {LIGHT_FOLDER}, found no {part}"
            )
        found.append({path.name for path in folder.glob("*.exr") if not path.name.startswith(".")})
    alone = sorted(found[0] ^ found[1])
    if alone and not allow_unpaired:
        present = PHOTO_FOLDER if alone[0] in found[0] else LIGHT_FOLDER
        raise ValueError(
            f"{root}: expected every file in both {PHOTO_FOLDER} and {LIGHT_FOLDER}, got {len(alone)} in one "
            f"of them only (first: {alone[0]}, in {present})"
        )
    names = sorted(found[0] & found[1])
    if not names:
        raise FileNotFoundError(f"{root}: expected pairs named {_PATTERN}, found none")
    try:
        return [LavalPair(parse_name(n), root / PHOTO_FOLDER / n, root / LIGHT_FOLDER / n) for n in names]
    except ValueError as error:
        raise ValueError(f"{root}: {error}") from error


def split_by_panorama(pairs: Sequence[LavalPair], shares: Mapping[str, float]) -> dict[str, list[LavalPair]]:
    """Deals the pairs out by their panorama, so that all crops of one room stand on one side.

    The side follows from the panorama's name alone (the first 64 bits of its SHA-256 as a fraction, against
    the running sum of the shares): the same on every machine, and unmoved by files that are added or missing.

    Args:
        pairs: what to split.
        shares: expected share of the panoramas on each side; they sum to 1.

    Returns:
        For each side its pairs, in their order; a side may stay empty.

    Raises:
        ValueError: a negative share, or shares that do not sum to 1.

    >>> name = parse_name("AG8A0001-others-40-1.62409-1.07406.exr")
    >>> sides = split_by_panorama([LavalPair(name, Path("a"), Path("b"))], {"train": 0.9, "test": 0.1})
    >>> {side: len(members) for side, members in sides.items()}
    {'train': 1, 'test': 0}
    """
    if any(not share >= 0 for share in shares.values()) or not math.isclose(sum(shares.values()), 1):
        raise ValueError(f"expected shares of at least 0 that sum to 1, got {dict(shares)}")
    sides: dict[str, list[LavalPair]] = {side: [] for side in shares}
    for pair in pairs:
        digest = hashlib.sha256(pair.name.panorama.encode()).digest()
        rest = int.from_bytes(digest[:8], "big") / 2**64
        chosen = ""
        for side, share in shares.items():
            if share == 0:
                continue
            chosen = side
            rest -= share
            if rest < 0:
                break
        sides[chosen].append(pair)
    return sides


def read_pair(
    pair: LavalPair,
) -> tuple[Float[Tensor, "height width 3"], Float[Tensor, "map_height map_width 3"]]:
    """Reads a crop and its light: linear radiance, Rec.709, in one scale.

    Raises:
        ValueError: a file is no OpenEXR, holds NaN, infinite or negative radiance, or the light is not 2:1;
            the message names the file.
        OSError: a file cannot be read.
    """
    photo = torch.from_numpy(exr.read(pair.photo)[0])
    low, high = (float(bound) for bound in photo.aminmax())
    if not (low >= 0 and high < math.inf):
        raise ValueError(
            f"{pair.photo}: expected finite radiance of at least 0, got values from {low:g} to {high:g}"
        )
    return photo, read_radiance(pair.light)


def samples_of_pairs(pairs: Sequence[LavalPair], canonical: CanonicalView) -> Iterator[EvaluationSample]:
    """Yields the pairs as samples of protocol M: exposure .18 / median luminance, sRGB, 8 bits, clipped at 1.

    The crop is seen through the network's canonical view with the field of view of its name; all-black crops
    are left out.

    Raises:
        ValueError: as `read_pair`.
        OSError: as `read_pair`.
    """
    for pair in pairs:
        photo, light = read_pair(pair)
        view, inside = canonical.resample(photo, pair.name.fov)
        if not bool((view[inside] > 0).any()):
            continue
        gain = exposure_gain(view, inside)
        yield EvaluationSample(
            scene=pair.name.panorama,
            azimuth_deg=pair.name.azimuth_deg,
            pitch=pair.name.pitch,
            gain=gain,
            photo=plain_photo(view, inside, gain).photo.permute(2, 0, 1),
            environment=equirect.resize(light, ENVIRONMENT_HEIGHT) * gain,
        )
