"""The surfaces that a building shares: walls, ceilings, trim, frames, doors, metal."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from mixlight.data.rooms.palette import (
    UPRIGHT,
    choose,
    floor,
    jittered,
    paint_colour,
    shaded,
    with_reflectance,
    wood_colour,
)
from mixlight.data.rooms.plan import Colour, Surface

__all__ = ["Palette", "draw_palette"]


@dataclass(frozen=True)
class Palette:
    """The surfaces that a building shares."""

    wall: Surface
    accent: Surface | None
    """For one wall of the main space."""
    ceiling: Surface
    floor: Surface
    skirting: Surface | None
    frame: Surface
    """Of windows."""
    door: Surface
    trim: Surface
    """Of door frames and wall panels."""
    metal: Surface
    """Of handles, rods and radiators."""


def _wall(rng: Random, kind: str, colour: Colour) -> Surface:
    seed = rng.randrange(10_000)
    rough = round(rng.uniform(0.55, 0.95), 3)
    raw = {"workshop": 0.4, "shop": 0.15, "hall": 0.12, "office": 0.08, "empty": 0.1, "bathroom": 0.0}.get(
        kind, 0.03
    )
    if rng.random() < raw:
        if rng.random() < 0.5:
            tint = choose(rng, [((1.0, 0.44, 0.26), 3.0), ((1.0, 0.98, 0.95), 2.0), ((1.0, 0.7, 0.45), 1.0)])
            high = 0.6 if tint[1] > 0.9 else 0.24
            return Surface(
                "brick",
                with_reflectance(jittered(rng, tint), rng.uniform(0.12, high)),
                (0.34, 0.31, 0.27),
                0.9,
                bump=0.6,
                seed=seed,
            )
        return Surface(
            "concrete",
            with_reflectance((1.0, 0.98, 0.95), rng.uniform(0.18, 0.42)),
            None,
            0.85,
            bump=0.2,
            seed=seed,
        )
    homely = kind in ("living", "bedroom", "hall", "corridor")
    if homely and rng.random() < 0.09:
        return Surface(
            "wallpaper",
            colour,
            shaded(colour, rng.choice([0.6, 0.8, 0.88, 1.12])),
            0.8,
            scale=round(rng.uniform(0.6, 2.0), 2),
            seed=seed,
        )
    if rng.random() < 0.12:
        return Surface(
            "plaster", colour, shaded(colour, 0.9), rough, bump=round(rng.uniform(0.1, 0.4), 2), seed=seed
        )
    return Surface("paint", colour, None, rough, bump=0.05, seed=seed)


def draw_palette(rng: Random, kind: str) -> Palette:
    """The surfaces of a plan whose main space is of this kind."""
    colour = paint_colour(rng)
    wall = _wall(rng, kind, colour)
    accent = None
    if rng.random() < 0.2:
        if rng.random() < 0.25:
            accent = Surface(
                "planks", wood_colour(rng), roughness=0.5, bump=0.1, turn=rng.choice([0.0, UPRIGHT])
            )
        else:
            accent = _wall(rng, kind, paint_colour(rng, calm=0.35))
    white = with_reflectance((1.0, 0.985, 0.955), rng.uniform(0.62, 0.82))
    ceiling = Surface("paint", white, None, 0.95, seed=rng.randrange(10_000))
    if kind in ("workshop", "shop") and rng.random() < 0.35:
        ceiling = Surface(
            "concrete", with_reflectance((1.0, 0.98, 0.95), rng.uniform(0.08, 0.4)), None, 0.9, bump=0.2
        )
    elif kind in ("living", "hall", "bedroom", "kitchen") and rng.random() < 0.06:
        ceiling = Surface("planks", wood_colour(rng), roughness=0.6, scale=rng.uniform(0.8, 1.3), bump=0.15)
    trim_colour = choose(
        rng, [(white, 3.0), (wood_colour(rng), 1.2), (with_reflectance((1, 0.97, 0.93), 0.3), 0.4)]
    )
    trim = Surface(
        "paint" if trim_colour == white else "wood", trim_colour, roughness=round(rng.uniform(0.25, 0.5), 3)
    )
    skirting = trim if kind not in ("workshop",) and rng.random() < 0.85 else None
    frame = choose(
        rng,
        [
            (
                Surface("paint", with_reflectance((1.0, 0.99, 0.98), rng.uniform(0.6, 0.8)), roughness=0.35),
                5.0,
            ),
            (Surface("wood", wood_colour(rng), roughness=0.45), 1.8),
            (Surface("metal", (0.05, 0.05, 0.052), roughness=0.45, metallic=0.4), 1.6),
            (Surface("metal", (0.45, 0.45, 0.45), roughness=0.4, metallic=0.8), 1.2),
        ],
    )
    door = choose(
        rng,
        [
            (Surface("paint", shaded(white, rng.uniform(0.9, 1.0)), roughness=0.4), 4.0),
            (Surface("wood", wood_colour(rng), roughness=0.45, bump=0.1, turn=UPRIGHT), 3.5),
            (Surface("paint", paint_colour(rng, calm=0.5), roughness=0.4), 1.0),
        ],
    )
    metal = choose(
        rng,
        [
            (Surface("metal", (0.55, 0.55, 0.54), roughness=0.3, metallic=1.0), 3.0),
            (Surface("metal", (0.5, 0.36, 0.14), roughness=0.3, metallic=1.0), 1.0),
            (Surface("metal", (0.04, 0.04, 0.04), roughness=0.5, metallic=0.5), 1.2),
        ],
    )
    return Palette(wall, accent, ceiling, floor(rng, kind), skirting, frame, door, trim, metal)
