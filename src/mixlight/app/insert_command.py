"""Set an object into a photo: lit by the photo's own light, with a shadow on the ground.

The object stands on the ground (or the table, or the shelf) that the photo shows at --at. All other pixels of
the photo stay as they are, bit for bit. Needs Mitsuba (pip install "mixlight[insert]") or Blender.
"""

import argparse
import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mixlight.app.arguments import whole
from mixlight.app.batch import PHOTO_MEGAPIXELS, megapixels, number
from mixlight.app.report import UsageError, complain, describe, print_json

if TYPE_CHECKING:
    from torch import Tensor

    from mixlight.image.ldr import Photo
    from mixlight.render.composite import Layers
    from mixlight.render.insert import Renderer
    from mixlight.render.scene_camera import SceneCamera

HELP = "an object set into a photo, with its shadow"

CAMERA_HEIGHT = 1.5
"""Metres above the floor at which most photos are taken; only for what is said about the object's size."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight insert`."""
    parser.add_argument("photo", metavar="PHOTO", help="JPEG, PNG, WebP, TIFF, or linear EXR or HDR")
    parser.add_argument(
        "--object", required=True, metavar="MODEL",
        help="a .glb or .gltf file, or one of ours: chair, spheres, teapot",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path("comp.png"), metavar="FILE",
        help="a .png in the photo's own encoding, or an .exr with linear light (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--at", type=_point, metavar="U,V",
        help="where the middle of the object's foot stands, as fractions of the photo's width and height "
        "from its upper left corner; it must lie below the horizon (default: two thirds of the way from the "
        "horizon to the lower edge)",
    )  # fmt: skip
    parser.add_argument(
        "--scale", type=_above_zero, default=1.0, metavar="S",
        help="times the size that the object would have (default: 1), at which its larger side spans 35 %% "
        "of the photo's height, or with --camera-height its own in metres",
    )  # fmt: skip
    parser.add_argument(
        "--camera-height", type=_above_zero, metavar="M",
        help="metres of the camera above the place where the object stands, if known: the model gets its "
        "own size",
    )  # fmt: skip
    parser.add_argument(
        "--turn-deg", type=_angle(360), default=0.0, metavar="A",
        help="turn the object counter-clockwise as seen from above (default: 0, its front to the camera)",
    )  # fmt: skip
    parser.add_argument(
        "--lighting", metavar="FILE",
        help="lighting.json, or a map (.exr, .hdr) in the photo's exposure, centred on its azimuth (default: "
        "estimated from the photo)",
    )  # fmt: skip
    parser.add_argument(
        "--exposure-ev", type=_angle(40), default=0.0, metavar="EV",
        help="stops by which the light is made brighter (default: 0)",
    )  # fmt: skip
    parser.add_argument(
        "--renderer", choices=("mitsuba", "blender"), default="mitsuba", help="(default: %(default)s)"
    )
    parser.add_argument(
        "--samples", type=whole(32, 65536), default=128, metavar="N",
        help="samples for each pixel, at most (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=whole(0, 2**31 - 1), default=0, metavar="N", help="of the random numbers"
    )
    parser.add_argument(
        "--layers",
        type=Path,
        metavar="FILE",
        help="also write an .exr with the layers beauty, shadow and mask",
    )
    for name, limit, what in (
        ("fov", None, "horizontal field of view (default: from EXIF, else 60)"),
        ("pitch", 89.0, "of the camera, negative looks down (default: from --lighting, else estimated)"),
        ("roll", 180.0, "of the camera, positive is clockwise (default: from --lighting, else estimated)"),
    ):
        kind = _fov if limit is None else _angle(limit)
        parser.add_argument(f"--{name}-deg", type=kind, metavar="A", help=f"in degrees, {what}")
    parser.add_argument(
        "--model", default="default", metavar="NAME_OR_PATH",
        help="weights that estimate light and pose (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--max-megapixels", type=megapixels, default=PHOTO_MEGAPIXELS, metavar="M",
        help="refuse a larger photo before it is decoded (default: %(default)g)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", dest="as_json", help="print one line of JSON")


