"""WebXR: an `XRLightEstimate` from a file, for apps that are written for one."""

from importlib.resources import files
from pathlib import Path
from typing import Any

from mixlight.export import sh
from mixlight.export.probe import Probe, describe, load_probe, make_probe, to_words
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light import entries
from mixlight.light.document import dumps, numbers

__all__ = ["FILE", "SCRIPT", "read", "write"]

FILE = "webxr.json"
SCRIPT = "light_estimate.js"


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `webxr.json`, `light_estimate.js` (it makes the estimate of the JSON) and `README.txt`.

    Convention: `sphericalHarmonicsCoefficients` are our radiance coefficients, rgb by index;
        `primaryLightDirection` {x, y, z, w: 0} points towards the light; `primaryLightIntensity`
        {x, y, z, w: 1} is its irradiance in linear rgb.

    Raises:
        OSError: a file cannot be made.
    """
    probe = make_probe(rig)
    document = to_words(probe, "webxr") | {
        "primaryLightDirection": _point(numbers(probe.direction), 0.0),
        "primaryLightIntensity": _point(numbers(probe.intensity), 1.0),
        "sphericalHarmonicsCoefficients": sh.to_document(probe.harmonics, "webxr"),
    }
    path = folder / FILE
    path.write_text(dumps(document), encoding="utf-8")
    script = folder / SCRIPT
    source = files("mixlight.export").joinpath("webxr_files", SCRIPT)
    script.write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    readme = write_readme(
        folder,
        rig,
        f"In your code: `import {{ lightEstimate }} from './{SCRIPT}'; "
        "const estimate = await lightEstimate();` gives what `frame.getLightEstimate(probe)` gives.",
        "Run with three.js r187 in Chromium, whose XREstimatedLight takes these numbers as they are; never "
        "compared with a device's own estimate.",
        where=describe(probe),
    )
    return [path, script, readme]


def read(folder: Path) -> Probe:
    """Read back what `write` has made, exact to float32.

    Raises:
        ValueError: no such file; the message names the file and the entry.
        OSError: the file cannot be read.
    """
    return load_probe(
        folder / FILE,
        "webxr",
        "sphericalHarmonicsCoefficients",
        "primaryLightDirection",
        "primaryLightIntensity",
        _xyz,
    )


def _point(xyz: list[float], w: float) -> dict[str, float]:
    return dict(zip("xyzw", [*xyz, w], strict=True))


def _xyz(value: Any, where: str) -> list[float]:
    point = entries.mapping(value, where)
    entries.keys(point, where, "xyzw")
    return [entries.number(point[axis], f"{where}.{axis}") for axis in "xyz"]
