"""Blender as a separate program: find it, hand it a script, and tell what went wrong in its own words.

Blender's Python module is compiled for one Python and one NumPy, so it is never imported here: scripts run in
a virtual environment of their own that holds PyPI's `bpy`, or in an installed Blender.
"""

import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import IO

__all__ = [
    "VARIABLE",
    "BlenderError",
    "BlenderMissing",
    "BlenderTimeout",
    "find_blender",
    "install_command",
    "run",
]

VARIABLE = "MIXLIGHT_BLENDER_PYTHON"
"""Environment variable that names the Python with `bpy`, or a Blender program."""

_RELEASE = "5.0.1"
_LAST_LINES = 12
_BOOTSTRAP = """
import os, runpy, sys
runpy.run_path(sys.argv[1], run_name="__main__")
sys.stdout.flush()
sys.stderr.flush()
os._exit(0)
"""
"""Ends a script that has done its work without taking `bpy` down, which in some releases crashes."""


class BlenderError(RuntimeError):
    """A script failed inside Blender; the message ends with Blender's own last lines."""


class BlenderTimeout(BlenderError):
    """A script took longer than it had; Blender was killed."""


class BlenderMissing(BlenderError):
    """No Blender was found; the message says how to get one."""


def install_command() -> str:
    """The shell command that puts Blender where `find_blender` looks.

    >>> print(install_command().replace(str(_home()), "HOME"))
    python3.11 -m venv HOME && HOME/bin/python -m pip install "bpy==5.0.1" "numpy<2"
    """
    home = _home()
    return f'python3.11 -m venv {home} && {home}/bin/python -m pip install "bpy=={_RELEASE}" "numpy<2"'


def find_blender() -> Path:
    """The Python that can `import bpy`, or the Blender program, that `run` starts.

    It is ``$MIXLIGHT_BLENDER_PYTHON``, else ``mixlight/blender/bin/python`` in ``$XDG_DATA_HOME`` (by default
    ``~/.local/share``). That it works shows when it runs.

    Raises:
        BlenderMissing: there is no such program; the message holds the command that installs it.
    """
    named = os.environ.get(VARIABLE)
    path = Path(named).expanduser() if named else _home() / "bin" / "python"
    if path.is_file() and os.access(path, os.X_OK):
        return path.absolute()  # not resolved: a virtual environment is known by its link
    found = f"{VARIABLE} names {path}, which is no program" if named else f"{path} does not exist"
    raise BlenderMissing(
        f"expected Blender, received none ({found}). Blender needs an environment of its own:\n"
        f"  {install_command()}\n"
        f"or set {VARIABLE} to a Python that can import bpy, or to a Blender program"
    )


def run(
    script: str | os.PathLike[str],
    arguments: Sequence[str | os.PathLike[str]] = (),
    *,
    timeout: float,
    blender: str | os.PathLike[str] | None = None,
    cwd: str | os.PathLike[str] | None = None,
) -> str:
    """Run a script inside Blender, without a window and without the user's settings, and return its output.

    The script finds its arguments behind ``--``, in every kind of Blender::

        arguments = sys.argv[sys.argv.index("--") + 1 :]

    It hands results over in files, and fails by raising (or by a non-zero `sys.exit`).

    Args:
        script: the Python file to run.
        arguments: texts and paths for the script.
        timeout: seconds after which Blender, with everything it started, is killed.
        blender: a Python with `bpy` or a Blender program (its file name starts with "blender"); what
            `find_blender` finds if not given.
        cwd: folder to run in.

    Returns:
        What Blender wrote to stdout and stderr, in their order. It is chatty: do not parse it for results.

    Raises:
        BlenderMissing: no Blender.
        BlenderError: the script raised, exited with another status than 0 or crashed; the message ends with
            Blender's last lines.
        BlenderTimeout: it ran out of time.
        OSError: the script cannot be read.
    """
    path = Path(script).absolute()
    process = start(
        path, arguments, blender=blender, cwd=cwd, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE
    )
    try:
        raw, _ = process.communicate(timeout=timeout)
    except BaseException as error:
        end(process)
        raw, _ = process.communicate()
        if isinstance(error, subprocess.TimeoutExpired):
            late = f"{path.name} in Blender: expected an end within {timeout:g} s, received none"
            raise BlenderTimeout(with_last_lines(late, decoded(raw))) from None
        raise
    output = decoded(raw)
    if process.returncode:
        raise failure(process.returncode, path, output)
    return output


def start(
    script: Path,
    arguments: Sequence[str | os.PathLike[str]],
    *,
    stdin: int,
    stdout: int | IO[bytes],
    blender: str | os.PathLike[str] | None = None,
    cwd: str | os.PathLike[str] | None = None,
) -> subprocess.Popen[bytes]:
    """Start a script inside Blender, in a process group of its own; stderr goes where stdout does.

    Raises:
        BlenderMissing: no Blender.
        OSError: the script cannot be read.
    """
    with script.open("rb"):  # Blender itself goes on without a script that is missing
        pass
    program = find_blender() if blender is None else Path(blender).absolute()
    try:
        return subprocess.Popen(
            [str(program), *_options(program), str(script), "--", *(os.fspath(a) for a in arguments)],
            stdin=stdin,
            stdout=stdout,
            stderr=subprocess.STDOUT,
            cwd=cwd,
            start_new_session=True,  # so that a timeout ends its children too
        )
    except OSError as error:
        raise BlenderMissing(
            f"expected a program that runs, received {program}: {error.strerror or error}"
        ) from None


def failure(code: int, script: Path, output: str) -> BlenderError:
    """The error for a Blender that ended by itself, from its exit status and what it said."""
    if "No module named 'bpy'" in output:
        return BlenderMissing("expected a Python that can import bpy, received one that cannot")
    return BlenderError(with_last_lines(f"{script.name} in Blender: {status(code)}", output))


def _home() -> Path:
    data = os.environ.get("XDG_DATA_HOME", "")
    # The XDG rules say to ignore what is not absolute.
    base = Path(data) if os.path.isabs(data) else Path.home() / ".local" / "share"
    return base / "mixlight" / "blender"


def _options(program: Path) -> list[str]:
    if program.name.lower().startswith("blender"):
        # The exit status counts only for scripts that stand behind it.
        return ["--background", "--factory-startup", "--python-exit-code", "1", "--python"]
    # -I: neither PYTHONPATH nor the current folder may put our own NumPy in the way.
    # -u: what the script printed stands before the traceback that ended it.
    return ["-I", "-u", "-c", _BOOTSTRAP]


def status(code: int) -> str:
    if code > 0:
        return f"exit status {code}"
    try:
        return f"ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"ended by signal {-code}"


def decoded(raw: bytes) -> str:
    return raw.decode("utf-8", errors="replace")


def with_last_lines(message: str, output: str) -> str:
    lines = [line.rstrip() for line in output.splitlines() if line.strip()]
    return "\n".join([message, *(f"  {line}" for line in lines[-_LAST_LINES:])])


def end(process: subprocess.Popen[bytes]) -> None:
    """Kill the process and whatever it started."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    except AttributeError:  # Windows has no process groups
        process.kill()
