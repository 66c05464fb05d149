"""What is installed around MixLight: packages, extras, other programs, and how to get what is missing."""

import importlib
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Literal

__all__ = ["Check", "Requirement", "extras", "packages", "parse", "programs", "requirements", "satisfies"]

State = Literal["ok", "missing", "broken"]

_MODULES = {"openexr": "OpenEXR", "opencv-python-headless": "cv2", "pillow": "PIL"}
"""Modules that are not called as their package is."""

_CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
_LISTED = 8
"""Packages of an extra that are named; those of the developers' extras are too many."""

_PATIENCE = 60.0
"""Seconds that a program has to tell its version."""


@dataclass(frozen=True)
class Check:
    """One thing that was looked at."""

    group: Literal["core", "weights", "extra", "program"]
    name: str
    state: State
    detail: str
    """Version and place, or what is wrong, in one line."""
    command: str | None = None
    """What to type to mend it."""

    @property
    def fatal(self) -> bool:
        """Whether MixLight itself does not work: extras and other programs are never that."""
        return self.state != "ok" and self.group in ("core", "weights")

    def as_json(self) -> dict[str, Any]:
        """As `mixlight doctor --json` shows it."""
        return {key: value for key, value in asdict(self).items() if value is not None}


@dataclass(frozen=True)
class Requirement:
    """One line of a package's requirements."""

    name: str
    specifier: str
    """Comparisons with versions, such as `>=2.11,<2.14`; empty: any version."""
    wants: tuple[str, ...] = ()
    """Extras of that package."""
    extra: str | None = None
    """The extra of ours that it belongs to; None: always needed."""


def parse(line: str) -> Requirement:
    """A requirement as package metadata writes it.

    Raises:
        ValueError: the line is none.

    >>> parse('onnx>=1.18; extra == "onnx"')
    Requirement(name='onnx', specifier='>=1.18', wants=(), extra='onnx')
    """
    match = re.fullmatch(
        r"\s*([\w.-]+)\s*(?:\[([\w\s,.-]*)\])?\s*((?:[<>=!~(][^;]*?)?)\s*(?:;\s*(.*))?", line
    )
    if match is None:
        raise ValueError(f"expected a requirement, received {line!r}")
    name, wants, specifier, marker = match.groups()
    extra = re.search(r"""extra\s*==\s*["']([\w.-]+)["']""", marker or "")
    inner = tuple(part.strip() for part in (wants or "").split(",") if part.strip())
    return Requirement(name, specifier.strip("() "), inner, extra[1] if extra else None)


def satisfies(version: str, specifier: str) -> bool:
    """Whether a version meets comparisons, by the numbers of its release alone.

    Raises:
        ValueError: a comparison that is not one of >=, >, <=, <, ==, !=, ~=.

    >>> satisfies("2.13.0+cpu", ">=2.11,<2.14"), satisfies("2.9.1", ">=2.11")
    (True, False)
    """
    have = _release(version)
    for part in filter(None, (piece.strip() for piece in specifier.split(","))):
        match = re.fullmatch(r"(>=|<=|==|!=|~=|>|<)\s*([\w.+!*-]+)", part)
        if match is None:
            raise ValueError(f"expected a comparison with a version, received {part!r}")
        sign, bound = match[1], _release(match[2])
        some = have[: len(bound)] + (0,) * (len(bound) - len(have))
        size = max(len(have), len(bound))
        mine, other = (v + (0,) * (size - len(v)) for v in (have, bound))
        if match[2].endswith(".*"):  # compared as far as it is written
            mine, other = some, bound
        fits = {
            ">=": mine >= other,
            ">": mine > other,
            "<=": mine <= other,
            "<": mine < other,
            "==": mine == other,
            "!=": mine != other,
            "~=": mine >= other and some[:-1] == bound[:-1],
        }[sign]
        if not fits:
            return False
    return True


def requirements() -> list[Requirement]:
    """What the installed package says that it needs.

    Raises:
        metadata.PackageNotFoundError: MixLight runs from its source folder without being installed.
    """
    return [parse(line) for line in metadata.requires("mixlight") or ()]


def packages(wanted: Iterable[Requirement]) -> Iterator[Check]:
    """Each package that MixLight cannot do without: is it there, new enough, and can it be imported?"""
    for need in wanted:
        if need.extra is not None:
            continue
        command = f'pip install "{need.name}{need.specifier}"'
        version = _version(need.name)
        if version is None:
            yield Check("core", need.name, "missing", f"expected {need.specifier or 'any version'}", command)
        elif not satisfies(version, need.specifier):
            yield Check("core", need.name, "broken", f"{version}, expected {need.specifier}", command)
        else:
            problem = _import_problem(_MODULES.get(need.name.lower(), need.name))
            detail = f"{version}, which cannot be imported: {problem}" if problem else version
            yield Check(
                "core",
                need.name,
                "broken" if problem else "ok",
                detail,
                f'pip install --force-reinstall "{need.name}=={version}"' if problem else None,
            )


