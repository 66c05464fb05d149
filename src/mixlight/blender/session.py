"""One Blender for many jobs: it starts once, and takes a folder of work at a time.

Starting Blender takes a second or two; a session spares that for every job but the first.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from mixlight.blender import program

__all__ = ["ANSWER", "Session"]

ANSWER = "answer.json"
"""What the script leaves in a job's folder, made whole by a rename, when it is done with it."""

_SHORTEST, _LONGEST = 0.01, 0.25
_TAIL = 20_000


class Session:
    """A script inside Blender that reads names of folders from stdin, one a line, until stdin ends.

    It works each folder off and writes `ANSWER` there: a JSON object with `ok`, and `error` where that is
    false.

    Args:
        script: the Python file to run.
        arguments: texts for the script.
        blender: as for `mixlight.blender.program.run`.
        renew_after: jobs after which another Blender takes over, as its memory grows from job to job.
    """

    def __init__(
        self,
        script: str | os.PathLike[str],
        arguments: Sequence[str] = (),
        *,
        blender: str | os.PathLike[str] | None = None,
        renew_after: int = 50,
    ) -> None:
        self._script = Path(script).absolute()
        self._arguments = list(arguments)
        self._blender = blender
        self._renew_after = renew_after
        self._jobs = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._stopped = False
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the session

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def ask(self, folder: Path, timeout: float) -> dict[str, Any]:
        """Have one folder worked off; starts Blender where none runs (any more).

        Args:
            folder: the job, absolute.
            timeout: seconds for it; after them Blender is killed, and the next call starts another.

        Returns:
            The script's answer, which may hold `ok: false`.

        Raises:
            BlenderMissing: no Blender.
            BlenderError: Blender ended or was killed during the job; the message ends with its last lines.
                The next call starts another.
            BlenderTimeout: it ran out of time.
        """
        process = self._running()
        answer = folder / ANSWER
        begun = time.monotonic()
        try:
            assert process.stdin is not None
            process.stdin.write(f"{folder}\n".encode())
            process.stdin.flush()
            while not answer.exists():
                ended = process.poll() is not None
                if ended and not answer.exists():  # it may have answered with its last breath
                    raise program.failure(process.returncode, self._script, self._output())
                taken = time.monotonic() - begun
                if not ended and taken > timeout:
                    late = f"{self._script.name} in Blender: expected an end within {timeout:g} s, got none"
                    raise program.BlenderTimeout(program.with_last_lines(late, self._output()))
                time.sleep(min(max(_SHORTEST, taken / 50), _LONGEST))  # 2 % late, and hardly ever awake
        except BrokenPipeError:
            process.wait()
            raise program.failure(process.returncode, self._script, self._output()) from None
        except BaseException:
            self._kill()
            raise
        found = json.loads(answer.read_text(encoding="utf-8"))
        assert isinstance(found, dict)
        return found

    def stop(self) -> None:
        """End Blender for good, from any thread; an `ask` under way then fails with a `BlenderError`."""
        with self._lock:
            self._stopped = True
            if self._process is not None:
                program.end(self._process)

    def close(self) -> None:
        """End Blender; what it was doing is lost."""
        self.stop()
        self._kill()
        self._log.close()

    def _running(self) -> subprocess.Popen[bytes]:
        worn = self._jobs >= self._renew_after
        if self._process is None or self._process.poll() is not None or worn:
            self._kill()
            self._jobs = 0
            self._log.truncate(0)
            self._log.seek(0)
            with self._lock:  # a `stop` comes before the start, and prevents it, or after it, and ends it
                if self._stopped:
                    raise program.BlenderError(f"{self._script.name} in Blender: the session is over")
                self._process = program.start(
                    self._script,
                    self._arguments,
                    blender=self._blender,
                    stdin=subprocess.PIPE,
                    stdout=self._log,
                )
        self._jobs += 1
        return self._process

    def _kill(self) -> None:
        if self._process is not None:
            program.end(self._process)
            self._process.wait()
            assert self._process.stdin is not None
            with contextlib.suppress(BrokenPipeError):
                self._process.stdin.close()
            self._process = None

    def _output(self) -> str:
        """The end of what Blender has said, which may be long after many jobs."""
        size = self._log.seek(0, os.SEEK_END)
        self._log.seek(max(0, size - _TAIL))
        text = program.decoded(self._log.read())
        self._log.seek(0, os.SEEK_END)
        return text
