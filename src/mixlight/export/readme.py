"""The three lines of text that every target ships."""

from pathlib import Path

from mixlight.export.rig import Rig

__all__ = ["write_readme"]


def write_readme(folder: Path, rig: Rig, how_to_load: str, checked: str, where: str | None = None) -> Path:
    """Write `README.txt`: how to load it, where the light is, how far it was checked. Three lines, always.

    Args:
        folder: the target's folder.
        rig: what was written.
        how_to_load: one line.
        checked: one line: with which program and version this was run, or that it never was.
        where: one line, for targets without a map; else `accounting` says it.

    Raises:
        ValueError: a line that is empty or holds a line break.

    >>> import tempfile, torch
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> energy = torch.zeros(128, 3)
    >>> energy[40] = energy[100] = 1.0
    >>> rig = make_rig(Lighting(torch.zeros(9, 3), energy), height=16)
    >>> with tempfile.TemporaryDirectory() as name:
    ...     print(write_readme(Path(name), rig, "Load it.", "Never run.").read_text(), end="")
    Load it.
    The map has the 2 lights taken out and they are on: use both together, neither holds the other's light.
    Never run.
    """
    lines = (how_to_load, accounting(rig) if where is None else where, checked)
    for line in lines:
        if not line.strip() or len(line.splitlines()) != 1:
            raise ValueError(f"expected a line of text, received {line!r}")
    path = folder / "README.txt"
    path.write_text("\n".join((*lines, "")), encoding="utf-8")
    return path


def accounting(rig: Rig) -> str:
    """In one line: where the light is, so that nobody counts it twice.

    >>> import torch
    >>> from mixlight.export.rig import make_rig
    >>> from mixlight.light import Lighting
    >>> accounting(make_rig(Lighting(torch.zeros(9, 3), torch.zeros(128, 3)), height=16))
    'The map holds all light; there are no separate lights.'
    """
    count = len(rig.lights)
    if not count:
        return "The map holds all light; there are no separate lights."
    lights, they = ("1 light", "it is") if count == 1 else (f"{count} lights", "they are")
    if rig.lights_on:
        return (
            f"The map has the {lights} taken out and {they} on: "
            "use both together, neither holds the other's light."
        )
    return (
        f"The map holds all light, so the {lights} beside it "
        f"{'is' if count == 1 else 'are'} switched off: switching on counts light twice."
    )
