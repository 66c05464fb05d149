"""What hangs before the windows of a room, as plain values for `Opening.details`."""

from __future__ import annotations

from random import Random
from typing import Any

from mixlight.data.rooms.palette import choose, fabric
from mixlight.data.rooms.plan_json import surface_document

__all__ = ["draw_dressing", "varied"]

_DRESSINGS: dict[str, tuple[tuple[str, float], ...]] = {
    "living": (
        ("none", 2.0),
        ("curtain", 4.0),
        ("sheer", 2.5),
        ("venetian", 1.0),
        ("roller", 0.8),
        ("roman", 0.6),
    ),
    "bedroom": (
        ("none", 1.0),
        ("curtain", 4.5),
        ("sheer", 2.0),
        ("venetian", 1.2),
        ("roller", 1.2),
        ("roman", 0.8),
    ),
    "office": (
        ("none", 4.0),
        ("curtain", 0.3),
        ("sheer", 0.3),
        ("venetian", 3.5),
        ("roller", 1.8),
        ("vertical", 1.2),
    ),
    "partition": (("none", 8.0), ("venetian", 2.0)),
    "kitchen": (
        ("none", 4.0),
        ("curtain", 1.2),
        ("sheer", 1.2),
        ("venetian", 1.5),
        ("roller", 1.5),
        ("roman", 0.8),
    ),
    "bathroom": (("none", 5.0), ("sheer", 0.8), ("venetian", 1.2), ("roller", 1.5)),
    "corridor": (("none", 4.0), ("curtain", 1.5), ("sheer", 1.0), ("roller", 0.5)),
    "empty": (("none", 7.0), ("roller", 1.0), ("venetian", 0.6)),
}
_PLAIN_DRESSINGS = (("none", 8.0), ("roller", 1.0), ("venetian", 0.6), ("vertical", 0.4), ("curtain", 0.3))


def draw_dressing(rng: Random, kind: str, style: str) -> dict[str, Any]:
    """What hangs before the windows of a room: kind, share drawn, cloth."""
    dressing = choose(rng, _DRESSINGS.get(kind, _PLAIN_DRESSINGS))
    if style in ("clerestory", "shopfront", "industrial", "small") and dressing in (
        "curtain",
        "sheer",
        "roman",
    ):
        dressing = "none"
    if dressing == "none":
        return {"dressing": "none", "drawn": 0.0}
    if dressing == "curtain":
        cloth = fabric(rng, transmission=rng.choice([0.0, rng.uniform(0.05, 0.3)]))
        drawn = choose(rng, [(rng.uniform(0.12, 0.4), 6.0), (rng.uniform(0.4, 0.9), 2.0), (1.0, 0.6)])
        return {
            "dressing": "curtain", "drawn": drawn, "fabric": surface_document(cloth),
            "to_floor": style != "counter" and rng.random() < 0.7, "sheer": rng.random() < 0.25,
            "pelmet": rng.random() < 0.12,
        }  # fmt: skip
    if dressing == "sheer":
        cloth = fabric(rng, transmission=rng.uniform(0.45, 0.75))
        return {
            "dressing": "sheer", "drawn": rng.choice([1.0, rng.uniform(0.3, 1.0)]),
            "fabric": surface_document(cloth), "to_floor": rng.random() < 0.5,
        }  # fmt: skip
    cloth = fabric(rng, transmission=0.0 if dressing == "venetian" else rng.uniform(0.05, 0.45))
    drawn = choose(rng, [(rng.uniform(0.1, 0.6), 3.0), (rng.uniform(0.6, 1.0), 1.5), (1.0, 1.0)])
    return {
        "dressing": dressing, "drawn": drawn, "fabric": surface_document(cloth),
        "tilt": round(rng.uniform(0.0, 1.1), 3),
    }  # fmt: skip


def varied(rng: Random, dressing: dict[str, Any]) -> dict[str, Any]:
    """The same dressing at the next window, not drawn quite as far."""
    drawn = dressing["drawn"]
    if 0 < drawn < 1:
        drawn = min(max(drawn + rng.uniform(-0.12, 0.12), 0.08), 1.0)
    return {**dressing, "drawn": round(drawn, 3)}
