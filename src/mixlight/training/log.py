"""The run's log: one JSON object a line, always; TensorBoard where it is asked for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mixlight.image.atomic import atomic_path

FILE_NAME = "log.jsonl"


class RunLog:
    """Appends records, each with a `step`; numbers also go to TensorBoard if wanted."""

    def __init__(self, out: Path, tensorboard: bool = False) -> None:
        """Opens the log in a folder.

        Raises:
            ImportError: TensorBoard is asked for and not installed.
        """
        self.path = out / FILE_NAME
        self._writer: Any = None
        if tensorboard:
            try:
                from torch.utils.tensorboard import SummaryWriter
            except ImportError as error:
                raise ImportError('tensorboard = true needs `pip install "mixlight[tensorboard]"`') from error
            self._writer = SummaryWriter(str(out / "tensorboard"))  # type: ignore[no-untyped-call]

    def cut(self, step: int) -> None:
        """Drops records after a step (of a run that was killed past its last checkpoint)."""
        if not self.path.is_file():
            return
        kept = [line for line in self.path.read_text("utf-8").splitlines() if _step_of(line) <= step]
        with atomic_path(self.path) as temporary:
            Path(temporary).write_text("".join(f"{line}\n" for line in kept), "utf-8")

    def write(self, record: dict[str, Any]) -> None:
        """Appends one record."""
        with self.path.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(record) + "\n")
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
    except (ValueError, KeyError):
        return float("inf")
