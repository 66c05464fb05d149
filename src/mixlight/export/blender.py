"""Blender: a script that builds world and Suns from `rig.json` and `environment.exr`, and the extension.

Native, and not through glTF, since Blender's glTF importer divides the strength of directional lights by 683
unless told otherwise, and knows no map.
"""

import io
import zipfile
from importlib.resources import files
from pathlib import Path

from mixlight.export.maps import write_exr
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.image.atomic import atomic_path
from mixlight.light.document import dumps

__all__ = ["EXTENSION_NAME", "SCRIPT_NAME", "extension_zip", "write", "write_extension"]

SCRIPT_NAME = "open_in_blender.py"
"""The script in the written folder."""

EXTENSION_NAME = "mixlight_blender_extension.zip"
"""The extension in the written folder; the same for every light."""

_FILES = (
    "blender_manifest.toml",
    "__init__.py",
    "documents.py",
    "operators.py",
    "panel.py",
    "properties.py",
    "scene.py",
    "synthesis.py",
)
_HOW = (
    f"Run `blender --python {SCRIPT_NAME}` here, or install {EXTENSION_NAME} (Preferences > Get Extensions > "
    "Install from Disk) and load rig.json in the sidebar (N) of the 3D view, tab MixLight."
)
_CHECKED = (
    "Checked in Blender 4.5.15 and 5.0.1 (Cycles), made for 4.2 LTS to 5.x; radiance 1 is the photo's white "
    "under the view transform Standard."
)


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `README.txt`, `open_in_blender.py`, `rig.json`, `environment.exr` and the extension.

    Args:
        rig: the light.
        folder: an existing folder.

    Returns:
        The files.

    Convention: `rig.json` is in Blender's axes (our right, ahead, up are its +X, +Y, +Z) and the map's
        columns are rolled left by a quarter of the width, so that an Environment Texture shows it the right
        way round as it is. A light of irradiance E becomes a Sun of strength max(E) and colour E / max(E).

    Raises:
        OSError: the disk refuses.

    >>> import tempfile, torch
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), torch.eye(128)[:, :3]), height=16)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in write(rig, Path(folder))]  # doctest: +NORMALIZE_WHITESPACE
    ['README.txt', 'open_in_blender.py', 'rig.json', 'environment.exr', 'mixlight_blender_extension.zip']
    """
    readme = write_readme(folder, rig, _HOW, _CHECKED)
    script = folder / SCRIPT_NAME
    script.write_bytes(_source("scene.py"))
    document = folder / "rig.json"
    document.write_text(dumps(rig.document("blender")), encoding="utf-8")
    panorama = folder / "environment.exr"
    write_exr(panorama, rig, "blender")
    extension = folder / EXTENSION_NAME
    extension.write_bytes(extension_zip())
    return [readme, script, document, panorama, extension]


def extension_zip() -> bytes:
    """The extension for Blender 4.2 LTS to 5.x, as "Install from Disk" takes it; the same bytes every time.

    >>> zipfile.ZipFile(io.BytesIO(extension_zip())).namelist()[0]
    'blender_manifest.toml'
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in _FILES:
            entry = zipfile.ZipInfo(name)  # of 1980, as every time: equal content makes equal bytes
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, _source(name))
    return buffer.getvalue()


def write_extension(path: Path) -> None:
    """Write the extension alone, as a zip file that appears whole or not at all.

    Raises:
        OSError: the file cannot be made.
    """
    with atomic_path(path) as temporary:
        temporary.write_bytes(extension_zip())


def _source(name: str) -> bytes:
    return files("mixlight.export").joinpath("blender_extension", name).read_bytes()
