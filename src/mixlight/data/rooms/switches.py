"""How people use lights: which are on at what time, and how warm they are, by kind of room."""

from __future__ import annotations

import random

__all__ = ["chance_on", "likely_temperature", "likely_times"]

_WORK = ("office", "shop", "workshop", "hall", "corridor")

_TIMES: dict[str, tuple[float, float, float]] = {
    "living": (0.64, 0.14, 0.22),
    "bedroom": (0.64, 0.14, 0.22),
    "office": (0.80, 0.08, 0.12),
    "kitchen": (0.68, 0.12, 0.20),
    "bathroom": (0.60, 0.12, 0.28),
    "hall": (0.70, 0.10, 0.20),
    "corridor": (0.65, 0.10, 0.25),
    "shop": (0.72, 0.13, 0.15),
    "workshop": (0.80, 0.08, 0.12),
    "empty": (0.85, 0.08, 0.07),
}

_HOME: dict[str, tuple[float, float, float]] = {
    "floor_lamp": (0.12, 0.65, 0.75),
    "table_lamp": (0.12, 0.60, 0.70),
    "sconce": (0.15, 0.50, 0.60),
    "under_cabinet": (0.20, 0.50, 0.60),
    "screen": (0.35, 0.40, 0.40),
    "candle": (0.06, 0.45, 0.55),
    "neighbour": (0.20, 0.55, 0.65),
    "pendant": (0.42, 0.60, 0.62),
}
_WORK_LAMPS = {3000.0: 0.2, 3500.0: 0.15, 4000.0: 0.45, 5000.0: 0.12, 6000.0: 0.08}
_WET_LAMPS = {2700.0: 0.3, 3000.0: 0.35, 4000.0: 0.3, 5000.0: 0.05}
_HOME_LAMPS = {2400.0: 0.12, 2700.0: 0.5, 3000.0: 0.3, 4000.0: 0.08}
_CEILING_HOME = (0.42, 0.55, 0.58)
_CEILING_WORK = (0.82, 0.90, 0.92)


def likely_times(room: str) -> tuple[float, float, float]:
    """Weights of day, dusk and night for pictures of such a room; they sum to 1."""
    return _TIMES.get(room, (0.7, 0.1, 0.2))


def chance_on(kind: str, room: str, time: str) -> float:
    """Probability that a fixture is on.

    Args:
        kind: of the fixture.
        room: kind of the space that it lights.
        time: `day`, `dusk` or `night`.

    >>> chance_on("floor_lamp", "living", "day"), chance_on("panel", "office", "day")
    (0.12, 0.82)
    """
    column = ("day", "dusk", "night").index(time)
    if kind in _HOME and not (kind == "pendant" and room in _WORK):
        return _HOME[kind][column]
    return (_CEILING_WORK if room in _WORK else _CEILING_HOME)[column]


def likely_temperature(room: str, rng: random.Random) -> float:
    """Draws the colour temperature that the lamps of a room have in common, in kelvins."""
    choices = _WORK_LAMPS if room in _WORK else _WET_LAMPS if room in ("kitchen", "bathroom") else _HOME_LAMPS
    return rng.choices(list(choices), list(choices.values()))[0]
