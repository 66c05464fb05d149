"""Our own parametric pieces: everything that a room may hold, made from numbers, without any library."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from random import Random

from mixlight.data.rooms import shapes
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.palette import choose
from mixlight.data.rooms.pieces import (
    bathrooms,
    beds,
    electronics,
    floor_things,
    hung,
    kitchens,
    plants,
    seating,
    shelves,
    tables,
    tableware,
    tools,
    trade,
    trifles,
    wardrobes,
)
from mixlight.data.rooms.pieces.kitchens import draw_kitchen, draw_wall_cabinet
from mixlight.data.rooms.pieces.piece import Piece
from mixlight.data.rooms.pieces.style import Style, draw_style
from mixlight.data.rooms.plan import Item

__all__ = [
    "PIECES",
    "Piece",
    "Style",
    "draw",
    "draw_kitchen",
    "draw_style",
    "draw_wall_cabinet",
    "parts",
    "parts_of",
    "pieces_of",
]

_MODULES = (
    seating,
    tables,
    shelves,
    wardrobes,
    beds,
    kitchens,
    bathrooms,
    electronics,
    hung,
    plants,
    tableware,
    trifles,
    floor_things,
    trade,
    tools,
)

PIECES: dict[str, Piece] = {piece.name: piece for module in _MODULES for piece in module.PIECES}
"""Every piece by its name, which an item's `piece` gives as own:NAME."""


def pieces_of(kind: str) -> tuple[Piece, ...]:
    """Our pieces of a kind of the catalogue."""
    return tuple(piece for piece in PIECES.values() if piece.kind == kind)


def draw(kind: str, rng: Random, style: Style) -> Item:
    """One of our pieces of a kind, standing at the origin.

    Raises:
        ValueError: we make none of this kind.
    """
    found = pieces_of(kind)
    if not found:
        raise ValueError(f"expected a kind of which we make pieces, received {kind!r}")
    return choose(rng, [(piece, piece.weight) for piece in found]).make(rng, style)


def parts_of(items: Iterable[Item]) -> list[Part]:
    """The parts of all pieces of ours among some items; pieces that are alike are built once.

    Raises:
        ValueError: a piece that we do not make.
    """
    built: dict[str, list[Part]] = {}
    found: list[Part] = []
    for item in items:
        if not item.piece.startswith("own:"):
            continue
        key = repr((item.piece, item.size, item.surfaces, item.parameters))
        if key not in built:
            built[key] = parts(replace(item, position=(0.0, 0.0, 0.0), turn=0.0))
        matrix = shapes.placement(item.position, item.turn)
        found.extend(shapes.move(part, matrix) for part in built[key])
    return found


def parts(item: Item) -> list[Part]:
    """The parts of one of our own pieces in the room frame, where the item stands.

    Raises:
        ValueError: the item is no piece of ours.
    """
    name = item.piece.removeprefix("own:")
    if name not in PIECES or not item.piece.startswith("own:"):
        raise ValueError(f"expected own:NAME with a NAME that mixlight makes, received {item.piece!r}")
    matrix = shapes.placement(item.position, item.turn)
    return [shapes.move(part, matrix) for part in PIECES[name].build(item)]
