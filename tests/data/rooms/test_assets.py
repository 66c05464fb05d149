"""The package of furniture: unpacked without root, read, and refused where it is something else."""

from __future__ import annotations

import io
import json
import lzma
import stat
import subprocess
import tarfile
import zipfile
from pathlib import Path

import pytest

from mixlight.blender.program import BlenderError
from mixlight.data.rooms import assets
from mixlight.data.rooms.assets import AssetsError, install, models_in, unpack
from mixlight.data.rooms.catalogue import KINDS, Catalogue

TABLE = """# A comment, \xa9
id=SweetHome3D#Test
id#1=Scopia#bed1
name#1=Bed
category#1=Bedroom
model#1=/scopia/bed1/bed1.obj
width#1=170.5
depth#1=216.5
height#1=110.8
dropOnTopElevation#1=55
creator#1=Scopia
id#2=Scopia#wall-flat-tv
name#2=Wall flat T\\u0056
model#2=/scopia/tv/tv.obj
width#2=102.8
depth#2=10.9
height#2=65.9
elevation#2=100
modelRotation#2=1 0 0 0 0 -1 0 1 0
creator#2=Scopia
id#3=Scopia#truck
name#3=Truck
model#3=/scopia/bed1/bed1.obj
width#3=272
depth#3=630
height#3=340
creator#3=Scopia
id#4=Scopia#technical_table
name#4=Gone
model#4=/scopia/gone/gone.obj
width#4=1
depth#4=1
height#4=1
creator#4=Scopia
"""

CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)) + (
    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
)


