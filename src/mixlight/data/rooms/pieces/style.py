"""The materials that the furniture of one room shares: a home is not furnished from a colour wheel."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from mixlight.data.rooms.palette import choose, wood_colour
from mixlight.data.rooms.plan import Colour, Surface

__all__ = ["CARDBOARD", "RAW_WOOD", "Style", "draw_style", "tone"]


@dataclass(frozen=True)
class Style:
    """What the pieces of a room are made of."""

    wood: Surface
    """Most furniture."""
    wood_2: Surface
    """The pieces that do not match."""
    front: Surface
    """Doors and drawers of kitchens, wardrobes and office furniture."""
    counter: Surface
    metal: Surface
    """Legs and handles."""
    dark_metal: Surface
    plastic: Surface
    ceramic: Surface
    screen: Surface
    """Glass of a screen that is off."""
    glass: Surface
    leaf: Surface
    paper: Surface
    upholstery: Surface
    upholstery_2: Surface
    linen: Surface
    """Bedclothes and towels."""
    rug: Surface
    accents: tuple[Surface, ...]
    """Small things: mostly quiet, some bright."""
    books: tuple[Surface, ...]
    """Spines."""


CARDBOARD = Surface("paper", (0.33, 0.21, 0.11), roughness=0.9)
"""Of boxes."""
RAW_WOOD = Surface("wood", (0.36, 0.23, 0.12), roughness=0.75)
"""Of crates, pallets and boards."""


def tone(rng: Random, tint: Colour, low: float, high: float, *, spread: float = 0.05) -> Colour:
    """A tint brought to a luminous reflectance between `low` and `high`, each channel a little off.

    >>> tone(Random(0), (1.0, 1.0, 1.0), 0.5, 0.5, spread=0.0)
    (0.5, 0.5, 0.5)
    """
    r, g, b = (c * (1 + rng.uniform(-spread, spread)) for c in tint)
    factor = rng.uniform(low, high) / (0.2126 * r + 0.7152 * g + 0.0722 * b)
    r, g, b = (round(min(max(c * factor, 0.012), 0.86), 4) for c in (r, g, b))
    return r, g, b


_UPHOLSTERY = (
    (((1.0, 0.97, 0.93), 0.05, 0.3), 4.0),  # greys
    (((1.0, 0.88, 0.72), 0.18, 0.45), 3.0),  # beige
    (((1.0, 0.62, 0.38), 0.04, 0.14), 2.0),  # browns
    (((0.45, 0.62, 1.0), 0.03, 0.14), 1.5),
    (((0.5, 0.9, 0.65), 0.03, 0.15), 1.2),
    (((1.0, 0.35, 0.25), 0.06, 0.16), 0.8),
    (((1.0, 0.72, 0.2), 0.2, 0.35), 0.5),
    (((1.0, 0.97, 0.94), 0.5, 0.65), 1.0),
    (((1.0, 0.95, 0.92), 0.02, 0.04), 1.2),
)

_BRIGHT = (
    ((1.0, 0.12, 0.07), 0.1, 0.2),
    ((0.1, 0.25, 1.0), 0.04, 0.15),
    ((1.0, 0.65, 0.05), 0.3, 0.5),
    ((0.1, 0.6, 0.25), 0.08, 0.2),
    ((1.0, 0.4, 0.05), 0.2, 0.35),
    ((0.15, 0.6, 0.7), 0.1, 0.3),
    ((0.75, 0.2, 0.6), 0.08, 0.25),
)


def upholstery(rng: Random, *, leather: float = 0.2) -> Surface:
    """Cloth or leather for something to sit on."""
    tint, low, high = choose(rng, _UPHOLSTERY)
    colour = tone(rng, tint, low, high)
    if rng.random() < leather:
        brown = tone(rng, rng.choice([(1.0, 0.55, 0.3), (1.0, 0.94, 0.9), (1.0, 0.45, 0.2)]), 0.02, 0.14)
        return Surface("leather", brown, roughness=rng.uniform(0.3, 0.55), bump=0.25, seed=rng.randrange(99))
    return Surface("fabric", colour, roughness=0.95, bump=0.35, scale=rng.choice([0.7, 1.0, 1.5]))


def _wood(rng: Random) -> Surface:
    if rng.random() < 0.22:  # lacquered, or a plain laminate
        colour = tone(
            rng,
            (1.0, 0.985, 0.95),
            *rng.choice([(0.6, 0.78), (0.6, 0.78), (0.02, 0.05), (0.2, 0.45)]),
            spread=0.015,
        )
        return Surface("paint", colour, roughness=rng.uniform(0.2, 0.5))
    return Surface(
        "wood",
        wood_colour(rng),
        roughness=round(rng.uniform(0.25, 0.6), 3),
        scale=round(rng.uniform(0.7, 1.4), 2),
        bump=0.05,
        seed=rng.randrange(1000),
    )


def _rug(rng: Random) -> Surface:
    tint, low, high = choose(rng, _UPHOLSTERY)
    return Surface(
        "carpet",
        tone(rng, tint, low, min(high * 1.4, 0.6)),
        tone(rng, rng.choice(_UPHOLSTERY)[0][0], 0.05, 0.45) if rng.random() < 0.6 else None,
        roughness=1.0,
        scale=rng.choice([0.5, 1.0, 2.0, 4.0]),
        bump=0.7,
        seed=rng.randrange(1000),
    )


def draw_style(rng: Random) -> Style:
    """The materials of one room's things."""
    metal = rng.choice(
        [
            Surface("metal", (0.56, 0.56, 0.55), roughness=0.28, metallic=1.0),
            Surface("metal", (0.62, 0.62, 0.61), roughness=0.12, metallic=1.0),
            Surface("metal", (0.42, 0.42, 0.41), roughness=0.45, metallic=1.0),
            Surface("metal", (0.035, 0.035, 0.037), roughness=0.5),
            Surface("metal", (0.55, 0.4, 0.17), roughness=0.3, metallic=1.0),
        ]
    )
    fronts = (
        (((1.0, 0.985, 0.95), 0.58, 0.78), 4.0),
        (((1.0, 0.98, 0.94), 0.2, 0.5), 2.0),
        (((1.0, 0.97, 0.95), 0.02, 0.06), 1.0),
        (((0.6, 0.75, 0.9), 0.08, 0.3), 1.0),
        (((0.7, 0.9, 0.7), 0.12, 0.35), 0.8),
    )
    tint, low, high = choose(rng, fronts)
    front = (
        Surface("paint", tone(rng, tint, low, high, spread=0.02), roughness=rng.uniform(0.12, 0.5))
        if rng.random() < 0.68
        else Surface("wood", wood_colour(rng), roughness=0.4, seed=rng.randrange(1000))
    )
    counter = choose(
        rng,
        [
            (Surface("stone", tone(rng, (1, 0.98, 0.95), 0.03, 0.12), roughness=0.15, scale=0.4), 2.5),
            (Surface("stone", tone(rng, (1, 0.97, 0.93), 0.3, 0.65), roughness=0.2, scale=0.5), 2.0),
            (Surface("wood", wood_colour(rng), roughness=0.4, scale=0.6), 2.5),
            (Surface("metal", (0.5, 0.5, 0.49), roughness=0.35, metallic=1.0), 0.7),
        ],
    )
    accents = []
    for _ in range(9):
        if rng.random() < 0.62:
            tint, low, high = choose(rng, _UPHOLSTERY)
        else:
            tint, low, high = rng.choice(_BRIGHT)
        kind = rng.choice(["plastic", "plastic", "paint", "wood", "metal"])
        accents.append(
            Surface(
                kind,
                tone(rng, tint, low, high, spread=0.12) if kind != "wood" else wood_colour(rng),
                roughness=round(rng.uniform(0.15, 0.7), 2),
                metallic=1.0 if kind == "metal" and rng.random() < 0.6 else 0.0,
            )
        )
    books = []
    for _ in range(8):
        tint, low, high = choose(rng, [*_UPHOLSTERY, *((bright, 0.8) for bright in _BRIGHT)])
        books.append(Surface("paper", tone(rng, tint, low, high, spread=0.15), roughness=0.6))
    return Style(
        wood=_wood(rng),
        wood_2=_wood(rng),
        front=front,
        counter=counter,
        metal=metal,
        dark_metal=Surface("metal", (0.03, 0.03, 0.032), roughness=0.45),
        plastic=Surface(
            "plastic", tone(rng, (1, 0.99, 0.97), *rng.choice([(0.02, 0.05), (0.5, 0.7)])), roughness=0.4
        ),
        ceramic=Surface("plastic", tone(rng, (1, 0.99, 0.97), 0.68, 0.8, spread=0.01), roughness=0.08),
        screen=Surface("plastic", (0.012, 0.012, 0.014), roughness=rng.choice([0.06, 0.12, 0.3])),
        glass=Surface("glass", (0.93, 0.97, 0.95), roughness=0.0, transmission=1.0),
        leaf=Surface("plant", tone(rng, (0.35, 1.0, 0.18), 0.03, 0.12, spread=0.12), roughness=0.45),
        paper=Surface("paper", (0.72, 0.71, 0.68), roughness=0.8),
        upholstery=upholstery(rng),
        upholstery_2=upholstery(rng, leather=0.1),
        linen=Surface(
            "fabric",
            tone(rng, *choose(rng, [(((1.0, 0.985, 0.95), 0.55, 0.75), 3.0), *_UPHOLSTERY])),
            roughness=0.95,
            bump=0.2,
        ),
        rug=_rug(rng),
        accents=tuple(accents),
        books=tuple(books),
    )
