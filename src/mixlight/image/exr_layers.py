"""OpenEXR pictures of several layers in 32-bit floats, for compositing programs.

A layer's channels are named `layer.R`, `layer.G`, ... as Nuke, Blender and Natron expect. Values may be
negative here, and the data may fill only a part of the picture.
"""

import os
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from mixlight.image._array import Array
from mixlight.image.atomic import atomic_path
from mixlight.image.color import REC709

__all__ = ["write"]

_NAMES = {1: "Y", 3: "RGB", 4: "RGBA"}


def write(
    path: str | os.PathLike[str],
    layers: Mapping[str, Float[Array, "rows columns channels"]],
    *,
    size: tuple[int, int] | None = None,
    offset: tuple[int, int] = (0, 0),
    attributes: Mapping[str, str | int | float] | None = None,
) -> None:
    """Writes layers of linear Rec.709, ZIP compressed, atomically.

    Args:
        path: the file to make.
        layers: name -> one (Y), three (RGB) or four (RGBA) channels, all of one size; the name "" stands for
            the picture itself.
        size: width and height of the whole picture (the display window); by default the layers'.
        offset: column and row of the whole picture at which the layers begin (the data window).
        attributes: further header entries.

    Raises:
        ValueError: no layers, layers of several sizes, or values that are not finite.
        OSError: the file cannot be made.

    >>> import tempfile, OpenEXR
    >>> shadow = np.full((2, 4, 3), -0.5, np.float32)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write(folder + "/a.exr", {"shadow": shadow}, size=(8, 8), offset=(2, 3))
    ...     file = OpenEXR.File(folder + "/a.exr", separate_channels=True)
    >>> sorted(file.channels()), float(file.channels()["shadow.R"].pixels[0, 0])
    (['shadow.B', 'shadow.G', 'shadow.R'], -0.5)
    """
    import OpenEXR

    shapes = {values.shape[:2] for values in layers.values()}
    if len(shapes) != 1 or any(
        v.ndim != 3 or v.shape[2] not in _NAMES or 0 in v.shape for v in layers.values()
    ):
        received = {name: list(values.shape) for name, values in layers.items()}
        raise ValueError(
            f"{path}: expected layers [rows, columns, 1, 3 or 4] of one size, received {received}"
        )
    ((rows, columns),) = shapes
    width, height = (columns, rows) if size is None else size
    channels = {}
    for layer, values in layers.items():
        if not np.isfinite(values).all():
            raise ValueError(
                f"{path}: expected finite values in the layer {layer!r}, received NaN or infinity"
            )
        for index, letter in enumerate(_NAMES[values.shape[2]]):
            name = f"{layer}.{letter}" if layer else letter
            channels[name] = np.ascontiguousarray(values[..., index], dtype=np.float32)
    first = np.array(offset, np.int32)
    header = dict(attributes or {}) | {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC709,
        "dataWindow": (first, first + np.array([columns - 1, rows - 1], np.int32)),
        "displayWindow": (np.zeros(2, np.int32), np.array([width - 1, height - 1], np.int32)),
    }
    with atomic_path(path) as temporary:
        try:
            OpenEXR.File(header, channels).write(str(temporary))
        except RuntimeError as error:
            reason = str(error).replace(str(temporary), str(path))
            raise OSError(f"{path}: expected to write an OpenEXR file, received: {reason}") from None