def run(arguments: argparse.Namespace) -> int:
    """Insert the object; returns the exit status."""
    if arguments.out.suffix.lower() not in (".png", ".exr"):
        raise UsageError(f"--out {arguments.out}: expected a name that ends in .png or .exr")
    if arguments.layers is not None and arguments.layers.suffix.lower() != ".exr":
        raise UsageError(f"--layers {arguments.layers}: expected a name that ends in .exr")
    if arguments.layers is not None and arguments.layers.resolve() == arguments.out.resolve():
        raise UsageError(f"--layers {arguments.layers}: expected another file than --out")
    from mixlight.blender.program import BlenderError

    start = time.perf_counter()
    try:
        said = _insert(arguments)
    except (ValueError, OSError, MemoryError, BlenderError) as error:
        if isinstance(error, UsageError | BrokenPipeError):
            raise
        message = describe(error, arguments.photo)
        complain(message)
        if arguments.as_json:
            print_json({"input": arguments.photo, "ok": False, "error": message})
        return 1
    summary, notes = said.pop("summary"), said["notes"]
    for note in notes:
        complain(f"{arguments.object}: not taken over: {note}")
    if arguments.as_json:
        seconds = round(time.perf_counter() - start, 3)
        print_json(
            {"input": arguments.photo, "ok": True, "out": str(arguments.out), **said, "seconds": seconds}
        )
    else:
        print(f"{arguments.photo} -> {arguments.out}  {summary}")
    return 0


def _insert(arguments: argparse.Namespace) -> dict[str, Any]:
    from mixlight.app.photos import field_of_view
    from mixlight.image.atomic import atomic_path
    from mixlight.image.ldr import read_photo
    from mixlight.render.insert import insert
    from mixlight.render.insertion import make_scene
    from mixlight.render.model import load_model
    from mixlight.render.scene_camera import default_point, place

    # The files first: they prove that the results can be written, and take their names only when all is done.
    with atomic_path(arguments.out) as out, _optional(arguments.layers) as layers_out:
        model = load_model(arguments.object)
        render = _renderer(arguments.renderer)
        photo = read_photo(arguments.photo, max_pixels=int(arguments.max_megapixels * 1e6))
        fov_x = None if arguments.fov_deg is None else math.radians(arguments.fov_deg)
        environment, camera = _light_and_camera(arguments, photo, field_of_view(photo, fov_x).radians)
        u, v = default_point(camera) if arguments.at is None else arguments.at
        lower, upper = model.bounds
        placement = place(
            camera, lower, upper, u, v,
            scale=arguments.scale, turn=math.radians(arguments.turn_deg),
            camera_height=arguments.camera_height,
        )  # fmt: skip
        scene = make_scene(photo.linear, camera, model, placement, environment)
        layers = insert(scene, photo.linear, render, samples=arguments.samples, seed=arguments.seed)
        _write(arguments, photo, layers, out)
        if layers_out is not None:
            _write_layers(layers_out, photo, layers)
    height = float(upper[1] - lower[1]) * placement.scale
    metres = CAMERA_HEIGHT if arguments.camera_height is None else arguments.camera_height
    size = f"{height * metres:.2f} m high if the camera is {metres:g} m above that place"
    return {
        "summary": f"(at {u:.3f},{v:.3f}; {size})",
        "at": [round(u, 5), round(v, 5)],
        "scale": placement.scale,
        "object_height": round(height, 5),
        "region": [layers.region.left, layers.region.top, layers.region.right, layers.region.bottom],
        "camera": {
            "pitch_deg": round(math.degrees(camera.pitch), 4),
            "roll_deg": round(math.degrees(camera.roll), 4),
            "fov_deg": round(math.degrees(camera.fov_x), 4),
        },
        "renderer": arguments.renderer,
        "notes": list(model.notes),
    }


def _optional(path: Path | None) -> Any:
    import contextlib

    from mixlight.image.atomic import atomic_path

    return contextlib.nullcontext() if path is None else atomic_path(path)


def _renderer(name: str) -> "Renderer":
    if name == "mitsuba":
        from mixlight.render import mitsuba

        mitsuba.check()
        return mitsuba.render
    from mixlight.render import cycles

    cycles.check()
    return cycles.render


