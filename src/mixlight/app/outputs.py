"""The files of one result, all or none: a folder is built under a hidden name and renamed when complete."""

import contextlib
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, UInt8
from torch import Tensor

from mixlight import __version__
from mixlight.image import exr, ldr, radiance
from mixlight.image.atomic import atomic_folder
from mixlight.light import document
from mixlight.light.lighting import Lighting

__all__ = ["FILES", "replaced_folder", "write_result"]

FILES = ("environment.exr", "environment.hdr", "lighting.json", "preview.png", "fit.json")
"""The names that belong to us: a new result replaces them, and leaves all other files of the folder alone."""


@contextlib.contextmanager
def replaced_folder(folder: Path) -> Iterator[Path]:
    """Gives a hidden new folder that becomes `folder` when the block ends (`mixlight.image.atomic`); files of
    an older one that are not ours (see `FILES`) are carried over, whatever they are.

    Raises:
        OSError: the folder's parent cannot be written to, or `folder` is a file.
    """
    with atomic_folder(folder, FILES) as fresh:
        yield fresh


def write_result(
    folder: Path,
    lighting: Lighting,
    environment: Float[Tensor, "height width 3"],
    preview: UInt8[np.ndarray, "rows columns 3"] | None,
    *,
    photo: Mapping[str, Any] | None = None,
    model: Mapping[str, Any] | None = None,
    reports: Mapping[str, Mapping[str, Any]] | None = None,
    detail: str | None = None,
    also: Callable[[Path], None] | None = None,
) -> None:
    """Write `environment.exr`, `environment.hdr`, `lighting.json`, `preview.png` and what else is given, all
    or none.

    Args:
        folder: where the files go; its parent exists.
        lighting: the light, as `lighting.json` holds it.
        environment: linear Rec.709 radiance of `lighting` in its frame.
        preview: 8-bit sRGB picture, where there is one.
        photo: what `lighting.json` says of the photo.
        model: the model's card; its name goes into the maps' headers.
        reports: name of a further JSON file -> what it holds.
        detail: what the maps hold beyond `lighting`, for their headers; None: nothing, and they can be made
            again from it.
        also: writes further files into the folder that it is given.

    Raises:
        ValueError: the light cannot be written (NaN, for instance), or `also` fails.
        OSError: the disk refuses.
    """
    texels = environment.detach().cpu().float().numpy()
    light = document.to_document(
        lighting, None if photo is None else dict(photo), None if model is None else dict(model)
    )
    header: dict[str, str | float] = {
        "software": f"mixlight {__version__}",
        "frame": lighting.frame,
        "exposure_gain": float(lighting.exposure_gain),
        "model": str((model or {}).get("name", "none")),
    }
    if detail is not None:
        header["detail"] = detail
    with replaced_folder(folder) as fresh:
        exr.write(fresh / "environment.exr", texels, dict(header))
        radiance.write(
            fresh / "environment.hdr", texels, {key.upper(): str(value) for key, value in header.items()}
        )
        document.save(light, fresh / "lighting.json")
        if preview is not None:
            ldr.write_png(fresh / "preview.png", preview)
        for file_name, report in (reports or {}).items():
            text = json.dumps(report, indent=2, allow_nan=False)
            (fresh / file_name).write_text(text + "\n", encoding="utf-8")
        if also is not None:
            also(fresh)
