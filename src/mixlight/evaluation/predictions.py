"""Predictions of any other system: a folder with one map for each photo of a protocol."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample
from mixlight.image import exr, radiance
from mixlight.sphere import equirect, frames

__all__ = ["Horizon", "Predictions"]

Horizon = Literal["level", "camera"]
"""Whether the maps stand upright, or are tilted as their photo's camera was."""

SUFFIXES = (".exr", ".hdr")


@dataclass(frozen=True)
class Predictions:
    """A folder of maps, each named as the protocol names its photo: `kitchen_az045.exr` or `.hdr`.

    Maps are 2:1 and of any size, linear radiance in the photo's exposure (1.0 is the photo's white).

    Convention: the map is centred on the photo's azimuth in the way of the program `frame` names
        (`mixlight.sphere.frames.FRAMES`; "mixlight": the centre of the image is where the photo looks). With
        the horizon `camera` the map's centre is the optical axis itself, and the map is turned upright by the
        photo's pitch.
    """

    folder: Path
    """Where they lie; below it, where a scene's name holds a slash."""
    frame: str = "mixlight"
    """Which program's layout they have."""
    horizon: Horizon = "level"
    """How they stand."""

    def __post_init__(self) -> None:
        if not self.folder.is_dir():
            raise FileNotFoundError(f"{self.folder}: expected a folder of predicted maps, found none")
        if self.frame not in frames.FRAMES:
            raise ValueError(f"expected a frame out of {', '.join(frames.FRAMES)}, got {self.frame!r}")
        if self.horizon not in get_args(Horizon):
            raise ValueError(
                f"expected a horizon out of {', '.join(get_args(Horizon))}, got {self.horizon!r}"
            )

    def file(self, name: str) -> Path:
        """The map of a sample.

        Raises:
            FileNotFoundError: there is none.
            ValueError: there are two.
        """
        found = [path for s in SUFFIXES if (path := self.folder / f"{name}{s}").is_file()]
        if not found:
            raise FileNotFoundError(
                f"{self.folder / name}: expected the predicted map {name}.exr or {name}.hdr, found none"
            )
        if len(found) > 1:
            raise ValueError(f"{self.folder / name}: expected one map, found {name}.exr and {name}.hdr")
        return found[0]

    def version(self, name: str) -> str:
        """What the score of a sample depends on: the file's digest, and how it is read.

        Raises:
            OSError: the file is missing or cannot be read.
        """
        digest = hashlib.sha256(self.file(name).read_bytes()).hexdigest()[:16]
        return f"{digest} {self.frame} {self.horizon}"

    def environment(self, sample: EvaluationSample) -> Float[Tensor, "height width 3"]:
        """The map for a sample in our frame, upright.

        Raises:
            ValueError: not such a file, not 2:1, NaN, infinite or negative radiance, or laid out for another
                program than `frame` by what its own header says; the message names the file.
            OSError: the file is missing or cannot be read.
        """
        path = self.file(sample.name)
        if path.suffix == ".exr":
            pixels, attributes = exr.read(path)
            header = {key.lower(): str(value) for key, value in attributes.items()}
        else:
            pixels, lines = radiance.read(path)
            header = {key.lower(): value for key, value in lines.items()}
        environment = torch.from_numpy(pixels)
        equirect.check(environment, str(path))
        # Only our own files say how they are laid out; a word like "frame" in another's may mean anything.
        said = header.get("frame") if header.get("software", "").startswith("mixlight") else None
        if said is not None and said != self.frame:
            raise ValueError(
                f"{path}: expected a map in the frame {self.frame!r}, got one whose header says {said!r}"
            )
        try:
            ours = frames.convert_panorama(environment, self.frame, "mixlight")
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
        if self.horizon == "camera":
            ours = equirect.rotate(ours, frames.rotation(0.0, sample.pitch)).clamp_min(0)
        return ours
