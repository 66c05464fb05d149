"""The targets by name. Nothing is imported before a target is used, so that the command line stays quick.

A target of light is the module of its name in this folder, with

    write(rig: Rig, folder: Path) -> list[Path]     # files into an existing folder, README.txt among them
    read(folder: Path) -> Rig                       # only where the format can be read back; Probe for phones

A target of the model (`onnx`) takes the name or the path of a model in place of the rig.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from mixlight.export.rig import Rig

__all__ = ["TARGETS", "Target", "select", "write_target"]


@dataclass(frozen=True)
class Target:
    """One consumer."""

    name: str
    """What stands after `--for`, and the name of the output folder."""
    summary: str
    """What is written, in a few words."""
    verified: bool
    """Whether the consumer itself has read what we write in our tests; otherwise the files say that it has
    not."""
    of: Literal["light", "model"] = "light"
    """What is exported."""

    @property
    def write(self) -> Callable[..., list[Path]]:
        """The target's `write`; imports its module."""
        function: Callable[..., list[Path]] = self._module().write
        return function

    @property
    def read(self) -> Callable[[Path], Any] | None:
        """The target's `read`, or None where the format cannot be read back; imports its module."""
        function: Callable[[Path], Any] | None = getattr(self._module(), "read", None)
        return function

    def _module(self) -> Any:
        return import_module(f"mixlight.export.{self.name}")


TARGETS: Mapping[str, Target] = MappingProxyType(
    {
        target.name: target
        for target in (
            Target("blender", "script and extension that build world nodes and Suns", verified=True),
            Target("three", "three.js: map, Object JSON of probe and lights, snippet", verified=True),
            Target("gltf", "glTF 2.0 with KHR_lights_punctual, and the map", verified=True),
            Target("usd", "stage with DomeLight and DistantLights", verified=True),
            Target("unity", "map, lights, SphericalHarmonicsL2, menu entry", verified=False),
            Target("unreal", "map, lights, harmonics, editor script", verified=False),
            Target("arcore", "LightEstimate as JSON: main light and harmonics", verified=False),
            Target("arkit", "ARDirectionalLightEstimate as JSON: main light and harmonics", verified=False),
            Target("filament", "harmonics, lights, and a map for cmgen", verified=True),
            Target("mitsuba", "scene with envmap and directional emitters", verified=True),
            Target("webxr", "XRLightEstimate as JSON: main light and harmonics", verified=True),
            Target("cubemap", "six faces, OpenEXR and Radiance", verified=True),
            Target("onnx", "the network itself, in one file", verified=True, of="model"),
        )
    }
)
"""Every target, by name."""


def select(names: Iterable[str]) -> list[Target]:
    """The targets of some names, each once, in the order given; "all" stands for every target of light.

    Raises:
        ValueError: an unknown name; the message lists the known ones.

    >>> [target.name for target in select(["usd,three", "usd"])]
    ['usd', 'three']
    """
    found: dict[str, Target] = {}
    for name in (part.strip() for entry in names for part in entry.split(",")):
        if name == "all":
            found |= {known: target for known, target in TARGETS.items() if target.of == "light"}
        elif name in TARGETS:
            found.setdefault(name, TARGETS[name])
        else:
            raise ValueError(f"expected targets out of {', '.join(TARGETS)} or all, received {name!r}")
    return list(found.values())


def write_target(target: Target, source: "Rig | str | Path", out: Path, **options: Any) -> list[Path]:
    """Write one target into the folder of its name in `out`, all of its files or none.

    Files of ours from an earlier run are replaced; others that lie in the folder stay.

    Args:
        target: which.
        source: the rig, or for a target of the model the model's name or path.
        out: an existing folder.
        options: what only this target's `write` takes (`precision` of onnx).

    Returns:
        The files, in the target's own order.

    Raises:
        ValueError: what the target cannot write.
        OSError: the folder cannot be written to.
    """
    from mixlight.image.atomic import atomic_folder  # not quick to import, and `--help` lists the targets

    folder = out / target.name
    with atomic_folder(folder) as fresh:
        return [folder / path.relative_to(fresh) for path in target.write(source, fresh, **options)]
