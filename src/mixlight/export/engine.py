"""What targets of game engines share: one JSON in the engine's axes and harmonics, beside a rolled map."""

from pathlib import Path
from typing import Any

from mixlight.export import sh
from mixlight.export.maps import read_map
from mixlight.export.reading import check_words, make_lights
from mixlight.export.rig import Rig
from mixlight.light import entries

__all__ = ["engine_document", "read_engine"]


def engine_document(rig: Rig, engine: str) -> dict[str, Any]:
    """The rig without its map: lights in the engine's axes, harmonics in its order, signs and scale.

    Two sets of harmonics: `ambient` is what the map holds, to go with the lights that are on; `all_light`
    stands alone.

    Convention: `direction` points towards the light; `irradiance` is that on a surface which faces it, and
        what the engine's own intensity is to be made of.

    Raises:
        ValueError: an engine that is not in `mixlight.export.sh.LAYOUTS`.

    >>> import torch
    >>> empty = torch.zeros(4, 8, 3)
    >>> document = engine_document(Rig(empty, (), True, torch.zeros(9, 3), torch.ones(9, 3)), "unity")
    >>> document["format"], document["harmonics"]["all_light"]["layout"]
    ('mixlight/unity', 'planar')
    """
    document = rig.document(engine) | {"format": f"mixlight/{engine}"}
    document["harmonics"] = {
        "ambient": sh.to_document(rig.ambient, engine),
        "all_light": sh.to_document(rig.sh, engine),
    }
    return document


def read_engine(folder: Path, engine: str, map_name: str = "environment.exr") -> Rig:
    """Read back `<engine>.json` and its map.

    Convention: the map is exact to half floats, all else to float32.

    Raises:
        ValueError: not such files, or not of one rig; the message names the file and the entry.
        OSError: a file cannot be read.
    """
    environment, header = read_map(folder / map_name)
    path = folder / f"{engine}.json"
    document = entries.load(path)
    try:
        words = check_words(document, "the document", f"mixlight/{engine}", header)
        entries.equal(words.get("frame"), "frame", engine)
        harmonics = entries.mapping(words.get("harmonics"), "harmonics")
        return Rig(
            environment=environment,
            lights=make_lights(words.get("lights"), engine),
            residual=words["map"] == "residual",
            ambient=sh.read_document(harmonics.get("ambient"), engine),
            sh=sh.read_document(harmonics.get("all_light"), engine),
            exposure_gain=float(words["exposure_gain"]),
            name=entries.text(words.get("name"), "name"),
        )
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
