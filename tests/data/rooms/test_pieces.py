"""Our own pieces: each fills its box, faces out, and is the same every time."""

from __future__ import annotations

import json
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from mixlight.data.rooms import pieces
from mixlight.data.rooms.catalogue import KINDS
from mixlight.data.rooms.mesh import Part
from mixlight.data.rooms.palette import reflectance
from mixlight.data.rooms.pieces.plants import leaf
from mixlight.data.rooms.pieces.style import draw_style
from mixlight.data.rooms.plan import SURFACES, Item

TAPS = {"kitchen": 0.3, "bath": 0.15}
"""Metres that a tap may stand above its piece: nothing is put there."""


def make(name: str, seed: int) -> Item:
    rng = Random(seed)
    return pieces.PIECES[name].make(rng, draw_style(rng))


def points(parts: list[Part]) -> np.ndarray:
    return np.concatenate([part.mesh.vertices for part in parts])


@pytest.mark.parametrize("name", pieces.PIECES)
def test_a_piece_fills_its_box_and_keeps_to_it(name: str) -> None:
    for seed in range(3):
        item = make(name, seed)
        parts = pieces.parts(item)
        low, high = points(parts).min(0), points(parts).max(0)
        half = np.array([item.size[0] / 2, item.size[1] / 2, item.size[2]])
        slack = np.array([0.02, 0.02, TAPS.get(name, 0.02)])
        assert (low >= [-half[0] - 0.02, -half[1] - 0.02, -0.009]).all(), (item, low)
        assert (high <= half + slack).all(), (item, high)
        largest = int(np.argmax(item.size))
        assert (high - low)[largest] > 0.5 * item.size[largest], item


@pytest.mark.parametrize("name", pieces.PIECES)
def test_parts_are_sound(name: str) -> None:
    item = make(name, 5)
    parts = pieces.parts(item)
    assert sum(len(part.mesh.faces) for part in parts) < 12_000
    for part in parts:
        mesh = part.mesh
        assert part.material in item.surfaces
        assert np.isfinite(mesh.vertices).all()
        assert mesh.uv is not None
        assert mesh.uv.shape == (len(mesh.faces), 4, 2)
        assert np.isfinite(mesh.uv).all()
        assert mesh.faces.max() < len(mesh.vertices)
        corners = mesh.vertices[mesh.faces[:, :3]]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        assert (areas > 0).mean() > 0.9


@pytest.mark.parametrize("name", pieces.PIECES)
def test_a_piece_is_plain_data_and_the_same_every_time(name: str) -> None:
    item = make(name, 7)
    assert item == make(name, 7)
    assert item.kind in KINDS
    assert item.piece == f"own:{name}"
    again = replace(item, parameters=json.loads(json.dumps(item.parameters)))
    for a, b in zip(pieces.parts(item), pieces.parts(again), strict=True):
        assert a.mesh.vertices == pytest.approx(b.mesh.vertices, abs=0)
        assert a.material == b.material


def test_a_piece_goes_where_its_item_stands() -> None:
    item = make("desk", 1)
    moved = replace(item, position=(2.0, 3.0, 0.5), turn=np.pi / 2)
    a, b = points(pieces.parts(item)), points(pieces.parts(moved))
    assert b == pytest.approx(np.stack((2.0 - a[:, 1], 3.0 + a[:, 0], 0.5 + a[:, 2]), -1))


def test_pieces_that_are_alike_are_built_once_and_stand_apart() -> None:
    item = make("chair_wood", 1)
    items = [item, replace(item, position=(1.0, 0.0, 0.0)), replace(item, piece="library:x"), make("cup", 2)]
    found = pieces.parts_of(items)
    single = [part for i in (0, 1, 3) for part in pieces.parts(items[i])]
    assert len(found) == len(single)
    for a, b in zip(found, single, strict=True):
        assert a.mesh.vertices == pytest.approx(b.mesh.vertices)


@pytest.mark.parametrize("piece", ["own:nothing", "library:sofa", "sofa"])
def test_what_is_no_piece_of_ours_is_refused(piece: str) -> None:
    with pytest.raises(ValueError, match="expected own:NAME"):
        pieces.parts(replace(make("sofa", 0), piece=piece))


def test_a_kind_that_we_do_not_make_is_refused() -> None:
    rng = Random(0)
    with pytest.raises(ValueError, match="expected a kind"):
        pieces.draw("person", rng, draw_style(rng))


def test_a_leafs_upper_side_is_up() -> None:
    mesh = leaf(0.2)
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).mean() > 0.8


def test_styles_use_known_surfaces_of_real_reflectance() -> None:
    for seed in range(20):
        style = draw_style(Random(seed))
        surfaces = [value for value in vars(style).values() if not isinstance(value, tuple)]
        surfaces += [*style.accents, *style.books]
        for surface in surfaces:
            assert surface.kind in SURFACES
            assert all(0 <= channel <= 0.9 or surface.kind == "glass" for channel in surface.colour)
        assert reflectance(style.upholstery.colour) < 0.75