def collection(extra: dict[str, str] | None = None) -> bytes:
    """A .sh3f file with two models that are known, one that is not, and one whose file is missing."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("PluginFurnitureCatalog.properties", TABLE.encode("latin-1"))
        files = {"scopia/bed1/bed1.obj": CUBE, "scopia/tv/tv.obj": CUBE} | (extra or {})
        for name, text in files.items():
            archive.writestr(name, text)
    return data.getvalue()


def debian(sh3f: bytes, *, suffix: str = ".xz") -> bytes:
    """A .deb file: an ar archive of a version, a control archive and the files."""
    files = io.BytesIO()
    with tarfile.open(fileobj=files, mode="w") as archive:
        entry = tarfile.TarInfo("./usr/share/sweethome3d/furniture/Scopia.sh3f")
        entry.size = len(sh3f)
        archive.addfile(entry, io.BytesIO(sh3f))
    body = lzma.compress(files.getvalue()) if suffix == ".xz" else files.getvalue()
    packed = b"!<arch>\n"
    for name, data in (("debian-binary", b"2.0\n"), ("control.tar.xz", b"odd"), (f"data.tar{suffix}", body)):
        packed += f"{name:<16}{0:<12}{0:<6}{0:<6}{100644:<8}{len(data):<10}".encode() + b"`\n" + data
        packed += b"\n" * (len(data) % 2)
    return packed


@pytest.fixture
def package(tmp_path: Path) -> Path:
    path = tmp_path / "sweethome3d-furniture_1.8-1_all.deb"
    path.write_bytes(debian(collection()))
    return path


def test_a_package_is_unpacked_and_read(package: Path, tmp_path: Path) -> None:
    folder, version = unpack(package, tmp_path / "out")
    assert version == "1.8-1"
    tv, bed = sorted(models_in(folder), key=lambda model: model.kind, reverse=True)
    assert (bed.name, bed.kind, bed.size) == ("scopia-bed1", "bed", (1.705, 2.165, 1.108))
    assert bed.top is None  # nothing is put on a bed by its catalogue; our own rules know better
    assert (tv.title, tv.elevation) == ("Wall flat TV", 1.0)
    assert tv.rotation == (1, 0, 0, 0, 0, -1, 0, 1, 0)
    assert tv.licence == "CC-BY-3.0"
    assert bed.file.read_text() == CUBE


@pytest.mark.parametrize("suffix", [".xz", ""])
def test_packed_files_may_be_compressed_or_not(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / "a_2_all.deb"
    path.write_bytes(debian(collection(), suffix=suffix))
    assert len(models_in(unpack(path, tmp_path / "out")[0])) == 2


def test_a_folder_of_collections_will_do(tmp_path: Path) -> None:
    (tmp_path / "Scopia.sh3f").write_bytes(collection())
    assert len(models_in(unpack(tmp_path, tmp_path / "out")[0])) == 2


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "expected a Debian package"),
        (b"PK something", "expected a Debian package"),
        (b"!<arch>\n", "found none"),
        (debian(collection())[:-40], "damaged or cut short"),
        (debian(b"no zip file"), "damaged"),
        (debian(collection(), suffix=".zst"), r"expected data.tar.xz, received data.tar.zst"),
        (debian(collection({"../outside": "x"})), "expected paths inside"),
    ],
)
def test_what_is_no_such_package_is_refused(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "x.deb"
    path.write_bytes(data)
    with pytest.raises(AssetsError, match=words):
        unpack(path, tmp_path / "out")
    assert not (tmp_path / "outside").exists()


def test_a_package_without_furniture_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with pytest.raises(AssetsError, match="found none"):
        models_in(tmp_path / "out")
    with pytest.raises(AssetsError, match="no collection"):
        unpack(tmp_path, tmp_path / "out")


def test_every_known_model_is_of_a_known_kind() -> None:
    kinds = assets._kinds()
    assert len(kinds) > 400
    assert set(kinds.values()) <= KINDS.keys()


def fake_run(script: Path, arguments: list[Path], **_: object) -> str:
    """Does what Blender does, as far as the host sees it."""
    jobs, blend, report = arguments
    assert Path(script).name == "import_furniture.py"
    models = json.loads(Path(jobs).read_text())
    Path(blend).write_bytes(b"BLENDER")
    answers = {m["name"]: {"faces": 6, "materials": 1, "textured": False} for m in models}
    answers["scopia-wall-flat-tv"] = {"error": "ValueError: no faces"}
    Path(report).write_text(json.dumps(answers))
    return ""


def test_a_library_is_made_whole(package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assets, "run", fake_run)
    folder = tmp_path / "data" / "rooms"
    made = install(package, folder)
    assert made == Catalogue.load(folder)
    assert [entry.name for entry in made.entries] == ["scopia-bed1"]
    assert made.origin["left_out"] == {"scopia-wall-flat-tv": "ValueError: no faces"}
    assert "Bed, by Scopia" in (folder / "ATTRIBUTION.txt").read_text()


def test_a_failure_leaves_the_old_library(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assets, "run", fake_run)
    folder = tmp_path / "rooms"
    before = install(package, folder)

    def fail(*_: object, **__: object) -> str:
        raise BlenderError("crashed")

    monkeypatch.setattr(assets, "run", fail)
    with pytest.raises(BlenderError):
        install(package, folder)
    assert Catalogue.load(folder) == before
    assert {path.name for path in tmp_path.iterdir()} == {package.name, "rooms"}


def test_fetching_needs_apt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(AssetsError, match=r"expected apt-get.*--deb FILE"):
        assets.fetch(tmp_path)
    script = tmp_path / "apt-get"
    script.write_text("#!/bin/sh\necho 'E: no such package'\nexit 100\n")
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    with pytest.raises(AssetsError, match="E: no such package"):
        assets.fetch(tmp_path)
    script.write_text("#!/bin/sh\n: > sweethome3d-furniture_1.8-1_all.deb\n")
    assert assets.fetch(tmp_path).name == "sweethome3d-furniture_1.8-1_all.deb"


def test_our_packages_are_what_dpkg_takes_for_one(package: Path) -> None:
    """The stand-in of these tests is read by the real program, where there is one."""
    try:
        done = subprocess.run(["dpkg-deb", "--fsys-tarfile", package], capture_output=True, check=False)
    except FileNotFoundError:
        return
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
        assert archive.getnames() == ["./usr/share/sweethome3d/furniture/Scopia.sh3f"]
