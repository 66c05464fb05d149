"""Unity: a map, lights and `SphericalHarmonicsL2` in Unity's axes, and a menu entry that sets a scene up."""

from importlib.resources import files
from pathlib import Path

from mixlight.export.engine import engine_document, read_engine
from mixlight.export.maps import write_exr, write_hdr
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light.document import dumps

__all__ = ["FILE", "SCRIPT", "read", "write"]

FILE = "unity.json"
SCRIPT = "MixLightImport.cs"


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `unity.json`, `environment.hdr`, `environment.exr`, `Editor/MixLightImport.cs` and `README.txt`.

    Convention: Unity's axes (x, y, -z). `harmonics.*.coefficients` fill `sh[channel, 0..8]` as
        `coefficients[9 * channel + index]`. A directional light of intensity 1 in the built-in and the
        universal pipeline shows a white matte surface as 1, so its colour times intensity is irradiance over
        pi.

    Raises:
        OSError: a file cannot be made.
    """
    (folder / "Editor").mkdir()
    names = (FILE, "environment.hdr", "environment.exr", f"Editor/{SCRIPT}")
    paths = [folder / name for name in names]
    paths[0].write_text(dumps(engine_document(rig, "unity")), encoding="utf-8")
    write_hdr(paths[1], rig, "unity")
    write_exr(paths[2], rig, "unity")
    source = files("mixlight.export").joinpath("unity_files", SCRIPT)
    paths[3].write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    readme = write_readme(
        folder,
        rig,
        "Copy this folder into Assets of a project in linear colour space (Unity 2021.3 or newer, built-in "
        f"or universal pipeline) and choose GameObject > Light > MixLight..., then {FILE}.",
        "Derived from Unity's documentation and shaders and never run in Unity: load the calibration card "
        "first, where yellow (-Z there) must lie ahead along Unity's +Z and red at the right.",
    )
    return [*paths, readme]


def read(folder: Path) -> Rig:
    """Read back what `write` has made (`mixlight.export.engine.read_engine`)."""
    return read_engine(folder, "unity")
