"""Furniture from Debian's package sweethome3d-furniture: fetched, converted, catalogued.

The package holds OBJ models with their sizes and makers, under CC0 and CC BY. Which of them are furniture of
a room, and of which kind, stands in sweethome3d.csv.
"""

from __future__ import annotations

import csv
import io
import json
import lzma
import os
import re
import shutil
import subprocess
import tarfile
import tempfile
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import resources
from pathlib import Path, PurePosixPath
from typing import Any

from mixlight.blender.program import run
from mixlight.data.rooms.attribution import attribution
from mixlight.data.rooms.catalogue import KINDS, Catalogue, Entry, library_folder
from mixlight.image.atomic import atomic_folder

__all__ = ["PACKAGE", "AssetsError", "Model", "fetch", "install", "models_in", "unpack"]

PACKAGE = "sweethome3d-furniture"
"""Name of the Debian package."""

_INSTALLED = Path("/usr/share/sweethome3d/furniture")
"""Where the package lies if the system has it."""

_OURS = ("furniture.blend", "catalogue.json", "ATTRIBUTION.txt")
"""The library's files."""

_LICENCES = {
    "KatorLegaz": "CC-BY-3.0-US",
    "Reallusion": "CC-BY-3.0-US",
    "Scopia": "CC-BY-3.0",
    "BlendSwap-CC-BY": "CC-BY-3.0",
    "BlendSwap-CC-0": "CC0-1.0",
}
"""Of each collection in the package, as its copyright file says."""


class AssetsError(ValueError):
    """The package cannot be had, or is not what was expected."""


@dataclass(frozen=True)
class Model:
    """One model of the package that becomes furniture."""

    name: str
    """In the library: letters, digits, dots and dashes."""
    kind: str
    file: Path
    size: tuple[float, float, float]
    """Width, depth, height in metres."""
    rotation: tuple[float, ...] | None
    """3 x 3, row by row, in the model's own axes (+Y up)."""
    top: float | None
    elevation: float | None
    title: str
    creator: str
    licence: str
    source: str


