"""The run's log: one JSON object a line, always; TensorBoard where it is asked for."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from mixlight.image.atomic import atomic_path

FILE_NAME = "log.jsonl"


class RunLog:
    """Appends records, each with a `step` and a `kind`; numbers also go to TensorBoard if wanted."""

    def __init__(self, out: Path, step: int = 0, tensorboard: bool = False) -> None:
        """Opens the log in a folder, and drops what was written after a step.

        A run that was killed past its last checkpoint has logged steps that it will do again.

        Args:
            out: the run's folder, which exists.
            step: the step from which the run goes on; with 0 an old log is emptied.
            tensorboard: also write TensorBoard events.

        Raises:
            ImportError: TensorBoard is asked for and not installed.
            OSError: the log cannot be written.
        """
        self.path = out / FILE_NAME
        self._writer: Any = None
        if tensorboard:
            try:
                from torch.utils.tensorboard import SummaryWriter
            except ImportError as error:
                raise ImportError('tensorboard = true needs `pip install "mixlight[tensorboard]"`') from error
            self._writer = SummaryWriter(str(out / "tensorboard"), purge_step=step + 1)
        if self.path.is_file():
            lines = self.path.read_text("utf-8", errors="replace").splitlines() if step else []
            kept = [line for line in lines if _step_of(line) <= step]
            with atomic_path(self.path) as temporary:
                temporary.write_text("".join(f"{line}\n" for line in kept), "utf-8")

    def write(self, record: dict[str, Any]) -> None:
        """Appends one record; JSON has no word for NaN and infinity, which become null.

        Raises:
            OSError: the log cannot be written.
        """
        finite = {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in record.items()
        }
        with self.path.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(finite, allow_nan=False) + "\n")
        if self._writer is not None:
            for name, value in record.items():
                if name != "step" and isinstance(value, int | float):
                    self._writer.add_scalar(f"{record['kind']}/{name}", value, record["step"])

    def close(self) -> None:
        """Flushes and closes TensorBoard's file."""
        if self._writer is not None:
            self._writer.close()


def _step_of(line: str) -> float:
    """The step of a line; a half-written last line counts as after everything."""
    try:
        return float(json.loads(line)["step"])
    except (ValueError, KeyError, TypeError):
        return float("inf")
