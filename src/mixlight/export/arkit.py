"""ARKit: what `ARDirectionalLightEstimate` gives, as JSON. Its order, sign and scale are undocumented."""

from pathlib import Path

from mixlight.export import sh
from mixlight.export.probe import Probe, describe, load_probe, make_probe, to_words
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.light.document import dumps, numbers

__all__ = ["FILE", "read", "write"]

FILE = "arkit.json"

UNVERIFIED = (
    "Apple documents 9 numbers each for red, green and blue, and neither their order nor their signs nor "
    "their scale, nor whether the direction points to the light: all of these are guesses here"
)
"""Stands in the file itself."""


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write `arkit.json` and `README.txt`.

    Convention: `sphericalHarmonicsCoefficients.coefficients` are our radiance coefficients as 9 red, 9 green,
        9 blue; `primaryLightDirection` is a unit vector towards the light and `primaryLightColor` its
        irradiance in linear rgb. ARKit's own intensity, one number in lumens, is left out, since its relation
        to radiance is not known.

    Raises:
        OSError: a file cannot be made.
    """
    probe = make_probe(rig)
    document = to_words(probe, "arkit") | {
        "verified": False,
        "note": UNVERIFIED,
        "primaryLightDirection": numbers(probe.direction),
        "primaryLightColor": numbers(probe.intensity),
        "sphericalHarmonicsCoefficients": sh.to_document(probe.harmonics, "arkit"),
    }
    path = folder / FILE
    path.write_text(dumps(document), encoding="utf-8")
    readme = write_readme(
        folder,
        rig,
        f"Read {FILE} and use its entries where your shader takes those of ARDirectionalLightEstimate; its "
        "words under sphericalHarmonicsCoefficients say what each number is.",
        f"Unverified: {UNVERIFIED}.",
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
        folder / FILE, "arkit", "sphericalHarmonicsCoefficients", "primaryLightDirection", "primaryLightColor"
    )
