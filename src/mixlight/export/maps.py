"""Map files for consumers: pixels rolled for their frame, and the frame in the file's header."""

import os

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight import __version__
from mixlight.export.rig import Rig
from mixlight.image import exr, radiance
from mixlight.sphere import equirect
from mixlight.sphere.frames import FRAMES, convert_panorama

__all__ = ["read_map", "write_exr", "write_hdr"]


def write_exr(path: str | os.PathLike[str], rig: Rig, frame: str) -> None:
    """Write the rig's map as OpenEXR in the frame of a consumer (`mixlight.image.exr.write`).

    The header says `software`, `frame`, `map` ("residual" or "full") and `exposure_gain`.

    Convention: the columns are rolled, so that the consumer's own loader shows the map the right way round.

    Raises:
        ValueError: unknown frame.
        OSError: the file cannot be made.
    """
    pixels = convert_panorama(rig.environment, "mixlight", frame).numpy()
    exr.write(
        path,
        pixels,
        {
            "software": f"mixlight {__version__}",
            "frame": frame,
            "map": rig.map_kind,
            "exposure_gain": float(rig.exposure_gain),
        },
    )


def write_hdr(path: str | os.PathLike[str], rig: Rig, frame: str) -> None:
    """Write the rig's map as Radiance in the frame of a consumer (`mixlight.image.radiance.write`).

    The header says `SOFTWARE`, `FRAME`, `MAP` ("residual" or "full") and `EXPOSURE_GAIN`.

    Convention: the columns are rolled, so that the consumer's own loader shows the map the right way round.

    Raises:
        ValueError: unknown frame.
        OSError: the file cannot be made.
    """
    pixels = convert_panorama(rig.environment, "mixlight", frame).numpy()
    radiance.write(
        path,
        pixels,
        {
            "SOFTWARE": f"mixlight {__version__}",
            "FRAME": frame,
            "MAP": rig.map_kind,
            "EXPOSURE_GAIN": repr(float(rig.exposure_gain)),
        },
    )


def read_map(path: str | os.PathLike[str]) -> tuple[Float[Tensor, "height width 3"], dict[str, str]]:
    """Read a map that `write_exr` or `write_hdr` has made, turned back into our frame.

    Returns:
        The panorama, and the header's words in lower case: `frame`, `map`, `exposure_gain`, ...

    Raises:
        ValueError: not such a file, or one without a frame of ours in its header.
        OSError: the file cannot be read.

    >>> import tempfile
    >>> from mixlight.sphere import calibration_card
    >>> card = calibration_card(16)
    >>> rig = Rig(card, (), False, torch.zeros(9, 3), torch.zeros(9, 3))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_exr(f"{folder}/map.exr", rig, "blender")
    ...     environment, header = read_map(f"{folder}/map.exr")
    >>> header["frame"], header["map"], round(float((environment - card).abs().max()), 3)
    ('blender', 'full', 0.001)
    """
    with open(path, "rb") as file:
        is_exr = file.read(4) == b"\x76\x2f\x31\x01"
    if is_exr:
        pixels, attributes = exr.read(path)
        header = {key.lower(): str(value) for key, value in attributes.items()}
    else:
        pixels, lines = radiance.read(path)
        header = {key.lower(): value for key, value in lines.items()}
    frame = header.get("frame", "")
    if frame not in FRAMES:
        raise ValueError(
            f"{os.fspath(path)}: expected a header with a frame out of {', '.join(FRAMES)}, received "
            f"{frame or 'none'!r}"
        )
    panorama = torch.from_numpy(pixels)
    equirect.check(panorama, os.fspath(path))
    return convert_panorama(panorama, frame, "mixlight"), header
