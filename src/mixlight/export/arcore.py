"""ARCore: what `LightEstimate` gives in the mode environmental HDR, as JSON."""

from pathlib import Path

from mixlight.export import sh
from mixlight.export.probe import Probe, describe, load_probe, make_probe, to_words
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light.document import dumps, numbers

__all__ = ["FILE", "read", "write"]

FILE = "arcore.json"


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `arcore.json` and `README.txt`.

    Convention: `mainLightDirection` is a unit vector towards the light, `mainLightIntensity` linear rgb, and
        `ambientSphericalHarmonics.coefficients` the 27 numbers, rgb by index, that
        `getEnvironmentalHdrAmbientSphericalHarmonics` gives: radiance in the Condon-Shortley basis, without
        the main light.

    Raises:
        OSError: a file cannot be made.
    """
    probe = make_probe(rig)
    document = to_words(probe, "arcore") | {
        "mainLightDirection": numbers(probe.direction),
        "mainLightIntensity": numbers(probe.intensity),
        "ambientSphericalHarmonics": sh.to_document(probe.harmonics, "arcore"),
    }
    path = folder / FILE
    path.write_text(dumps(document), encoding="utf-8")
    readme = write_readme(
        folder,
        rig,
        f"Read {FILE} and use its entries where your shader takes those of ARCore's LightEstimate (mode "
        "ENVIRONMENTAL_HDR); turn both about +Y by the azimuth of the photo in your session, -Z ahead.",
        "Derived from ARCore's reference and never run in ARCore; directions are +X right, +Y up, -Z where "
        "the photo looks.",
        where=describe(probe),
    )
    return [path, readme]


def read(folder: Path) -> Probe:
    """Read back what `write` has made, exact to float32.

    Raises:
        ValueError: no such file; the message names the file and the entry.
        OSError: the file cannot be read.
    """
    return load_probe(
        folder / FILE, "arcore", "ambientSphericalHarmonics", "mainLightDirection", "mainLightIntensity"
    )
