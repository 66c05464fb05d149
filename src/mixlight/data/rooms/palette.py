"""What things are made of: calm paint, floors, tiles, wood, fabrics.

Colours are linear reflectances as real things have them: white wall paint .6 to .82 (fresh paint has .85, a
lived-in wall less), beige .45 to .65, oak floors .1 to .3, carpets .05 to .35.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import TypeVar

from mixlight.data.rooms.plan import Colour, Surface

__all__ = [
    "UPRIGHT",
    "choose",
    "fabric",
    "floor",
    "jittered",
    "paint_colour",
    "reflectance",
    "shaded",
    "tiles",
    "with_reflectance",
    "wood_colour",
]

T = TypeVar("T")

WOODS: tuple[tuple[str, Colour, float], ...] = (
    ("light oak", (0.34, 0.225, 0.125), 4.0),
    ("oak", (0.235, 0.14, 0.072), 5.0),
    ("honey pine", (0.37, 0.21, 0.085), 2.0),
    ("beech", (0.40, 0.25, 0.14), 2.0),
    ("walnut", (0.115, 0.062, 0.033), 3.0),
    ("cherry", (0.19, 0.075, 0.034), 1.5),
    ("wenge", (0.040, 0.026, 0.019), 1.5),
    ("grey oak", (0.235, 0.2, 0.165), 2.0),
    ("whitewashed", (0.44, 0.385, 0.32), 1.0),
)
"""Name, mean colour, how common."""

UPRIGHT = 1.5707963
"""Turn of a pattern whose grain runs up a wall."""

CALM = 0.75
"""Share of walls that are white, grey or beige."""


def choose(rng: Random, options: Sequence[tuple[T, float]]) -> T:
    """One of the options, as often as its weight says.

    >>> choose(Random(1), [("a", 0.0), ("b", 2.0)])
    'b'
    """
    return rng.choices([option for option, _ in options], [weight for _, weight in options])[0]


def reflectance(colour: Colour) -> float:
    """Luminous reflectance of a colour (Rec.709 weights).

    >>> reflectance((0.5, 0.5, 0.5))
    0.5
    """
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]


def shaded(colour: Colour, factor: float) -> Colour:
    """A colour made darker or lighter; its channels stay between .015 and .88, as those of real things do."""
    r, g, b = (round(min(max(c * factor, 0.015), 0.88), 4) for c in colour)
    return r, g, b


def with_reflectance(colour: Colour, luminous: float) -> Colour:
    """A tint as a colour of this luminous reflectance.

    >>> with_reflectance((1.0, 0.9, 0.75), 0.5)
    (0.5492, 0.4943, 0.4119)
    """
    return shaded(colour, luminous / reflectance(colour))


def jittered(rng: Random, colour: Colour, amount: float = 0.04) -> Colour:
    """A colour with each channel changed by at most `amount` of itself."""
    r, g, b = (c * (1 + rng.uniform(-amount, amount)) for c in colour)
    return r, g, b


def wood_colour(rng: Random) -> Colour:
    """The mean colour of a wood."""
    colour = choose(rng, [(colour, weight) for _, colour, weight in WOODS])
    return shaded(jittered(rng, colour, 0.06), rng.uniform(0.8, 1.2))


def paint_colour(rng: Random, *, calm: float = CALM) -> Colour:
    """The colour of a painted wall: white, grey or beige with probability `calm`, else one with a hue."""
    if rng.random() < calm:
        tone = choose(rng, [("white", 5.0), ("beige", 2.2), ("grey", 1.8)])
        if tone == "white":
            tint = choose(
                rng, [((1.0, 0.975, 0.925), 3.0), ((1.0, 0.995, 0.98), 2.0), ((0.97, 0.99, 1.0), 1.0)]
            )
            return with_reflectance(jittered(rng, tint, 0.012), rng.uniform(0.58, 0.8))
        if tone == "beige":
            tint = choose(rng, [((1.0, 0.9, 0.75), 2.0), ((1.0, 0.87, 0.69), 1.0), ((1.0, 0.92, 0.83), 1.5)])
            return with_reflectance(jittered(rng, tint, 0.02), rng.uniform(0.4, 0.66))
        tint = choose(rng, [((1.0, 0.98, 0.95), 1.5), ((0.95, 0.98, 1.0), 1.0)])
        return with_reflectance(jittered(rng, tint, 0.015), rng.uniform(0.25, 0.58))
    tint, low, high = choose(
        rng,
        [
            (((0.78, 1.0, 0.80), 0.3, 0.6), 2.0),  # sage
            (((0.72, 0.88, 1.0), 0.3, 0.6), 2.0),  # pale blue
            (((1.0, 0.80, 0.72), 0.35, 0.6), 1.3),  # blush
            (((1.0, 0.86, 0.50), 0.4, 0.62), 1.5),  # yellow
            (((0.30, 0.50, 1.0), 0.04, 0.16), 1.0),  # navy
            (((0.45, 1.0, 0.60), 0.05, 0.2), 1.0),  # forest
            (((1.0, 0.38, 0.20), 0.1, 0.26), 1.0),  # terracotta
            (((1.0, 0.9, 0.85), 0.03, 0.1), 0.8),  # near black
            (((1.0, 0.35, 0.42), 0.05, 0.15), 0.5),  # wine
        ],
    )
    return with_reflectance(jittered(rng, tint, 0.06), rng.uniform(low, high))


def tiles(rng: Random, *, wall: bool) -> Surface:
    """Ceramic tiles, for a wall or a floor."""
    if wall:
        tint, low, high = choose(
            rng,
            [
                (((1.0, 0.99, 0.97), 0.6, 0.78), 5.0),
                (((1.0, 0.92, 0.8), 0.4, 0.65), 2.0),
                (((0.96, 0.98, 1.0), 0.2, 0.5), 2.0),
                (((0.7, 0.95, 1.0), 0.25, 0.5), 1.0),
                (((0.6, 1.0, 0.75), 0.1, 0.4), 0.7),
                (((1.0, 0.98, 0.95), 0.04, 0.1), 0.7),
            ],
        )
        scale = rng.choice([0.33, 0.5, 0.67, 1.0, 1.0, 2.0])
    else:
        tint, low, high = choose(
            rng,
            [
                (((1.0, 0.93, 0.84), 0.2, 0.42), 3.0),
                (((0.98, 1.0, 1.0), 0.1, 0.32), 3.0),
                (((1.0, 0.97, 0.93), 0.04, 0.12), 1.7),
                (((1.0, 0.45, 0.26), 0.1, 0.22), 1.3),
                (((1.0, 0.99, 0.97), 0.42, 0.6), 0.6),
            ],
        )
        scale = rng.choice([0.67, 1.0, 1.0, 1.5, 2.0])
    colour = with_reflectance(jittered(rng, tint, 0.03), rng.uniform(low, high))
    grout = with_reflectance(
        (1.0, 0.96, 0.9), min(max(reflectance(colour) * rng.choice([0.5, 0.7, 1.3]), 0.06), 0.6)
    )
    return Surface(
        "tile",
        colour,
        second=grout,
        roughness=round(rng.uniform(0.08, 0.45), 3),
        scale=scale,
        bump=0.2,
        seed=rng.randrange(10_000),
    )


def fabric(rng: Random, *, transmission: float = 0.0) -> Surface:
    """Cloth for curtains: mostly quiet, sometimes dark or of a colour."""
    tint, low, high = choose(
        rng,
        [
            (((1.0, 0.96, 0.88), 0.45, 0.7), 4.0),
            (((1.0, 0.98, 0.96), 0.15, 0.45), 3.0),
            (((1.0, 0.85, 0.65), 0.2, 0.5), 2.0),
            (((0.5, 0.7, 1.0), 0.06, 0.3), 1.2),
            (((0.6, 1.0, 0.65), 0.08, 0.3), 1.0),
            (((1.0, 0.42, 0.3), 0.08, 0.25), 1.0),
            (((1.0, 0.95, 0.9), 0.03, 0.1), 1.0),
        ],
    )
    colour = with_reflectance(jittered(rng, tint, 0.05), rng.uniform(low, high))
    kind = "translucent" if transmission > 0 else "fabric"
    return Surface(
        kind,
        colour,
        roughness=0.95,
        transmission=round(transmission, 3),
        bump=0.2,
        seed=rng.randrange(10_000),
    )


_FLOORS: dict[str, tuple[tuple[str, float], ...]] = {
    "living": (
        ("planks", 5.5),
        ("parquet", 1.2),
        ("carpet", 1.8),
        ("tile", 1.2),
        ("concrete", 0.3),
        ("stone", 0.3),
    ),
    "bedroom": (("planks", 4.5), ("parquet", 0.8), ("carpet", 4.0), ("tile", 0.5)),
    "office": (("carpet", 5.5), ("planks", 2.5), ("concrete", 0.8), ("tile", 0.7)),
    "kitchen": (("tile", 5.0), ("planks", 3.5), ("stone", 0.8), ("parquet", 0.5), ("concrete", 0.3)),
    "bathroom": (("tile", 8.0), ("stone", 1.5), ("planks", 0.6)),
    "hall": (
        ("stone", 3.0),
        ("tile", 2.5),
        ("planks", 2.0),
        ("parquet", 1.0),
        ("carpet", 1.5),
        ("concrete", 0.8),
    ),
    "corridor": (("tile", 2.5), ("planks", 2.5), ("carpet", 2.5), ("stone", 1.2), ("concrete", 0.5)),
    "shop": (("tile", 3.0), ("planks", 2.5), ("concrete", 2.0), ("stone", 1.0), ("carpet", 0.8)),
    "workshop": (("concrete", 6.5), ("planks", 1.5), ("tile", 0.8)),
    "empty": (("planks", 3.5), ("carpet", 2.0), ("concrete", 2.0), ("tile", 1.5), ("parquet", 1.0)),
}


def floor(rng: Random, kind: str) -> Surface:
    """A floor for a space of this kind; reflectance .03 to .5, mostly .1 to .35."""
    made_of = choose(rng, _FLOORS[kind])
    seed = rng.randrange(10_000)
    turn = rng.choice([0.0, UPRIGHT])
    if made_of in ("planks", "parquet"):
        colour = wood_colour(rng)
        return Surface(
            "planks",
            colour,
            second=shaded(colour, rng.uniform(0.5, 0.85)),
            roughness=round(rng.uniform(0.22, 0.6), 3),
            scale=round(rng.uniform(0.8, 1.8) if made_of == "planks" else rng.uniform(0.4, 0.65), 3),
            bump=0.1,
            turn=turn if made_of == "planks" else turn + 0.7853982,
            seed=seed,
        )
    if made_of == "carpet":
        tint, low, high = choose(
            rng,
            [
                (((1.0, 0.9, 0.76), 0.12, 0.32), 3.0),
                (((0.97, 0.99, 1.0), 0.035, 0.2), 4.0),
                (((0.6, 0.75, 1.0), 0.04, 0.14), 1.5),
                (((1.0, 0.45, 0.38), 0.05, 0.14), 0.8),
                (((0.6, 1.0, 0.7), 0.05, 0.15), 0.6),
            ],
        )
        colour = with_reflectance(jittered(rng, tint, 0.04), rng.uniform(low, high))
        return Surface(
            "carpet", colour, second=shaded(colour, 0.7), roughness=1.0, bump=0.5, turn=turn, seed=seed
        )
    if made_of == "tile":
        return replace(tiles(rng, wall=False), turn=rng.choice([0.0, 0.0, 0.0, 0.7853982]))
    if made_of == "stone":
        tint = choose(rng, [((1.0, 0.95, 0.86), 2.0), ((0.98, 1.0, 1.0), 1.5), ((1.0, 0.85, 0.7), 0.8)])
        colour = with_reflectance(tint, rng.choice([rng.uniform(0.2, 0.42), rng.uniform(0.04, 0.18)]))
        return Surface(
            "stone", colour, second=shaded(colour, 0.6), roughness=round(rng.uniform(0.1, 0.4), 3), seed=seed
        )
    colour = with_reflectance((1.0, 0.98, 0.94), rng.uniform(0.09, 0.28))
    return Surface("concrete", colour, roughness=round(rng.uniform(0.35, 0.85), 3), bump=0.15, seed=seed)
