"""One TOML file to one dataclass: everything that a training run depends on."""

from __future__ import annotations

import dataclasses
import math
import tomllib
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mixlight.data.camera_model import CameraSettings
from mixlight.data.crops import CropSettings
from mixlight.data.labels import LabelSettings
from mixlight.data.training_set import SamplingSettings
from mixlight.loss.lamps import LampWeights
from mixlight.loss.total import LossWeights
from mixlight.network.model import ModelSettings
from mixlight.training.presets import PRESETS, with_preset

WORDS = ("imagenet", "none")
"""Starts of a backbone that are no path."""

FREE = ("workers", "tensorboard", "checkpoint_every")
"""Keys that do not touch the result of a run, and may change when it goes on."""

_FREE_TABLES: Mapping[str, Mapping[str, Any]] = {"sampling.weights": SamplingSettings().weights}
"""Tables whose keys are anybody's, with their defaults: given in a file, one replaces the default as a
whole."""


@dataclass(frozen=True)
class OptimiserSettings:
    """How the weights are moved."""

    name: str = "adamw"
    """`adamw` or `adam`."""
    learning_rate: float = 1e-3
    """Peak rate of the heads."""
    backbone_rate: float = 3e-4
    """Peak rate of the backbone."""
    weight_decay: float = 0.02
    """Decay of matrices: decoupled with adamw, part of the gradient with adam; biases and norms have none."""
    warmup_steps: int = 50
    """Linear rise to the peak."""
    final_share: float = 0.02
    """The rate ends at this share of its peak, after a half cosine."""
    clip_norm: float = 5.0
    """Largest norm of the gradient."""
    ema_decay: float = 0.99
    """Decay of the averaged weights that are validated and shipped."""
    frozen_share: float = 0.0
    """Share of the backbone's parameter tensors, from the input on, that are not trained."""
    freeze_norms: bool = True
    """Keep the backbone's batch-norm statistics at their ImageNet values."""

    def __post_init__(self) -> None:
        if self.name not in ("adamw", "adam"):
            raise ValueError(f"expected name adamw or adam, got {self.name!r}")
        for name in ("learning_rate", "backbone_rate", "weight_decay", "warmup_steps"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"expected {name} of at least 0, got {getattr(self, name)}")
        for name in ("final_share", "ema_decay", "frozen_share"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"expected {name} in [0, 1], got {getattr(self, name)}")
        if not self.clip_norm > 0:
            raise ValueError(f"expected clip_norm above 0, got {self.clip_norm}")


