"""The training run: resumable at any step, the same result as if it had never been interrupted."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset
from tqdm import tqdm

from mixlight.data.labels import default_cache
from mixlight.data.panoramas import PanoramaRecord, read_table, select
from mixlight.data.training_set import Batch, TrainingSet
from mixlight.light.separate import luminance
from mixlight.loss.total import TotalLoss
from mixlight.network import weights
from mixlight.network.model import MixLightNet, mean_linear_colour
from mixlight.training import checkpoint as checkpoints
from mixlight.training.config import TrainingConfig, to_plain
from mixlight.training.log import RunLog
from mixlight.training.schedule import freeze, make_optimiser, rate_share, set_rate, set_training_mode
from mixlight.training.validation import ValidationSet

_MEAN_BATCHES = 4
MODEL_FILE = "model.safetensors"


class _Steps(Dataset[Batch]):
    """Batches by step number, for a loader process."""

    def __init__(self, training_set: TrainingSet, seed: int, size: int) -> None:
        self.training_set, self.seed, self.size = training_set, seed, size

    def __getitem__(self, step: int) -> Batch:
        return self.training_set.batch(self.seed, step, self.size)


def train(config: TrainingConfig, out: Path, *, resume: bool = True, cache: Path | None = None) -> Path:
    """Trains a network and writes `model.safetensors`, `log.jsonl`, `config.json` and a checkpoint to `out`.

    A run that was killed goes on from its last checkpoint; batches and dropout depend on the seed and the
    step alone, so on a CPU in float32 it ends with the weights of an unbroken run.

    Returns the path of the model: the averaged weights with the best validation score, in float16.

    Raises:
        ValueError: bad tables, or an `out` that holds a run with another config.
        FileNotFoundError: a table or a panorama is missing.
    """
    return Run(config, out, resume=resume, cache=cache).finish()


class Run:
    """One training run."""

    def __init__(self, config: TrainingConfig, out: Path, *, resume: bool, cache: Path | None) -> None:
        self.config, self.out = config, out
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        records = [record for table in config.tables for record in read_table(table)]
        canonical = config.model.canonical
        self.training_set = TrainingSet(
            select(records, "train"),
            canonical,
            config.labels,
            cache or default_cache(),
            config.crops,
            config.camera,
            config.sampling,
        )
        self.validation = ValidationSet(_validation_records(records), canonical, config.validation_rooms)
        with torch.random.fork_rng():
            torch.manual_seed(config.seed)
            self.model = MixLightNet(config.model, pretrained=True)
        freeze(self.model, config.optimiser)
        self._start_from_mean()
        self.model.to(self.device)
        self.average = {k: v.detach().clone() for k, v in self.model.state_dict().items()}
        self.best: dict[str, Tensor] = {}
        self.best_metrics: dict[str, float] = {}
        self.optimiser = make_optimiser(self.model, config.optimiser)
        self.loss = TotalLoss(config.loss, config.model.anchors, config.model.sharpness).to(self.device)
        self.step = 0
        out.mkdir(parents=True, exist_ok=True)
        self.log = RunLog(out, tensorboard=config.tensorboard)
        if resume and (out / checkpoints.FILE_NAME).is_file():
            self._restore(checkpoints.load(out / checkpoints.FILE_NAME))
        self.log.cut(self.step)
        (out / "config.json").write_text(json.dumps(to_plain(config), indent=2) + "\n", encoding="utf-8")

    def finish(self) -> Path:
        """Runs the remaining steps and writes the model."""
        config = self.config
        progress = tqdm(
            total=config.steps, initial=self.step, unit="step", disable=None, desc=config.name, leave=True
        )
        started = time.monotonic()
        for batch in self._batches():
            terms = self._train_step(batch)
            self.step += 1
            last = self.step == config.steps
            if self.step % 10 == 0 or last:
                pace = (time.monotonic() - started) / 10
                self.log.write({"step": self.step, "kind": "train", "seconds": round(pace, 3), **terms})
                started = time.monotonic()
            progress.set_postfix(loss=f"{terms['loss']:.3f}", refresh=False)
            progress.update()
            if self.step % config.validate_every == 0 or last:
                self._validate()
            if self.step % config.checkpoint_every == 0 or last:
                self._save_checkpoint()
        progress.close()
        self.log.close()
        return self._save_model()

    def _batches(self) -> Iterator[Batch]:
        config = self.config
        steps = range(self.step, config.steps)
        dataset = _Steps(self.training_set, config.seed, config.batch_size)
        loader = DataLoader(
            dataset,
            batch_size=None,
            sampler=steps,
            num_workers=config.workers,
            prefetch_factor=4 if config.workers else None,
            multiprocessing_context="fork" if config.workers else None,
        )
        return iter(loader)

    def _train_step(self, batch: Batch) -> dict[str, float]:
        config = self.config
        set_training_mode(self.model, config.optimiser)
        set_rate(self.optimiser, rate_share(self.step, config.steps, config.optimiser))
        with torch.random.fork_rng():
            torch.manual_seed(config.seed * 1_000_003 + self.step)
            photo = batch.photo.to(self.device)
            with torch.autocast(self.device.type, torch.bfloat16, enabled=config.precision == "bfloat16"):
                prediction, mean = self.model.relative(photo)
        prediction = prediction.scaled(mean)
        loss, terms = self.loss(
            prediction.scores,
            prediction.distribution,
            prediction.intensity,
            prediction.colour,
            prediction.ambient,
            prediction.camera,
            batch.anchor_energy.to(self.device),
            batch.ambient.to(self.device),
            batch.small_map.to(self.device),
            batch.camera.to(self.device),
        )
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()
        norm = torch.nn.utils.clip_grad_norm_(self.model.parameters(), config.optimiser.clip_norm)
        if bool(norm.isfinite()):
            self.optimiser.step()
        self._update_average()
        values = {"loss": loss.detach(), "gradient": norm, **terms}
        return {name: round(float(value), 5) for name, value in values.items()}

    @torch.no_grad()
    def _update_average(self) -> None:
        # Bias-corrected at the start: the first steps average over what there is.
        decay = min(self.config.optimiser.ema_decay, (1 + self.step) / (10 + self.step))
        for key, value in self.model.state_dict().items():
            if value.dtype.is_floating_point:
                self.average[key].lerp_(value, 1 - decay)
            else:
                self.average[key].copy_(value)

    def _validate(self) -> None:
        trained = {k: v.detach().clone() for k, v in self.model.state_dict().items()}
        self.model.load_state_dict(self.average)
        metrics = self.validation.evaluate(self.model.cpu())
        self.model.to(self.device).load_state_dict(trained)
        self.log.write(
            {"step": self.step, "kind": "validation", **{k: round(v, 5) for k, v in metrics.items()}}
        )
        if not self.best or metrics["score"] < self.best_metrics["score"]:
            self.best = {k: v.detach().clone() for k, v in self.average.items()}
            self.best_metrics = {**metrics, "step": float(self.step)}

    def _start_from_mean(self) -> None:
        """Sets the output biases to the mean photo-relative light of a few training batches."""
        energy, ambient, poses = [], [], []
        for k in range(_MEAN_BATCHES):
            batch = self.training_set.batch(self.config.seed, -1 - k + 2**31, self.config.batch_size)
            mean = mean_linear_colour(batch.photo)[:, None]
            energy.append(batch.anchor_energy / mean)
            ambient.append(batch.ambient / mean)
            poses.append(batch.camera)
        sources, rest = torch.cat(energy), torch.cat(ambient)
        share = luminance(sources)
        share = share / share.sum(-1, keepdim=True).clamp(min=1e-9)
        total = sources.sum(1).clamp(min=1e-6)
        base = rest[:, 0].clamp(min=1e-4).log().mean(0).exp()
        shape = (rest[:, 1:] / rest[:, :1].clamp(min=1e-4)).mean(0) * base
        self.model.heads.start_from(
            share.mean(0),
            float(total.norm(dim=-1).log().mean()),
            total.log().mean(0) - total.log().mean(),
            torch.cat([base[None], shape]),
            torch.cat(poses).mean(0),
        )

    def _restore(self, saved: checkpoints.Checkpoint) -> None:
        if saved.notes["config"] != json.loads(json.dumps(to_plain(self.config))):
            raise ValueError(
                f"{self.out}: holds a run with another config; choose another folder or remove its checkpoint"
            )
        self.step = saved.step
        self.model.load_state_dict(saved.model)
        self.average = {k: v.to(self.device) for k, v in saved.average.items()}
        self.best = {k: v.to(self.device) for k, v in saved.best.items()}
        self.best_metrics = saved.notes["best_metrics"]
        checkpoints.restore_optimiser(self.optimiser, saved.optimiser)

    def _save_checkpoint(self) -> None:
        checkpoints.save(
            self.out / checkpoints.FILE_NAME,
            checkpoints.Checkpoint(
                self.step,
                self.model.state_dict(),
                self.average,
                self.best,
                checkpoints.flatten_optimiser(self.optimiser),
                {"config": to_plain(self.config), "best_metrics": self.best_metrics},
            ),
        )

    def _save_model(self) -> Path:
        state = {k: v.half() if v.dtype.is_floating_point else v for k, v in self.best.items()}
        path = self.out / MODEL_FILE
        weights.save(path, state, make_card(self.config, self.training_set, self.best_metrics))
        return path


def make_card(
    config: TrainingConfig, training_set: TrainingSet, metrics: dict[str, float]
) -> dict[str, Any]:
    """The card that travels inside the weights: what they are, and what they were made from."""
    plain = to_plain(config)
    plain["tables"] = [Path(table).name for table in config.tables]
    return {
        "kind": "mixlight",
        "name": config.name,
        "settings": config.model.to_card(),
        "frame": "mixlight: +X right, +Y up, -Z forward; the photo's azimuth is the map's centre",
        "units": "radiance 1.0 is the photo's linear white",
        "config": plain,
        "commit": _commit(),
        "data": {
            "tables": plain["tables"],
            "panoramas": len(training_set.records),
            "by_category": _counts(record.category for record in training_set.records),
        },
        "validation": metrics,
        "torch": torch.__version__,
        "licence": "Apache-2.0; backbone initialised from EfficientNet-Lite0 (Apache-2.0, ImageNet)",
    }


def _counts(names: Iterator[str]) -> dict[str, int]:
    counts: dict[str, int] = {}
    for name in names:
        counts[name] = counts.get(name, 0) + 1
    return counts


def _commit() -> str:
    """The commit of the source tree that trains, or `unknown` outside a checkout."""
    here = Path(__file__).parent
    try:
        found = subprocess.run(
            ["git", "describe", "--always", "--dirty"], cwd=here, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return found.stdout.strip()


def _validation_records(records: list[PanoramaRecord]) -> list[PanoramaRecord]:
    return select(records, "val")
