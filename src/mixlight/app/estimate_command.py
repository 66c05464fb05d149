"""Estimate the HDR light of indoor photos.

For each photo writes DIR/<name>/ with environment.exr and environment.hdr (the map), lighting.json
(everything, in numbers) and preview.png. Radiance 1.0 is the photo's linear white; the centre of the map is
where the photo looks.
"""

import argparse
import math
from typing import TYPE_CHECKING, Any

from mixlight.app.batch import (
    PHOTO_MEGAPIXELS,
    Job,
    add_batch_arguments,
    number,
    output_folder,
    plan,
    run_batch,
)
from mixlight.app.report import UsageError, describe

if TYPE_CHECKING:
    from mixlight.app.photos import FieldOfView
    from mixlight.image.ldr import Photo
    from mixlight.network.estimator import Estimate, Estimator

HELP = "one indoor photo in, its HDR light out"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight estimate`."""
    parser.add_argument(
        "photos", nargs="+", metavar="PHOTO", help="JPEG, PNG, WebP, TIFF, or linear EXR or HDR"
    )
    parser.add_argument(
        "--fov-deg", type=_fov, metavar="F",
        help="horizontal field of view in degrees (default: from EXIF, else 60)",
    )  # fmt: skip
    parser.add_argument(
        "--model", default="default", metavar="NAME_OR_PATH",
        help="a shipped model, or a .safetensors file (default: %(default)s)",
    )  # fmt: skip
    add_batch_arguments(parser, what="photo", max_megapixels=PHOTO_MEGAPIXELS)


def run(arguments: argparse.Namespace) -> int:
    """Estimate each photo; returns the exit status."""
    fov_x = None if arguments.fov_deg is None else math.radians(arguments.fov_deg)
    with output_folder(arguments.out) as out:
        # torch is imported only now, when the call as such is known to be right.
        from mixlight.network.estimator import Estimator

        try:
            estimator = Estimator.load(arguments.model)
        except (ValueError, OSError) as error:
            raise UsageError(f"--model: {describe(error, arguments.model)}") from error
        max_pixels = int(arguments.max_megapixels * 1e6)

        def work(job: Job) -> dict[str, Any]:
            return _estimate_one(job, estimator, fov_x, arguments.height, max_pixels)

        return run_batch(plan(arguments.photos, out), work, as_json=arguments.as_json)


def _estimate_one(
    job: Job, estimator: "Estimator", fov_x: float | None, height: int, max_pixels: int
) -> dict[str, Any]:
    from mixlight.app.outputs import write_result
    from mixlight.app.photos import field_of_view, linear_tensor
    from mixlight.app.preview import SPHERE, auto_exposure, estimate_preview, shrink
    from mixlight.app.scene import light_markers, photo_outline, sphere_renderer
    from mixlight.image.ldr import read_photo
    from mixlight.light.lights import merge

    renderer = sphere_renderer(SPHERE)
    photo = read_photo(job.source, max_pixels=max_pixels)
    fov = field_of_view(photo, fov_x)
    result = estimator.estimate(linear_tensor(photo), fov.radians)
    # Lobes too weak to be listed in lighting.json are not in the map either.
    lighting = result.lighting.pruned()
    environment = lighting.environment(height)
    lights = merge(lighting)
    preview = estimate_preview(
        photo.linear,
        environment.numpy(),
        renderer.render(environment).numpy(),
        renderer.mask.numpy(),
        light_markers(lights),
        photo_outline(*photo.size, fov.radians, result.pitch, result.roll),
        # A photo holds its own white. A linear file has none, and may need a gain to be seen at all.
        gain=1.0 if photo.source == "ldr" else auto_exposure(shrink(photo.linear, 256)),
        caption=photo.name,
    )
    camera = _camera(fov, result)
    write_result(
        job.folder,
        lighting,
        environment,
        preview,
        photo=_photo_record(photo, camera),
        model=estimator.card,
    )
    return {
        "summary": _summary(fov, len(lights)),
        "lights": len(lights),
        "active_anchors": len(lighting.active),
        "camera": camera,
    }


def _camera(fov: "FieldOfView", result: "Estimate") -> dict[str, Any]:
    camera: dict[str, Any] = {
        "pitch_deg": round(math.degrees(result.pitch), 4),
        "roll_deg": round(math.degrees(result.roll), 4),
        "fov_deg": round(math.degrees(fov.radians), 4),
        "fov_source": fov.source,
    }
    return camera | ({} if fov.note is None else {"fov_note": fov.note})


def _photo_record(photo: "Photo", camera: dict[str, Any]) -> dict[str, Any]:
    width, height = photo.size
    record = {
        "name": photo.name,
        "width": width,
        "height": height,
        "format": photo.format,
        "source": photo.source,
        "bit_depth": photo.bit_depth,
        "camera": camera,
    }
    return record | ({"notes": list(photo.notes)} if photo.notes else {})


def _summary(fov: "FieldOfView", lights: int) -> str:
    angle = f"{math.degrees(fov.radians):.1f}° {'given' if fov.source == 'option' else fov.source}"
    return f"({lights} light{'' if lights == 1 else 's'}; field of view {angle})"


def _fov(text: str) -> float:
    value = number(text)
    if not 1.0 < value < 170.0:
        raise argparse.ArgumentTypeError(f"expected an angle between 1 and 170 degrees, received {text!r}")
    return value