@dataclass(frozen=True)
class TrainingConfig:
    """A training run."""

    tables: tuple[str, ...]
    """CSV tables of panoramas; relative paths are relative to the config file."""
    name: str = "mixlight"
    """Name of the model, written on its card."""
    method: str = "mixlight"
    """What is trained: `mixlight`, or a baseline, `gardner19` or `emlight` (`mixlight.training.presets`).
    Sets the values that make up the method; what the file says itself stands above them."""
    seed: int = 0
    """Seed of weights, views and dropout; at least 0."""
    steps: int = 1000
    """Number of optimiser steps."""
    batch_size: int = 32
    """Views a step."""
    members: int = 1
    """Number of trainings whose weights are averaged to the model, as far as that is better on val. All start
    from the same weights, those of `seed`, so that they end near enough to each other to be averaged, and
    each sees other views (with `frozen_views` the same ones in another order)."""
    member: int = 0
    """Which of the members a run is; its views and dropout are drawn from `views_seed`."""
    camera_views: int = 0
    """Above 0 the model's outputs for the camera's pose are fitted anew at the end, to that many training
    views, in whole batches; its light stays as it is (`mixlight.training.camera`)."""
    precision: str = "float32"
    """`float32` or `bfloat16` (autocast of the network; the loss stays in float32)."""
    validate_every: int = 100
    """Steps between validations."""
    checkpoint_every: int = 50
    """Steps between checkpoints."""
    validation_rooms: int = 2
    """Azimuths of each rendered validation room (real panoramas always have 8)."""
    workers: int = 1
    """Processes that make batches; 0 makes them in the training process."""
    backbone_weights: str = "imagenet"
    """Where the backbone starts: `imagenet` (the weights that ship with the package), `none` (at random), or
    a weights file of the backbone; a relative path is relative to the config file."""
    model_weights: str = ""
    """Weights of a whole model to go on from: the name of a shipped one, or a file (a relative path is
    relative to the config file); it may have seen views of another size. Empty: `backbone_weights`, and heads
    that predict the mean light."""
    tensorboard: bool = False
    """Also write TensorBoard events (needs the extra `tensorboard`)."""
    model: ModelSettings = field(default_factory=ModelSettings)
    """The network."""
    labels: LabelSettings = field(default_factory=LabelSettings)
    """How panoramas become targets."""
    crops: CropSettings = field(default_factory=CropSettings)
    """Which views are taken."""
    camera: CameraSettings = field(default_factory=CameraSettings)
    """How they are photographed."""
    sampling: SamplingSettings = field(default_factory=SamplingSettings)
    """How often each kind of panorama is seen."""
    unit: str = "photo"
    """What radiance errors are measured in: `photo`, the photo's mean luminance, or `truth`, the true mean
    radiance. An error relative to the truth is smallest for too dark a guess, since it forgives darkness
    more."""
    loss: LossWeights = field(default_factory=LossWeights)
    """What counts."""
    lamps: LampWeights = field(default_factory=LampWeights)
    """What counts beside that where the model's `sources` are `lamps`."""
    optimiser: OptimiserSettings = field(default_factory=OptimiserSettings)
    """How the weights are moved."""
    frozen_views: int = 0
    """Above 0 the backbone is not trained at all: its features on this many views (drawn as in training, the
    same for every seed of the run) are computed once, kept in the cache, and the heads are trained on those.
    A run then takes seconds, for studies that compare many."""

    def __post_init__(self) -> None:
        if not self.tables:
            raise ValueError("expected at least one CSV table in tables, got none")
        for name in ("members", "steps", "batch_size", "validate_every", "checkpoint_every"):
            if getattr(self, name) < 1:
                raise ValueError(f"expected {name} of at least 1, got {getattr(self, name)}")
        for name in ("seed", "member", "camera_views", "validation_rooms", "workers", "frozen_views"):
            if getattr(self, name) < 0:
                raise ValueError(f"expected {name} of at least 0, got {getattr(self, name)}")
        if self.method not in PRESETS:
            raise ValueError(f"expected a method out of {', '.join(PRESETS)}, got {self.method!r}")
        if self.unit not in ("photo", "truth"):
            raise ValueError(f"expected unit photo or truth, got {self.unit!r}")
        if self.precision not in ("float32", "bfloat16"):
            raise ValueError(f"expected precision float32 or bfloat16, got {self.precision!r}")
        if self.labels.anchors != self.model.anchors:
            raise ValueError(
                f"expected the same number of anchors in labels and model, got {self.labels.anchors} and "
                f"{self.model.anchors}"
            )

    @property
    def views_seed(self) -> int:
        """Seed of views and dropout: of a first member the `seed` itself, of later ones far from it."""
        return self.seed + 10_007 * self.member

    def split_members(self) -> tuple[TrainingConfig, ...]:
        """The configs of the members' own runs; the camera is fitted to their average alone."""
        return tuple(
            dataclasses.replace(self, members=1, member=k, camera_views=0) for k in range(self.members)
        )


