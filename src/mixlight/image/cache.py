"""Where the library keeps what it can make again."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["cache_folder"]


def cache_folder(name: str) -> Path:
    """The user's cache folder for one kind of thing: `$XDG_CACHE_HOME/mixlight/<name>` or below `~/.cache`.

    A relative `XDG_CACHE_HOME` is ignored, as its specification demands. The folder need not exist.

    >>> cache_folder("labels").parts[-2:]
    ('mixlight', 'labels')
    """
    root = Path(os.environ.get("XDG_CACHE_HOME") or "")
    return (root if root.is_absolute() else Path.home() / ".cache") / "mixlight" / name
