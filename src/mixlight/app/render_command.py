"""Render three spheres (diffuse gray, matte silver, mirror silver) under an estimated light or an HDR map.

The camera sees them as objects set into the photo: the mirror's centre shows what is behind the photographer.
"""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from mixlight.app.batch import PANORAMA_MEGAPIXELS, megapixels, number
from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from torch import Tensor

HELP = "three spheres under a light"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight render`."""
    parser.add_argument(
        "light",
        metavar="LIGHTING_OR_MAP",
        help="lighting.json, or a panorama (.hdr, .exr) twice as wide as high",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("spheres.png"), metavar="FILE",
        help="a .png to look at, or an .exr with linear radiance (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--exposure-ev", type=_exposure, metavar="EV",
        help="stops by which the .png is made brighter (default: 0 for a light of ours; for any other map "
        "what brings its median to middle gray)",
    )  # fmt: skip
    parser.add_argument(
        "--size",
        type=_size,
        default=256,
        metavar="PIXELS",
        help="pixels across a sphere (default: %(default)s)",
    )
    parser.add_argument(
        "--max-megapixels", type=megapixels, default=PANORAMA_MEGAPIXELS, metavar="M",
        help="refuse a larger map before it is decoded (default: %(default)g)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Render the spheres; returns the exit status."""
    if arguments.out.suffix.lower() not in (".png", ".exr"):
        raise UsageError(f"--out {arguments.out}: expected a name that ends in .png or .exr")
    try:
        gain = _render(arguments)
    except (ValueError, OSError, MemoryError) as error:
        message = describe(error, arguments.light)
        complain(message)
        if arguments.as_json:
            print_json({"input": arguments.light, "ok": False, "error": message})
        return 1
    if arguments.as_json:
        print_json({"input": arguments.light, "ok": True, "out": str(arguments.out), "gain": gain})
    else:
        print(f"{arguments.light} -> {arguments.out}  (gain {gain:.4g})")
    return 0


def _render(arguments: argparse.Namespace) -> float:
    import numpy as np

    from mixlight.app.preview import spheres_picture
    from mixlight.app.scene import sphere_renderer
    from mixlight.image import exr, ldr
    from mixlight.image.atomic import atomic_path

    with atomic_path(arguments.out) as out:  # first, as it proves that the picture can be written
        environment, gain = _environment(arguments.light, int(arguments.max_megapixels * 1e6))
        if arguments.exposure_ev is not None:
            gain = 2.0**arguments.exposure_ev
        renderer = sphere_renderer(arguments.size)
        spheres = renderer.render(environment).numpy()
        if arguments.out.suffix.lower() == ".exr":
            exr.write(out, np.concatenate(list(spheres), axis=1))
            return 1.0
        ldr.write_png(out, spheres_picture(spheres, renderer.mask.numpy(), arguments.size, gain=gain))
    return gain


def _environment(source: str, max_pixels: int) -> "tuple[Tensor, float]":
    """The map to render with, in our frame, and the gain at which it is best seen."""
    from mixlight.app.preview import auto_exposure
    from mixlight.app.scene import read_map
    from mixlight.light import document
    from mixlight.sphere import equirect

    if Path(source).suffix.lower() == ".json":
        return document.load(source).environment(128), 1.0
    panorama, is_ours = read_map(source, max_pixels=max_pixels)
    environment = equirect.resize(panorama, min(256, panorama.shape[0]))
    if is_ours:
        return environment, 1.0
    return environment, auto_exposure(environment.numpy(), equirect.solid_angle(environment.shape[0]).numpy())


def _exposure(text: str) -> float:
    value = number(text)
    if not (math.isfinite(value) and abs(value) <= 40.0):
        raise argparse.ArgumentTypeError(f"expected a number of stops from -40 to 40, received {text!r}")
    return value


def _size(text: str) -> int:
    value = int(text) if text.isdecimal() else 0
    if not 16 <= value <= 1024:
        raise argparse.ArgumentTypeError(f"expected a whole number from 16 to 1024, received {text!r}")
    return value