def read_config(path: str | Path, overrides: Mapping[str, Any] | None = None) -> TrainingConfig:
    """Reads a TOML file; what it does not say keeps its default.

    Args:
        path: the TOML file.
        overrides: dotted keys (`optimiser.learning_rate`) with values that replace those of the file. A table
            given in the file replaces a default table as a whole; an override of one key of it changes that
            key alone.

    Raises:
        ValueError: not TOML, an unknown or missing key, a value of the wrong type or outside its range; the
            message names the file and the dotted key.
        FileNotFoundError: no such file.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: expected a TOML config, found no such file")
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: expected TOML, {error}") from error
    try:
        for dotted, value in (overrides or {}).items():
            _override(values, dotted, value)
        values = with_preset(values)
        config: TrainingConfig = _build(TrainingConfig, values, "")
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    start, model = config.backbone_weights, config.model_weights
    return dataclasses.replace(
        config,
        tables=tuple(str((path.parent / table).resolve()) for table in config.tables),
        backbone_weights=start if start in WORDS else str((path.parent / start).resolve()),
        model_weights=str((path.parent / model).resolve()) if Path(model).suffix else model,
    )


def to_plain(config: Any) -> dict[str, Any]:
    """The config as plain values, defaults included, as it is saved with every run."""
    return dataclasses.asdict(config)


def differences(saved: Mapping[str, Any], current: TrainingConfig) -> list[str]:
    """What a run would do differently under another config, one line a key: `seed: 0 -> 1`.

    Keys that do not touch the result are not compared (`FREE`), and a key that the saved config did not know
    had its default.

    Args:
        saved: `to_plain` of a config, as JSON gives it back.
        current: the config to compare.

    >>> differences({"tables": ["a.csv"], "seed": 1}, TrainingConfig(("a.csv",), seed=2, workers=8))
    ['seed: 1 -> 2']
    """
    default = _flat(to_plain(TrainingConfig(current.tables)))
    old, new = default | _flat(saved), _flat(to_plain(current))
    return [
        f"{key}: {old.get(key)!r} -> {new.get(key)!r}"
        for key in sorted(old.keys() | new.keys())
        if key not in FREE and old.get(key) != new.get(key)
    ]


def _flat(values: Mapping[str, Any], where: str = "") -> dict[str, Any]:
    """Nested tables as dotted keys; lists for tuples, as in JSON."""
    flat: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, Mapping) and f"{where}{key}" not in _FREE_TABLES:
            flat |= _flat(value, f"{where}{key}.")
        else:
            flat[f"{where}{key}"] = list(value) if isinstance(value, tuple) else value
    return flat


def _override(values: dict[str, Any], dotted: str, value: Any) -> None:
    *parents, last = dotted.split(".")
    table = values
    for depth, key in enumerate(parents, 1):
        where = ".".join(parents[:depth])
        table = table.setdefault(key, dict(_FREE_TABLES.get(where, {})))
        if not isinstance(table, dict):
            raise ValueError(f"unknown key {dotted}; {where} is no table")
    table[last] = value


def _build(kind: Any, values: Any, where: str) -> Any:
    if not isinstance(values, Mapping):
        raise ValueError(f"expected a table for {where.rstrip('.')}, got {values!r}")
    hints = typing.get_type_hints(kind)
    known = {f.name: f for f in dataclasses.fields(kind)}
    arguments = {}
    for key, value in values.items():
        dotted = f"{where}{key}"
        if key not in known:
            raise ValueError(f"unknown key {dotted}; expected one of {', '.join(known)}")
        arguments[key] = _convert(hints[key], value, dotted)
    for name, spec in known.items():
        required = spec.default is dataclasses.MISSING and spec.default_factory is dataclasses.MISSING
        if required and name not in arguments:
            raise ValueError(f"missing key {where}{name}")
    try:
        return kind(**arguments)
    except ValueError as error:
        raise ValueError(f"{where.rstrip('.')}: {error}" if where else str(error)) from error


def _convert(hint: Any, value: Any, dotted: str) -> Any:
    if dataclasses.is_dataclass(hint):
        return _build(hint, value, f"{dotted}.")
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        if value not in arguments:
            raise ValueError(f"expected {' or '.join(map(str, arguments))} for {dotted}, got {value!r}")
        return value
    if origin is tuple:
        if not isinstance(value, list | tuple):
            raise ValueError(f"expected a list for {dotted}, got {value!r}")
        if arguments[-1] is Ellipsis:
            return tuple(_convert(arguments[0], item, dotted) for item in value)
        if len(value) != len(arguments):
            raise ValueError(f"expected {len(arguments)} values for {dotted}, got {len(value)}")
        return tuple(_convert(a, item, dotted) for a, item in zip(arguments, value, strict=True))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise ValueError(f"expected a table for {dotted}, got {value!r}")
        return {str(k): _convert(arguments[1], v, f"{dotted}.{k}") for k, v in value.items()}
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, hint) or (hint is not bool and isinstance(value, bool)):
        raise ValueError(f"expected {_WORDING[hint]} for {dotted}, got {value!r}")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"expected a finite number for {dotted}, got {value!r}")
    return value


_WORDING = {float: "a number", int: "a whole number", str: "a string", bool: "true or false"}
