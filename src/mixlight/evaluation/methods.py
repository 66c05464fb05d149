"""What is compared: methods by the names that the command line knows."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Literal

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight.data.evaluation_set import EvaluationSample
from mixlight.data.panoramas import PanoramaRecord, select
from mixlight.evaluation import floors
from mixlight.evaluation.oracles import ORACLES
from mixlight.evaluation.predictions import Horizon, Predictions
from mixlight.evaluation.protocols import Protocol
from mixlight.light.detail import Detail
from mixlight.light.lighting import Lighting
from mixlight.network import srgb, weights
from mixlight.network.canonical import CanonicalView
from mixlight.network.estimator import Estimator
from mixlight.network.methods import AnyNet, create, environments
from mixlight.network.model import ModelSettings

__all__ = ["FLOORS", "STANDARD", "Kind", "Method", "Methods"]

Kind = Literal["network", "floor", "oracle", "files"]
"""What a method may look at: a photo, training data or the photo's pixels, the truth, anything."""

Answer = Float[Tensor, "height width 3"] | Lighting


@dataclass(frozen=True)
class Method:
    """Something that answers a photo with light."""

    name: str
    """Of its row in the tables."""
    kind: Kind
    """What it looks at."""
    answer: Callable[[EvaluationSample], Answer]
    """The light of a sample: a map in our frame and the photo's exposure, or a lighting."""
    version: Callable[[str], str]
    """What the answer to the sample of a name depends on beside the sample: another is scored anew."""
    about: Mapping[str, object] = field(default_factory=dict)
    """What a results file says of it."""


FLOORS: Mapping[str, str] = {
    "training-mean": "mean light of the training panoramas",
    "training-mean-geometric": "mean shape of the training panoramas' light, at their typical brightness",
    "photo-mean": "constant light of the photo's mean colour",
    "photo-extended": "the photo's pixels, and their smooth continuation",
}
"""Name of a floor: what it is."""

STANDARD = (
    *FLOORS,
    "oracle:top_fraction",
    "oracle:max_fraction",
    "oracle:sh2",
    "oracle:gardner19",
    "oracle:emlight",
)
"""Floors and ceilings: what stands in every table. The other oracles can be asked for."""

_TRAINING_AZIMUTHS = 8


class Methods:
    """Opens methods by name, for one protocol and one set of panoramas."""

    def __init__(
        self,
        protocol: Protocol,
        records: Sequence[PanoramaRecord],
        frame: str = "mixlight",
        horizon: Horizon = "level",
    ) -> None:
        """Take what methods may need.

        Args:
            protocol: which the methods are compared by.
            records: all panoramas of the tables; those of the split `train` give the training mean.
            frame: layout of predictions from files.
            horizon: how these stand.
        """
        self.protocol = protocol
        self.frame, self.horizon = frame, horizon
        train = select(records, "train")
        self._train = [record for record in train if record.category == "indoor"] or train
        self._mean = cache(self._training_mean)

    @property
    def standard(self) -> tuple[str, ...]:
        """Floors and ceilings that can be had: without training panoramas, not their mean."""
        return tuple(name for name in STANDARD if self._train or not name.startswith("training-mean"))

    def open(self, name: str) -> Method:
        """The method of a name, which may have a label of its own before it: `ours=runs/a/model.safetensors`.

        - `mixlight`: the model in the box, or `mixlight:NAME` of one that ships; `mixlight+detail`: the same
          with the photo's own pixels in the map.
        - a path to a weights file: the network in it.
        - `training-mean`, `training-mean-geometric`, `photo-mean`, `photo-extended`: floors.
        - `oracle:NAME`: the truth through a representation (`mixlight.evaluation.oracles.ORACLES`).
        - `predictions:DIR`: maps in a folder.

        Raises:
            ValueError: an unknown name, or weights that cannot be used.
            FileNotFoundError: no such weights or folder, or no training panoramas for their mean.
        """
        label, equals, rest = name.partition("=")
        if not equals:
            label, rest = "", name
        if rest in FLOORS:
            return self._floor(rest, label)
        kind, _, what = rest.partition(":")
        if kind == "oracle":
            return self._oracle(what, label)
        if kind == "predictions" and what:
            return self._files(Path(what), label)
        if rest.endswith(".safetensors"):
            return _network(rest, label or Path(rest).stem)
        if kind in ("mixlight", "mixlight+detail"):
            return _network(what or "default", label or rest, detail=kind.endswith("+detail"))
        raise ValueError(
            f"expected a method out of mixlight, mixlight+detail, {', '.join(FLOORS)}, oracle:NAME, "
            f"predictions:DIR or a path to a .safetensors file, got {rest!r}"
        )

    def _floor(self, name: str, label: str) -> Method:
        answers: dict[str, Callable[[EvaluationSample], Tensor]] = {
            "training-mean": lambda sample: self._mean(False),
            "training-mean-geometric": lambda sample: self._mean(True),
            "photo-mean": floors.photo_mean_light,
            "photo-extended": floors.photo_extended_light,
        }
        about: dict[str, object] = {"is": FLOORS[name]}
        version = name
        if name.startswith("training-mean"):
            if not self._train:
                raise FileNotFoundError(
                    f"{name}: expected panoramas of the split train in the tables, got none"
                )
            about["panoramas"] = len(self._train)
            version += _digest(f"{record.path} {record.path.stat().st_size}" for record in self._train)
        return Method(label or name, "floor", answers[name], lambda sample_name: version, about)

    def _oracle(self, what: str, label: str) -> Method:
        if what not in ORACLES:
            raise ValueError(f"expected an oracle out of {', '.join(ORACLES)}, got {what!r}")
        text, oracle = ORACLES[what]
        return Method(
            label or f"oracle:{what}",
            "oracle",
            lambda sample: oracle(sample.environment),
            lambda name: "",
            {"is": text},
        )

    def _files(self, folder: Path, label: str) -> Method:
        files = Predictions(folder, self.frame, self.horizon)
        about = {"is": "maps from files", "frame": self.frame, "horizon": self.horizon}
        return Method(label or folder.resolve().name, "files", files.environment, files.version, about)

    def _training_mean(self, geometric: bool) -> Tensor:
        samples = (s for record in self._train for s in self.protocol.samples(record, _TRAINING_AZIMUTHS))
        return floors.training_mean_light(samples, geometric)