def fetch(folder: Path) -> Path:
    """Download the package into a folder with apt-get, without root, and return its path.

    Raises:
        AssetsError: no apt-get, or it failed.
    """
    advice = f"download Debian's package {PACKAGE} and name it: mixlight rooms assets --deb FILE"
    if shutil.which("apt-get") is None:
        raise AssetsError(f"expected apt-get to fetch {PACKAGE}, received no such program; {advice}")
    done = subprocess.run(
        ["apt-get", "download", PACKAGE],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    found = sorted(folder.glob(f"{PACKAGE}_*.deb"))
    if done.returncode != 0 or not found:
        last = done.stdout.strip().splitlines()[-1:] or ["it said nothing"]
        raise AssetsError(f"apt-get download {PACKAGE} failed: {last[0]}; {advice}")
    return found[-1]


def unpack(package: Path, folder: Path) -> tuple[Path, str]:
    """Unpack the collections of a .deb file (or a folder with .sh3f files) into a folder.

    Returns:
        The folder, with one sub-folder for each collection, and the package's version.

    Raises:
        AssetsError: it is no such package.
    """
    if package.is_dir():
        archives = {path.stem: path.read_bytes() for path in sorted(package.glob("*.sh3f"))}
        version = "installed"
    else:
        archives = dict(_collections(package))
        version = [*package.stem.split("_"), "unknown"][1]
    if not archives:
        raise AssetsError(f"{package}: expected Debian's {PACKAGE}, found no collection of furniture in it")
    for name, data in archives.items():
        try:
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                _extract(archive, folder / name)
        except zipfile.BadZipFile as error:
            raise AssetsError(f"{package}: damaged: {name}: {error}") from None
    return folder, version


def _extract(archive: zipfile.ZipFile, folder: Path) -> None:
    for entry in archive.infolist():
        path = PurePosixPath(entry.filename)
        if path.is_absolute() or ".." in path.parts:
            raise AssetsError(f"expected paths inside {folder.name}, received {entry.filename!r}")
        archive.extract(entry, folder)


def _collections(package: Path) -> Iterator[tuple[str, bytes]]:
    """The .sh3f files of a .deb file: an ar archive with a tar archive in it."""
    with tarfile.open(fileobj=io.BytesIO(_member(package, "data.tar")), mode="r:") as archive:
        for entry in archive:
            path = PurePosixPath(entry.name)
            if entry.isfile() and path.suffix == ".sh3f":
                file = archive.extractfile(entry)
                if file is not None:
                    yield path.stem, file.read()


def _member(package: Path, wanted: str) -> bytes:
    data = package.read_bytes()
    if not data.startswith(b"!<arch>\n"):
        raise AssetsError(f"{package}: expected a Debian package, received something else")
    at = 8
    while at + 60 <= len(data):
        name = data[at : at + 16].decode("ascii", "replace").strip().rstrip("/")
        try:
            size = int(data[at + 48 : at + 58])
        except ValueError:
            break
        body = data[at + 60 : at + 60 + size]
        if len(body) != size:
            break
        if name == wanted:
            return body
        if name == f"{wanted}.xz":
            try:
                return lzma.decompress(body)
            except lzma.LZMAError as error:
                raise AssetsError(f"{package}: damaged: {error}") from None
        if name.startswith(wanted):
            raise AssetsError(
                f"{package}: expected {wanted}.xz, received {name}: unpack it and name the folder"
            )
        at += 60 + size + size % 2
    raise AssetsError(f"{package}: expected {wanted}.xz in it, found none: the file is damaged or cut short")


def models_in(folder: Path) -> list[Model]:
    """The models of the unpacked collections that are furniture, in the order of their names.

    Raises:
        AssetsError: none is there.
    """
    kinds = _kinds()
    found = []
    for collection in sorted(path for path in folder.iterdir() if path.is_dir()):
        table = collection / "PluginFurnitureCatalog.properties"
        if not table.is_file():
            continue
        for entry in _properties(table.read_text(encoding="latin-1")):
            kind = kinds.get(entry.get("id", ""))
            file = collection / entry.get("model", "").lstrip("/")
            if kind is not None and file.is_file():
                found.append(_model(entry, kind, file, collection.name))
    if not found:
        raise AssetsError(f"expected the furniture of {PACKAGE}, found none that is known")
    return sorted(found, key=lambda model: model.name)


def _model(entry: dict[str, str], kind: str, file: Path, collection: str) -> Model:
    width, depth, height = (round(float(entry[key]) / 100, 4) for key in ("width", "depth", "height"))
    top = float(entry.get("dropOnTopElevation", -1)) / 100
    elevation = float(entry.get("elevation", 0)) / 100
    rotation = entry.get("modelRotation")
    return Model(
        name=re.sub(r"[^a-z0-9]+", "-", entry["id"].lower().replace("#", ".."), flags=re.ASCII).strip("-"),
        kind=kind,
        file=file,
        size=(width, depth, height),
        rotation=None if rotation is None else tuple(float(value) for value in rotation.split()),
        top=round(top, 4) if KINDS[kind].carries and 0 < top < height - 0.01 else None,
        elevation=round(elevation, 4) if elevation > 0 else None,
        title=entry["name"],
        creator=entry.get("creator", ""),
        licence=_LICENCES.get(collection, "CC-BY-3.0"),
        source=f"{PACKAGE}, {collection}",
    )


def _properties(text: str) -> list[dict[str, str]]:
    """The numbered entries of a table: `key#7=value`, with Java's escapes."""
    entries: dict[int, dict[str, str]] = {}
    for line in text.splitlines():
        match = re.match(r"(\w+)#(\d+)=(.*)", line.strip())
        if match:
            key, number, value = match.groups()
            value = re.sub(r"\\u([0-9a-fA-F]{4})", lambda m: chr(int(m[1], 16)), value)
            entries.setdefault(int(number), {})[key] = value.strip()
    return [entries[number] for number in sorted(entries)]


def _kinds() -> dict[str, str]:
    """Which kind each known model is."""
    table = resources.files("mixlight.data.rooms").joinpath("sweethome3d.csv").read_text(encoding="utf-8")
    return {row["id"]: row["kind"] for row in csv.DictReader(io.StringIO(table))}


def install(
    package: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    *,
    blender: str | os.PathLike[str] | None = None,
    timeout: float = 3600.0,
    more: Callable[[Path], list[Model]] | None = None,
) -> Catalogue:
    """Make the library: a .blend file, its catalogue and ATTRIBUTION.txt, in the user's data folder.

    A library that is there already is replaced when the new one is whole, never before.

    Args:
        package: the .deb file, or a folder with its .sh3f files; the system's, else fetched,
            if not given.
        folder: where to put the library; `library_folder` if not given.
        blender: which Blender converts; the one that `find_blender` finds if not given.
        timeout: seconds that Blender may take; it takes about two minutes.
        more: makes further models, with their files in the folder that it is given.

    Raises:
        AssetsError: the package cannot be had or read, or Blender made nothing of it.
        BlenderError: no Blender, or it failed.
        OSError: a file cannot be read or written.
    """
    target = library_folder() if folder is None else Path(folder)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="mixlight-") as name:
        work = Path(name)
        if package is not None:
            source = Path(package)
        else:
            source = _INSTALLED if any(_INSTALLED.glob("*.sh3f")) else fetch(work)
        unpacked, version = unpack(source, work / "unpacked")
        models = models_in(unpacked)
        with atomic_folder(target, ours=_OURS) as made:
            further = more(work) if more is not None else []
            catalogue = _convert([*models, *further], made, work, version, blender, timeout)
    return Catalogue(target / catalogue.blend.name, catalogue.entries, catalogue.origin)


def _convert(
    models: list[Model],
    folder: Path,
    work: Path,
    version: str,
    blender: str | os.PathLike[str] | None,
    timeout: float,
) -> Catalogue:
    jobs, report = work / "models.json", work / "report.json"
    jobs.write_text(
        json.dumps(
            [{"name": m.name, "file": str(m.file), "size": m.size, "rotation": m.rotation} for m in models]
        ),
        encoding="utf-8",
    )
    blend = folder / "furniture.blend"
    script = resources.files("mixlight.data.rooms").joinpath("cycles", "import_furniture.py")
    with resources.as_file(script) as path:
        run(path, [jobs, blend, report], timeout=timeout, blender=blender)
    answers = json.loads(report.read_text(encoding="utf-8"))
    entries = tuple(
        Entry(
            name=m.name,
            kind=m.kind,
            size=m.size,
            top=m.top,
            elevation=m.elevation,
            textured=answers[m.name]["textured"],
            faces=answers[m.name]["faces"],
            title=m.title,
            creator=m.creator,
            licence=m.licence,
            source=m.source,
        )
        for m in models
        if "error" not in answers[m.name]
    )
    if not entries:
        raise AssetsError("Blender could read none of the models")
    left = {m.name: answers[m.name]["error"] for m in models if "error" in answers[m.name]}
    origin: dict[str, Any] = {"package": PACKAGE, "version": version, "left_out": left}
    others = Counter(entry.source for entry in entries if not entry.source.startswith(PACKAGE))
    if others:
        origin["others"] = dict(others)
    catalogue = Catalogue(blend, entries, origin)
    catalogue.save(folder)
    (folder / "ATTRIBUTION.txt").write_text(attribution(entries), encoding="utf-8")
    return catalogue
