"""Estimate the HDR light of indoor photos.

For each photo writes DIR/<name>/ with environment.exr and environment.hdr (the map), lighting.json
(everything, in numbers) and preview.png, and with --for a folder for each other program. Radiance 1.0 is the
photo's linear white; the centre of the map is where the photo looks.
"""

import argparse
import math
from functools import partial
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
from mixlight.app.exports import add_target_arguments, chosen_targets
from mixlight.app.report import UsageError, complain, describe

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from torch import Tensor

    from mixlight.app.photos import FieldOfView
    from mixlight.export.registry import Target
    from mixlight.export.rig import Rig
    from mixlight.image.ldr import Photo
    from mixlight.light.detail import Detail
    from mixlight.light.lighting import Lighting
    from mixlight.network.estimator import Estimate, Estimator

HELP = "one indoor photo in, its HDR light out"

EXPORT_HEIGHT = 256
"""Rows of the maps for other programs, as of `mixlight export`; `--height` where that is more."""


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
    parser.add_argument(
        "--detail", choices=("photo",),
        help="photo: put the photo's own pixels into the part of the map that it shows, for mirrors",
    )  # fmt: skip
    add_target_arguments(parser, required=False)
    add_batch_arguments(parser, what="photo", max_megapixels=PHOTO_MEGAPIXELS)


def run(arguments: argparse.Namespace) -> int:
    """Estimate each photo; returns the exit status."""
    fov_x = None if arguments.fov_deg is None else math.radians(arguments.fov_deg)
    targets = chosen_targets(arguments)
    for target in targets:
        if target.of != "light":
            raise UsageError(
                f"--for {target.name}: expected a target of light, received one of the model "
                f"(see `mixlight export --for {target.name}`)"
            )
    with output_folder(arguments.out) as out:
        # torch is imported only now, when the call as such is known to be right.
        from mixlight.network.estimator import Estimator

        try:
            estimator = Estimator.load(arguments.model)
        except (ValueError, OSError) as error:
            raise UsageError(f"--model: {describe(error, arguments.model)}") from error

        def work(job: Job) -> dict[str, Any]:
            return _estimate_one(job, estimator, fov_x, targets, arguments)

        return run_batch(plan(arguments.photos, out), work, as_json=arguments.as_json)


def _estimate_one(
    job: Job,
    estimator: "Estimator",
    fov_x: float | None,
    targets: "list[Target]",
    arguments: argparse.Namespace,
) -> dict[str, Any]:
    from mixlight.app.outputs import write_result
    from mixlight.app.photos import field_of_view, linear_tensor
    from mixlight.app.preview import SPHERE, auto_exposure, estimate_preview, shrink
    from mixlight.app.scene import light_markers, photo_outline, sphere_renderer
    from mixlight.image.ldr import read_photo
    from mixlight.light.lights import merge

    renderer = sphere_renderer(SPHERE)
    photo = read_photo(job.source, max_pixels=int(arguments.max_megapixels * 1e6))
    fov = field_of_view(photo, fov_x)
    linear = linear_tensor(photo)
    result = estimator.estimate(linear, fov.radians)
    # Lobes too weak to be listed in lighting.json are not in the map either.
    lighting = result.lighting.pruned()
    see = _see(linear, fov.radians, result) if arguments.detail else None
    detail = see(arguments.height) if see else None
    environment = detail.environment(lighting) if detail else lighting.environment(arguments.height)
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
    record = _photo_record(photo, camera)
    if detail:
        record["detail"] = _detail_record(detail, lighting)
    rig = _rig(lighting, see, arguments) if targets else None
    stale = _not_renewed(job.folder, targets)
    write_result(
        job.folder,
        lighting,
        environment,
        preview,
        photo=record,
        model=estimator.card,
        detail="photo" if detail else None,
        also=None if rig is None else partial(_write_targets, targets, rig),
    )
    for folder in stale:
        complain(f"{folder}: left as an earlier run made it; it holds another light than lighting.json now")
    said = {
        "summary": _summary(fov, len(lights), targets),
        "lights": len(lights),
        "active_anchors": len(lighting.active),
        "camera": camera,
    }
    return said | (
        {"targets": [target.name for target in targets], "map": rig.map_kind} if rig is not None else {}
    )


def _see(linear: "Tensor", fov_x: float, result: "Estimate") -> "Callable[[int], Detail]":
    """The photo laid on maps of any number of rows."""
    from mixlight.light.detail import Detail

    return lambda height: Detail.of_photo(linear, fov_x, height, pitch=result.pitch, roll=result.roll)


def _detail_record(detail: "Detail", lighting: "Lighting") -> dict[str, Any]:
    """What lighting.json says of the photo in the map, which cannot be made from the numbers alone."""
    return {
        "source": "photo",
        "share_of_sphere": round(detail.share, 4),
        "opacity": round(detail.opacity(lighting), 4),
    }


def _rig(lighting: "Lighting", see: "Callable[[int], Detail] | None", arguments: argparse.Namespace) -> "Rig":
    """The light for other programs, the photo in its map where it is in the map."""
    from mixlight.export.rig import make_rig

    height = max(EXPORT_HEIGHT, arguments.height)
    height += height % 2  # so that consumers' quarter turns are exact
    return make_rig(
        lighting,
        lights=arguments.lights,
        residual=arguments.residual,
        height=height,
        environment=see(height).environment if see else None,
    )


def _write_targets(targets: "list[Target]", rig: "Rig", folder: "Path") -> None:
    """Every target, each into its own folder; the first that cannot be written is an error of the photo."""
    from mixlight.export.registry import write_target

    for target in targets:
        try:
            write_target(target, rig, folder)
        except ImportError as error:  # an extra is missing; the message says which
            raise ValueError(f"{target.name}: {error}") from error


def _not_renewed(folder: "Path", targets: "list[Target]") -> "list[Path]":
    """Exports of an earlier run into the same folder that this run leaves as they are."""
    from mixlight.export.registry import TARGETS

    renewed = {target.name for target in targets}
    return [
        folder / name for name in TARGETS if name not in renewed and (folder / name / "README.txt").is_file()
    ]


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


def _summary(fov: "FieldOfView", lights: int, targets: "list[Target]") -> str:
    angle = f"{math.degrees(fov.radians):.1f}° {'given' if fov.source == 'option' else fov.source}"
    names = f"; for {', '.join(target.name for target in targets)}" if targets else ""
    return f"({lights} light{'' if lights == 1 else 's'}; field of view {angle}{names})"


def _fov(text: str) -> float:
    value = number(text)
    if not 1.0 < value < 170.0:
        raise argparse.ArgumentTypeError(f"expected an angle between 1 and 170 degrees, received {text!r}")
    return value
