"""The training run: resumable at any step, the same result as if it had never been interrupted."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import torch
from torch import Tensor
from tqdm import tqdm

from mixlight.data.labels import default_cache
from mixlight.data.panoramas import PanoramaRecord, check_split, read_table, select
from mixlight.data.training_set import Batch, TrainingSet
from mixlight.image.atomic import atomic_path
from mixlight.light.separate import luminance
from mixlight.network import weights
from mixlight.network.methods import AnyNet, create
from mixlight.network.model import mean_linear_colour
from mixlight.training import checkpoint as checkpoints
from mixlight.training.average import follow
from mixlight.training.camera import fit_camera
from mixlight.training.card import commit, make_card, versions
from mixlight.training.config import WORDS, OptimiserSettings, TrainingConfig, differences, to_plain
from mixlight.training.features import FeatureBank, FeatureBatch, cached_bank
from mixlight.training.log import RunLog
from mixlight.training.members import prepare, train_members
from mixlight.training.objective import Truth, make_objective, truth_of
from mixlight.training.schedule import freeze, make_optimiser, rate_share, set_rate, set_training_mode
from mixlight.training.stream import stream
from mixlight.training.validation import ValidationSet

MODEL_FILE = "model.safetensors"
CONFIG_FILE = "config.json"

_FROZEN = OptimiserSettings(frozen_share=1.0)

_MEAN_BATCHES = 4
"""Batches whose mean light an untrained network predicts."""

_LOG_EVERY = 10

_MOST_SKIPPED = 20
"""Steps in a row whose gradient may be infinite or NaN before the run is given up."""


def train(config: TrainingConfig, out: Path, *, resume: bool = True, cache: Path | None = None) -> Path:
    """Trains a network and writes `model.safetensors`, `log.jsonl`, `config.json` and a checkpoint to a
    folder.

    A run that was stopped or killed goes on from its last checkpoint. Batches and dropout depend on the seed
    and the step alone, so on a CPU, in float32 and with the same number of threads, it ends with the very
    weights of an unbroken run.

    Args:
        config: what to train, and on what.
        out: the folder of the run; made if it is missing.
        resume: go on from a checkpoint in `out`; else start anew and drop it.
        cache: where labels are kept between runs; the user's cache folder if not given.

    Returns:
        The path of the model: the averaged weights with the best validation score, in float16; of a config
        with several `members` the mean of theirs.

    Raises:
        ValueError: bad tables, panoramas or backbone weights; or `out` holds a run with another config or
            other panoramas, or a single run where members are asked for, or the reverse.
        FloatingPointError: the gradient or the validation score is not finite: training has diverged.
        OSError: a file is missing or cannot be read, or `out` cannot be written.
        ImportError: `tensorboard = true`, and it is not installed.
    """
    prepare(out, resume, single=config.members == 1)
    if config.members == 1:
        return Run(config, out, resume=resume, cache=cache).finish()

    def start(member: TrainingConfig, folder: Path, validation: ValidationSet | None) -> Run:
        return Run(member, folder, resume=True, cache=cache, validation=validation)

    return train_members(config, out, start)


class Run:
    """One training run; see `train`."""

    def __init__(
        self,
        config: TrainingConfig,
        out: Path,
        *,
        resume: bool,
        cache: Path | None,
        validation: ValidationSet | None = None,
    ) -> None:
        if config.members != 1:
            raise ValueError(f"expected a config of one member for one run, got members = {config.members}")
        self.config, self.out = config, out
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        out.mkdir(parents=True, exist_ok=True)
        # A run that cannot go on says so before minutes of loading.
        saved = self._saved() if resume else None
        records = [record for table in config.tables for record in read_table(table)]
        check_split(records)  # across the tables, too
        self.validation = validation or ValidationSet(
            select(records, "val"), config.model.canonical, config.validation_rooms
        )
        listed = [(r.scene, r.category, r.split) for r in records if r.split != "test"]
        self.data = hashlib.sha256(repr(listed).encode()).hexdigest()
        self.model = self._make_model()
        freeze(self.model, config.optimiser if not config.frozen_views else _FROZEN)
        self.model.to(self.device)
        self.training_set = self._make_views(select(records, "train"), cache or default_cache())
        self.optimiser = make_optimiser(self.model, config.optimiser)
        self.objective = make_objective(config).to(self.device)
        self.step = 0
        self.skipped = 0
        self.best: dict[str, Tensor] = {}
        self.best_metrics: dict[str, float] = {}
        if saved is None:
            if not config.model_weights:
                self._start_from_mean()
            self.average = {k: v.detach().clone() for k, v in self.model.state_dict().items()}
            self._checkpoint.unlink(missing_ok=True)
        else:
            self._restore(saved)
        checkpoints.remove_leftovers(self._checkpoint)
        self.log = RunLog(out, self.step, config.tensorboard)
        self.log.write({"step": self.step, "kind": "start", "commit": commit(), **versions()})
        self.write_config()

    def finish(self) -> Path:
        """Runs the remaining steps and writes the model."""
        config = self.config
        progress = tqdm(
            total=config.steps, initial=self.step, unit="step", disable=None, desc=config.name, leave=True
        )
        with contextlib.closing(self.log), progress:
            started, logged = time.monotonic(), self.step
            for batch in self._batches():
                terms = self.train_step(batch)
                self.step += 1
                last = self.step == config.steps
                if self.step % _LOG_EVERY == 0 or last:
                    pace = (time.monotonic() - started) / (self.step - logged)
                    self.log.write({"step": self.step, "kind": "train", "seconds": round(pace, 3), **terms})
                    started, logged = time.monotonic(), self.step
                progress.set_postfix(loss=f"{terms['loss']:.3f}", refresh=False)
                progress.update()
                if self.step % config.validate_every == 0 or last:
                    paused = time.monotonic()
                    self._validate()
                    started += time.monotonic() - paused
                if self.step % config.checkpoint_every == 0 or last:
                    self._save_checkpoint()
        return self.write(self.best, self.best_metrics, {})

    def write_config(self) -> None:
        """Writes the config, defaults included, beside the model."""
        with atomic_path(self.out / CONFIG_FILE) as temporary:
            temporary.write_text(json.dumps(to_plain(self.config), indent=2) + "\n", encoding="utf-8")

    def write(
        self, state: Mapping[str, Tensor], metrics: Mapping[str, float], more: Mapping[str, object]
    ) -> Path:
        """Writes weights as the model of the run, with a camera that is fitted to them if the config says so.

        Args:
            state: the weights.
            metrics: what they are on val.
            more: what else the card says.
        """
        config, path = self.config, self.out / MODEL_FILE
        if config.camera_views:
            self.model.load_state_dict(state)
            fit_camera(self.model, self._batches_aside(-(-config.camera_views // config.batch_size)))
            state = self.model.state_dict()
        card = make_card(config, self.training_set.records, metrics)
        weights.save(path, state, {**card, **more}, half=True)
        return path

    @property
    def _checkpoint(self) -> Path:
        return self.out / checkpoints.FILE_NAME

    def _batches(self) -> Iterator[Batch | FeatureBatch]:
        config = self.config
        steps = range(self.step, config.steps)
        return stream(self.training_set, config.views_seed, config.batch_size, steps, config.workers)

    @contextlib.contextmanager
    def _seeded(self, seed: int) -> Iterator[None]:
        """Chance from a seed alone; the caller's generators stay as they were."""
        with torch.random.fork_rng([self.device] if self.device.type == "cuda" else []):
            torch.manual_seed(seed)
            yield

    def _make_model(self) -> AnyNet:
        config, start = self.config, self.config.backbone_weights
        with self._seeded(config.seed):
            model = create(config.model, pretrained=start == "imagenet")
        if config.model_weights:
            whole = weights.find(config.model_weights)
            weights.load_into(model, weights.load(whole)[0], whole)
        elif start not in WORDS:
            weights.load_into(model.backbone, weights.load(start)[0], start)
        return model

    def _make_views(self, records: Sequence[PanoramaRecord], cache: Path) -> TrainingSet | FeatureBank:
        """Views of the training panoramas, as photos or as features of a frozen backbone."""
        config = self.config

        def make() -> TrainingSet:
            canonical = config.model.canonical
            return TrainingSet(
                records, canonical, config.labels, cache, config.crops, config.camera, config.sampling
            )

        if not config.frozen_views:
            return make()
        return cached_bank(config, records, self.model.backbone, make, cache)

    def train_step(self, batch: Batch | FeatureBatch) -> dict[str, float]:
        """Does one optimiser step on a batch; returns the loss and its terms (the caller counts the step)."""
        config = self.config
        set_training_mode(self.model, config.optimiser)
        set_rate(self.optimiser, rate_share(self.step, config.steps, config.optimiser))
        half = torch.autocast(self.device.type, torch.bfloat16, enabled=config.precision == "bfloat16")
        with self._seeded(config.views_seed * 1_000_003 + self.step), half:
            if isinstance(batch, FeatureBatch):
                mean = batch.mean.to(self.device)
                prediction = self.model.heads(batch.features.to(self.device), mean)
            else:
                prediction, mean = self.model.relative(batch.photo.to(self.device))
        loss, terms = self.objective(
            prediction.scaled(mean),
            truth_of(batch).to(self.device),
            luminance(mean) if config.unit == "photo" else None,
            self.step / config.steps,
        )
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        norm = torch.nn.utils.clip_grad_norm_(self.model.parameters(), config.optimiser.clip_norm)
        if math.isfinite(float(norm)):
            self.optimiser.step()
            self.skipped = 0
        else:
            self._skip(float(loss.detach()))
        follow(self._moving(), self.model.state_dict(), config.optimiser.ema_decay, self.step)
        values = {"loss": loss.detach(), "gradient": norm, **terms}
        numbers = torch.stack([value.float() for value in values.values()]).tolist()
        return {name: round(number, 5) for name, number in zip(values, numbers, strict=True)}

    def _skip(self, loss: float) -> None:
        """Leaves out a step whose gradient is not finite, in sight of the log; many in a row end the run."""
        self.skipped += 1
        self.log.write({"step": self.step + 1, "kind": "skipped", "loss": loss})
        if self.skipped == _MOST_SKIPPED:
            raise FloatingPointError(
                f"{self.out}: expected finite gradients, got none in {_MOST_SKIPPED} steps up to "
                f"{self.step + 1}; a lower learning_rate may help"
            )

    def _moving(self) -> dict[str, Tensor]:
        """The averaged weights that training can change."""
        frozen = self.config.frozen_views > 0
        return {k: v for k, v in self.average.items() if not (frozen and k.startswith("backbone."))}

    def _validate(self) -> None:
        trained = {k: v.detach().clone() for k, v in self.model.state_dict().items()}
        self.model.load_state_dict(self.average)
        metrics = self.validation.evaluate(self.model)
        self.model.load_state_dict(trained)
        self.log.write(
            {"step": self.step, "kind": "validation", **{k: round(v, 5) for k, v in metrics.items()}}
        )
        if not math.isfinite(metrics["score"]):
            raise FloatingPointError(
                f"{self.out}: expected a finite validation score, got {metrics['score']} at step {self.step}"
            )
        if not self.best or metrics["score"] < self.best_metrics["score"]:
            self.best = {k: v.detach().clone() for k, v in self.average.items()}
            self.best_metrics = {**metrics, "step": float(self.step)}

    def _start_from_mean(self) -> None:
        """Sets the output biases to the mean photo-relative light of a few training batches."""
        truths, means = [], []
        for batch in self._batches_aside(_MEAN_BATCHES):
            means.append(batch.mean if isinstance(batch, FeatureBatch) else mean_linear_colour(batch.photo))
            truths.append(truth_of(batch))
        together = Truth.joined(truths)
        self.objective.start(self.model, together.scaled(1 / torch.cat(means)))

    def _batches_aside(self, count: int) -> Iterator[Batch | FeatureBatch]:
        """Batches of steps far beyond the run's own."""
        for k in range(count):
            yield self.training_set.batch(self.config.seed, 2**31 - 1 - k, self.config.batch_size)

    def _saved(self) -> checkpoints.Checkpoint | None:
        """The checkpoint to go on from, if there is one."""
        if not self._checkpoint.is_file():
            return None
        saved = checkpoints.load(self._checkpoint)
        if not {"config", "best_metrics"} <= saved.notes.keys():
            raise ValueError(f"{self._checkpoint}: expected a checkpoint of a training run, got another")
        changed = differences(saved.notes["config"], self.config)
        if changed:
            raise ValueError(
                f"{self.out}: holds a run with another config ({'; '.join(changed)}); choose another folder, "
                "or start anew (--fresh)"
            )
        return saved

    def _restore(self, saved: checkpoints.Checkpoint) -> None:
        if saved.notes.get("data", self.data) != self.data:
            raise ValueError(
                f"{self.out}: holds a run on other panoramas than the tables list now; choose another "
                "folder, or start anew (--fresh)"
            )
        self.step = saved.step
        self.model.load_state_dict(saved.model)
        # In the weights' own order in memory: arithmetic on mixed orders takes other paths, which may round
        # otherwise.
        self.average = {
            k: torch.empty_like(v).copy_(saved.average[k]) for k, v in self.model.state_dict().items()
        }
        self.best = {k: v.to(self.device) for k, v in saved.best.items()}
        self.best_metrics = saved.notes["best_metrics"]
        checkpoints.restore_optimiser(self.optimiser, saved.optimiser)

    def _save_checkpoint(self) -> None:
        checkpoints.save(
            self._checkpoint,
            checkpoints.Checkpoint(
                self.step,
                self.model.state_dict(),
                self.average,
                self.best,
                checkpoints.flatten_optimiser(self.optimiser),
                {
                    "config": to_plain(self.config),
                    "data": self.data,
                    "best_metrics": self.best_metrics,
                },
            ),
        )
