"""(e) A whole training step against the bare backbone's forward and backward on the same batch.

The step holds the heads, every loss with the rendered spheres, clipping, the optimiser and the moving
average.
Batches come from loader processes in training and are not part of either side. Views have the size that the
model in the box was trained on.
"""

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.timing import Result, side_by_side
from mixlight.data.training_set import Batch
from mixlight.image import radiance
from mixlight.network.estimator import Estimator
from mixlight.training.config import read_config
from mixlight.training.loop import Run
from mixlight.training.schedule import set_training_mode

SIZE = 32


def measure() -> Result:
    generator = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = ["scene,file,split,category"]
        for split in ("train", "val"):
            radiance.write(
                folder / f"{split}.hdr", generator.lognormal(-1, 1, (64, 128, 3)).astype(np.float32)
            )
            rows.append(f"{split},{split}.hdr,{split},indoor")
        (folder / "table.csv").write_text("\n".join(rows) + "\n")
        shipped = Estimator.load().model.settings
        (folder / "config.toml").write_text(
            f'tables = ["table.csv"]\nbatch_size = {SIZE}\n'
            f"[model]\nheight = {shipped.height}\nwidth = {shipped.width}\n"
        )
        run = Run(read_config(folder / "config.toml"), folder / "run", resume=False, cache=folder)
        batch = run.training_set.batch(0, 0, SIZE)
        assert isinstance(batch, Batch)  # as the config freezes nothing
        backbone = run.model.backbone

        def bare() -> None:
            set_training_mode(run.model, run.config.optimiser)
            backbone(batch.photo).mean().backward()
            run.optimiser.zero_grad(set_to_none=True)

        return side_by_side(
            "e",
            1.15,
            (
                f"training step, {SIZE} views of {shipped.height}x{shipped.width}",
                lambda: run.train_step(batch),
            ),
            ("backbone forward and backward", bare),
            rounds=21,
        )
