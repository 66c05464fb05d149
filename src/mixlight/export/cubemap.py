"""Six faces of the map for each way in which engines sample a cube."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import torch
from jaxtyping import Float
from torch import Tensor

from mixlight import __version__
from mixlight.export.reading import check_words, coefficients, make_lights
from mixlight.export.readme import write_readme
from mixlight.export.rig import Rig
from mixlight.image import exr, radiance
from mixlight.light import entries
from mixlight.light.document import dumps
from mixlight.sphere import cubemap, equirect

__all__ = ["FILE", "LAYOUTS", "CubeLayout", "faces", "read", "write"]

FILE = "cubemap.json"

NAMES = ("px", "nx", "py", "ny", "pz", "nz")
"""Stems of the faces' files, in the order in which graphics APIs take them: +X -X +Y -Y +Z -Z."""


@dataclass(frozen=True)
class CubeLayout:
    """The direction that an engine hands to the sampler, for a direction of ours."""

    signs: tuple[int, int, int]
    """(x, y, z) of ours is sampled at these signs times x, y, z; at most one of x and z is negative."""
    summary: str
    """Who samples so."""


LAYOUTS: Mapping[str, CubeLayout] = MappingProxyType(
    {
        "opengl": CubeLayout(
            (1, 1, 1), "OpenGL, Vulkan, WebGL and Direct3D shaders that sample our direction"
        ),
        "three": CubeLayout((-1, 1, 1), "three.js CubeTexture, which samples (-x, y, z)"),
        "unity": CubeLayout((1, 1, -1), "left-handed engines, +Z ahead: Unity's six-sided cube maps"),
    }
)
"""A folder each. Seen from inside, the faces of "opengl" are mirrored, those of the other two are not."""


def write(rig: Rig, folder: Path) -> list[Path]:
    """Write six faces as .exr and .hdr for each layout, `cubemap.json` and `README.txt`.

    Faces are as fine as the map is at the horizon: an edge of a quarter of its width.

    Convention: +X -X +Y -Y +Z -Z as the sampler sees them (`mixlight.sphere.cubemap`); the upper left corner
        of a file is the texture coordinate (0, 0).

    Raises:
        OSError: a file cannot be made.
    """
    paths = []
    cubes = {name: faces(rig.environment, name) for name in LAYOUTS}
    gain = float(rig.exposure_gain)
    for name, cube in cubes.items():
        (folder / name).mkdir()
        for stem, face in zip(NAMES, cube.numpy(), strict=True):
            about = {"software": f"mixlight {__version__}", "map": rig.map_kind, "cube": name, "face": stem}
            path = folder / name / stem
            exr.write(path.with_suffix(".exr"), face, {**about, "exposure_gain": gain})
            words = {key.upper(): value for key, value in about.items()}
            radiance.write(path.with_suffix(".hdr"), face, words | {"EXPOSURE_GAIN": repr(gain)})
            paths += [path.with_suffix(".exr"), path.with_suffix(".hdr")]
    document = rig.document() | {
        "format": "mixlight/cubemap",
        "height": rig.environment.shape[0],
        "cube": {
            "faces": list(NAMES),
            "size": cubes["opengl"].shape[1],
            "layouts": {
                name: {"samples": list(layout.signs), "for": layout.summary}
                for name, layout in LAYOUTS.items()
            },
        },
    }
    path = folder / FILE
    path.write_text(dumps(document), encoding="utf-8")
    readme = write_readme(
        folder,
        rig,
        f"Load px nx py ny pz nz (this order) from opengl/, three/ or unity/: {FILE} says which direction "
        "each samples, and lists the lights.",
        "opengl/ and three/ were run in Chromium (WebGL 2 and three.js r187, the calibration card from six "
        "sides); unity/ is derived from Unity's documentation and never run.",
    )
    return [*paths, path, readme]


def faces(environment: Float[Tensor, "height width 3"], layout: str) -> Float[Tensor, "6 size size 3"]:
    """The six faces of a map for one of `LAYOUTS`, with an edge of a quarter of its width.

    Sampling on another grid changes the energy of what is as small as a texel, by a percent or so. The faces
    are scaled, each channel by one factor, so that theirs is the map's.

    Convention: looking up s = signs * d in the cube gives the radiance of our direction d.

    >>> from mixlight.sphere import calibration_card
    >>> faces(calibration_card(64), "three")[0, 12, 12]  # +X of the sampler: our -X, cyan
    tensor([0.0000, 4.0009, 3.9998])
    """
    energy = equirect.integrate(environment)
    width = environment.shape[1]
    x, _, z = LAYOUTS[layout].signs
    if x < 0 or z < 0:
        environment = equirect.mirror(environment)  # x -> -x; half a turn more makes it z -> -z
        environment = environment.roll(width // 2, 1) if z < 0 else environment
    cube = cubemap.from_equirect(environment, max(1, width // 4)).clamp_min(0)
    return cube * _ratio(energy, _energy(cube))


def read(folder: Path) -> Rig:
    """Read back what `write` has made, from the faces of `opengl/`.

    Convention: the map is sampled twice, which blurs it by about a texel; energy, lights and harmonics stay.

    Raises:
        ValueError: not such files; the message names the file and the entry.
        OSError: a file cannot be read.
    """
    path = folder / FILE
    document = entries.load(path)
    pictures, header = [], {}
    for stem in NAMES:
        pixels, attributes = exr.read(folder / "opengl" / f"{stem}.exr")
        pictures.append(torch.from_numpy(pixels))
        header = {key: str(value) for key, value in attributes.items()}
    try:
        words = check_words(document, "the document", "mixlight/cubemap", header)
        entries.equal(words.get("frame"), "frame", "mixlight")
        height = entries.whole(words.get("height"), "height", 2, 1 << 16)
        harmonics = entries.mapping(words.get("harmonics"), "harmonics")
        cube = torch.stack(pictures)
        environment = cubemap.to_equirect(cube, height)
        environment = environment * _ratio(_energy(cube), equirect.integrate(environment))
        return Rig(
            environment=environment,
            lights=make_lights(words.get("lights"), "mixlight"),
            residual=words["map"] == "residual",
            ambient=coefficients(harmonics.get("ambient"), "harmonics.ambient"),
            sh=coefficients(harmonics.get("all_light"), "harmonics.all_light"),
            exposure_gain=float(words["exposure_gain"]),
            name=entries.text(words.get("name"), "name"),
        )
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _energy(cube: Float[Tensor, "6 size size 3"]) -> Float[Tensor, "3"]:
    """Integral of the radiance over the sphere."""
    return torch.einsum(
        "fijc,ij->c", cube.double(), cubemap.solid_angle(cube.shape[1], dtype=torch.float64)
    ).float()


def _ratio(wanted: Float[Tensor, "3"], found: Float[Tensor, "3"]) -> Float[Tensor, "3"]:
    return torch.where(found > 0, wanted / torch.where(found > 0, found, 1), 1)