def _network(name_or_path: str, label: str, detail: bool = False) -> Method:
    """A network of any kind by its weights; the photo is shown to it as the estimator shows a user's."""
    path = weights.find(name_or_path)
    digest = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    _, card = weights.load(path)
    about: dict[str, object] = {key: card.get(key) for key in ("name", "kind", "commit", "seed")}
    about |= {"weights": digest[:16]}
    if card.get("kind") == "mixlight":
        estimator = Estimator.load(path)

        def answer(sample: EvaluationSample) -> Answer:
            photo = srgb.decode(sample.photo).permute(1, 2, 0)
            estimate = estimator.estimate_views(
                _seen(photo, sample.fov, estimator.model.settings.canonical)[None]
            )[0]
            if not detail:
                return estimate.lighting
            seen = Detail.of_photo(
                photo, sample.fov, len(sample.environment), pitch=estimate.pitch, roll=estimate.roll
            )
            return seen.environment(estimate.lighting)

        if detail:
            about["detail"] = "photo"
        return Method(label, "network", answer, lambda sample_name: f"{digest} {detail}", about)
    network = _load(path, card)

    @torch.inference_mode()
    def other(sample: EvaluationSample) -> Answer:
        photo = srgb.decode(sample.photo).permute(1, 2, 0)
        view = _seen(photo, sample.fov, network.settings.canonical)
        light = network(srgb.encode(view).permute(2, 0, 1)[None])
        return environments(light, network.settings, len(sample.environment))[0]

    return Method(label, "network", other, lambda sample_name: digest, about)


def _load(path: str | Path, card: dict[str, object]) -> AnyNet:
    """A network of another method than ours."""
    settings = card.get("settings")
    if not isinstance(settings, dict):
        raise weights.WeightsError(f"{path}: expected weights with their settings on the card, got none")
    try:
        network = create(ModelSettings.from_card(settings))
    except ValueError as error:
        raise weights.WeightsError(f"{path}: settings on the card: {error}") from error
    state, _ = weights.load(path)
    weights.load_into(network, state, path)
    return network.eval()


def _seen(photo: Tensor, fov: float, canonical: CanonicalView) -> Tensor:
    """What a network sees of a linear photo: that photo itself where it is in the network's view already."""
    if photo.shape[:2] == (canonical.height, canonical.width) and abs(fov - canonical.fov) < 1e-9:
        return photo
    return canonical.resample(photo, fov)[0].clamp(max=1)


def _digest(parts: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]
