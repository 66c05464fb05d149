"""Fit light to HDR panoramas.

For each panorama writes DIR/<name>/ with the files of `mixlight estimate` and fit.json: the energy before
and after, what clamping negative ambient lobes does, and the error of three spheres lit by the fit, against
the panorama itself.
"""

import argparse
import math
from pathlib import Path
from typing import Any

from mixlight.app.batch import (
    PANORAMA_MEGAPIXELS,
    Job,
    add_batch_arguments,
    number,
    output_folder,
    plan,
    run_batch,
)

HELP = "an HDR panorama in, its light as ambient and sources out"

PROTOCOL = (
    "M: linear RMSE over the pixels and channels of each sphere, lit by the fit and by the panorama, both "
    "times gain, which brings the panorama's median luminance to 0.18; si: after the best single scale"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line of `mixlight fit`."""
    parser.add_argument(
        "panoramas", nargs="+", metavar="PANORAMA", help=".hdr or .exr, twice as wide as high, linear"
    )
    parser.add_argument(
        "--separation", choices=("top_fraction", "max_fraction"), default="top_fraction",
        help="sources are the brightest part of the sphere, or what exceeds a part of the maximum "
        "(default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--fraction",
        type=_fraction,
        default=0.05,
        metavar="X",
        help="that part, from 0 to 1 (default: %(default)s)",
    )
    parser.add_argument(
        "--degree", type=_degree, default=2, metavar="L",
        help="degree of the ambient light's harmonics, 0 to 6 (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--anchors", type=_anchors, default=128, metavar="N",
        help="directions that a source can have (default: %(default)s)",
    )  # fmt: skip
    add_batch_arguments(parser, what="panorama", max_megapixels=PANORAMA_MEGAPIXELS)


def run(arguments: argparse.Namespace) -> int:
    """Fit each panorama; returns the exit status."""
    with output_folder(arguments.out) as out:
        jobs = plan(arguments.panoramas, out)
        return run_batch(jobs, lambda job: _fit_one(job, arguments), as_json=arguments.as_json)


def _fit_one(job: Job, arguments: argparse.Namespace) -> dict[str, Any]:
    from mixlight.app.outputs import write_result
    from mixlight.app.preview import SPHERE, auto_exposure, fit_preview
    from mixlight.app.scene import light_markers, read_map, sphere_renderer
    from mixlight.light.compare import rmse_and_si_rmse
    from mixlight.light.fit import energy_report, fit
    from mixlight.light.lights import merge
    from mixlight.sphere import equirect

    panorama, _ = read_map(job.source, max_pixels=int(arguments.max_megapixels * 1e6))
    settings = {
        "separation": arguments.separation,
        "fraction": arguments.fraction,
        "degree": arguments.degree,
        "anchors": arguments.anchors,
    }
    lighting = fit(panorama, **settings)
    energy = energy_report(panorama, lighting)
    shown = equirect.resize(panorama, min(512, panorama.shape[0]))
    environment = lighting.environment(arguments.height)
    gain = auto_exposure(shown.numpy(), equirect.solid_angle(shown.shape[0]).numpy())

    renderer = sphere_renderer(SPHERE)
    true_spheres, fitted_spheres = renderer.render(shown), renderer.render(environment)
    mask = renderer.mask
    rmse, si_rmse = rmse_and_si_rmse(fitted_spheres[:, mask] * gain, true_spheres[:, mask] * gain)
    errors = {
        name: {"rmse": float(rmse[i]), "si_rmse": float(si_rmse[i])}
        for i, name in enumerate(("diffuse", "matte", "mirror"))
    }
    lights = merge(lighting)
    preview = fit_preview(
        shown.numpy(),
        environment.numpy(),
        true_spheres.numpy(),
        fitted_spheres.numpy(),
        mask.numpy(),
        light_markers(lights),
        gain=gain,
        caption=Path(job.source).name,
    )
    report = {
        "format": "mixlight/fit",
        "version": 1,
        "panorama": {"name": Path(job.source).name, "width": panorama.shape[1], "height": panorama.shape[0]},
        "settings": settings,
        "energy": energy,
        "spheres": {"protocol": PROTOCOL, "gain": gain, **errors},
    }
    write_result(job.folder, lighting, environment, preview, reports={"fit.json": report})
    return {
        "summary": f"({len(lights)} light{'' if len(lights) == 1 else 's'}; RMSE "
        + ", ".join(f"{name} {error['rmse']:.3f}" for name, error in errors.items())
        + ")",
        "lights": len(lights),
        "active_anchors": len(lighting.active),
        "energy": energy,
        "spheres": errors,
    }


def _fraction(text: str) -> float:
    value = number(text)
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"expected a number between 0 and 1, received {text!r}")
    return value


def _degree(text: str) -> int:
    if not (text.isdecimal() and int(text) <= 6):
        raise argparse.ArgumentTypeError(f"expected a whole number from 0 to 6, received {text!r}")
    return int(text)


def _anchors(text: str) -> int:
    value = number(text)
    if not (math.isfinite(value) and value.is_integer() and 8 <= value <= 4096):
        raise argparse.ArgumentTypeError(f"expected a whole number from 8 to 4096, received {text!r}")
    return int(value)