def _light_and_camera(
    arguments: argparse.Namespace, photo: "Photo", fov_x: float
) -> "tuple[Tensor, SceneCamera]":
    """The map that lights the object, and the camera."""
    from mixlight.app.photos import linear_tensor
    from mixlight.app.scene import read_map
    from mixlight.light import document
    from mixlight.network.estimator import Estimator
    from mixlight.render.scene_camera import SceneCamera
    from mixlight.sphere import equirect

    given = (arguments.pitch_deg, arguments.roll_deg)
    pose: tuple[float, float] | None = None
    environment: Tensor | None = None
    if arguments.lighting is not None and Path(arguments.lighting).suffix.lower() == ".json":
        record = document.read(arguments.lighting)
        environment = document.from_document(record).environment(MAP_HEIGHT)
        about = record["photo"] or {}
        known = about.get("camera")
        # The pose of another photo tells nothing; a smaller copy of this one has its shape.
        alike = (
            abs(about.get("width", 0) * photo.size[1] / (about.get("height", 1) * photo.size[0]) - 1) < 0.01
        )
        if known is not None and alike:
            pose = math.radians(known["pitch_deg"]), math.radians(known["roll_deg"])
            if arguments.fov_deg is None:
                fov_x = math.radians(known["fov_deg"])
    elif arguments.lighting is not None:
        panorama, _ = read_map(arguments.lighting, max_pixels=140_000_000)
        environment = equirect.resize(panorama, min(4 * MAP_HEIGHT, panorama.shape[0]))
    if environment is None or (pose is None and None in given):
        try:
            estimator = Estimator.load(arguments.model)
        except (ValueError, OSError) as error:
            raise UsageError(f"--model: {describe(error, arguments.model)}") from error
        estimate = estimator.estimate(linear_tensor(photo), fov_x)
        pose = pose or (estimate.pitch, estimate.roll)
        if environment is None:
            environment = estimate.lighting.pruned().environment(MAP_HEIGHT)
    pitch, roll = pose or (0.0, 0.0)
    pitch = pitch if arguments.pitch_deg is None else math.radians(arguments.pitch_deg)
    roll = roll if arguments.roll_deg is None else math.radians(arguments.roll_deg)
    camera = SceneCamera(*photo.size, fov_x, pitch, roll)
    return environment * 2.0**arguments.exposure_ev, camera


MAP_HEIGHT = 256
"""Rows of the map that an estimate is rendered from; its smallest lobes are 10 texels wide there."""


def _write(arguments: argparse.Namespace, photo: "Photo", layers: "Layers", out: Path) -> None:
    """The photo with the object in it."""
    import numpy as np

    from mixlight.image import exr_layers, png
    from mixlight.image.color import linear_to_srgb
    from mixlight.image.encoded import read_encoded
    from mixlight.render.composite import composite

    region = layers.region.slices
    over = composite(photo.linear, layers)
    if out.suffix.lower() == ".exr" or photo.source == "hdr":
        linear = photo.linear.copy()
        linear[region] = over
        if out.suffix.lower() == ".exr":
            exr_layers.write(out, {"": linear})
        else:  # such a photo has no encoding of its own
            png.write(out, np.round(linear_to_srgb(linear.clip(0, 1)) * 65535).astype(np.uint16))
        return
    where = np.zeros(photo.linear.shape[:2], dtype=bool)
    where[region] = layers.touched
    encoded = read_encoded(arguments.photo, photo)
    encoded.write_png(out, encoded.paint(over[layers.touched], where))


def _write_layers(path: Path, photo: "Photo", layers: "Layers") -> None:
    """Beauty (premultiplied, with alpha), shadow (to be added to the photo) and mask."""
    import numpy as np

    from mixlight import __version__
    from mixlight.image import exr_layers

    mask = layers.coverage[..., None]
    exr_layers.write(
        path,
        {"beauty": np.concatenate([layers.beauty, mask], -1), "shadow": layers.shadow, "mask": mask},
        size=photo.size,
        offset=(layers.region.left, layers.region.top),
        attributes={
            "software": f"mixlight {__version__}",
            "comment": "linear Rec.709: composite = beauty + (1 - mask) * max(photo + shadow, 0)",
        },
    )


def _point(text: str) -> tuple[float, float]:
    parts = [number(part) for part in text.split(",")]
    if len(parts) != 2 or not all(math.isfinite(part) for part in parts):
        raise argparse.ArgumentTypeError(f"expected two numbers such as 0.5,0.8, received {text!r}")
    return parts[0], parts[1]


def _above_zero(text: str) -> float:
    value = number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, received {text!r}")
    return value


def _angle(limit: float) -> Any:
    def read(text: str) -> float:
        value = number(text)
        if not abs(value) <= limit:
            raise argparse.ArgumentTypeError(
                f"expected a number from {-limit:g} to {limit:g}, received {text!r}"
            )
        return value

    return read


def _fov(text: str) -> float:
    value = number(text)
    if not 1.0 < value < 170.0:
        raise argparse.ArgumentTypeError(f"expected an angle between 1 and 170 degrees, received {text!r}")
    return value