def extras(wanted: Iterable[Requirement]) -> Iterator[Check]:
    """Each extra: are its packages installed? They are not imported, as some take seconds."""
    groups: dict[str, list[Requirement]] = {}
    for need in wanted:
        if need.extra is not None:
            groups.setdefault(need.extra, []).append(need)
    for extra in sorted(groups):
        found, lacking = [], []
        for need in sorted(_members(extra, groups), key=lambda need: need.name.lower()):
            version = _version(need.name)
            if version is None:
                lacking.append(need.name)
            elif not satisfies(version, need.specifier):
                lacking.append(f"{need.name}{need.specifier} (found {version})")
            else:
                found.append(f"{need.name} {version}")
        if lacking:
            yield Check(
                "extra", extra, "missing", f"without {', '.join(lacking)}", f'pip install "mixlight[{extra}]"'
            )
        else:
            detail = ", ".join(found) if len(found) <= _LISTED else f"all {len(found)} packages"
            yield Check("extra", extra, "ok", detail)


def programs() -> Iterator[Check]:
    """Programs that some targets and tests start: Blender, Node.js, Chromium."""
    yield _blender()
    yield _program("Node.js", ("node",), "apt-get install nodejs npm")
    yield _program("Chromium", _CHROMIUM, "apt-get install chromium", variable="MIXLIGHT_CHROMIUM")


def _blender() -> Check:
    from mixlight.blender.program import BlenderError, BlenderMissing, find_blender, install_command, run

    command = install_command()
    try:
        path = find_blender()
    except BlenderMissing as error:
        detail = _first_line(str(error)).partition(". ")[0]  # the command follows
        return Check("program", "Blender", "missing", detail, command)
    script = "import sys, bpy\nopen(sys.argv[-1], 'w').write(bpy.app.version_string)\n"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "version.py").write_text(script, encoding="utf-8")
        try:
            run(folder / "version.py", [folder / "version.txt"], timeout=_PATIENCE, blender=path)
            version = (folder / "version.txt").read_text(encoding="utf-8").strip()
        except (BlenderError, OSError) as error:
            return Check("program", "Blender", "broken", f"{path}: {_first_line(str(error))}", command)
    return Check("program", "Blender", "ok", f"{version}, {path}")


def _program(name: str, names: tuple[str, ...], command: str, *, variable: str | None = None) -> Check:
    """Looks for a program under the names that it goes by, or under the one that a variable gives."""
    given = os.environ.get(variable) if variable else None
    path = next(filter(None, map(shutil.which, (given,) if given else names)), None)
    if path is None:
        where = f"{variable} names {given}, which is no program" if given else f"no {names[0]} on the PATH"
        return Check("program", name, "missing", where, command)
    try:
        done = subprocess.run(
            [path, "--version"], capture_output=True, text=True, timeout=_PATIENCE, check=False
        )
        said, problem = done.stdout, done.returncode and f"ends with status {done.returncode}"
    except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError) as error:
        said, problem = "", _first_line(str(error))
    if problem:
        return Check("program", name, "broken", f"{path} --version: {problem}", command)
    version = re.search(r"\d+(\.\d+)+", said)
    return Check("program", name, "ok", f"{version[0] if version else 'version unknown'}, {path}")


def _members(extra: str, groups: Mapping[str, list[Requirement]]) -> set[Requirement]:
    """The packages of an extra, those of the extras that it names included."""
    found: set[Requirement] = set()
    seen: set[str] = set()
    waiting = [extra]
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        for need in groups.get(name, ()):
            if need.name.lower() == "mixlight":
                waiting += need.wants
            else:
                found.add(need)
    return found


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _import_problem(module: str) -> str | None:
    try:
        importlib.import_module(module)
    except Exception as error:  # a broken package may raise anything: that is what is looked for
        return _first_line(f"{type(error).__name__}: {error}")
    return None


def _release(version: str) -> tuple[int, ...]:
    match = re.match(r"v?(?:\d+!)?(\d+(?:\.\d+)*)", version)
    return tuple(int(part) for part in match[1].split(".")) if match else ()


def _first_line(text: str) -> str:
    line = next((line.strip() for line in text.splitlines() if line.strip()), "")
    return line if len(line) <= 200 else f"{line[:199]}…"
