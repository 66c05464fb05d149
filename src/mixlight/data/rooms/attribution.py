"""Who made what a data set of rooms was made with: the text that lies beside it."""

from __future__ import annotations

from collections.abc import Iterable

from mixlight.data.rooms.catalogue import Entry

__all__ = ["attribution"]

_LICENCES = {
    "CC0-1.0": "https://creativecommons.org/publicdomain/zero/1.0/",
    "CC-BY-3.0": "https://creativecommons.org/licenses/by/3.0/",
    "BSD-3-Clause": "https://opensource.org/license/bsd-3-clause",
    "CC-BY-3.0-US": "https://creativecommons.org/licenses/by/3.0/us/",
}
"""Full texts of the licences in the library."""


def attribution(entries: Iterable[Entry], *, skies: Iterable[str] = ()) -> str:
    """The text of ATTRIBUTION.txt: what was taken from others, by whom, under which licence.

    Args:
        entries: the objects of the library that the rooms use.
        skies: names of the outdoor panoramas behind the windows.

    Returns:
        Plain text that ends in a newline; the same for the same things in any order.

    >>> print(attribution([]).splitlines()[0])
    Rooms rendered by MixLight
    """
    lines = [
        "Rooms rendered by MixLight",
        "",
        "Walls, windows, lamps and all furniture that is not listed here were made by MixLight from numbers;",
        "nobody else has a claim on them.",
    ]
    models = sorted({(e.licence, e.source, e.creator, e.title) for e in entries})
    if models:
        lines += [
            "",
            f"3D models ({len(models)}), rendered in the rooms. Changed: converted from",
            "OBJ, scaled, joined to one mesh, thinned above 30,000 faces, pictures made smaller,",
            "recoloured in part.",
        ]
        group = None
        for licence, source, creator, title in models:
            if (licence, source) != group:
                group = (licence, source)
                where = _LICENCES.get(licence)
                lines += ["", f"{source}, {licence}" + (f" <{where}>" if where else "") + ":"]
            lines.append(f"  {title}" + (f", by {creator}" if creator else ""))
    named = sorted(set(skies))
    if named:
        lines += [
            "",
            f"Outdoor panoramas ({len(named)}) behind the windows; their sun was replaced by a lamp:",
            "",
        ]
        lines += [f"  {name}" for name in named]
    return "\n".join(lines) + "\n"
